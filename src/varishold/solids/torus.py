"""A ring."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Self

import numpy as np
from numpy.typing import NDArray

from varishold.solids.body import Part
from varishold.solids.solid import Solid

__all__ = ["Torus"]

# Straight pieces of its body, and corners of a piece's section.
_PIECES, _CORNERS = 24, 12


@dataclass(frozen=True)
class Torus(Solid):
    """A ring with a round section that lies on the table.

    Parameters
    ----------
    diameter_m : float
        Size: largest breadth. Metres.
    tube_m : float
        Diameter of its section. Metres.
    """

    name: ClassVar[str] = "torus"

    diameter_m: float
    tube_m: float

    @classmethod
    def of_size(cls, size_m: float) -> Self:
        return cls(size_m, 0.4 * size_m)

    @property
    def top_m(self) -> float:
        return self.tube_m

    def height(self, x: NDArray[np.float64], y: NDArray[np.float64]) -> NDArray[np.float64]:
        tube = self.tube_m / 2
        off = np.hypot(x, y) - (self.diameter_m / 2 - tube)
        return np.where(np.abs(off) <= tube, tube + np.sqrt(np.maximum(tube * tube - off * off, 0.0)), 0.0)

    def body(self) -> tuple[Part, ...]:
        tube = self.tube_m / 2
        turn = 2 * np.pi * np.arange(_CORNERS) / _CORNERS
        across, up = self.diameter_m / 2 - tube + tube * np.cos(turn), tube + tube * np.sin(turn)
        ends = 2 * np.pi * np.arange(_PIECES + 1) / _PIECES
        rings = np.stack([np.outer(np.cos(ends), across), np.outer(np.sin(ends), across)], axis=-1)
        points = np.concatenate([rings, np.broadcast_to(up, rings.shape[:2])[..., None]], axis=-1)
        return tuple(Part.hull(points[k : k + 2].reshape(-1, 3)) for k in range(_PIECES))
