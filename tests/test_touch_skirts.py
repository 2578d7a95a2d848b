"""A gel's skirt on a height map does not make a body larger, and what has no skirt stays as it was."""

from __future__ import annotations

import math

import numpy as np
import pytest
from numpy.typing import NDArray

from varishold import Pad, Recording, recognize_recording
from varishold.touch.answer import Answer

Floats = NDArray[np.float64]
SIDE, PITCH, TOP = 128, 125e-6, 1e-3
Y, X = (np.mgrid[:SIDE, :SIDE] - (SIDE - 1) / 2) * PITCH


def body(name: str, turn: float = 0.4) -> tuple[Floats, float, float]:
    """Return a height where it is pressed, and its breadths a twentieth of the way up: the short and the long one."""
    u, v = X * math.cos(turn) + Y * math.sin(turn), Y * math.cos(turn) - X * math.sin(turn)
    left = 0.95 * TOP
    if name in ("sphere", "lying cylinder"):
        radius = 5e-3
        away = np.hypot(u, v) if name == "sphere" else v
        z = TOP - radius + np.sqrt(np.maximum(radius**2 - away**2, 0))
        short = 2 * math.sqrt(2 * radius * left - left**2)
    else:
        away = {"cone": np.hypot(u, v), "pyramid": np.maximum(abs(u), abs(v)), "ridge": abs(v)}[name]
        z, short = TOP - away / 3, 6 * left
    if name in ("lying cylinder", "ridge"):
        return np.where(abs(u) < 5e-3, z, 0), short, 10e-3
    return z, short, short


def stretched(z: Floats, reach: float) -> Floats:
    """Return the membrane over a body: above it nowhere lower, and falling off by e in so many metres beside it."""
    z = np.maximum(z, 0)
    u, per = z.copy(), 4 + (PITCH / reach) ** 2
    for _ in range(600):
        p = np.pad(u, 1, mode="edge")
        u = np.maximum(z, (p[2:, 1:-1] + p[:-2, 1:-1] + p[1:-1, 2:] + p[1:-1, :-2]) / per)
    return u


def told(frame: Floats, seed: int = 0) -> Answer:
    noisy = frame + np.random.default_rng(seed).normal(0, 0.01 * TOP, frame.shape)
    (answer,) = recognize_recording(Recording({"pad": Pad(noisy[None], pitch_m=PITCH)}, unit="m"))
    return answer


@pytest.mark.parametrize("name", ["sphere", "cone", "pyramid", "lying cylinder", "ridge"])
def test_a_skirt_does_not_widen_a_body(name: str) -> None:
    z, short, long = body(name)
    answer = told(stretched(z, 0.6e-3))
    assert answer.surface.name == name
    # The lowest section is wider by a skirt on either side.
    assert answer.surface.size[1] > 1.02 * short
    assert answer.size[1] == pytest.approx(short, rel=0.04)
    (long_low, long_high), (low, high) = answer.size_interval
    assert low <= short <= high
    assert long_low <= long <= long_high
    assert low < answer.size[1] < high
    assert high >= answer.surface.size_interval_of(height_map=True)[1][1]


@pytest.mark.parametrize("name", ["sphere", "cone", "pyramid", "lying cylinder", "ridge"])
def test_without_a_skirt_the_lowest_section_tells(name: str) -> None:
    z, short, _ = body(name)
    answer = told(np.maximum(z, 0))
    assert answer.size == answer.surface.size_of(height_map=True)
    assert answer.size_interval == answer.surface.size_interval_of(height_map=True)
    assert answer.size[1] == pytest.approx(short, rel=0.02)


def test_what_the_pad_cuts_is_measured_as_it_is() -> None:
    z, _, _ = body("sphere")
    answer = told(stretched(z, 0.6e-3)[:, :75])
    assert answer.surface.cut
    assert answer.size == answer.surface.size
