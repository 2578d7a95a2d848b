"""Frames on which rounding may decide: whole counts, ends of the range, plateaus, noise, and what breaks."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from varishold.solids import draw_contact, ideal_frame
from varishold.touch.writers.vectors import SOLIDS

Floats = NDArray[np.float64]
Shape = tuple[int, int]
Rng = np.random.Generator


def pressed(rng: Rng, shape: Shape) -> Floats:
    """Return a drawn solid pressed into a pad, 1 at its peak."""
    side = min(shape)
    field = (float(shape[0]), float(shape[1]))
    drawn = draw_contact(rng, str(rng.choice(SOLIDS)), field_m=field, size_m=(0.3 * side, 0.8 * side))
    frame = ideal_frame(drawn.solid, shape, 1.0, depth_m=drawn.depth_m, pose=drawn.pose)
    return np.asarray(frame / max(frame.max(), 1e-12))


def noisy(rng: Rng, shape: Shape, sigma: float = 0.01) -> Floats:
    return pressed(rng, shape) + rng.normal(0, sigma, shape)


def rounded(frame: Floats, counts: int) -> Floats:
    return np.asarray(np.round(frame * counts) / counts)


def saturated(rng: Rng, shape: Shape) -> Floats:
    return np.clip(pressed(rng, shape) * rng.uniform(1, 4) + rng.normal(0, 0.02, shape), 0, 1)


def bumps(rng: Rng, shape: Shape) -> Floats:
    y, x = np.mgrid[: shape[0], : shape[1]]
    frame = np.zeros(shape)
    for _ in range(rng.integers(1, 5)):
        away = (x - rng.uniform(0, shape[1])) ** 2 + (y - rng.uniform(0, shape[0])) ** 2
        frame = np.maximum(frame, rng.uniform(0.2, 1) * np.exp(-away / rng.uniform(1, 0.1 * frame.size + 1)))
    return frame + rng.normal(0, 0.01 * rng.integers(2), shape)


def smooth(rng: Rng, shape: Shape) -> Floats:
    frame = rng.normal(0, 1, shape)
    for _ in range(rng.integers(1, 4)):
        p = np.pad(frame, 1, mode="edge")
        frame = (p[1:-1, 1:-1] + p[:-2, 1:-1] + p[2:, 1:-1] + p[1:-1, :-2] + p[1:-1, 2:]) / 5
    return frame


def unread(rng: Rng, shape: Shape) -> Floats:
    return np.where(rng.random(shape) < rng.uniform(0.01, 0.2), np.nan, noisy(rng, shape))


def dead(rng: Rng, shape: Shape) -> Floats:
    frame = noisy(rng, shape)
    if rng.random() < 0.5:
        frame[rng.integers(shape[0])] = 0
    else:
        frame[rng.random(shape) < 0.03] = 0
    return frame


def lifted(rng: Rng, shape: Shape) -> Floats:
    y, x = np.mgrid[: shape[0], : shape[1]]
    return noisy(rng, shape) + rng.uniform(-0.5, 0.5) + rng.uniform(-0.02, 0.02) * x + rng.uniform(-0.02, 0.02) * y


def steps(rng: Rng, shape: Shape) -> Floats:
    frame = pressed(rng, shape)
    return (frame > rng.uniform(0.1, 0.9)) + rng.uniform(0, 1) * (frame > rng.uniform(0.1, 0.9))


#: Each draws a frame of a shape, mostly between 0 and 1.
ODD_FRAMES: dict[str, Callable[[Rng, Shape], Floats]] = {
    "pressed": pressed,
    "noisy": lambda rng, shape: noisy(rng, shape, 10 ** rng.uniform(-3, -1)),
    "two": lambda rng, shape: np.maximum(pressed(rng, shape), rng.uniform(0.2, 1) * pressed(rng, shape)),
    "counts": lambda rng, shape: rounded(noisy(rng, shape), rng.choice([31, 100, 255, 1023, 4095])),
    "coarse": lambda rng, shape: rounded(noisy(rng, shape, 0.05), rng.choice([3, 5, 8, 15])),
    "saturated": saturated,
    "saturated counts": lambda rng, shape: rounded(saturated(rng, shape), rng.choice([15, 63, 255, 1023])),
    "steps": steps,
    "bumps": bumps,
    "smooth": smooth,
    "random": lambda rng, shape: rng.uniform(0, 1, shape),
    "few values": lambda rng, shape: rng.integers(0, 6, shape) / 5,
    "unread": unread,
    "dead": dead,
    "lifted": lifted,
    "faint": lambda rng, shape: rng.uniform(0, 0.1) * pressed(rng, shape) + rng.normal(0, 0.03, shape),
}
