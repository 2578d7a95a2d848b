"""Laws of noise and of the standard plane: what is put in comes out, whatever the sensor does to it."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from varishold.frame.noise import frame_noise
from varishold.frame.quiet import recording_noise
from varishold.kernel import bind

default_floor = bind("vh_default_floor", "dd", "d")

few = settings(max_examples=20)
seeds = st.integers(0, 2**32 - 1)


def dome(shape: tuple[int, int]) -> np.ndarray:
    y, x = np.mgrid[: shape[0], : shape[1]]
    return np.exp(-((x - shape[1] / 2) ** 2 + (y - shape[0] / 2) ** 2) / (0.08 * shape[0] * shape[1]))


@few
@given(seeds, st.sampled_from([(24, 24), (2, 200), (200, 2), (1, 300), (300, 1), (16, 40), (190, 150)]))
def test_noise_is_found_in_frames_of_every_shape(seed: int, shape: tuple[int, int]) -> None:
    rng = np.random.default_rng(seed)
    frame = rng.normal(0, 0.02, shape) + (dome(shape) if min(shape) > 2 else 0.3)
    assert frame_noise(frame) == pytest.approx(0.02, rel=0.3)
    assert frame_noise(3 * frame) == pytest.approx(3 * frame_noise(frame))
    assert frame_noise(frame.T) == pytest.approx(frame_noise(frame), rel=0.2)
    # What changes evenly over the pad is no noise.
    slope = np.linspace(0, 5, shape[1]) + np.linspace(0, 3, shape[0])[:, None]
    assert frame_noise(frame + slope) == pytest.approx(frame_noise(frame), rel=1e-6, abs=1e-12)


@few
@given(seeds)
def test_taxels_that_are_missing_or_broken_say_nothing_of_noise(seed: int) -> None:
    rng = np.random.default_rng(seed)
    frame = rng.normal(0, 0.02, (24, 24)) + dome((24, 24))
    valid = rng.random((24, 24)) < 0.95
    spoilt = np.where(valid, frame, 1e6)
    missing = np.where(valid, frame, np.nan)
    assert frame_noise(spoilt, valid=valid) == pytest.approx(0.02, rel=0.3)
    assert frame_noise(missing) == frame_noise(spoilt, valid=valid) == frame_noise(spoilt, field=valid)


@few
@given(seeds)
def test_noise_that_is_cut_off_at_zero_is_restored(seed: int) -> None:
    rng = np.random.default_rng(seed)
    frame = np.maximum(rng.normal(0, 0.02, (40, 40)), 0)
    assert frame_noise(frame) == pytest.approx(0.02, rel=0.35)


def test_smooth_frames_and_small_ones_have_none() -> None:
    assert frame_noise(dome((32, 32))) < 0.002
    assert frame_noise(np.ones((8, 8))) == 0
    assert frame_noise(np.random.default_rng(0).random((3, 3))) == 0
    assert frame_noise(np.full((4, 4), np.nan)) == 0
    steps = np.add.outer(np.arange(12), np.arange(12))
    assert frame_noise(steps) == pytest.approx(1 / np.sqrt(12))  # rounding at the least
    assert frame_noise(steps.astype(float)) == 0


@few
@given(seeds, st.sampled_from([8, 30, 400]))
def test_noise_in_time_is_that_of_quiet_frames(seed: int, n: int) -> None:
    rng = np.random.default_rng(seed)
    uneven = rng.normal(0, 1.0, (10, 10))
    frames = rng.normal(0, 0.05, (n, 10, 10))
    if n > 8:
        frames[n // 2 :] += 20 * dome((10, 10))
    assert recording_noise(frames) == pytest.approx(0.05, rel=0.25)
    # A drift of the whole pad is no noise.
    drift = np.linspace(0, 1, n)[:, None, None]
    assert recording_noise(frames + drift) == pytest.approx(recording_noise(frames), rel=0.25)
    broken = frames.copy()
    broken[:, 3, 3] = rng.normal(0, 50, n)
    valid = np.ones((10, 10), bool)
    valid[3, 3] = False
    assert recording_noise(broken, valid=valid) == pytest.approx(0.05, rel=0.25)
    assert np.isfinite(recording_noise(frames + uneven))


def test_without_quiet_frames_each_frame_is_asked() -> None:
    rng = np.random.default_rng(1)
    few_frames = dome((20, 20)) + rng.normal(0, 0.02, (5, 20, 20))
    assert recording_noise(few_frames) == pytest.approx(0.02, rel=0.2)
    assert recording_noise(np.zeros((0, 4, 4))) == 0
    assert recording_noise(np.zeros((20, 8, 8))) == 0
    assert recording_noise(few_frames, field=np.zeros((20, 20), bool)) == 0
    whole = rng.integers(0, 2, (40, 12, 12))
    assert recording_noise(whole) >= 1 / np.sqrt(12)


@few
@given(st.floats(0, 10), st.floats(0, 100))
def test_the_standard_plane_stands_clear_of_skirt_and_noise_and_swallows_no_form(sigma: float, peak: float) -> None:
    floor = default_floor(sigma, peak)
    assert floor > 0
    assert floor >= 0.05 * peak
    assert floor <= max(0.1 * peak, 1e-150)
    assert floor >= min(4 * sigma, 0.1 * peak)
    if 0.05 * peak < 4 * sigma < 0.1 * peak:
        assert floor == pytest.approx(4 * sigma)
