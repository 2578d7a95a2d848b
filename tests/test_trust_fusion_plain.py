"""Late fusion beside plain probabilities, and the limits of what it takes."""

from __future__ import annotations

import math
import pickle
from types import MappingProxyType

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import minimize

from varishold.errors import InputError
from varishold.trust import calibrate, class_weights
from varishold.trust.fusion import MIXING, SourceWeights, _Loss, checked_truth, choose_weights, fuse, log_loss


def fused_row(rows, weights, mixing, prior):
    """One grasp in probabilities: powers over the prior, mixed with it, multiplied; the prior where nothing is left."""
    product = list(prior)
    for row, w, m in zip(rows, weights, mixing, strict=True):
        top = max(row)
        if math.isnan(row[0]) or top == -math.inf or w == 0:
            continue
        least = -30.0 if m > 0 else -math.inf
        likely = [math.exp(max(one - top, least)) for one in row]
        said = [p * (x / p) ** w if p > 0 else 0.0 for x, p in zip(likely, prior, strict=True)]
        whole = sum(said)
        said = [x / whole if whole > 0 else 0.0 for x in said]
        mixed = [(1 - m) * x + m * p for x, p in zip(said, prior, strict=True)]
        product = [a * (x / p if p > 0 else 0.0) for a, x, p in zip(product, mixed, prior, strict=True)]
    whole = sum(product)
    return [x / whole for x in product] if whole > 0 else list(prior)


@given(
    st.integers(0, 2**31),
    st.sampled_from([0.0, 0.3, 1.0, 2.5]),
    st.sampled_from([0.0, 0.01, 0.5]),
    st.booleans(),
    st.sampled_from(["even", "uneven", "excluded"]),
)
@settings(max_examples=60)
def test_fusing_is_that_of_plain_probabilities(seed: int, weight: float, mixing: float, own: bool, kind: str) -> None:
    rng = np.random.default_rng(seed)
    a, b = rng.normal(0, 2, (2, 6, 3))
    a[0], b[1], a[2, 1], b[2, 0], a[3], b[4, :2] = np.nan, np.nan, -np.inf, -np.inf, -np.inf, -np.inf
    a[5] *= 40
    prior = {"even": np.full(3, 1 / 3), "uneven": np.array([0.5, 0.3, 0.2]), "excluded": np.array([0.4, 0.0, 0.6])}[
        kind
    ]
    with np.errstate(divide="ignore"):
        # A constant more in the prior says nothing.
        log_prior = None if kind == "even" else np.log(prior) + 3.0
    trust = SourceWeights({"a": weight, "b": 1.5, "c": 1.0}, {"a": mixing, "b": 0.02, "c": 0.9})
    if own:
        told = fuse({"c": None, "a": a, "b": b}, trust, mixing=0.7, log_prior=log_prior)
        shares = [mixing, 0.02]
    else:
        told = fuse({"a": a, "b": b, "c": None}, dict(trust.weights), mixing=mixing, log_prior=log_prior)
        shares = [mixing, mixing]
    expected = [fused_row([x, y], [weight, 1.5], shares, prior) for x, y in zip(a, b, strict=True)]
    np.testing.assert_allclose(np.exp(told), expected, rtol=1e-6, atol=1e-12)


def test_without_weights_each_counts_once_and_is_mixed_by_a_hundredth() -> None:
    a, b = np.log([[0.7, 0.2, 0.1]]), np.log([[0.2, 0.5, 0.3]])
    assert MIXING == 0.01
    expected = fused_row([a[0], b[0]], [1, 1], [0.01, 0.01], [1 / 3] * 3)
    np.testing.assert_allclose(np.exp(fuse({"a": a, "b": b}))[0], expected)
    np.testing.assert_allclose(np.exp(fuse({"a": np.zeros((1, 1))})), [[1.0]])
    assert fuse({"a": np.zeros((0, 3))}).shape == (0, 3)


def test_weights_are_kept_as_numbers_and_cannot_be_changed() -> None:
    given = {"a": 1, "b": np.float32(0.5)}
    trust = SourceWeights(given, {"b": 0, "a": np.int64(0)})
    given["a"] = 7
    assert isinstance(trust.weights, MappingProxyType)
    assert isinstance(trust.mixing, MappingProxyType)
    assert (dict(trust.weights), dict(trust.mixing)) == ({"a": 1.0, "b": 0.5}, {"a": 0.0, "b": 0.0})
    assert all(type(of) is float for of in (*trust.weights.values(), *trust.mixing.values()))
    assert pickle.loads(pickle.dumps(trust)) == trust


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (
            lambda: SourceWeights({"b": 1.0, "a": 1.0}, {"c": 0.1}),
            "weights are of the sources ['a', 'b'], mixing of ['c']",
        ),
        (
            lambda: SourceWeights({"a": -0.1}, {"a": 0.1}),
            "weight of source 'a' must be a number from 0 to below inf, got -0.1",
        ),
        (
            lambda: SourceWeights({"a": True}, {"a": 0.1}),
            "weight of source 'a' must be a number from 0 to below inf, got True",
        ),
        (
            lambda: SourceWeights({"a": np.inf}, {"a": 0.1}),
            "weight of source 'a' must be a number from 0 to below inf, got inf",
        ),
        (
            lambda: SourceWeights({"a": 1.0}, {"a": 1}),
            "mixing weight of source 'a' must be a number from 0 to below 1, got 1",
        ),
        (
            lambda: SourceWeights({"a": 1.0}, {"a": np.nan}),
            "mixing weight of source 'a' must be a number from 0 to below 1, got nan",
        ),
        (
            lambda: fuse({"a": np.zeros((2, 3))}, mixing=-0.1),
            "mixing weight must be a number from 0 to below 1, got -0.1",
        ),
        (lambda: fuse({"a": np.zeros((2, 3))}, {}), "no weight for source 'a'; there are weights for none"),
        (lambda: fuse({"a": np.zeros((2, 0))}), "log-probabilities of 'a' must have shape (n, k), got (2, 0)"),
        (
            lambda: fuse({"a": [[0.0, 1.0], [np.inf, 0.0]]}),
            "log-probabilities of 'a' must be below infinity, got inf in row 1",
        ),
        (
            lambda: fuse({"a": [[np.nan] * 2, [0.0, 1.0], [np.nan, 0.0]]}),
            "log-probabilities of 'a': row 2 is NaN in part; all of it or none",
        ),
        (
            lambda: fuse({"a": np.zeros((2, 3))}, log_prior=[0.0, 1.0, np.nan]),
            "log_prior must be log-probabilities, some of them above -inf",
        ),
        (
            lambda: fuse({"a": np.zeros((2, 3))}, log_prior=[0.0, 1.0, np.inf]),
            "log_prior must be log-probabilities, some of them above -inf",
        ),
        (lambda: checked_truth([0, -1], 2, 3), "truth must be from 0 to 2, got -1 for grasp 1"),
        (lambda: checked_truth([0, 1, 3], 3, 3), "truth must be from 0 to 2, got 3 for grasp 2"),
        (
            lambda: checked_truth([0.0, 1.0], 2, 3),
            "truth must be one whole number a grasp, shape (2,), got float64 of (2,)",
        ),
        (lambda: checked_truth([0, 1], 3, 3), "truth must be one whole number a grasp, shape (3,), got int64 of (2,)"),
    ],
)
def test_what_is_wrong_is_told(call, message: str) -> None:
    with pytest.raises(InputError) as told:
        call()
    assert str(told.value) == message


def test_truth_is_of_every_whole_kind() -> None:
    for kind in (np.uint8, np.int16):
        found = checked_truth(np.array([0, 2], dtype=kind), 2, 3)
        assert (found.tolist(), found.dtype) == ([0, 2], np.intp)


def test_log_loss_is_the_mean_of_what_truth_lacks() -> None:
    p = np.array([[0.5, 0.5], [0.9, 0.1], [0.2, 0.8]])
    assert log_loss(np.log(p), [0, 1, 1]) == pytest.approx(-(math.log(0.5) + math.log(0.1) + math.log(0.8)) / 3)


@pytest.mark.parametrize("seed", [0, 1, 2, 3])
def test_chosen_weights_are_the_best_from_a_modest_and_a_bold_start(seed: int) -> None:
    rng = np.random.default_rng(seed)
    n, k = 60, 3
    truth = rng.integers(0, k, n)
    right = np.eye(k)[truth]
    said = {
        "good": 1.5 * right + rng.normal(0, 1, (n, k)),
        "bold": 6 * np.where(rng.random((n, 1)) < 0.35, np.roll(right, 1, axis=1), right) + rng.normal(0, 0.3, (n, k)),
        "none": None,
    }
    said["good"][:9] = np.nan
    log_prior = np.log([0.5, 0.3, 0.2])
    chosen = choose_weights(said, truth, log_prior=log_prior)
    own = log_loss(fuse(said, chosen, log_prior=log_prior), truth)
    loss = _Loss([said["good"], said["bold"]], truth, log_prior)
    bounds = [(0.0, 5.0)] * 2 + [(0.001, 0.9)] * 2
    found = [
        minimize(lambda at: loss(at)[0], start, method="L-BFGS-B", bounds=bounds).fun
        for start in ((1, 1, 0.01, 0.01), (2, 2, 0.3, 0.3))
    ]
    assert own == pytest.approx(min(found), abs=1e-5)
    assert (chosen.weights["none"], chosen.mixing["none"]) == (1.0, 0.01)
    assert list(chosen.weights) == ["good", "bold", "none"]


@pytest.mark.parametrize("seed", range(3))
def test_what_counts_twice_is_as_if_it_were_there_twice(seed: int) -> None:
    rng = np.random.default_rng(seed)
    truth = rng.integers(0, 3, 40)
    said = {name: np.eye(3)[truth] * by + rng.normal(0, 1, (40, 3)) for name, by in (("good", 2.0), ("poor", 0.5))}
    often = rng.integers(1, 4, 40)
    twice = np.repeat(np.arange(40), often)
    counted = choose_weights(said, truth, counts=often)
    there = choose_weights({name: of[twice] for name, of in said.items()}, truth[twice])
    assert counted.weights == pytest.approx(there.weights, rel=1e-3)
    assert counted.mixing == pytest.approx(there.mixing, abs=1e-3)
    assert calibrate(said["good"], truth, often.astype(float)) == calibrate(said["good"][twice], truth[twice])


@pytest.mark.parametrize("counts", [[1.0, 2.0], [1.0, 0.0, 1.0], [1.0, np.nan, 1.0], [[1.0, 1.0, 1.0]]])
def test_counts_are_one_positive_number_a_grasp(counts: object) -> None:
    with pytest.raises(InputError, match=r"counts must be one number above 0 a grasp, shape \(3,\)"):
        choose_weights({"a": np.zeros((3, 2))}, [0, 1, 0], counts=counts)


@pytest.mark.parametrize("seed", range(3))
def test_a_class_weighs_as_the_root_of_how_many_are_of_it(seed: int) -> None:
    truth = np.random.default_rng(seed).choice([0, 1, 3], 50, p=[0.8, 0.15, 0.05])
    weight = class_weights(truth)
    assert weight.mean() == pytest.approx(1.0)
    sums = np.array([weight[truth == k].sum() for k in np.unique(truth)])
    roots = np.sqrt(np.unique(truth, return_counts=True)[1])
    assert sums / sums.sum() == pytest.approx(roots / roots.sum())


def test_chosen_weights_have_their_bounds() -> None:
    truth = np.arange(60) % 2
    modest = np.log(np.where(np.arange(2) == truth[:, None], 0.6, 0.4))
    sure = choose_weights({"a": modest}, truth)
    assert sure.weights["a"] == pytest.approx(5.0)
    assert sure.mixing["a"] == pytest.approx(0.001)
    # What is always wrong counts nothing.
    wrong = choose_weights({"a": modest[:, ::-1]}, truth)
    assert log_loss(fuse({"a": modest[:, ::-1]}, wrong), truth) == pytest.approx(math.log(2), abs=1e-6)
    lost = choose_weights({"a": 50.0 * modest[:, ::-1], "b": modest}, truth)
    assert 0 <= lost.weights["a"] <= 0.05 or lost.mixing["a"] == pytest.approx(0.9)


@pytest.mark.parametrize("kind", ["plain", "excluded"])
def test_the_loss_is_that_of_fusing_and_its_slope_is_that_of_steps(kind: str) -> None:
    rng = np.random.default_rng(5)
    prior = np.array([0.5, 0.3, 0.2]) if kind == "plain" else np.array([0.6, 0.4, 0.0])
    with np.errstate(divide="ignore"):
        log_prior = np.log(prior)
    truth = rng.integers(0, 3 if kind == "plain" else 2, 20)
    a, b = rng.normal(0, 1.5, (2, 20, 3))
    a[:4], b[6] = np.nan, -np.inf
    loss = _Loss([a, b], truth, log_prior)
    at = np.array([1.3, 0.6, 0.2, 0.05])
    value, slope = loss(at)
    trust = SourceWeights({"a": 1.3, "b": 0.6}, {"a": 0.2, "b": 0.05})
    assert value == pytest.approx(log_loss(fuse({"a": a, "b": b}, trust, log_prior=log_prior), truth))
    steps = [(loss(at + step)[0] - loss(at - step)[0]) / 2e-5 for step in 1e-5 * np.eye(4)]
    np.testing.assert_allclose(slope, steps, rtol=1e-4, atol=1e-7)


def test_what_the_prior_excludes_costs_a_thousand_nats_and_has_no_slope() -> None:
    with np.errstate(divide="ignore"):
        log_prior = np.log([0.5, 0.5, 0.0])
    said = np.random.default_rng(0).normal(0, 1, (4, 3))
    value, slope = _Loss([said], np.array([0, 1, 2, 0]), log_prior)(np.array([1.0, 0.1]))
    rest = _Loss([said[[0, 1, 3]]], np.array([0, 1, 0]), log_prior)(np.array([1.0, 0.1]))[0]
    assert value == pytest.approx((3 * rest + 1000) / 4)
    assert np.isfinite(slope).all()


def test_a_probability_of_zero_stands_for_thirty_nats_where_it_is_mixed() -> None:
    said = np.array([[0.0, -np.inf]])
    trust = SourceWeights({"a": 0.1}, {"a": 1e-9})
    least = math.exp(-3) / (1 + math.exp(-3))
    np.testing.assert_allclose(np.exp(fuse({"a": said}, trust)), [[1 - least, least]], rtol=1e-6)
    np.testing.assert_allclose(np.exp(fuse({"a": said}, {"a": 0.1}, mixing=0)), [[1, 0]])
