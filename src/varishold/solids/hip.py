"""A hip roof."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Self

import numpy as np
from numpy.typing import NDArray

from varishold.solids.chance import GOES_ON, Chance
from varishold.solids.raised import Raised
from varishold.solids.solid import Drawn

__all__ = ["Hip"]


@dataclass(frozen=True)
class Hip(Raised):
    """A hip roof: four sides of equal slope that meet in a crest shorter than the base.

    Parameters
    ----------
    length_m : float
        Longer side of the base; the crest is `length_m - breadth_m` long. Metres.
    breadth_m : float
        Shorter side of the base. Metres.
    height_m : float
        Height of the crest above the base plane. Metres.
    """

    name: ClassVar[str] = "hip"

    length_m: float
    breadth_m: float
    height_m: float

    @classmethod
    def of_size(cls, size_m: float) -> Self:
        return cls(1.8 * size_m, size_m, 0.5 * size_m)

    @classmethod
    def drawn(cls, chance: Chance) -> Drawn:
        long_m, short_m = chance.size_m, chance.size_m / chance.aspect
        depth_m = chance.depth_m(short_m)
        base_m = long_m + (GOES_ON - 1) * short_m
        return cls(base_m, GOES_ON * short_m, GOES_ON * depth_m).at_random(chance, depth_m, long_m, short_m)

    def rise(self, x: NDArray[np.float64], y: NDArray[np.float64]) -> NDArray[np.float64]:
        inward = np.minimum(self.length_m / 2 - np.abs(x), self.breadth_m / 2 - np.abs(y))
        return inward / (self.breadth_m / 2)
