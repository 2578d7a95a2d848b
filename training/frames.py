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


#: Weights and pads of each table: pads of a few taxels, of ten to twenty along the shorter side, and larger ones. A row
#: of small sizes stands beside each usual one: what presses is often much smaller than the pad.
PADS: dict[str, tuple[tuple[float, Pad], ...]] = {
    "small": (
        (0.32, Pad((5, 9), (1.9, 5.5), (0.005, 0.025))),
        (0.13, Pad((6, 13), (1.9, 6.5), (0.005, 0.025))),
        (0.14, Pad((8, 8), (2.2, 7.5), (0.005, 0.025))),
        (0.13, Pad((6, 6), (1.9, 5.5), (0.005, 0.025))),
        (0.10, Pad((7, 4), (1.8, 4.0), (0.005, 0.025))),
        (0.06, Pad((4, 16), (1.8, 5.0), (0.005, 0.025))),
        (0.05, Pad((4, 4), (1.7, 3.8), (0.005, 0.025))),
        (0.07, Pad((9, 9), (2.2, 8.0), (0.005, 0.025))),
    ),
    "middle": (
        (0.38, Pad((16, 16), (3.6, 13.0), (0.003, 0.03))),
        (0.12, Pad((16, 16), (2.1, 5.5), (0.003, 0.03))),
        (0.12, Pad((10, 10), (2.2, 8.5), (0.003, 0.03))),
        (0.11, Pad((12, 12), (2.4, 10.0), (0.003, 0.03))),
        (0.09, Pad((20, 20), (2.6, 16.0), (0.003, 0.03))),
        (0.08, Pad((12, 20), (2.4, 10.5), (0.003, 0.03))),
        (0.05, Pad((14, 30), (2.6, 12.0), (0.003, 0.03))),
        (0.05, Pad((21, 16), (2.6, 13.5), (0.003, 0.03))),
    ),
    "surfaces": (
        (0.46, Pad((32, 32), (7.0, 26.0), (0.002, 0.025))),
        (0.11, Pad((32, 32), (2.2, 8.0), (0.002, 0.025))),
        (0.14, Pad((24, 24), (4.0, 19.0), (0.002, 0.03))),
        (0.05, Pad((24, 24), (2.2, 6.0), (0.002, 0.03))),
        (0.04, Pad((24, 40), (4.0, 20.0), (0.002, 0.025))),
        (0.10, Pad((40, 48), (6.0, 33.0), (0.002, 0.025))),
        (0.10, Pad((64, 64), (8.0, 50.0), (0.002, 0.02))),
    ),
}
#: Pads of ten taxels and more along the shorter side.
PADS["wide"] = tuple((weight / 2, pad) for table in ("middle", "surfaces") for weight, pad in PADS[table])


def draw_pad(rng: np.random.Generator, pads: tuple[tuple[float, Pad], ...]) -> Pad:
    """Draw a pad by its weight."""
    weights = np.array([w for w, _ in pads])
    return pads[int(rng.choice(len(pads), p=weights / weights.sum()))][1]
