"""When a touch begins, how long it lasts, and what is none: by the noise, the time, and what was there before."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from varishold.touch import find_contacts
from varishold.touch.tracking.felt import feel
from varishold.touch.tracking.following import Following
from varishold.touch.tracking.touch import Touch

SIDE = 16
SIGMA = 1.0
NOTHING = np.zeros((SIDE, SIDE))


def patch(height: float, taxels: int = 6, row: int = 8, col: int = 8) -> np.ndarray:
    """Return a frame with so many taxels of a height, side by side in two rows."""
    frame = np.zeros((SIDE, SIDE))
    for k in range(taxels):
        frame[row + k % 2, col + k // 2] = height
    return frame


def follow(
    frames: list[np.ndarray], rate_hz: float = 200.0, *, may_begin: bool = True
) -> tuple[list[tuple[str, int, int]], Following]:
    """Return what begins and ends, as (word, number, frame), and who followed it."""
    following, found = Following(), []
    for k, frame in enumerate(frames):
        contacts = find_contacts(frame) if frame.any() else []
        begun, over = following.update(k / rate_hz, feel(contacts, SIGMA), frame, SIGMA, may_begin=may_begin)
        found += [("touched", touch.number, k) for touch in begun] + [("released", touch.number, k) for touch in over]
    return found, following


def words(found: list[tuple[str, int, int]]) -> list[tuple[str, int]]:
    return [(word, number) for word, number, _ in found]


@pytest.mark.parametrize(
    ("taxels", "height", "begins"),
    [
        *((3, 7, False), (3, 9, True), (6, 7, False), (6, 9, True)),
        *((2, 9, False), (2, 30, False), (2, 34, True), (1, 30, False), (1, 34, True)),
    ],
)
def test_a_touch_begins_where_it_stands_clear_of_the_noise(taxels: int, height: float, begins: bool) -> None:
    found, _ = follow([NOTHING] * 3 + [patch(height, taxels)] * 9)
    assert words(found) == [("touched", 1)] * begins


def test_nothing_begins_before_the_noise_is_known() -> None:
    assert follow([patch(100)] * 9, may_begin=False)[0] == []


@pytest.mark.parametrize(
    ("highest", "left", "lasts"), [(100, 6, True), (100, 4, False), (1000, 60, True), (1000, 40, False)]
)
def test_a_touch_lasts_until_it_is_nearly_gone(highest: float, left: float, lasts: bool) -> None:
    found, following = follow([NOTHING] + [patch(highest)] * 9 + [patch(left)] * 9)
    assert words(found) == [("touched", 1)] + [("released", 1)] * (not lasts)
    assert len(following.told) == lasts


@pytest.mark.parametrize("rate_hz", [25.0, 50.0, 100.0, 200.0, 250.0, 500.0, 1000.0, 4000.0])
def test_a_touch_is_told_by_frames_and_by_time(rate_hz: float) -> None:
    """After two frames and four milliseconds; over after two frames without it and ten milliseconds since the last."""
    n = 60
    found, _ = follow([NOTHING] * n + [patch(100)] * n + [NOTHING] * n, rate_hz)
    begins = max(1, math.ceil(0.004 * rate_hz - 1e-3))
    ends = max(2, math.ceil(0.010 * rate_hz - 1e-3))
    assert found == [("touched", 1, n + begins), ("released", 1, 2 * n - 1 + ends)]


@pytest.mark.parametrize(
    ("height", "after_s", "col", "begins"),
    [(100, 0.1, 8, False), (200, 0.1, 8, True), (100, 0.1, 2, True), (100, 0.9, 8, False), (100, 1.2, 8, True)],
)
def test_what_a_touch_has_left_is_none_for_a_second(height: float, after_s: float, col: int, begins: bool) -> None:
    rest = [NOTHING] * round(after_s * 200)
    found, _ = follow([NOTHING] + [patch(1000)] * 9 + rest + [patch(height, col=col)] * 9)
    assert words(found) == [("touched", 1), ("released", 1)] + [("touched", 2)] * begins


def test_a_frame_without_it_ends_no_touch() -> None:
    held = [patch(100)] * 9
    found, following = follow([*held, NOTHING, *held])
    assert words(found) == [("touched", 1)]
    # At a high rate many frames fit into ten milliseconds.
    assert words(follow([*held * 4, *[NOTHING] * 5, *held * 4], 1000.0)[0]) == [("touched", 1)]
    assert following.told[0].missed == 0


def test_a_touch_too_faint_for_a_contact_beside_another_lasts() -> None:
    """Where a frame still stands high under a touch, it is there."""
    both, rate_hz = patch(100) + patch(100, col=0), 200.0
    following = Following()
    for k in range(30):
        contacts = feel(find_contacts(both), SIGMA)
        felt = contacts if k < 10 else [one for one in contacts if one.position[0] > 0]
        _, over = following.update(k / rate_hz, felt, both, SIGMA, may_begin=True)
        assert over == []
    assert [touch.is_visible for touch in following.told].count(False) == 1
    # Where it has gone from the frame, too, it is over.
    alone = patch(100)
    ended: list[Touch] = []
    for k in range(30, 34):
        ended += following.update(k / rate_hz, feel(find_contacts(alone), SIGMA), alone, SIGMA, may_begin=True)[1]
    assert len(ended) == 1


# A bar, and what is left of it where its middle has gone.
WHOLE, PARTS = patch(100, 10, col=4), patch(100, 4, col=4) + patch(100, 4, col=9)
WHOLE[8:10, 6:11] = 100


@pytest.mark.parametrize(("lasts_s", "begins"), [(0.08, False), (0.12, True)])
def test_what_falls_off_is_a_touch_of_its_own_after_a_while(lasts_s: float, begins: bool) -> None:
    whole, parts = WHOLE, PARTS
    n = round(lasts_s * 200)
    found, following = follow([NOTHING] + [whole] * 40 + [parts] * n)
    assert words(found) == [("touched", 1)] + [("touched", 2)] * begins
    if begins:
        assert found[1][2] == 41 + 20
        assert following.told[1].onset_s == pytest.approx(41 / 200)
    else:
        # Until then it belongs to the touch that it fell off from.
        assert set(following.told[0].felt.taxels.tolist()) >= set(np.flatnonzero(parts).tolist())
        assert not following.told[0].is_whole


def test_what_has_fallen_off_and_comes_back_was_never_gone() -> None:
    whole, parts = WHOLE, PARTS
    found, following = follow([whole] * 20 + ([parts] * 10 + [whole] * 10) * 6)
    assert words(found) == [("touched", 1)]
    assert following.told[0].is_whole


@pytest.mark.parametrize(("apart", "later", "one"), [(2, 5, True), (3, 5, True), (5, 5, False), (2, 30, False)])
def test_what_comes_in_beside_a_touch_soon_after_it_may_be_its_part(apart: int, later: int, one: bool) -> None:
    """It waits a tenth of a second, whether both grow together by then; what is far, or later, does not wait."""
    first = patch(100, 6, col=2)
    both = first + patch(60, 6, col=5 + apart)
    found, _ = follow([NOTHING] + [first] * later + [both] * 60)
    assert words(found) == [("touched", 1), ("touched", 2)]
    waits = found[1][2] - (1 + later)
    assert waits == (20 if one else 1)
    grown = first + patch(60, 6 + 2 * apart, col=5)
    found, _ = follow([NOTHING] + [first] * later + [both] * 10 + [grown] * 30)
    # What was told and is one with the other a moment later was its part.
    assert words(found) == ([("touched", 1)] if one else [("touched", 1), ("touched", 2), ("released", 2)])
    found, following = follow([NOTHING] + [first] * later + [both] * 40 + [grown] * 30)
    assert words(found) == [("touched", 1), ("touched", 2)]
    assert [touch.is_merged for touch in following.told] == [True, True]


@given(st.permutations([2, 6, 11]), st.integers(1, 4))
@settings(max_examples=12)
def test_numbers_are_given_once_in_the_order_in_which_touches_are_told(cols: list[int], apart: int) -> None:
    frames, now = [NOTHING], NOTHING
    for col in cols:
        now = now + patch(100, 4, row=8, col=col)
        frames += [now] * (30 * apart)
    found, following = follow(frames + [NOTHING] * 9 + [patch(300)] * 9)
    assert words(found) == [*(("touched", k) for k in (1, 2, 3)), *(("released", k) for k in (1, 2, 3)), ("touched", 4)]
    assert [touch.number for touch in following.told] == [4]
    assert following.clear() == following.touches + following.told or following.touches == []


def test_what_is_cleared_is_forgotten() -> None:
    _, following = follow([NOTHING] + [patch(1000)] * 9)
    (touch,) = following.clear()
    assert (touch.number, following.touches, following.told) == (1, [], [])
    # Nothing is left of it: the next is told, however faint.
    begun = [
        following.update(9 + k / 200, feel(find_contacts(patch(20)), SIGMA), patch(20), SIGMA, may_begin=True)[0]
        for k in range(4)
    ]
    assert [len(each) for each in begun] == [0, 1, 0, 0]


@pytest.mark.parametrize("rate_hz", [50.0, 200.0, 1000.0])
def test_taxels_that_are_slow_to_let_go_are_no_touches(rate_hz: float) -> None:
    rng = np.random.default_rng(0)
    rows, cols = np.mgrid[:SIDE, :SIDE] - 7.5
    form = 200.0 * np.maximum(1.0 - np.hypot(rows, cols) / 6.0, 0.0)
    course = np.repeat([0.0, 1.0, 0.0, 1.0, 0.0], [int(s * rate_hz) for s in (0.2, 0.4, 1.5, 0.4, 0.4)])
    falls = np.exp(-1.0 / (rate_hz * rng.uniform(0.02, 0.4, (SIDE, SIDE))))
    frames, at = [], NOTHING
    for share in course:
        at = np.maximum(share * form, falls * at)
        frames.append(at + rng.normal(0.0, SIGMA, (SIDE, SIDE)))
    following, begun = Following(), []
    for k, frame in enumerate(frames):
        felt = feel(find_contacts(frame, sigma=SIGMA), SIGMA)
        new, _ = following.update(k / rate_hz, felt, frame, SIGMA, may_begin=True)
        begun += [k / rate_hz for _ in new]
    assert begun == pytest.approx([0.2, 2.1], abs=0.15)


def test_two_that_were_one_contact_are_both_told_though_they_ease_off_meanwhile() -> None:
    # Side by side they press as one contact; they part while both press less, and stay.
    both = [patch(200, 16, col=4) + patch(200, 16, col=8)] * 10
    frames = [NOTHING] * 5 + both
    frames += [patch(200 - 4 * k, 8, col=4 - (k > 4)) + patch(200 - 4 * k, 8, col=10) for k in range(8)]
    frames += [patch(168, 8, col=3) + patch(168, 8, col=10)] * 60
    found, following = follow(frames)
    assert words(found) == [("touched", 1), ("touched", 2)]
    assert len(following.told) == 2
