"""A straight wedge without ends."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Self

import numpy as np
from numpy.typing import NDArray

from varishold.solids.chance import GOES_ON, Chance
from varishold.solids.raised import Raised
from varishold.solids.solid import Drawn

__all__ = ["Wedge"]


@dataclass(frozen=True)
class Wedge(Raised):
    """A wedge whose crest runs along x and leaves the field at both ends.

    Parameters
    ----------
    breadth_m : float
        Breadth of the base across the crest. Metres.
    height_m : float
        Height of the crest above the base plane. Metres.
    """

    name: ClassVar[str] = "edge"
    may_leave_field: ClassVar[bool] = True

    breadth_m: float
    height_m: float

    @classmethod
    def of_size(cls, size_m: float) -> Self:
        return cls(size_m, 0.5 * size_m)

    @classmethod
    def drawn(cls, chance: Chance) -> Drawn:
        depth_m = chance.depth_m(chance.size_m)
        return cls(GOES_ON * chance.size_m, GOES_ON * depth_m).at_random(chance, depth_m, np.inf, chance.size_m)

    def rise(self, x: NDArray[np.float64], y: NDArray[np.float64]) -> NDArray[np.float64]:
        return 1 - np.abs(y) / (self.breadth_m / 2) + 0.0 * x
