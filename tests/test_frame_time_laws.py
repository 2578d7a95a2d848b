"""The noise of a recording against a slow reference, the limits of every validator, and what a remark counts."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from varishold.errors import InputError
from varishold.frame import frame_noise, recording_noise
from varishold.frame.checks import (
    as_array,
    as_floats,
    as_floor,
    as_levels,
    as_numbers,
    as_pitch,
    as_usable,
    as_valid,
    beyond_reading,
    falling,
)
from varishold.frame.floor import noise_reach
from varishold.frame.health import extent_of, full_scale, remarks_of, stuck_taxels
from varishold.frame.quiet import off_plane, timed_noise
from varishold.kernel import bind

timed_floor = bind("vh_timed_floor", "dd", "d")


def spread_over(n, most):
    """At most so many of the numbers 0 to n - 1, evenly."""
    return sorted({int(k * (n - 1) / (most - 1)) for k in range(most)}) if n > 1 else [0]


def unloaded(frames, usable, *, uneven=False):
    """Sigma of the changes between the quietest quarter of pairs; None where they are loaded or show nothing.

    With `uneven` what is the same in 16 frames and more is no load.
    """
    pairs = [
        (frames[i][usable].astype(float), frames[i + 1][usable].astype(float))
        for i in spread_over(len(frames) - 1, 256)
    ]
    ranked = sorted(range(len(pairs)), key=lambda k: (max(pairs[k][0].sum(), pairs[k][1].sum()), k))
    quiet = [pairs[k] for k in ranked[: max(len(pairs) // 4, 4)]]
    zeros = [float(a == 0 and b == 0) for before, after in quiet for a, b in zip(before, after, strict=True)]
    if sum(zeros) / len(zeros) > 0.5:
        return None
    changes = []
    for before, after in quiet:
        change = (after - before) / math.sqrt(2)
        changes += np.abs(change - np.median(change)).tolist()
    sigma = float(np.median(changes)) / 0.6744897501960817
    reach = np.median([np.abs(before - np.median(before)).max() for before, _ in quiet])
    if uneven and len(quiet) >= 16:
        same = np.median([before for before, _ in quiet], axis=0)
        reach = min(reach, np.median([np.abs(before - same).max() for before, _ in quiet]))
    if sigma == 0 or reach > 6 * sigma:
        return None
    return max(sigma, 1 / math.sqrt(12)) if frames.dtype.kind in "iu" else sigma


def differences(frames, usable):
    """The lower quartile of what differences of successive frames show, form taken out."""
    found = []
    for i in spread_over(len(frames) - 1, 64):
        before, after = frames[i].astype(float), frames[i + 1].astype(float)
        hidden = (before == after) & (before == before[usable].min())
        sigma = frame_noise(after - before, valid=usable & ~hidden) / math.sqrt(2)
        if sigma > 0:
            found.append(sigma)
    if len(found) < 4:
        return None
    quieter = float(np.quantile(found, 0.25))
    return max(quieter, 1 / math.sqrt(12)) if frames.dtype.kind in "iu" else quieter


def drawn(rng, n, kind):
    y, x = np.ogrid[:9, :11]
    bump = np.maximum(1 - np.hypot(x - 5, y - 4) / 4, 0)
    noise = rng.normal(0, 0.5, (n, 9, 11))
    load = {"quiet": 0.0, "press": np.maximum(np.sin(np.arange(n) / 3), 0), "held": 1 + 0.1 * np.arange(n)}[kind[0]]
    frames = noise + 20 * np.asarray(load).reshape(-1, 1, 1) * bump
    if kind[1] == "uneven":
        frames = frames + rng.normal(0, 8, (9, 11))
    if kind[1] == "zeros":
        frames = np.where(frames > 1.2, frames, 0.0)
    if kind[1] == "whole":
        frames = np.rint(0.3 * frames + 40).astype(np.int16)
    return frames


KINDS = [(load, way) for load in ("quiet", "press", "held") for way in ("plain", "uneven", "zeros", "whole")]


@given(st.integers(0, 2**31), st.sampled_from([1, 4, 7, 8, 9, 20, 65, 66, 67, 300]), st.sampled_from(KINDS))
@settings(max_examples=60)
def test_noise_in_time_is_that_of_the_reference(seed, n, kind):
    rng = np.random.default_rng(seed)
    frames = drawn(rng, n, kind)
    usable = rng.random((9, 11)) > 0.05
    quiet = unloaded(frames, usable) if n >= 8 else None
    if quiet is None:
        chosen = [frames[i] for i in spread_over(n, 64)]
        loaded = [frame_noise(f, valid=usable) for f in chosen if np.ptp(f[usable]) > 0]
        expected = float(np.median(loaded)) if loaded else 0.0
        timed = unloaded(frames, usable, uneven=True) if n >= 8 else None
        timed = differences(frames, usable) if n >= 8 and timed is None else timed
    else:
        expected = timed = quiet
    assert recording_noise(frames, valid=usable) == pytest.approx(expected, rel=1e-9)
    got = timed_noise(frames, field=usable)
    assert (got is None) == (timed is None)
    if timed is not None:
        assert got == pytest.approx(timed, rel=1e-9)


def test_without_taxels_there_is_no_noise():
    frames = np.random.default_rng(0).normal(size=(20, 5, 6))
    nowhere = np.zeros((5, 6), bool)
    assert recording_noise(frames, valid=nowhere) == 0
    assert timed_noise(frames, field=nowhere) is None
    assert timed_noise(frames[:7]) is None
    assert timed_noise(frames[:8]) is not None
    # What never changes shows no noise.
    assert timed_noise(np.ones((20, 5, 6))) is None
    assert timed_noise(np.zeros((20, 5, 6), int)) is None


@given(st.floats(-5, 5), st.floats(-2, 2), st.floats(-2, 2), st.integers(0, 2**31))
def test_what_no_slope_explains(offset, down, right, seed):
    rng = np.random.default_rng(seed)
    row, col = np.mgrid[:7, :9]
    usable = rng.random((7, 9)) > 0.2
    own = rng.normal(size=(7, 9))
    off = off_plane(own + offset + down * row + right * col, usable)
    # It is the same whatever slope is added, sums up to nothing along each, and is nothing elsewhere.
    np.testing.assert_allclose(off, off_plane(own, usable), atol=1e-9)
    for along in (1, row, col):
        assert (off * along).sum() == pytest.approx(0, abs=1e-8)
    assert not off[~usable].any()
    np.testing.assert_allclose(off_plane(np.where(usable, off, 99.0), usable), off, atol=1e-9)


# ---- limits


@pytest.mark.parametrize("n", [1, 2, 1 << 16])
def test_so_many_levels_are_taken(n):
    assert as_levels(n)[0] == n
    assert as_levels(np.int32(n))[1].size == 0
    count, thresholds = as_levels(np.arange(float(n)))
    assert (count, len(thresholds)) == (0, n)
    if n < 9:
        assert as_levels(list(range(n)))[1].tolist() == list(range(n))[::-1]


TOO_MANY = (1 << 16) + 1


@pytest.mark.parametrize(
    "levels", [0, -1, TOO_MANY, np.arange(1.0 * TOO_MANY), np.arange(TOO_MANY), [], [[1.0]], True, ["a"], 1.5, None]
)
def test_levels_that_cannot_be_are_refused(levels):
    with pytest.raises(InputError, match="levels must be"):
        as_levels(levels)


def test_thresholds_fall():
    given = np.array([1.0, 3.0, 2.0])
    assert falling(given).tolist() == [3.0, 2.0, 1.0]
    assert given.tolist() == [1.0, 3.0, 2.0]
    # What compiled code takes comes back as it is; all else sorted.
    assert as_levels(given)[1] is given
    assert as_levels([1, 3, 2])[1].tolist() == [3.0, 2.0, 1.0]
    assert as_levels(given.astype(np.float32))[1].dtype == np.float64
    with pytest.raises(InputError, match="levels must be finite"):
        falling(np.array([1.0, np.nan]))


def test_what_is_no_number_is_an_empty_array():
    for wrong in ("wide", [1, [2]], None, 10**400, object()):
        assert as_array(wrong).size in (0, 1)
    assert as_array("wide").shape == (0,)
    assert as_array([1, 2]).tolist() == [1.0, 2.0]
    source = np.array([1.0])
    as_array(source)[0] = 5
    assert source[0] == 1.0


@pytest.mark.parametrize("pitch", [1e-9, 1e3, [0.001, 0.002], np.array(0.5), np.array([[0.5]])])
def test_pitches_within_reach(pitch):
    if np.ndim(pitch) == 2:
        with pytest.raises(InputError, match="pitch_m must be one spacing"):
            as_pitch(pitch)
        return
    row, col = as_pitch(pitch)
    assert (row, col) == (np.ravel(pitch)[0], np.ravel(pitch)[-1])
    with pytest.raises(InputError, match="mine must be one spacing"):
        as_pitch(2000.0, "mine")


def test_floors_and_frames_that_are_ready_are_not_copied():
    assert as_floor(0.25) == 0.25
    assert as_floor(np.float32(0.5)) == 0.5
    with pytest.raises(InputError, match="sigma must be finite and not negative, got -1"):
        as_floor(-1, "sigma")
    ready = np.ones((3, 4))
    assert as_floats(ready, 2, "a frame") is ready
    for other in (ready.T, ready[:, ::2], ready.astype(np.float32), ready.astype(">f8"), [[1, 2]]):
        got = as_floats(other, 2, "a frame")
        assert got is not other
        assert got.flags.carray
        assert got.dtype == np.float64
        np.testing.assert_array_equal(got, other)
    with pytest.raises(InputError, match=r"frames must be .* \(n_frames, rows, cols\), got float64 of shape \(3, 4\)"):
        as_floats(ready, 3, "frames")
    with pytest.raises(InputError, match="a frame must be numbers"):
        as_floats(np.ones((0, 4)), 2, "a frame")
    assert as_numbers(np.ones((0, 2, 2)), 3, "frames").shape == (0, 2, 2)
    assert as_numbers(np.ones((2, 2), np.float16), 2, "a frame").dtype == np.float16
    masked = np.ma.masked_equal(ready, 1.0)
    with pytest.raises(InputError, match="must not be masked here"):
        as_numbers(masked, 2, "a frame")
    assert as_numbers(masked, 2, "a frame", masked=True).shape == (3, 4)


def test_masks_meet():
    field, valid = np.ones((2, 3), bool), np.ones((2, 3), bool)
    field[0, 0] = valid[1, 2] = False
    np.testing.assert_array_equal(as_usable(np.ones((2, 3)), (2, 3), field, valid), field & valid)
    np.testing.assert_array_equal(as_usable(np.ones((2, 3)), (2, 3)), np.ones((2, 3), bool))
    np.testing.assert_array_equal(as_usable(np.ones((2, 3)), (2, 3), None, valid), valid)
    frames = np.ma.masked_array(np.ones((4, 2, 3)), mask=np.broadcast_to(~valid, (4, 2, 3)))
    np.testing.assert_array_equal(as_valid(frames, field, (2, 3)), field & valid)
    with pytest.raises(InputError, match=r"mask must have the shape of a frame, \(2, 3\), got \(3, 2\)"):
        as_valid(np.ma.masked_equal(np.eye(3, 2), 1.0), None, (2, 3))


def test_the_first_taxel_that_is_not_finite_is_named():
    frame = np.ones((3, 3))
    frame[0, 1] = 1e200
    assert str(beyond_reading(frame)).startswith("a frame must be within +-1e+100, got 1e+200 at (row, col) = (0, 1);")
    frame[1, 2] = frame[2, 0] = np.inf
    assert str(beyond_reading(frame)).startswith("a frame must be finite, got inf at (row, col) = (1, 2);")


# ---- floors, extents and remarks


@given(st.floats(0, 1), st.floats(0.01, 100))
def test_where_time_told_the_noise_the_plane_lies_at_four_sigma_and_two_percent(sigma, peak):
    assert timed_floor(sigma, peak) == pytest.approx(max(4 * sigma, 0.02 * peak))
    assert noise_reach(sigma, 256) == pytest.approx(sigma * noise_reach(1.0, 256))


def test_noise_reaches_farther_on_larger_pads():
    reaches = [noise_reach(1.0, n) for n in (4, 256, 4096, 640 * 480)]
    assert reaches == sorted(reaches)
    assert reaches[1] == pytest.approx(4, abs=0.15)
    assert reaches[3] == pytest.approx(5.5, abs=0.2)


def test_whatever_the_blocks_an_extent_is_the_same():
    rng = np.random.default_rng(0)
    frames = rng.normal(1, 2, (12, 4, 5)).astype(np.float32)
    frames[3, 1, 1] = np.nan
    usable = np.ones((4, 5), bool)
    usable[1, 1] = usable[2, 2] = False
    frames[:, 2, 2] = -1e9
    for size in (1, 3, 12):
        blocks = [(k, frames[k : k + size]) for k in range(0, 12, size)]
        extent = extent_of(iter(blocks), usable)
        np.testing.assert_array_equal(extent.low[usable], frames.min(axis=0)[usable])
        np.testing.assert_array_equal(extent.high[usable], frames.max(axis=0)[usable])


def test_polarity_is_told_by_sum_depth_and_share_together():
    def of(values):
        extent_of([(0, np.asarray(values, float).reshape(1, 1, -1))], np.ones((1, np.size(values)), bool))

    upright = [1.0] * 97
    # Two of a hundred go deep and outweigh the rest; one alone, or two that are less deep, are no matter.
    with pytest.raises(InputError, match="mostly negative"):
        of([*upright, 0, -99, -99])
    of([*upright, 0, 0, -400])
    of([*upright, 0, -97, -97])
    of([*upright, 100, -199, -197])
    with pytest.raises(InputError, match="mostly negative"):
        of([*upright, 90, -199, -199])
    # Of three hundred taxels, three are a share that counts.
    many = [0.1] * 298
    of([*many, -99, -99])
    with pytest.raises(InputError, match="mostly negative"):
        of([*many[:-1], -99, -99, -99])
    # Whole numbers without a sign cannot be negative, and what is nought counts on neither side.
    extent_of([(0, np.zeros((2, 2, 2), np.uint8))], np.ones((2, 2), bool))
    with pytest.raises(InputError, match=r"4 values below 0, 1 above; -9 to 1\)"):
        extent_of([(0, np.array([[[0, -9, -9], [1, -9, -9]]]))], np.ones((2, 3), bool))


def test_values_up_to_a_hundred_digits_are_taken():
    ones = np.ones((2, 2), bool)
    extent_of([(0, np.full((1, 2, 2), 1e100))], ones)
    extent_of([(0, np.full((1, 2, 2), -1e100))], ones, signed=True)
    with pytest.raises(InputError, match="is the file damaged"):
        extent_of([(0, np.full((1, 2, 2), 1.01e100))], ones)


def test_remarks_tell_what_the_masks_are():
    rng = np.random.default_rng(0)
    usable = np.ones((10, 10), bool)
    frames = rng.uniform(1, 5, (12, 10, 10))
    frames[2, 0, :3] = 7.0
    extent = extent_of([(0, frames)], usable)
    assert remarks_of(extent, usable, np.float64, 12) == (
        "each of 3 taxels ((0, 0), (0, 1), (0, 2)) reaches exactly the same highest value, 7: saturated, or flat",
    )
    assert full_scale(extent, usable, np.float64) == 7.0
    # A taxel outside the field says nothing.
    usable[0, :2] = False
    assert full_scale(extent, usable, np.float64) is None
    assert remarks_of(extent, usable, np.float64, 12) == ()
    for bits in (7, 8, 10, 12, 14, 15, 16, 24, 31, 32):
        whole = (frames % 3).astype(np.int64)
        whole[1, 5, 5] = 2**bits - 1
        seen = extent_of([(0, whole)], usable)
        assert full_scale(seen, usable, np.int64) == 2**bits - 1
        assert full_scale(seen, usable, np.uint32) == 2**bits - 1
    still = frames.copy()
    still[:, 4, 4] = still[:, 4, 5] = 3.0
    told = stuck_taxels(extent_of([(0, still)], usable), usable, 12)
    assert np.argwhere(told).tolist() == [[4, 4], [4, 5]]
