"""Pads to draw on, faces whose outline has no name, and what taxels make of a height map."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from varishold.solids import pad_points

Array = NDArray[np.float64]

#: Pillars whose outline has no name of its own.
NAMELESS_PILLARS = ("triangular-pillar", "hexagonal-pillar", "elliptic-pillar")


@dataclass(frozen=True)
class Pad:
    """A pad to draw on: its shape, the range of contact sizes in taxels, and of noise over the peak."""

    shape: tuple[int, int]
    size: tuple[float, float]
    noise: tuple[float, float]


def nameless_pillar(rng: np.random.Generator, key: str, pad: Pad, per_taxel: int) -> Array:
    """Return a flat face of an outline that has no name, sampled `per_taxel` times along a taxel's side."""
    x, y = pad_points(pad.shape, 1.0, per_taxel=per_taxel)
    breadth = rng.uniform(*pad.size)
    free_y, free_x = (max((n - breadth) / 2, 0.0) for n in pad.shape)
    yaw = rng.uniform(-np.pi, np.pi)
    dx, dy = x - rng.uniform(-free_x, free_x), y - rng.uniform(-free_y, free_y)
    c, s = np.cos(yaw), np.sin(yaw)
    u, v = 2 * (c * dx + s * dy) / breadth, 2 * (c * dy - s * dx) / breadth
    if key == "elliptic-pillar":
        return (u**2 + (v * rng.uniform(1.4, 2.5)) ** 2 <= 1).astype(np.float64)
    sides = 3 if key == "triangular-pillar" else 6
    angle = 2 * np.pi * np.arange(sides) / sides
    inner = np.cos(np.pi / sides)
    return np.all([u * np.cos(a) + v * np.sin(a) <= inner for a in angle], axis=0).astype(np.float64)


def taxel_mean(fine: Array, per_taxel: int) -> Array:
    """Return the mean over each taxel of a map with `per_taxel` samples along a taxel's side."""
    rows, cols = fine.shape[0] // per_taxel, fine.shape[1] // per_taxel
    mean: Array = fine.reshape(rows, per_taxel, cols, per_taxel).mean(axis=(1, 3))
    return mean


#: Weights and pads of a few taxels: fingertips.
SMALL_PADS: tuple[tuple[float, Pad], ...] = (
    (0.40, Pad((5, 9), (1.9, 5.5), (0.005, 0.025))),
    (0.15, Pad((6, 13), (1.9, 6.5), (0.005, 0.025))),
    (0.15, Pad((8, 8), (2.2, 7.5), (0.005, 0.025))),
    (0.15, Pad((6, 6), (1.9, 5.5), (0.005, 0.025))),
    (0.15, Pad((7, 4), (1.8, 4.0), (0.005, 0.025))),
)


def draw_pad(rng: np.random.Generator, pads: tuple[tuple[float, Pad], ...]) -> Pad:
    """Draw a pad by its weight."""
    weights = np.array([w for w, _ in pads])
    return pads[int(rng.choice(len(pads), p=weights / weights.sum()))][1]
