"""A cone's tip."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Self

import numpy as np
from numpy.typing import NDArray

from varishold.solids.body import Part, regular_polygon
from varishold.solids.chance import GOES_ON, Chance
from varishold.solids.raised import Raised
from varishold.solids.solid import Drawn

__all__ = ["Cone"]


@dataclass(frozen=True)
class Cone(Raised):
    """A circular cone, tip toward the skin.

    Parameters
    ----------
    diameter_m : float
        Diameter of the base. Metres.
    height_m : float
        Height of the tip above the base plane. Metres.
    """

    name: ClassVar[str] = "cone"
    round: ClassVar[bool] = True

    diameter_m: float
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
        return 1 - np.hypot(x, y) / (self.diameter_m / 2)

    def body(self) -> tuple[Part, ...]:
        return (Part.prism(regular_polygon(48, self.diameter_m / 2), self.height_m, top_scale=0.0),)
