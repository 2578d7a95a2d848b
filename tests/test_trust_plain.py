"""Calibration and folds beside a plain search and plain counting."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from varishold.errors import InputError
from varishold.trust import Calibration, calibrate, conformal_p_value, group_folds
from varishold.trust.folds import kept_together, same_partition

TEMPERATURES = [0.25 * 256 ** (k / 64) for k in range(65)]
MIXINGS = [0.001, 0.003, 0.01, 0.02, 0.05, 0.1, 0.2]


def probability(scores: np.ndarray, temperature: float, mixing: float) -> np.ndarray:
    out = []
    for row in scores:
        top = max(row)
        share = [math.exp((score - top) / temperature) for score in row]
        out.append([(1 - mixing) * one / sum(share) + mixing / len(row) for one in share])
    return np.array(out)


@pytest.mark.parametrize("scale", [0.3, 3.0, 40.0, 2000.0])
def test_of_many_classes_the_calibration_is_the_one_of_plain_exponentials(scale: float) -> None:
    rng = np.random.default_rng(7)
    truth = rng.integers(0, 200, 400)
    scores = scale * (rng.normal(0, 1, (400, 200)) + 2 * np.eye(200)[truth])
    below = scores - scores.max(axis=1, keepdims=True)
    losses = {}
    for temperature in np.geomspace(0.25, 64.0, 65).tolist():
        odds = np.exp(below / temperature)
        share = odds[np.arange(400), truth] / odds.sum(axis=1)
        losses |= {(temperature, m): float(-np.log(m / 200 + (1 - m) * share).sum()) for m in MIXINGS}
    found = calibrate(scores, truth)
    assert (found.temperature, found.mixing) == min(losses, key=lambda of: losses[of])


@given(st.integers(0, 2**31), st.sampled_from([0.02, 0.3, 3.0, 60.0, 500.0]), st.sampled_from([0.0, 0.03, 0.5]))
@settings(max_examples=12, deadline=None)
def test_a_calibration_is_the_best_of_the_grid(seed: int, scale: float, wrong: float) -> None:
    rng = np.random.default_rng(seed)
    truth = rng.integers(0, 3, 12)
    scores = scale * (2 * np.eye(3)[truth] + rng.normal(0, 1, (12, 3)))
    scores[rng.random(12) < wrong] *= -1
    # What a fold did not know tells nothing of its truth, and is no score for others.
    scores[0, truth[0]] = -np.inf
    scores[1, (truth[1] + 1) % 3] = -np.inf
    known = np.isfinite(scores[np.arange(12), truth])
    found = calibrate(scores, truth)
    losses = {
        (t, m): -sum(math.log(p[k]) for p, k in zip(probability(scores[known], t, m), truth[known], strict=True))
        for t in TEMPERATURES
        for m in MIXINGS
    }
    assert found.mixing in MIXINGS
    assert min(abs(found.temperature / t - 1) for t in TEMPERATURES) < 1e-9
    own = -sum(
        math.log(p[k])
        for p, k in zip(probability(scores[known], found.temperature, found.mixing), truth[known], strict=True)
    )
    assert own == pytest.approx(min(losses.values()), rel=1e-9)
    np.testing.assert_allclose(found.probabilities(scores), probability(scores, found.temperature, found.mixing))


def test_the_ends_of_the_grid_are_reached() -> None:
    # Scores that are right and too small, and scores that are wrong as often as can be.
    sharp = calibrate(0.05 * np.eye(2)[np.zeros(50, int)], np.zeros(50, int))
    assert (sharp.temperature, sharp.mixing) == (0.25, 0.001)
    lost = calibrate(1e6 * np.eye(2)[np.zeros(50, int)], np.ones(50, int))
    assert lost.mixing == 0.2
    flat = calibrate(400.0 * np.eye(2)[np.arange(100) % 2], np.arange(100) // 2 % 2)
    assert flat.temperature == pytest.approx(64.0)
    # Of what does equally well, the first of the grid.
    assert calibrate(np.zeros((8, 2)), np.zeros(8, int)) == Calibration(0.25, 0.001)
    # Nothing known: what is plain.
    nothing = calibrate(np.full((3, 2), -np.inf), np.zeros(3, int))
    assert nothing == Calibration(1.0, 0.01)


@given(
    st.lists(st.integers(0, 2), min_size=1, max_size=10),
    st.lists(st.integers(0, 3), min_size=20, max_size=20),
    st.integers(2, 5),
)
def test_groups_are_dealt_in_turn_where_every_class_can_still_be_learned(
    drawn: list[int], groups: list[int], folds: int
) -> None:
    labels = np.array([*drawn, *drawn])
    given_ = np.array(groups[: len(labels)])
    order = sorted(set(given_.tolist()))
    every = set(labels.tolist())

    def whole(dealt: np.ndarray) -> bool:
        held = set(dealt.tolist())
        return len(held) > 1 and all(set(labels[dealt != k].tolist()) == every for k in held)

    ways = [np.array([order.index(group) % n for group in given_]) for n in range(folds, 1, -1)]
    good = [dealt for dealt in ways if whole(dealt)]
    fold = group_folds(labels, given_, folds=folds)
    if good:
        np.testing.assert_array_equal(fold, good[0])
        assert kept_together(fold, given_)
    else:
        np.testing.assert_array_equal(fold, group_folds(labels, folds=folds))
    assert fold.dtype == np.intp
    assert kept_together(fold, given_) == all(
        len({int(f) for f, g in zip(fold, given_, strict=True) if g == group}) == 1 for group in order
    )


@given(st.lists(st.integers(0, 3), min_size=1, max_size=12), st.integers(2, 9))
def test_without_groups_each_class_is_cut_in_blocks_of_neighbours(drawn: list[int], folds: int) -> None:
    labels = np.array([*drawn, *drawn])
    fold = group_folds(labels, folds=folds)
    most = min(folds, max(np.bincount(labels)))
    for label in set(drawn):
        of = fold[labels == label]
        assert (np.diff(of) >= 0).all()
        n = min(most, len(of))
        assert sorted(set(of.tolist())) == list(range(n))
        sizes = np.bincount(of)
        assert sizes.max() - sizes.min() <= 1
    assert group_folds([]).shape == (0,)


@given(st.lists(st.integers(0, 2), min_size=1, max_size=8), st.lists(st.integers(0, 2), min_size=8, max_size=8))
def test_two_lists_part_alike_where_equal_names_go_with_equal_names(one: list[int], other: list[int]) -> None:
    second = other[: len(one)]
    pairs = set(zip(one, second, strict=True))
    told = len(pairs) == len(set(one)) == len(set(second))
    assert same_partition(one, second) == told
    assert not same_partition(one, [*second, 0])


def test_a_p_value_is_of_one_row_of_known_things() -> None:
    with pytest.raises(InputError, match=r"got shape \(1, 2\)"):
        conformal_p_value([1.0], [[1.0, 2.0]])
    assert conformal_p_value([2.0, 2.5], [2.0]).tolist() == [1.0, 0.5]


@pytest.mark.parametrize("mixing", MIXINGS)
def test_the_share_of_answers_about_nothing_is_found(mixing: float) -> None:
    wrong = round(mixing / 2 * 2000)
    truth = (np.arange(2000) < wrong).astype(int)
    assert calibrate(np.tile([1e4, 0.0], (2000, 1)), truth).mixing == mixing


def test_there_are_five_folds_unless_others_are_asked_for() -> None:
    assert group_folds(np.repeat(["a", "b"], 10)).tolist() == [0, 0, 1, 1, 2, 2, 3, 3, 4, 4] * 2
    assert (
        group_folds(np.tile(["a", "b"], 7), np.repeat(np.arange(7), 2)).tolist()
        == np.repeat([0, 1, 2, 3, 4, 0, 1], 2).tolist()
    )


def test_sessions_of_a_class_that_would_fall_together_are_dealt_to_fewer_folds() -> None:
    labels, sessions = np.repeat(np.arange(5), 4), np.repeat(np.arange(10) % 2 * 5 + np.arange(10) // 2, 2)
    fold = group_folds(labels, sessions)
    assert kept_together(fold, sessions)
    assert fold.tolist() == (sessions % 4).tolist()


def test_groups_that_are_all_one_are_no_fold() -> None:
    assert group_folds(["a", "a", "b", "b"], [1, 1, 1, 1]).tolist() == [0, 1, 0, 1]


def test_lists_of_different_lengths_part_nothing_alike() -> None:
    assert not same_partition(["a", "b"], ["a", "b", "a"])
    assert not same_partition(["a"], [])


def test_what_is_told_of_folds_names_the_rarest_class() -> None:
    with pytest.raises(InputError) as told:
        group_folds(["a", "a", "b", "c", "c", "c"])
    assert str(told.value) == "'b' has one press only: give each class at least two"
    with pytest.raises(InputError) as told:
        group_folds(["a", "a"], [1, 2, 3])
    assert str(told.value) == "groups must be one a press, 2 of them, got (3,)"
