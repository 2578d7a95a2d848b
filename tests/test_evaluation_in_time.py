"""Laws of which presses are neighbours in time, and of the leaks that this shows."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from varishold.evaluation.held_out import Felt
from varishold.evaluation.in_time import in_order_of_time
from varishold.evaluation.leaks import find_leaks
from varishold.evaluation.splits import split_presses
from varishold.touch.course.presses import Press

DAY_S, NOW_S = 86_400.0, 1.7e9


def press(begins_s: float, seed: int = 0) -> Press:
    frames = np.random.default_rng(seed).uniform(0, 1, (4, 5, 5)) * np.arange(4)[:, None, None]
    return Press({"pad": frames}, {"pad": np.ones((5, 5), np.bool_)}, begins_s + np.arange(4) / 10)


@given(st.permutations(range(6)), st.sampled_from([1.0, 590.0]))
def test_recordings_that_follow_one_another_are_one_go_in_whatever_order_they_are_named(
    named: list[int], pause_s: float
) -> None:
    begins = [NOW_S + k * pause_s + (k >= 3) * DAY_S for k in named]
    order, goes = in_order_of_time([press(at) for at in begins], np.arange(6))
    assert np.array(named)[order].tolist() == [*range(6)]
    assert goes[order].tolist() == [0, 0, 0, 1, 1, 1]


@pytest.mark.parametrize("begins", [[0.0, 0.0, 0.0], [0.0, 0.2, 5.0]])
def test_recordings_that_overlap_have_clocks_of_their_own(begins: list[float]) -> None:
    runs = np.array(["a", "b", "c"])
    order, goes = in_order_of_time([press(at) for at in begins], runs)
    assert order.tolist() == [0, 1, 2]
    assert goes is runs


def test_without_times_presses_stay_as_they_stand() -> None:
    timeless = Press({"pad": np.ones((1, 3, 3))}, {"pad": np.ones((3, 3), np.bool_)})
    assert in_order_of_time([press(5.0), timeless], np.arange(2))[0].tolist() == [0, 1]
    assert in_order_of_time([], np.arange(0))[0].tolist() == []


def names_of(labels: list[str], groups: list[str] | None, begins: list[float]) -> list[str]:
    presses = [press(at, seed) for seed, at in enumerate(begins)]
    classes, codes = np.unique(labels, return_inverse=True)
    felt = Felt(presses, codes, classes, None if groups is None else np.array(groups))
    split = split_presses(np.array(labels), felt.groups)
    return [leak.name for leak in find_leaks(felt, split, np.arange(len(labels)), seed=0)]


def test_groups_that_take_turns_are_seen_in_files_of_one_press_each() -> None:
    labels, groups = [*"ab" * 6], [*"xxyy" * 3]
    close = [NOW_S + 20 * k for k in range(12)]
    assert "groups take turns" in names_of(labels, groups, close)
    assert "groups take turns" not in names_of(labels, groups, [0.0] * 12)
    # Each group is of a day of its own.
    assert "groups take turns" not in names_of(
        labels, [*"x" * 6, *"y" * 6], [at + DAY_S * (k > 5) for k, at in enumerate(close)]
    )
    # Three days, on each of which one group follows the other.
    assert "groups take turns" not in names_of(labels, groups, [at + DAY_S * (k // 4) for k, at in enumerate(close)])


def test_things_that_were_pressed_in_one_go_each_are_seen_in_files_of_one_press_each() -> None:
    labels = [*"a" * 6, *"b" * 6]
    assert "one session a thing" in names_of(labels, None, [NOW_S + 20 * k for k in range(12)])
    assert "one session a thing" in names_of(labels, None, [NOW_S + 20 * k + DAY_S * (k > 5) for k in range(12)])
    assert "one session a thing" not in names_of(labels, None, [NOW_S + 20 * (k % 6) + 7 * (k > 5) for k in range(12)])
    assert "one session a thing" not in names_of(labels, None, [NOW_S + 20 * k + DAY_S * (k % 2) for k in range(12)])
