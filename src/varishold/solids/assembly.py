"""A thing put together by chance from simple bodies, which nobody has a name for."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from varishold.solids.body import regular_polygon
from varishold.solids.by_chance import DrawnByChance, prism_corners, turn_by

__all__ = ["Assembly"]

Floats = NDArray[np.float64]

# How tall it is, in parts of its size.
_TALL = (1.4, 2.4)
# Corners of a round section.
_ROUND = 24
# So much of a profile's breadth a bar leaves free beside another, at least: with less it would be one bar or an L.
_FREE = 0.12


@dataclass(frozen=True)
class Assembly(DrawnByChance):
    """Bars side by side (as a T, a cross, a U or a Z), bodies stacked or turned on a lathe, two pillars, or a skew one.

    Parameters
    ----------
    breadth_m : float
        Size: its breadth along its own y. Metres.
    number : int
        Which of all assemblies it is.
    """

    name: ClassVar[str] = "assembly"

    def drawn_hulls(self) -> list[Floats]:
        rng = np.random.default_rng([self.number, 5])
        make = (_bars, _stacked, _turned, _pillars, _skew)[int(rng.integers(5))]
        return make(rng, float(rng.uniform(*_TALL)))


def _bars(rng: np.random.Generator, tall: float) -> list[Floats]:
    """A bar, and one or two across it that end at neither of its ends: one of them may be lower."""
    wide, deep = rng.uniform(0.25, 0.5, 2)
    heights = tall * np.where(rng.random(3) < 0.7, 1.0, rng.uniform(0.4, 0.9, 3))
    parts = [prism_corners(_rectangle((0.0, 1.0), (0.0, deep)), tall)]
    across = rng.uniform(0.6, 1.2)
    if rng.random() < 0.5:
        # A T or, where it goes through, a cross.
        at = rng.uniform(_FREE, 1.0 - wide - _FREE)
        back = 0.0 if rng.random() < 0.5 else rng.uniform(_FREE, 0.6)
        parts.append(prism_corners(_rectangle((at, at + wide), (-back, across)), heights[0]))
    else:
        # A U, or a Z where they go to different sides.
        for k, (start, end) in enumerate(((0.0, 0.8 * wide), (1.0 - 0.8 * wide, 1.0))):
            side = -1.0 if k and rng.random() < 0.5 else 1.0
            reach = sorted((deep / 2, side * across * rng.uniform(0.7, 1.0)))
            parts.append(prism_corners(_rectangle((start, end), (reach[0], reach[1])), heights[k]))
    return parts


def _stacked(rng: np.random.Generator, tall: float) -> list[Floats]:
    """Two or three prisms of different sections and breadths on each other."""
    ends = np.cumsum([0.0, *rng.dirichlet(np.full(int(rng.integers(2, 4)), 4.0)) * tall])
    breadth, parts = 1.0, []
    for low, high in pairwise(ends.tolist()):
        turn = turn_by(rng.uniform(0, 2 * np.pi))
        section = breadth * (_section(rng) @ turn)
        parts.append(prism_corners(section, high - low, start=low))
        breadth *= rng.uniform(0.5, 0.85) if rng.random() < 0.7 else rng.uniform(1.15, 1.5)
    return parts


def _turned(rng: np.random.Generator, tall: float) -> list[Floats]:
    """A body of rotation (or with a corner more): a barrel, an hourglass, a bottle, a pear."""
    n = int(rng.integers(3, 6))
    heights, breadths = np.linspace(0.0, tall, n), rng.uniform(0.45, 1.0, n)
    section = regular_polygon(int(rng.choice([4, 5, 6, 8, _ROUND])), 0.5)
    return [
        prism_corners(
            breadths[k] * section, heights[k + 1] - heights[k], start=heights[k], top=breadths[k + 1] / breadths[k]
        )
        for k in range(n - 1)
    ]


def _pillars(rng: np.random.Generator, tall: float) -> list[Floats]:
    """Two pillars that touch or stand a little apart on one plate."""
    first, second = _section(rng), rng.uniform(0.5, 1.0) * _section(rng)
    turn, apart = rng.uniform(0, 2 * np.pi), rng.uniform(0.6, 1.0)
    away = apart * np.array([np.cos(turn), np.sin(turn)])
    plate = np.vstack([first, second + away])
    return [
        prism_corners(first, tall),
        prism_corners(second + away, tall * rng.uniform(0.6, 1.0)),
        prism_corners(plate, 0.08 * tall),
    ]


def _skew(rng: np.random.Generator, tall: float) -> list[Floats]:
    """A prism that leans, or whose top is turned or pressed flat against its base."""
    section = _section(rng)
    top = rng.uniform(0.5, 1.0, 2) * (section @ turn_by(rng.uniform(-0.8, 0.8))) + rng.uniform(-0.25, 0.25, 2)
    both = [np.column_stack([flat, np.full(len(flat), z)]) for flat, z in ((section, 0.0), (top, tall))]
    return [np.vstack(both)]


def _section(rng: np.random.Generator) -> Floats:
    """A regular section of breadth 1, drawn out a little."""
    polygon = regular_polygon(int(rng.choice([3, 4, 5, 6, 8, _ROUND])), 0.5)
    out: Floats = polygon * np.array([rng.uniform(0.7, 1.4), 1.0])
    return out


def _rectangle(x: tuple[float, float], y: tuple[float, float]) -> Floats:
    return np.array([[x[0], y[0]], [x[1], y[0]], [x[1], y[1]], [x[0], y[1]]])
