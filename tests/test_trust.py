"""Laws of trust: p-values, folds and probabilities."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy.stats import binomtest, kstest

from varishold.errors import InputError
from varishold.trust import (
    Calibration,
    calibrate,
    conformal_p_value,
    difference_interval,
    group_folds,
    known_share,
    share_interval,
    strange_share,
)


def test_p_values_of_exchangeable_things_are_uniform() -> None:
    rng = np.random.default_rng(0)
    found = np.concatenate([conformal_p_value(rng.standard_cauchy(1), rng.standard_cauchy(199)) for _ in range(4000)])
    assert kstest(found, "uniform").pvalue > 0.01
    for error in (0.01, 0.05, 0.2):
        assert np.mean(found <= error) < error + 3 * np.sqrt(error / len(found))


@given(arrays(float, st.integers(1, 30), elements=st.integers(-3, 3)), st.integers(-4, 4))
def test_a_p_value_counts_what_is_at_least_as_strange(known: np.ndarray, strange: int) -> None:
    (found,) = conformal_p_value([strange], known)
    assert found == (1 + sum(known >= strange)) / (1 + len(known))


def test_a_p_value_needs_something_known() -> None:
    with pytest.raises(InputError, match="at least one known thing"):
        conformal_p_value([1.0], [])


@given(st.lists(st.integers(0, 3), min_size=1, max_size=12), st.integers(2, 6))
def test_folds_leave_every_class_something_to_learn_from(drawn: list[int], folds: int) -> None:
    labels = np.array([*drawn, *drawn])
    fold = group_folds(labels, folds=folds)
    for k in np.unique(fold):
        assert set(labels[fold != k]) == set(labels)
    assert len(np.unique(fold)) > 1


@given(st.integers(2, 5), st.integers(2, 7))
def test_a_session_is_never_split(n_classes: int, n_sessions: int) -> None:
    labels = np.tile(np.repeat(np.arange(n_classes), 2), n_sessions)
    session = np.repeat(np.arange(n_sessions), 2 * n_classes)
    fold = group_folds(labels, session)
    assert all(len(np.unique(fold[session == s])) == 1 for s in range(n_sessions))


def test_without_sessions_neighbours_are_held_out_together() -> None:
    assert group_folds(np.repeat(["a", "b"], 10), folds=5).tolist() == [0, 0, 1, 1, 2, 2, 3, 3, 4, 4] * 2
    # Each class has its own session: none can be held out.
    assert group_folds(np.repeat(["a", "b"], 4), np.repeat([1, 2], 4), folds=2).tolist() == [0, 0, 1, 1] * 2


def test_folds_tell_what_is_wrong() -> None:
    with pytest.raises(InputError, match="'b' has one press only: give each class at least two"):
        group_folds(["a", "a", "b"])
    with pytest.raises(InputError, match="groups must be one a press, 2 of them"):
        group_folds(["a", "a"], [1])


def test_calibrated_probabilities_are_as_often_right_as_they_say() -> None:
    rng = np.random.default_rng(1)
    truth = rng.integers(0, 4, 8000)
    # Scores that claim five times too much.
    scores = 5.0 * np.log(np.eye(4)[truth] + rng.gamma(0.4, 1.0, (8000, 4)))
    found = calibrate(scores[:4000], truth[:4000])
    p = found.probabilities(scores[4000:])
    right = p.argmax(axis=1) == truth[4000:]
    assert abs(p.max(axis=1).mean() - right.mean()) < 0.04
    sure = p.max(axis=1) > 0.9
    assert right[sure].mean() > 0.85


def test_probabilities_sum_to_one_and_a_class_that_a_fold_lacked_has_a_little() -> None:
    p = Calibration(2.0, 0.1).probabilities(np.array([[0.0, -np.inf], [1e4, -1e4]]))
    np.testing.assert_allclose(p.sum(axis=1), 1.0)
    np.testing.assert_allclose(p[:, 1], 0.05)


@given(total=st.integers(1, 500), data=st.data())
def test_the_interval_of_a_share_is_wilsons_and_holds_it(total: int, data: st.DataObject) -> None:
    counted = data.draw(st.integers(0, total))
    low, high = share_interval(counted, total)
    assert 0 <= low <= counted / total <= high <= 1
    want = binomtest(counted, total).proportion_ci(method="wilson")
    assert (low, high) == pytest.approx((want.low, want.high), abs=1e-12)


def test_nothing_counted_leaves_every_share_possible() -> None:
    assert share_interval(0, 0) == (0.0, 1.0)
    assert share_interval(0, 5)[0] == 0
    assert share_interval(5, 5)[1] == 1


@pytest.mark.parametrize("strangers", [0.0, 0.1, 0.4])
@pytest.mark.parametrize("power", [0.0, 0.3, 0.8, 0.98])
def test_of_all_things_a_share_is_strange_and_among_those_of_one_stated_share_as_many_are(
    power: float, strangers: float
) -> None:
    rng, significance, n = np.random.default_rng(7), 0.02, 40_000
    a = np.log(np.clip(power, significance, 1.0)) / np.log(significance)
    known = rng.random(n) >= strangers
    p_values = np.maximum(np.where(known, rng.random(n), rng.random(n) ** (1 / a)), 1e-300)
    stated = np.array([known_share(p, power, significance, strangers) for p in p_values])
    for low, high in ((0.0, 0.5), (0.5, 0.9), (0.9, 0.97), (0.97, 1.0)):
        inside = (stated >= low) & (stated <= high)
        if inside.sum() > 500:
            assert known[inside].mean() == pytest.approx(stated[inside].mean(), abs=0.03)


@given(st.floats(1e-6, 1.0), st.floats(1e-6, 1.0), st.floats(0.0, 1.0))
def test_what_is_stranger_is_known_no_more_likely(one: float, other: float, power: float) -> None:
    low, high = sorted((one, other))
    assert 0 <= known_share(low, power, 0.02, 0.1) <= known_share(high, power, 0.02, 0.1) <= 1
    # Tests that tell nothing leave nine of ten.
    assert known_share(low, 0.02, 0.02, 0.1) == pytest.approx(0.9)
    assert known_share(1.0, power, 0.02, 0.1) >= 0.9 - 1e-12


@pytest.mark.parametrize(
    ("n_known", "strangers", "error"), [(10, 0.1, 0.1), (300, 0.1, 0.008), (50, 0.5, 0.05), (10, 0.02, 0.1)]
)
def test_what_is_refused_is_strange_as_often_as_stated(n_known: int, strangers: float, error: float) -> None:
    """Where every stranger is odder than all that is known; less one, the p-value would promise .9 or more of each."""
    rng = np.random.default_rng(11)
    known = rng.normal(size=(4000, n_known))
    strange = rng.random(4000) < strangers
    felt = np.where(strange, 99.0, rng.normal(size=4000))
    p = np.array([conformal_p_value([one], of).item() for one, of in zip(felt, known, strict=True)])
    refused = p <= error
    stated = np.array([strange_share(each, strangers) for each in p[refused]])
    often = float(strange[refused].mean())
    assert stated.mean() == pytest.approx(often, abs=0.05)
    assert (1 - p[refused]).mean() > 0.89


def test_a_stranger_is_the_likelier_the_odder_and_the_commoner_it_is() -> None:
    for strangers in (0.01, 0.1, 0.6):
        told = [strange_share(p, strangers) for p in (0.001, 0.01, 0.1, 1.0)]
        assert told == sorted(told, reverse=True)
        assert told[-1] == pytest.approx(strangers)
        assert all(a < b for a, b in zip(told, [strange_share(p, 0.7) for p in (0.001, 0.01, 0.1, 1.0)], strict=True))
    # Where nobody else can come nothing is strange, however odd.
    assert strange_share(1e-9, 0.0) == 0.0


@given(st.integers(0, 40), st.integers(0, 40), st.integers(1, 60))
def test_an_interval_of_a_difference_is_what_mcnemars_test_does_not_reject(a: int, b: int, both: int) -> None:
    total = a + b + both
    low, high = difference_interval(a, b, total)
    assert -1 <= low <= (a - b) / total <= high <= 1
    assert (low, high) == pytest.approx(tuple(-end for end in reversed(difference_interval(b, a, total))))
    rejected = (a - b) ** 2 > 1.959963984540054**2 * (a + b)
    assert rejected == (low > 1e-12 or high < -1e-12)


@pytest.mark.parametrize(("a", "b", "total"), [(9, 2, 44), (4, 0, 60), (0, 3, 20), (12, 12, 24)])
def test_ends_of_a_difference_are_those_of_the_score_test(a: int, b: int, total: int) -> None:
    def score(difference: float) -> float:
        # The likeliest shares of things of which only one is true, under this difference, found by trying them all.
        low, high = max(0.0, -difference), (1 - difference) / 2
        only_other = np.linspace(low, high, 200_001)[1:-1]
        only_one = only_other + difference
        likely = a * np.log(only_one) + b * np.log(only_other)
        likely += (total - a - b) * np.log(np.maximum(1 - only_one - only_other, 1e-300))
        k = int(np.argmax(likely))
        variance = total * (only_one[k] + only_other[k] - difference**2)
        return float((a - b - total * difference) / np.sqrt(variance))

    low, high = difference_interval(a, b, total)
    for end, want in ((low, 1.96), (high, -1.96)):
        assert abs(end) < 1
        assert score(end) == pytest.approx(want, abs=2e-3)


def test_an_interval_of_no_difference_is_as_wide_as_wilsons_of_nothing() -> None:
    assert difference_interval(0, 0, 0) == (-1.0, 1.0)
    assert difference_interval(0, 0, 40)[1] == pytest.approx(share_interval(0, 40)[1])
