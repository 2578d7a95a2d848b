"""Laws of readings that were smoothed or interpolated: taxels share their noise, and small forms are not sure."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter, median_filter, zoom

from varishold import Pad, Recording, recognize_recording
from varishold.frame.quiet import shared_noise
from varishold.frame.smooth import frame_is_smoothed

Frames = NDArray[np.float64]
COURSE = np.r_[np.zeros(20), np.linspace(0.1, 1.0, 8), np.ones(12), np.linspace(0.9, 0.1, 6), np.zeros(20)]


def pressed(side: int, noise: float = 10.0, seed: int = 0) -> Frames:
    y, x = np.mgrid[:side, :side] - (side - 1) / 2
    form = 1.0 * (np.maximum(abs(y), abs(x)) < 0.22 * side)
    frames: Frames = 300.0 + 1000.0 * COURSE[:, None, None] * form
    return frames + np.random.default_rng(seed).normal(0.0, noise, frames.shape)


SMOOTH = {
    "gaussian": lambda frames: gaussian_filter(frames, (0, 1, 1)),
    "median": lambda frames: median_filter(frames, (1, 3, 3)),
    "linear": lambda frames: zoom(frames[:, ::2, ::2], (1, 2, 2), order=1, mode="nearest", grid_mode=True),
    "cubic": lambda frames: zoom(frames[:, ::2, ::2], (1, 2, 2), order=3, mode="nearest", grid_mode=True),
}


@pytest.mark.parametrize("how", SMOOTH)
@pytest.mark.parametrize("side", [12, 16, 24])
def test_smoothed_readings_share_their_noise_and_small_forms_are_not_sure(how: str, side: int) -> None:
    frames = SMOOTH[how](pressed(side))
    assert shared_noise(frames, np.ones(frames.shape[1:], np.bool_)) > 0.33
    for answer in recognize_recording(Recording({"pad": Pad(frames)}), frames="press"):
        assert answer.surface.probability <= 0.85 + 1e-9
        assert any("taxels share their noise" in note for note in answer.frame_notes)


@pytest.mark.parametrize("side", [4, 8, 16, 32])
@pytest.mark.parametrize("kind", ["normal", "counts", "rows", "hum", "none", "uneven", "shot"])
def test_noise_of_taxels_is_their_own(side: int, kind: str) -> None:
    rng = np.random.default_rng(side)
    frames = pressed(side, 0.0 if kind == "none" else 10.0)
    if kind == "counts":
        frames = np.rint(frames / 20.0)
    elif kind == "rows":
        frames += rng.normal(0.0, 20.0, (len(frames), side, 1))
    elif kind == "hum":
        frames += rng.normal(0.0, 20.0, (len(frames), 1, 1))
    elif kind == "uneven":
        frames += rng.normal(0.0, 1.0, frames.shape) * np.exp(rng.normal(0.0, 1.0, (side, side)))
    elif kind == "shot":
        frames = rng.poisson(np.maximum(frames, 0.0) / 10.0).astype(np.float64)
    assert shared_noise(frames, np.ones((side, side), np.bool_)) < 0.25


@pytest.mark.parametrize("side", [8, 16, 32])
@pytest.mark.parametrize(("ramp", "held", "pause"), [(3, 0, 1), (2, 1, 2), (8, 0, 0), (10, 3, 2)])
def test_what_presses_without_a_pause_is_no_noise(side: int, ramp: int, held: int, pause: int) -> None:
    rng = np.random.default_rng(side)
    up = np.linspace(0.0, 1.0, ramp + 2)[1:-1]
    course = np.r_[up, np.ones(held), up[::-1], np.zeros(pause)]
    y, x = np.mgrid[:side, :side]
    frames = []
    for row, col in rng.uniform(0.25, 0.75, (8, 2)) * side:
        form = gaussian_filter(1.0 * (np.hypot(y - row, x - col) < 0.25 * side), 0.7)
        frames.append(100.0 * course[:, None, None] * form)
    pressed = np.concatenate(frames)
    noise = rng.normal(0.0, 1.0, pressed.shape)
    works = np.ones((side, side), np.bool_)
    assert shared_noise(pressed + noise, works) < 0.3
    smooth = gaussian_filter(noise, (0, 0.8, 0.8))
    assert shared_noise(pressed + smooth / smooth.std(), works) > 0.3


def test_what_is_no_taxel_tells_nothing() -> None:
    frames, field = pressed(16), np.ones((16, 16), np.bool_)
    field[:, 8:] = False
    frames[:, ~field] = 5.0
    assert shared_noise(frames, field) < 0.1
    assert shared_noise(frames[:4], field) == shared_noise(frames[:, :1], field[:1]) == 0.0


HELD = 30


@pytest.mark.parametrize("how", ["gaussian", "linear", "cubic"])
@pytest.mark.parametrize("side", [16, 24, 32])
@pytest.mark.parametrize("n_frames", [1, 3])
def test_a_single_frame_shows_that_it_was_smoothed(how: str, side: int, n_frames: int) -> None:
    called = 0
    for seed in range(10):
        frames = SMOOTH[how](pressed(side, seed=seed))[HELD : HELD + n_frames]
        called += frame_is_smoothed(frames[0], np.ones((side, side), np.bool_))
        for answer in recognize_recording(Recording({"pad": Pad(frames)})):
            said = any("taxels share their noise" in note for note in answer.frame_notes)
            assert not said or answer.surface.contact.n_taxels >= 256 or answer.surface.probability <= 0.85 + 1e-9
    assert called >= 9


@pytest.mark.parametrize("side", [8, 12, 16, 32])
@pytest.mark.parametrize("kind", ["normal", "counts", "rows", "slope", "none", "uneven", "gains", "skirt"])
def test_a_single_frame_of_a_sensor_was_not_smoothed(side: int, kind: str) -> None:
    for seed in range(12):
        rng = np.random.default_rng([side, seed])
        frame = pressed(side, 0.0 if kind == "none" else 10.0, seed)[HELD]
        if kind == "counts":
            frame = np.rint(frame / 20.0)
        elif kind == "rows":
            frame += rng.normal(0.0, 30.0, (side, 1)) + rng.normal(0.0, 30.0, side)
        elif kind == "slope":
            frame += np.add.outer(np.arange(side), 2.0 * np.arange(side)) * 100.0 / side
        elif kind == "uneven":
            frame += rng.normal(0.0, 1.0, frame.shape) * np.exp(rng.normal(0.0, 1.0, (side, side)))
        elif kind == "gains":
            frame *= np.exp(rng.normal(0.0, 0.2, frame.shape))
        elif kind == "skirt":
            frame = gaussian_filter(pressed(side, 0.0)[HELD], 1.0) + rng.normal(0.0, 10.0, frame.shape)
        assert not frame_is_smoothed(frame, np.ones(frame.shape, np.bool_))


def test_scale_turns_and_slopes_change_nothing_of_that() -> None:
    works = np.ones((16, 16), np.bool_)
    for seed in range(10):
        frame = pressed(16, 10.0 + 30.0 * (seed % 2), seed)[HELD]
        for smooth in (0.0, 0.4, 0.5, 0.7):
            one = gaussian_filter(frame, smooth)
            found = frame_is_smoothed(one, works)
            assert frame_is_smoothed(one * 1e-3, works) == found
            assert frame_is_smoothed(one + 5e3, works) == found
            assert frame_is_smoothed(one.T, works) == frame_is_smoothed(one[::-1, ::-1], works) == found


def test_where_no_taxel_is_or_nothing_shows_no_frame_was_smoothed() -> None:
    smooth = gaussian_filter(pressed(16)[HELD], 1.0)
    works = np.ones((16, 16), np.bool_)
    assert frame_is_smoothed(smooth, works)
    beside = np.abs(np.arange(16) - 7.5) > 5.0
    assert not frame_is_smoothed(smooth, ~(beside[:, None] | beside))
    assert not frame_is_smoothed(smooth, np.zeros((16, 16), np.bool_))
    assert not frame_is_smoothed(np.full((16, 16), 3.0), works)
    assert not frame_is_smoothed(smooth[:2], works[:2])
    # What is no taxel may hold anything.
    absent = works.copy()
    absent[0, 0] = False
    marked = np.where(absent, smooth, np.nan)
    assert frame_is_smoothed(marked, absent)
