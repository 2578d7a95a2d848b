"""Laws of presses too light for a pad's total: found where some taxels show them, and nowhere else."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from varishold import Pad, Recording

Frames = NDArray[np.float64]


def noise(side: int, n: int = 200, seed: int = 0, scale: float = 1.0) -> Frames:
    frames: Frames = 50.0 + scale * np.random.default_rng(seed).normal(0.0, 1.0, (n, side, side))
    return frames


def cone(side: int, at: int, radius: float) -> Frames:
    y, x = np.mgrid[:side, :side]
    form: Frames = np.maximum(1.0 - np.hypot(y - at, x - at) / radius, 0.0)
    return form


def presses(frames: Frames, **of_pad: NDArray[np.bool_]) -> list[range]:
    return list(Recording({"pad": Pad(frames, **of_pad)}).presses.frames)


@pytest.mark.parametrize("side", [24, 64, 128])
@pytest.mark.parametrize("peak", [12.0, 40.0])
def test_small_presses_are_found_on_large_pads(side: int, peak: float) -> None:
    frames = noise(side)
    for start in (40, 100, 150):
        frames[start : start + 12] += peak * cone(side, side // 3, 4.0)
    found = presses(frames)
    assert [(run.start, run.stop) for run in found] == [(40, 52), (100, 112), (150, 162)]


@pytest.mark.parametrize("counts", [False, True])
def test_light_presses_beside_a_strong_one(counts: bool) -> None:
    frames = noise(24)
    frames[50:70] += 2000.0 * (cone(24, 12, 40.0) > 0)
    frames[100:115] += 30.0 * cone(24, 8, 5.0)
    frames[150:165] += 30.0 * cone(24, 15, 5.0)
    found = presses(np.rint(frames).astype(np.int64) if counts else frames)
    assert [(run.start, run.stop) for run in found] == [(50, 70), (100, 115), (150, 165)]


@pytest.mark.parametrize("side", [24, 32, 48])
@pytest.mark.parametrize("kind", [float, np.uint8])
def test_small_presses_are_found_in_short_pauses_where_noise_ends_at_zero(side: int, kind: type) -> None:
    # Something presses in half of the frames in which the total shows nothing.
    frames = [np.zeros((side, side))] * 12
    for k in range(12):
        form = np.ones((side, side)) if k % 4 == 1 else 0.75 * cone(side, 6 + 11 * k % (side - 12), 5.0)
        frames += [200.0 * share * form for share in (0.3, 0.6, 0.9, 1.0, 1.0, 1.0, 0.8, 0.4)]
        frames += [np.zeros((side, side))] * 6
    noisy = np.array(frames) + np.random.default_rng(0).normal(0.0, 2.5, (len(frames), side, side))
    found = presses(np.clip(np.rint(noisy), 0, 255).astype(kind))
    assert len(found) == 12


@pytest.mark.parametrize("side", [6, 16, 48])
@pytest.mark.parametrize("kind", ["normal", "counts", "clipped", "shot", "uneven"])
def test_noise_is_no_press(side: int, kind: str) -> None:
    for seed in range(8):
        rng = np.random.default_rng([seed, side])
        frames = noise(side, seed=seed)
        if kind == "counts":
            frames = np.rint(0.5 * frames)
        elif kind == "clipped":
            frames = np.maximum(frames - 50.0, 0.0)
        elif kind == "shot":
            frames = rng.poisson(3.0, frames.shape).astype(np.float64)
        elif kind == "uneven":
            frames = (frames - 50.0) * np.exp(0.5 * rng.normal(0.0, 1.0, (side, side)))
        assert presses(frames) == []


def test_what_single_taxels_do_and_what_does_not_come_and_go_is_none() -> None:
    spikes = noise(64)
    rng = np.random.default_rng(1)
    for k in range(30, 170, 7):
        spikes[k : k + 4, rng.integers(64), rng.integers(64)] += 40.0
    assert presses(spikes) == []
    stays = noise(64)
    stays[120:] += 10.0 * cone(64, 20, 4.0)
    begins = noise(64)
    begins[:60] += 10.0 * cone(64, 20, 4.0)
    assert presses(stays) == presses(begins) == []


def test_gaps_and_broken_taxels_tell_nothing() -> None:
    frames = noise(64)
    frames[:, :, 40:] = np.nan
    frames[:, 3, 3] = 7.0
    frames[60:75] += 15.0 * cone(64, 20, 4.0)
    field = np.ones((64, 64), np.bool_)
    field[:, 40:] = False
    assert [(run.start, run.stop) for run in presses(frames, field=field)] == [(60, 75)]
