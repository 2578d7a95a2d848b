"""A shape made by chance, which nobody has a name for."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from varishold.solids.body import regular_polygon
from varishold.solids.by_chance import DrawnByChance, prism_corners, turn_by

__all__ = ["Lump"]

# Corners of a rounded section.
_ROUND = 24
# A tall lump's height, in parts of its size, and what its top may shrink to.
_TALL, _LEAST_TOP = (1.4, 2.4), 0.4


@dataclass(frozen=True)
class Lump(DrawnByChance):
    """A tall prism on a crooked polygon or an oval, a pillar with another one stuck to it, or a squat stone.

    Parameters
    ----------
    breadth_m : float
        Size: its breadth along its own y. Metres.
    number : int
        Which of all lumps it is.
    """

    name: ClassVar[str] = "lump"

    def drawn_hulls(self) -> list[NDArray[np.float64]]:
        rng = np.random.default_rng(self.number)
        kind = ("crooked", "oval", "joined", "stone")[int(rng.integers(4))]
        tall = float(rng.uniform(*_TALL))
        top = 1.0 if rng.random() < 0.5 else float(rng.uniform(_LEAST_TOP, 1.0))
        if kind == "crooked":
            parts = [prism_corners(_crooked(rng), tall, top=top)]
        elif kind == "oval":
            parts = [prism_corners(_oval(rng), tall, top=top)]
        elif kind == "joined":
            first, second = _oval(rng), 0.6 * _crooked(rng)
            turn = rng.uniform(0, 2 * np.pi)
            parts = [
                prism_corners(first, tall),
                prism_corners(second + 0.45 * np.array([np.cos(turn), np.sin(turn)]), tall),
            ]
        else:
            points = rng.normal(size=(14, 3))
            points /= np.linalg.norm(points, axis=1, keepdims=True)
            stone = points * np.array([rng.uniform(0.5, 1.0), 0.5, rng.uniform(0.3, 0.8)])
            parts = [stone - np.array([0.0, 0.0, stone[:, 2].min()])]
        return parts


def _crooked(rng: np.random.Generator) -> NDArray[np.float64]:
    n = int(rng.integers(3, 8))
    turns = 2 * np.pi * (np.arange(n) + rng.uniform(0.0, 0.7, n)) / n
    corners: NDArray[np.float64] = rng.uniform(0.35, 0.6, (n, 1)) * np.column_stack([np.cos(turns), np.sin(turns)])
    return corners


def _oval(rng: np.random.Generator) -> NDArray[np.float64]:
    across = regular_polygon(_ROUND, 0.5)
    power = float(np.exp(rng.uniform(np.log(0.4), np.log(1.4))))
    corners = 0.5 * np.sign(across) * np.abs(2 * across) ** power * np.array([rng.uniform(0.55, 1.6), 1.0])
    out: NDArray[np.float64] = corners @ turn_by(rng.uniform(0, np.pi))
    return out
