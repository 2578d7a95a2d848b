"""The end face of an upright cylinder."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Self

import numpy as np
from numpy.typing import NDArray

from varishold.solids.body import Part
from varishold.solids.chance import GOES_ON, Chance
from varishold.solids.raised import GRIP_HEIGHT_M, Raised
from varishold.solids.solid import Drawn

__all__ = ["Cylinder"]


@dataclass(frozen=True)
class Cylinder(Raised):
    """A cylinder that stands on its end: a flat circular face.

    Parameters
    ----------
    diameter_m : float
        Diameter of the face. Metres.
    height_m : float
        How far the face stands above the base plane. Metres.
    """

    name: ClassVar[str] = "cylinder"
    round: ClassVar[bool] = True

    diameter_m: float
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
        return (x * x + y * y <= (self.diameter_m / 2) ** 2).astype(np.float64)

    def body(self) -> tuple[Part, ...]:
        return (Part.cylinder(self.diameter_m, self.height_m),)
