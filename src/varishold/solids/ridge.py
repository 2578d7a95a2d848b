"""A gabled ridge."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Self

import numpy as np
from numpy.typing import NDArray

from varishold.solids.chance import GOES_ON, Chance
from varishold.solids.raised import Raised
from varishold.solids.solid import Drawn

__all__ = ["Ridge"]


@dataclass(frozen=True)
class Ridge(Raised):
    """A gabled roof: its crest runs the whole length, its ends are upright.

    Parameters
    ----------
    length_m : float
        Length of the crest and of the base. Metres.
    breadth_m : float
        Breadth of the base across the crest. Metres.
    height_m : float
        Height of the crest above the base plane. Metres.
    """

    name: ClassVar[str] = "ridge"

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
        return cls(long_m, GOES_ON * short_m, GOES_ON * depth_m).at_random(chance, depth_m, long_m, short_m)

    def rise(self, x: NDArray[np.float64], y: NDArray[np.float64]) -> NDArray[np.float64]:
        return np.where(np.abs(x) <= self.length_m / 2, 1 - np.abs(y) / (self.breadth_m / 2), 0.0)
