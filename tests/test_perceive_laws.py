"""Laws of evidence with answers on paper: failed touches, distances, likelihoods, sizes, what a touch is worth."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from varishold.errors import InputError
from varishold.perceive import Belief, Evidence, Library, expected_information, fuse
from varishold.perceive.conformity import Calibration
from varishold.perceive.likelihood import log_mean, squared_distances
from varishold.perceive.metric import Metric, fit_metric
from varishold.perceive.size_model import FREEDOM, fit_size_model

seeds = st.integers(0, 2**32 - 1)
few = settings(max_examples=25)

#: How often a touch that failed in an example succeeds there another time, and the other way round.
CHANCE = 0.1


def entropy(*p: float) -> float:
    return -sum(x * np.log(x) for x in p if x > 0)


@pytest.fixture(scope="module")
def slippery() -> Library:
    """A ball whose tip can always be touched, and a box whose tip failed in 12 of 16 tries; both feel alike."""
    rng = np.random.default_rng(0)

    def grasp() -> Evidence:
        return Evidence("grasp", {"form.0": rng.normal()})

    ball = [[grasp(), Evidence("tip", {"form.0": 0.0})] for _ in range(16)]
    box = [[grasp(), Evidence("tip", {"form.0": 0.0})] for _ in range(4)]
    box += [[grasp(), Evidence("tip", {}, failed=True)] for _ in range(12)]
    return Library.from_examples({"ball": ball, "box": box})


# P(fails) of the ball's examples, and of the box's on the whole.
BALL, BOX = CHANCE, (12 * (1 - CHANCE) + 4 * CHANCE) / 16


def test_a_touch_that_fails_speaks_for_what_it_fails_on(slippery: Library) -> None:
    belief = Belief.before(slippery).after(Evidence("tip", {}, failed=True))
    assert belief.probability["box"] == pytest.approx(BOX / (BOX + BALL))
    assert belief.remarks == ("tip: tried, and nothing was held",)
    assert belief.p_value == 1.0
    again = belief.after(Evidence("tip", {}, failed=True))
    often = (12 * (1 - CHANCE) ** 2 + 4 * CHANCE**2) / 16
    assert again.probability["box"] == pytest.approx(often / (often + CHANCE**2))


def test_a_touch_that_succeeds_speaks_against_what_it_fails_on(slippery: Library) -> None:
    belief = Belief.before(slippery).after(Evidence("tip", {}))
    assert belief.probability["ball"] == pytest.approx((1 - BALL) / (2 - BALL - BOX))
    both = belief.after(Evidence("tip", {}, failed=True))
    # An example that held the tip once may fail the next time, as often as the other way round.
    mixed = CHANCE * (1 - CHANCE)
    assert both.probability == pytest.approx({"ball": 0.5, "box": 0.5})
    assert mixed > 0


def test_where_no_touch_ever_failed_a_failure_says_nothing(slippery: Library) -> None:
    belief = Belief.before(slippery).after(Evidence("grasp", {}, failed=True))
    assert belief.probability == pytest.approx({"ball": 0.5, "box": 0.5})


def test_a_touch_is_worth_what_its_outcome_tells_of_the_name(slippery: Library) -> None:
    fails = (BALL + BOX) / 2
    after_failure = entropy(BALL / (BALL + BOX), BOX / (BALL + BOX))
    after_success = entropy((1 - BALL) / (2 - BALL - BOX), (1 - BOX) / (2 - BALL - BOX))
    worth = np.log(2) - fails * after_failure - (1 - fails) * after_success
    assert expected_information(Belief.before(slippery), "tip") == pytest.approx(worth, rel=1e-6)
    with pytest.raises(InputError, match="knows no touch 'poke'"):
        expected_information(Belief.before(slippery), "poke")


def test_a_touch_that_parts_the_objects_is_worth_the_whole_name() -> None:
    rng = np.random.default_rng(1)
    names = ("a", "b", "c")
    library = Library.from_examples(
        {
            name: [
                [Evidence("telling", {"f": 50.0 * k + rng.normal()}), Evidence("idle", {"g": rng.normal()})]
                for _ in range(30)
            ]
            for k, name in enumerate(names)
        }
    )
    before = Belief.before(library)
    assert expected_information(before, "telling") == pytest.approx(np.log(3), rel=0.02)
    assert expected_information(before, "idle") < 0.1
    sure = before.after(Evidence("telling", {"f": 50.0}))
    assert sure.best == "b"
    assert expected_information(sure, "telling") < 0.01


# Distances


@few
@given(seeds)
def test_whitened_numbers_scatter_by_one_in_every_direction(seed: int) -> None:
    rng = np.random.default_rng(seed)
    mix = rng.normal(size=(3, 3))
    metric = Metric(("a", "b", "c"), rng.normal(size=3), rng.uniform(0.5, 2, 3), mix @ mix.T + 0.1 * np.eye(3))
    np.testing.assert_allclose(metric.whitening.T @ metric.covariance @ metric.whitening, np.eye(3), atol=1e-8)
    x = rng.normal(size=(4, 3))
    np.testing.assert_allclose(metric.standardized(metric.shift + metric.scale * x), np.clip(x, -6, 6))
    assert metric.standardized(metric.shift + 1e9).tolist() == [6.0] * 3
    assert metric.standardized(metric.shift - 1e9).tolist() == [-6.0] * 3
    part = metric.of(np.array([True, False, True]))
    assert part.names == ("a", "c")
    np.testing.assert_array_equal(part.covariance, metric.covariance[[0, 0, 2, 2], [0, 2, 0, 2]].reshape(2, 2))
    np.testing.assert_array_equal((part.shift, part.scale), (metric.shift[[0, 2]], metric.scale[[0, 2]]))
    assert metric.of(np.ones(3, np.bool_)) is metric


@few
@given(seeds, st.floats(0.01, 100), st.floats(-50, 50))
def test_a_metric_does_not_depend_on_units_and_knows_scatter_within_objects_alone(
    seed: int, factor: float, shift: float
) -> None:
    rng = np.random.default_rng(seed)
    owner = np.repeat(np.arange(4), 20)
    values = rng.normal(size=(80, 2)) * (1.0, 0.3) + 3.0 * rng.normal(size=(4, 2))[owner]
    one = fit_metric(("a", "b"), values, owner)
    other = fit_metric(("a", "b"), values * (1, factor) + (0, shift), owner)
    np.testing.assert_allclose(other.covariance, one.covariance, rtol=1e-6, atol=1e-9)
    np.testing.assert_allclose(one.scale, values.std(axis=0))
    np.testing.assert_allclose(one.shift, values.mean(axis=0))
    units = one.standardized(values)
    inner = sum(np.cov(units[owner == k].T) for k in range(4)) / 4
    few_examples = 1 + 2 / 76
    np.testing.assert_allclose(one.covariance, inner + 0.2 * few_examples * np.eye(2), rtol=1e-6, atol=1e-9)
    # Objects that lie elsewhere scatter no more for it, as long as the scale is the same.
    bare = fit_metric(("a", "b"), values, owner, shrink=0.0)
    np.testing.assert_allclose(bare.covariance, inner, rtol=1e-6, atol=1e-9)


def test_what_changes_evenly_with_size_is_no_scatter() -> None:
    rng = np.random.default_rng(4)
    owner, log_size = np.repeat([0, 1], 40), rng.uniform(-3, -2, 80)
    values = np.column_stack([5 * log_size + 2 * log_size**2, rng.normal(size=80)])
    blind = fit_metric(("a", "b"), values, owner, shrink=0.0)
    told = fit_metric(("a", "b"), values, owner, log_size, shrink=0.0)
    assert blind.covariance[0, 0] > 0.5
    assert told.covariance[0, 0] == pytest.approx(0, abs=1e-9)
    assert told.covariance[1, 1] == pytest.approx(blind.covariance[1, 1], rel=0.15)


def test_a_number_that_is_missing_counts_as_usual_and_a_constant_one_keeps_its_unit() -> None:
    values = np.array([[1.0, 7.0], [np.nan, 7.0], [3.0, 7.0], [np.nan, 7.0]])
    metric = fit_metric(("a", "b"), values, np.zeros(4, np.int64))
    assert metric.shift.tolist() == [2.0, 7.0]
    assert metric.scale.tolist() == [1.0, 1.0]
    with pytest.raises(InputError, match=r"needs examples of shape \(n, 2\)"):
        fit_metric(("a", "b"), np.zeros((0, 2)), np.zeros(0, np.int64))


@few
@given(seeds)
def test_distances_and_means_of_likelihoods(seed: int) -> None:
    rng = np.random.default_rng(seed)
    a, b = rng.normal(size=(5, 3)).astype(np.float32), rng.normal(size=(4, 3)).astype(np.float32)
    np.testing.assert_allclose(squared_distances(a, b), ((a[:, None] - b) ** 2).sum(axis=2), rtol=1e-4, atol=1e-5)
    assert (squared_distances(a, a) >= 0).all()
    p = rng.uniform(0.1, 1, (3, 6))
    np.testing.assert_allclose(np.exp(log_mean(np.log(p) - 800) + 800), p.mean(axis=1))
    np.testing.assert_allclose(np.exp(log_mean(np.log(p), over=3)), p.sum(axis=1) / 3)


def test_the_kernel_falls_as_a_power_and_fewer_numbers_say_less(slippery: Library) -> None:
    model = replace(slippery.touches["grasp"], width=2.0, fall=6.0)
    square = np.array([0.0, 4.0, 12.0])
    np.testing.assert_allclose(np.exp(model.kernel(square, 1)), (1 + square / 4) ** -3.0)
    wide = replace(model, metric=Metric(("a", "b"), np.zeros(2), np.ones(2), np.eye(2)))
    np.testing.assert_allclose(np.exp(wide.kernel(square, 2)), (1 + square / 8) ** -3.0)
    np.testing.assert_allclose(np.exp(wide.kernel(square, 1)), (1 + square / 4) ** (-3.0 * np.sqrt(0.5)))


def test_surprisal_is_of_the_share_of_examples_that_conform_no_better() -> None:
    told = Calibration(np.array([3.0, 1.0, np.nan, 4.0, 2.0]))
    for score, share in ((0.5, 1 / 5), (1.0, 2 / 5), (2.5, 3 / 5), (4.0, 1.0), (9.0, 1.0)):
        assert told.surprisal(score) == pytest.approx(-np.log(share))


# Sizes


def test_a_size_model_finds_the_line_from_fitted_sizes_to_sizes() -> None:
    rng = np.random.default_rng(5)
    fitted = rng.uniform(-3.2, -2.2, (60, 1))
    true = 0.9 * fitted[:, 0] + 0.1 + rng.normal(0, 0.01, 60)
    owner = np.repeat([0, 1], 30)
    true[owner == 1] += 0.3
    true[3] = 5.0  # one slip among thirty does not move the line
    model = fit_size_model(("size.circle",), fitted, true, owner)
    np.testing.assert_allclose(model.line[:, 0], 0.9, atol=0.03)
    np.testing.assert_allclose(model.line @ (-2.7, 1.0), (-2.33, -2.03), atol=0.01)
    assert (model.scale > 0.004).all()
    assert (model.scale < 0.03).all()
    sizes = np.linspace(-3, -1, 2001)
    told = model.log_likelihood(np.array([-2.7]), sizes)
    np.testing.assert_allclose(sizes[told.argmax(axis=1)], (-2.33, -2.03), atol=0.01)
    # Student's t about it: symmetric, and as heavy as its freedom says.
    off = 3 * model.scale[0]
    middle = float(model.line[0] @ (-2.7, 1.0))
    left, right, top = (model.log_likelihood(np.array([-2.7]), np.array([middle + d]))[0, 0] for d in (-off, off, 0.0))
    assert left == pytest.approx(right)
    assert top - left == pytest.approx((FREEDOM + 1) / 2 * np.log(1 + 9 / FREEDOM))
    assert top == pytest.approx(-np.log(model.scale[0]))
    assert not model.log_likelihood(np.array([np.nan]), sizes).any()
    one = model.only([1])
    np.testing.assert_array_equal(one.line, model.line[1:])
    more = model.with_object(fitted[owner == 0], true[owner == 0])
    np.testing.assert_array_equal(more.line, model.line[[0, 1, 0]])
    np.testing.assert_array_equal(more.scale, model.scale[[0, 1, 0]])


def test_an_object_of_one_size_has_that_size_times_what_is_fitted() -> None:
    fitted = np.full((10, 2), -2.5)
    model = fit_size_model(("size.circle", "size.square"), fitted, np.full(10, -2.4), np.zeros(10, np.int64))
    # Both numbers count alike, and a fitted size grows with the size.
    np.testing.assert_allclose(model.line[0, :2], 0.5, rtol=1e-6)
    assert model.line[0] @ (-2.5, -2.5, 1) == pytest.approx(-2.4)
    unknown = fit_size_model(("size.circle",), np.full((3, 1), np.nan), np.full(3, -2.0), np.zeros(3, np.int64))
    assert np.isnan(unknown.line).all()
    assert not unknown.log_likelihood(np.array([-2.0]), np.array([-2.0, -1.0])).any()


@pytest.mark.parametrize("n", [1, 2, 3])
def test_several_grips_tell_a_size_less_than_so_many_times_as_well(n: int) -> None:
    rng = np.random.default_rng(6)
    sizes = rng.uniform(0.04, 0.12, 40).tolist()
    touches = ("one", "two", "three")
    library = Library.from_examples(
        {
            "ball": [
                [Evidence(t, {"f": rng.normal(), "size.circle": np.log(s) + rng.normal(0, 0.05)}) for t in touches]
                for s in sizes
            ]
        },
        sizes_m={"ball": sizes},
    )
    belief = Belief.before(library)
    for touch in touches[:n]:
        belief = belief.after(Evidence(touch, {"size.circle": np.log(0.07)}))
    middle, low, high = belief.size() or (0.0, 0.0, 0.0)
    assert middle == pytest.approx(0.07, rel=0.05)
    width = np.log(high / low)
    # One grip is off by .05, its interval four times that; n that err alike are as good as n / (1 + .6 (n - 1)).
    assert width == pytest.approx(4 * 0.05 / np.sqrt(n / (1 + 0.6 * (n - 1))), rel=0.45)
    assert low < middle < high


def test_the_size_of_an_object_that_the_library_does_not_know_is_refused(slippery: Library) -> None:
    with pytest.raises(InputError, match="the library has no 'egg'; it knows ball, box"):
        Belief.before(slippery).size("egg")


# Fusion


@few
@given(seeds, st.floats(0.1, 3))
def test_fusion_multiplies_powers_of_what_is_said_against_the_prior(seed: int, weight: float) -> None:
    rng = np.random.default_rng(seed)
    one, other, prior = rng.dirichlet(np.ones(3), 4), rng.dirichlet(np.ones(3), 4), rng.dirichlet(np.ones(3))
    got = np.exp(
        fuse({"a": np.log(one), "b": np.log(other)}, {"a": weight, "b": 1.0}, mixing=0.0, log_prior=np.log(prior))
    )
    wanted = prior * (one / prior) ** weight * (other / prior)
    np.testing.assert_allclose(got, wanted / wanted.sum(axis=1, keepdims=True), rtol=1e-9)


def test_a_mixing_weight_bounds_what_one_source_can_say() -> None:
    sure = np.log([[1 - 1e-12, 1e-12]])
    for mixing in (0.01, 0.2):
        p = np.exp(fuse({"a": sure}, mixing=mixing))[0]
        np.testing.assert_allclose(p, [1 - mixing / 2, mixing / 2], rtol=1e-6)
    both = np.exp(fuse({"a": sure, "b": sure[:, ::-1]}, mixing=0.1))[0]
    np.testing.assert_allclose(both, 0.5)
