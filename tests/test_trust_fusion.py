"""Laws and contracts of late fusion."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import check_grad

from benchmarks._held_out import held_out_log_probabilities, training_folds
from varishold.errors import InputError
from varishold.trust.fusion import SourceWeights, _Loss, choose_weights, fuse, log_loss

seeds = st.integers(0, 2**31)


def source(seed: int, n: int = 30, k: int = 4, sharp: float = 2.0, truth=None):
    said = np.random.default_rng(seed).normal(0, sharp, (n, k))
    if truth is not None:
        said[np.arange(n), truth] += sharp
    return said - np.log(np.exp(said).sum(axis=1, keepdims=True))


@settings(max_examples=30)
@given(seeds, st.floats(0, 0.5), st.floats(0, 4))
def test_probabilities_sum_to_one_and_order_of_sources_and_objects_is_free(seed, mixing, weight):
    a, b = source(seed), source(seed + 1, sharp=1.0)
    weights = {"a": weight, "b": 1.0}
    fused = fuse({"a": a, "b": b}, weights, mixing=mixing)
    np.testing.assert_allclose(np.exp(fused).sum(axis=1), 1)
    np.testing.assert_allclose(fuse({"b": b, "a": a}, weights, mixing=mixing), fused, atol=1e-12)
    turned = fuse({"a": a[:, ::-1], "b": b[:, ::-1]}, weights, mixing=mixing)
    np.testing.assert_allclose(turned[:, ::-1], fused, atol=1e-12)
    # A constant in each row says nothing.
    np.testing.assert_allclose(fuse({"a": a + 7, "b": b - 3}, weights, mixing=mixing), fused, atol=1e-9)


@settings(max_examples=20)
@given(seeds)
def test_independent_sources_multiply_by_bayes_rule(seed):
    prior = source(seed, 1)[0]
    likelihoods = [source(seed + i) for i in (1, 2)]
    posteriors = {str(i): fuse({"": like}, mixing=0) for i, like in enumerate(likelihoods)}
    posteriors = {name: p + prior for name, p in posteriors.items()}
    expected = prior + likelihoods[0] + likelihoods[1]
    expected -= np.log(np.exp(expected).sum(axis=1, keepdims=True))
    np.testing.assert_allclose(fuse(posteriors, mixing=0, log_prior=prior), expected, atol=1e-9)


def test_a_missing_source_is_left_out_row_by_row():
    a, b = source(1), source(2)
    b[::2] = np.nan
    fused = fuse({"a": a, "b": b, "c": None})
    np.testing.assert_allclose(fused[::2], fuse({"a": a})[::2])
    np.testing.assert_allclose(fused[1::2], fuse({"a": a[1::2], "b": b[1::2]}))
    nothing = fuse({"a": np.full((2, 3), np.nan)}, log_prior=np.log([0.5, 0.3, 0.2]))
    np.testing.assert_allclose(np.exp(nothing), [[0.5, 0.3, 0.2]] * 2)


def test_a_source_that_counts_nothing_changes_nothing_even_when_it_is_certain():
    a = source(1, k=2)
    certain = np.tile([0.0, -np.inf], (30, 1))
    np.testing.assert_allclose(fuse({"a": a, "b": certain}, {"a": 1.0, "b": 0.0}), fuse({"a": a}))


def test_contradiction_ends_in_the_prior_and_a_mixing_weight_bounds_what_a_source_can_say():
    a, b = np.array([[0.0, -np.inf]]), np.array([[-np.inf, 0.0]])
    np.testing.assert_allclose(np.exp(fuse({"a": a, "b": b}, mixing=0)), [[0.5, 0.5]])
    np.testing.assert_allclose(np.exp(fuse({"a": a}, mixing=0)), [[1.0, 0.0]])
    np.testing.assert_allclose(np.exp(fuse({"a": a}, mixing=0.1)), [[0.95, 0.05]])
    everything = np.full((1, 2), -np.inf)
    np.testing.assert_allclose(np.exp(fuse({"a": everything})), [[0.5, 0.5]])
    # One object that the prior excludes stays excluded.
    assert fuse({"a": b}, log_prior=[0.0, -np.inf])[0].tolist() == [0.0, -np.inf]
    assert fuse({"a": b}, mixing=0, log_prior=[0.0, -np.inf])[0].tolist() == [0.0, -np.inf]


@settings(max_examples=15)
@given(seeds, st.floats(0.2, 3), st.floats(0.01, 0.6))
def test_the_gradient_of_the_loss_is_right(seed, weight, mixing):
    truth = np.random.default_rng(seed).integers(0, 4, 30)
    a, b = source(seed, truth=truth), source(seed + 1)
    b[:5], a[3, 1] = np.nan, -np.inf
    loss = _Loss([a, b], truth, np.log([0.4, 0.3, 0.2, 0.1]))
    at = np.array([weight, 1.0, mixing, 0.05])
    slope = float(np.linalg.norm(loss(at)[1]))
    assert check_grad(lambda t: loss(t)[0], lambda t: loss(t)[1], at) < 1e-4 * max(1.0, slope)
    weights = SourceWeights({"a": weight, "b": 1.0}, {"a": mixing, "b": 0.05})
    fused = fuse({"a": a, "b": b}, weights, log_prior=np.log([0.4, 0.3, 0.2, 0.1]))
    assert log_loss(fused, truth) == pytest.approx(loss(at)[0])


@settings(max_examples=10)
@given(seeds)
def test_chosen_weights_are_no_worse_than_even_ones_or_either_source(seed):
    truth = np.random.default_rng(seed).integers(0, 4, 200)
    sources = {"a": source(seed, 200, truth=truth), "b": source(seed + 1, 200, sharp=0.5, truth=truth)}
    chosen = choose_weights(sources, truth)
    best = log_loss(fuse(sources, chosen), truth)
    assert best <= log_loss(fuse(sources), truth) + 1e-6
    for name, said in sources.items():
        assert best <= log_loss(fuse({name: said}), truth) + 1e-3


def test_a_source_that_repeats_another_does_not_count_twice_and_a_lapsing_one_is_found_out():
    rng = np.random.default_rng(3)
    truth = rng.integers(0, 5, 2000)
    honest = np.log(rng.dirichlet(np.ones(5), 2000))
    truth = np.array([rng.choice(5, p=np.exp(row)) for row in honest])
    chosen = choose_weights({"a": honest, "again": honest}, truth)
    assert sum(chosen.weights.values()) == pytest.approx(1.0, abs=0.15)
    sure = np.log(np.where(np.arange(5) == truth[:, None], 0.996, 0.001))
    shuffled = rng.random(2000) < 0.4
    sure[shuffled] = sure[shuffled][:, rng.permutation(5)]
    assert choose_weights({"sure": sure}, truth).mixing["sure"] == pytest.approx(0.4, abs=0.15)


def test_a_silent_source_keeps_weight_one():
    truth = np.arange(10) % 3
    chosen = choose_weights({"a": source(1, 10, 3), "none": None, "nan": np.full((10, 3), np.nan)}, truth)
    assert chosen.weights["none"] == chosen.weights["nan"] == 1


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: fuse({}), "at least one source"),
        (lambda: fuse({"a": None}), "at least one source"),
        (lambda: fuse({"a": [0.5, 0.5]}), r"'a' must have shape \(n, k\), got \(2,\)"),
        (lambda: fuse({"a": [["x"]]}), "must be one array of numbers"),
        (lambda: fuse({"a": [[0.0, np.inf]]}), "below infinity, got inf in row 0"),
        (lambda: fuse({"a": [[0.0, 1.0], [0.0, np.nan]]}), "row 1 is NaN in part"),
        (lambda: fuse({"a": np.zeros((2, 3)), "b": np.zeros((2, 4))}), r"a \(2, 3\), b \(2, 4\)"),
        (lambda: fuse({"a": np.zeros((2, 3))}, {"b": 1.0}), "no weight for source 'a'; there are weights for 'b'"),
        (lambda: fuse({"a": np.zeros((2, 3))}, {"a": -1.0}), "must be a number from 0 to below inf, got -1.0"),
        (lambda: fuse({"a": np.zeros((2, 3))}, mixing=1.0), "mixing weight must be a number from 0 to below 1"),
        (lambda: fuse({"a": np.zeros((2, 3))}, mixing="x"), "mixing weight must be a number from 0 to below 1"),
        (lambda: fuse({"a": np.zeros((2, 3))}, {"a": "x"}), "must be a number from 0 to below inf, got 'x'"),
        (lambda: fuse([np.zeros((2, 3))]), "by name, got list"),
        (lambda: fuse({"a": np.zeros((2, 3))}, log_prior=[0.0]), r"log_prior must have shape \(3,\)"),
        (lambda: fuse({"a": np.zeros((2, 3))}, log_prior=[-np.inf] * 3), "some of them above -inf"),
        (lambda: SourceWeights({"a": 1.0}, {"b": 0.1}), "weights are of the sources"),
        (lambda: SourceWeights({"a": 1.0}, {"a": 2.0}), "mixing weight of source 'a'"),
        (lambda: choose_weights({"a": np.zeros((2, 3))}, [0, 3]), "truth must be from 0 to 2, got 3 for grasp 1"),
        (lambda: choose_weights({"a": np.zeros((2, 3))}, ["x", "y"]), "one whole number a grasp"),
        (lambda: log_loss(np.zeros((0, 3)), np.zeros(0, int)), "no grasp"),
        (lambda: training_folds([0, 1], 1), "folds must be a whole number"),
        (lambda: training_folds([[0]]), "one object a grasp"),
        (lambda: held_out_log_probabilities(None, [1.0], [0]), "X must have shape"),
        (lambda: held_out_log_probabilities(None, [[1.0]], [0]), "at least two folds"),
        (lambda: held_out_log_probabilities(None, [[1.0]], [0], fold=[0, 1]), "fold must be one number"),
    ],
)
def test_bad_input_is_told_in_one_line(call, message):
    with pytest.raises(InputError, match=message) as caught:
        call()
    assert "\n" not in str(caught.value)


def test_folds_keep_neighbours_together_and_every_object_in_each():
    truth = np.tile([0, 1, 2], 10)
    fold = training_folds(truth, 5)
    for name in range(3):
        assert fold[truth == name].tolist() == sorted([0, 1, 2, 3, 4] * 2)


class Nearest:
    """Names the nearest mean, surely."""

    def fit(self, X, y):
        self.classes_ = np.unique(y)
        self.means = np.stack([X[y == c].mean(axis=0) for c in self.classes_])
        return self

    def predict_proba(self, X):
        near = ((X[:, None] - self.means) ** 2).sum(axis=2).argmin(axis=1)
        return np.eye(len(self.classes_))[near]


def test_held_out_answers_come_from_grasps_not_seen():
    rng = np.random.default_rng(0)
    truth = np.repeat(np.arange(3), 10)
    X = truth[:, None] + rng.normal(0, 0.05, (30, 2))
    X[4] = np.nan
    said = held_out_log_probabilities(Nearest(), X, truth, n_objects=4)
    assert said.shape == (30, 4)
    assert np.isnan(said[4]).all()
    rest = np.arange(30) != 4
    assert (said[rest].argmax(axis=1) == truth[rest]).all()
    assert np.isneginf(said[rest][:, 3]).all()
    # An object that only one fold holds is never known when that fold is asked.
    alone = held_out_log_probabilities(Nearest(), X, truth, fold=np.where(truth == 2, 1, np.arange(30) % 3))
    assert np.isneginf(alone[truth == 2][:, 2]).all()
