"""The end face of a rectangular pillar."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Self

import numpy as np
from numpy.typing import NDArray

from varishold.solids.body import Part
from varishold.solids.chance import GOES_ON, Chance
from varishold.solids.raised import Raised
from varishold.solids.solid import Drawn

__all__ = ["RectangularPillar"]


@dataclass(frozen=True)
class RectangularPillar(Raised):
    """A rectangular pillar that stands on its end: a flat rectangular face.

    Parameters
    ----------
    length_m : float
        Longer side of the face. Metres.
    breadth_m : float
        Shorter side of the face. Metres.
    height_m : float
        How far the face stands above the base plane. Metres.
    """

    name: ClassVar[str] = "rectangular pillar"

    length_m: float
    breadth_m: float
    height_m: float

    @classmethod
    def of_size(cls, size_m: float) -> Self:
        return cls(1.8 * size_m, size_m, size_m)

    @classmethod
    def drawn(cls, chance: Chance) -> Drawn:
        long_m, short_m = chance.size_m, chance.size_m / chance.aspect
        depth_m = chance.depth_m(short_m)
        return cls(long_m, short_m, GOES_ON * depth_m).at_random(chance, depth_m, long_m, short_m)

    def rise(self, x: NDArray[np.float64], y: NDArray[np.float64]) -> NDArray[np.float64]:
        inside = (np.abs(x) <= self.length_m / 2) & (np.abs(y) <= self.breadth_m / 2)
        return inside.astype(np.float64)

    def body(self) -> tuple[Part, ...]:
        return (Part.box(self.length_m, self.breadth_m, self.height_m),)
