"""Laws of readings that were smoothed or interpolated: taxels share their noise, and small forms are not sure."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter, median_filter, zoom

from varishold import Pad, Recording, recognize_recording
from varishold.frame.quiet import shared_noise

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
