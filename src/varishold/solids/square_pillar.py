"""The end face of a square pillar."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Self

import numpy as np
from numpy.typing import NDArray

from varishold.solids.body import Part
from varishold.solids.chance import GOES_ON, Chance
from varishold.solids.raised import GRIP_HEIGHT_M, Raised
from varishold.solids.solid import Drawn

__all__ = ["SquarePillar"]


@dataclass(frozen=True)
class SquarePillar(Raised):
    """A square pillar that stands on its end: a flat square face.

    Parameters
    ----------
    breadth_m : float
        Side of the face. Metres.
    height_m : float
        How far the face stands above the base plane. Metres.
    """

    name: ClassVar[str] = "square pillar"

    breadth_m: float
    height_m: float

    @classmethod
    def of_size(cls, size_m: float) -> Self:
        return cls(size_m, size_m)

    @classmethod
    def to_grip(cls, size_m: float) -> Self:
        return cls(size_m, GRIP_HEIGHT_M)

    @classmethod
    def drawn(cls, chance: Chance) -> Drawn:
        depth_m = chance.depth_m(chance.size_m)
        return cls(chance.size_m, GOES_ON * depth_m).at_random(chance, depth_m, chance.size_m, chance.size_m)

    def rise(self, x: NDArray[np.float64], y: NDArray[np.float64]) -> NDArray[np.float64]:
        return (np.maximum(np.abs(x), np.abs(y)) <= self.breadth_m / 2).astype(np.float64)

    def body(self) -> tuple[Part, ...]:
        return (Part.box(self.breadth_m, self.breadth_m, self.height_m),)
