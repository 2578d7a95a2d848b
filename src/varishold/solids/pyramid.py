"""A pyramid's tip."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Self

import numpy as np
from numpy.typing import NDArray

from varishold.solids.body import Part, regular_polygon
from varishold.solids.chance import GOES_ON, Chance
from varishold.solids.raised import Raised
from varishold.solids.solid import Drawn

__all__ = ["Pyramid"]


@dataclass(frozen=True)
class Pyramid(Raised):
    """A square pyramid, tip toward the skin.

    Parameters
    ----------
    breadth_m : float
        Side of the base. Metres.
    height_m : float
        Height of the tip above the base plane. Metres.
    """

    name: ClassVar[str] = "pyramid"

    breadth_m: float
    height_m: float

    @classmethod
    def of_size(cls, size_m: float) -> Self:
        return cls(size_m, 0.5 * size_m)

    @classmethod
    def to_grip(cls, size_m: float) -> Self:
        return cls(size_m, 2.0 * size_m)

    @classmethod
    def drawn(cls, chance: Chance) -> Drawn:
        depth_m = chance.depth_m(chance.size_m)
        return cls(GOES_ON * chance.size_m, GOES_ON * depth_m).at_random(chance, depth_m, chance.size_m, chance.size_m)

    def rise(self, x: NDArray[np.float64], y: NDArray[np.float64]) -> NDArray[np.float64]:
        return 1 - np.maximum(np.abs(x), np.abs(y)) / (self.breadth_m / 2)

    def body(self) -> tuple[Part, ...]:
        base = regular_polygon(4, self.breadth_m / np.sqrt(2), turn_rad=np.pi / 4)
        return (Part.prism(base, self.height_m, top_scale=0.0),)
