"""Laws of a recording's health: what is dead, stuck, saturated or upside down, against plain counting."""

from __future__ import annotations

import numpy as np
import pytest

from varishold import Pad
from varishold.errors import InputError
from varishold.frame.checks import as_floor
from varishold.frame.health import (
    Extent,
    broken_taxels,
    dead_taxels,
    extent_of,
    full_scale,
    remarks_of,
    stuck_taxels,
    taxels_in_words,
)

ALL = np.ones((10, 10), bool)


def noisy(n_frames: int = 12, seed: int = 0) -> np.ndarray:
    return np.random.default_rng(seed).uniform(1.0, 5.0, (n_frames, 10, 10))


def extent(frames: np.ndarray, usable: np.ndarray = ALL, *, signed: bool = False) -> Extent:
    """Return the extent, looked at in three blocks."""
    starts = [0, len(frames) // 3, len(frames) // 2]
    blocks = zip(starts, np.split(frames, starts[1:]), strict=True)
    return extent_of(((at, block) for at, block in blocks if len(block)), usable, signed=signed)


@pytest.mark.parametrize("kind", [np.float64, np.float32, np.int16, np.uint8])
def test_the_extent_is_the_lowest_and_the_highest_of_all_frames(kind: type) -> None:
    frames = (20 * noisy()).astype(kind)
    seen = extent(frames)
    np.testing.assert_array_equal(seen.low, frames.min(axis=0))
    np.testing.assert_array_equal(seen.high, frames.max(axis=0))


def test_what_is_not_finite_is_named_where_it_stands_and_only_on_usable_taxels() -> None:
    frames = noisy()
    frames[7, 3, 4] = np.inf
    with pytest.raises(InputError, match=r"\(row, col\) = \(3, 4\) of frame 7"):
        extent(frames)
    usable = ALL.copy()
    usable[3, 4] = False
    assert extent(frames, usable).high[0, 0] == frames[:, 0, 0].max()
    with pytest.raises(InputError, match="is the file damaged"):
        extent(frames.clip(max=1) * 1e101)
    with pytest.raises(InputError, match="is the file damaged"):
        extent(np.where(np.isfinite(frames), -frames, 0) * 1e100, signed=True)


def test_a_recording_upside_down_is_refused_but_not_noise_nor_one_broken_taxel() -> None:
    frames = noisy()
    with pytest.raises(InputError, match=r"1200 values below 0, 0 above; .*polarity = 'down'"):
        extent(-frames)
    extent(-frames, signed=True)
    rng = np.random.default_rng(1)
    extent(rng.normal(-0.1, 1.0, frames.shape))
    one = frames.copy()
    one[:, 2, 2] = -1e6
    extent(one)
    two = one.copy()
    two[:, 5, 5] = -1e6
    with pytest.raises(InputError, match="24 values below 0, 1176 above"):
        extent(two)
    # As deep as high, or outweighed by little: no polarity can be told.
    extent(np.concatenate([frames, -frames]))
    extent(np.concatenate([frames, -1.9 * frames]))
    with pytest.raises(InputError, match="mostly negative"):
        extent(np.concatenate([frames, -2.1 * frames]))
    with pytest.raises(InputError, match="mostly negative"):
        extent_of([(0, np.array([[[-5.0, 1.0]]]))], np.ones((1, 2), bool))


def test_a_taxel_is_dead_or_stuck_where_the_others_live_and_the_recording_is_long_enough() -> None:
    frames = noisy(8)
    frames[:, 1, 1], frames[:, 2, 3] = 0.0, 4.5
    seen = extent(frames)
    dead, stuck = dead_taxels(seen, ALL, 8), stuck_taxels(seen, ALL, 8)
    assert np.argwhere(dead).tolist() == [[1, 1]]
    assert np.argwhere(stuck).tolist() == [[2, 3]]
    np.testing.assert_array_equal(broken_taxels(seen, ALL, np.float64, 8), dead | stuck)
    assert not dead_taxels(seen, ALL, 7).any()
    assert not stuck_taxels(seen, ALL, 7).any()
    gone = ALL.copy()
    gone[1, 1] = gone[2, 3] = False
    assert not broken_taxels(seen, gone, np.float64, 8).any()


@pytest.mark.parametrize(("n_still", "told"), [(10, True), (11, False)])
def test_more_than_a_tenth_that_are_still_are_no_fault(n_still: int, told: bool) -> None:
    frames = noisy()
    # No two of them in a line.
    places = np.arange(0, 100, 9)[:n_still]
    frames.reshape(12, -1)[:, places] = 0.0
    assert np.count_nonzero(dead_taxels(extent(frames), ALL, 12)) == n_still * told
    frames.reshape(12, -1)[:, places] = 2.0
    assert np.count_nonzero(broken_taxels(extent(frames), ALL, np.float64, 12)) == n_still * told
    assert np.count_nonzero(stuck_taxels(extent(frames), ALL, 12)) == n_still
    assert not stuck_taxels(extent(np.ones((12, 10, 10))), ALL, 12).any()


@pytest.mark.parametrize("highest", [127, 255, 1023, 4095, 16383, 32767])
def test_whole_numbers_are_saturated_at_the_full_scale_of_a_converter(highest: int) -> None:
    frames = noisy().astype(np.int32)
    frames[3, 4, 4] = highest
    assert full_scale(extent(frames), ALL, np.int32) == highest
    assert remarks_of(extent(frames), ALL, np.int32, 12) == (f"taxel (4, 4) reaches full scale, {highest}: saturated",)
    frames[3, 4, 4] = highest - 1
    assert full_scale(extent(frames), ALL, np.int32) is None
    assert remarks_of(extent(frames), ALL, np.int32, 12) == ()
    # One that stands there all the time may be pressed all the time.
    frames[:, 4, 4] = highest
    assert not broken_taxels(extent(frames), ALL, np.int32, 12).any()


def test_floats_are_saturated_where_several_reach_exactly_the_same() -> None:
    for side, enough in ((10, 2), (20, 4)):
        usable = np.ones((side, side), bool)
        for n in range(1, 6):
            frames = np.random.default_rng(n).uniform(0, 1, (9, side, side))
            frames.reshape(9, -1)[4, :n] = 1.5
            seen = extent_of([(0, frames)], usable)
            assert (full_scale(seen, usable, np.float64) == 1.5) == (n >= enough)
            said = [remark for remark in remarks_of(seen, usable, np.float64, 9) if "saturated, or flat" in remark]
            assert len(said) == (n >= enough)


@pytest.mark.parametrize("divided_by", [1.0, 3.7, 255.0])
@pytest.mark.parametrize("counts", [6, 20, 100])
def test_counts_that_stand_as_floats_are_not_saturated_where_they_happen_to_be_highest(
    counts: int, divided_by: float
) -> None:
    frames = np.random.default_rng(0).integers(0, counts + 1, (12, 10, 10)) / divided_by
    frames[3, 2:4, 2:4] = counts / divided_by
    assert full_scale(extent(frames), ALL, np.float64) is None
    frames[3, 2:4, 2:4] = 255 / divided_by
    assert full_scale(extent(frames), ALL, np.float64) == 255 / divided_by


@pytest.mark.parametrize("kind", [np.float32, np.float64])
def test_a_step_that_no_converter_has_is_none(kind: type) -> None:
    frames = np.random.default_rng(0).uniform(0.0, 1.0, (12, 10, 10)).astype(kind)
    frames[:, 0, 0] = np.nextafter(kind(0), kind(1))
    frames[3, 2:4, 2:4] = 1.5
    assert full_scale(extent(frames), ALL, kind) == 1.5


@pytest.mark.parametrize("full", [255, 4095, 1.0])
def test_what_always_stands_at_full_scale_is_stuck_only_alone_beside_what_comes_and_goes(full: float) -> None:
    kind = np.float64 if full == 1.0 else np.int32
    course = np.concatenate([np.zeros(6), np.linspace(0, 0.8, 8), np.zeros(4)])
    pressed = np.zeros((10, 10))
    pressed[2:6, 2:6] = 1.0
    still = course[:, None, None] * pressed * full + np.random.default_rng(0).uniform(0, 0.03 * full, (18, 10, 10))

    def broken(rows: object, cols: object) -> np.ndarray:
        frames = still.astype(kind)
        frames[:, rows, cols] = full
        return broken_taxels(extent(frames), ALL, kind, len(frames))

    # Of floats one taxel alone tells of no full scale, and is stuck wherever it stands.
    for at in ((3, 3), (1, 1), (6, 4)):
        assert np.argwhere(broken(*at)).tolist() == [list(at)]
    assert broken(8, 8)[8, 8] == (full == 1.0)
    # A line is; what is broad, or far from all that is pressed, may have been pressed all the time.
    assert broken(3, slice(None)).sum() == 10
    assert not broken(slice(3, 5), slice(3, 5)).any()
    assert not broken(9, slice(None)).any()


def test_remarks_name_each_oddity_once() -> None:
    frames = noisy()
    frames[:, 1, 1], frames[:, 2, 3] = 0.0, 4.5
    assert remarks_of(extent(frames), ALL, np.float64, 12) == (
        "taxel (2, 3) never changes its value: stuck; mark it in valid",
        "taxel (1, 1) is always 0 while nearly all others are not: dead or never touched",
    )
    still = np.full((12, 10, 10), 3.0)
    assert remarks_of(extent(still), ALL, np.float64, 12) == ("nothing changes: every value of every frame is 3",)


def test_many_taxels_are_counted_after_four() -> None:
    mask = np.zeros((3, 3), bool)
    for n, words in ((1, "taxel (0, 0)"), (2, "each of 2 taxels ((0, 0), (0, 1))")):
        mask.flat[:n] = True
        assert taxels_in_words(mask) == words
    mask.flat[:4] = True
    assert taxels_in_words(mask) == "each of 4 taxels ((0, 0), (0, 1), (0, 2), (1, 0))"
    mask.flat[:6] = True
    assert taxels_in_words(mask) == "each of 6 taxels ((0, 0), (0, 1), (0, 2), (1, 0) and 2 more)"


def test_no_floor_is_told_from_any_floor() -> None:
    assert as_floor(None) == -1.0
    assert as_floor(0) == 0.0
    for wrong in (-1e-9, np.inf, np.nan, "much", 10**400):
        with pytest.raises(InputError, match="finite and not negative"):
            as_floor(wrong)  # type: ignore[arg-type]


def test_where_taxels_lack_some_readings_it_is_said_what_that_may_mean() -> None:
    frames = np.where(np.arange(20)[:, None, None] % 2, np.full((20, 4, 4), np.nan), 3.0)
    with pytest.raises(InputError, match="mark dead taxels in valid; where NaN means that nothing touches, write 0"):
        Pad(frames)
    frames = np.ones((20, 4, 4))
    frames[:, 1, 1] = np.nan
    with pytest.raises(InputError, match=r"mark dead taxels in valid$"):
        Pad(frames)


@pytest.mark.parametrize("value", [0.0, 7.0])
@pytest.mark.parametrize("every", [2, 3, 5])
@pytest.mark.parametrize("columns", [False, True])
def test_lines_between_others_that_say_nothing_are_broken_however_many(value: float, every: int, columns: bool) -> None:
    frames = np.random.default_rng(0).normal(50.0, 1.0, (40, 15, 15))
    frames[20:30, 4:11, 4:11] += 100.0
    lines = np.arange(15) % every == 1
    out = np.broadcast_to(lines[None, :] if columns else lines[:, None], (15, 15))
    frames[:, out] = value
    assert np.array_equal(Pad(frames).broken, out)
    # Where readings are cut off at 0 most taxels say nothing as long as nothing touches.
    assert not Pad(np.where(frames > 60.0, frames, 0.0)).broken.any()


def test_half_a_pad_that_says_nothing_is_not_filled() -> None:
    frames = np.random.default_rng(0).normal(50.0, 1.0, (40, 16, 16))
    frames[20:30, 4:11, 4:11] += 100.0
    frames[:, 8:] = 0.0
    assert not Pad(frames).broken.any()


def _quiet_counts(side: int, noise: float, seed: int) -> tuple[np.ndarray, tuple[int, int]]:
    """Return whole counts of eight round presses far from some corners, and a taxel in the midst of one."""
    rng = np.random.default_rng(seed)
    rows, cols = np.mgrid[:side, :side]
    ramp = np.r_[
        np.sin(np.arange(1, 5) / 10 * np.pi), np.ones(8), np.sin(np.arange(4, 0, -1) / 10 * np.pi), np.zeros(10)
    ]
    frames = [np.zeros((10, side, side))]
    for _ in range(8):
        row, col = rng.integers(2, side - 2, 2)
        reach = rng.uniform(2.5, 2.5 + side / 12)
        bump = np.clip(1.5 - np.hypot(rows - row, cols - col) / reach, 0.0, 1.0)
        frames.append(ramp[:, None, None] * bump * 180.0)
    counts = 12.0 + np.concatenate(frames)
    return np.rint(counts + noise * rng.normal(size=counts.shape)).astype(np.uint8), (int(row), int(col))


@pytest.mark.parametrize("side", [8, 16, 32])
@pytest.mark.parametrize("noise", [0.1, 0.18, 0.25, 0.35, 0.5])
def test_of_quiet_whole_numbers_only_what_stays_still_amid_what_is_pressed_is_broken(side: int, noise: float) -> None:
    for seed in range(6):
        frames, (row, col) = _quiet_counts(side, noise, seed)
        pad = Pad(frames)
        assert not pad.broken.any()
        assert not pad.remarks
        for value, word in ((0, "always 0"), (12, "never changes"), (40, "never changes")):
            frames[:, row, col] = value
            pad = Pad(frames)
            assert np.argwhere(pad.broken).tolist() == [[row, col]]
            assert [word in remark for remark in pad.remarks] == [True]


@pytest.mark.parametrize("noise", [0.1, 0.18])
def test_of_quiet_whole_numbers_that_nothing_presses_no_taxel_is_stuck(noise: float) -> None:
    frames = np.rint(12 + noise * np.random.default_rng(0).normal(size=(300, 16, 16))).astype(np.uint8)
    assert not Pad(frames).broken.any()
    assert not any("stuck" in remark for remark in Pad(frames).remarks)


def test_a_corner_of_what_is_pressed_may_stay_still() -> None:
    frames = np.full((60, 8, 8), 12, np.uint8)
    frames[20:40, :5, :5] += 90
    frames[:, 0, 0] = 12
    assert not Pad(frames).broken.any()
    assert not Pad(frames).remarks
