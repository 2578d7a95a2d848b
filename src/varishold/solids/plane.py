"""A flat face larger than any pad."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Self

import numpy as np
from numpy.typing import NDArray

from varishold.solids.chance import GOES_ON, Chance
from varishold.solids.raised import Raised
from varishold.solids.solid import Drawn

__all__ = ["Plane"]


@dataclass(frozen=True)
class Plane(Raised):
    """A flat face without borders.

    Parameters
    ----------
    height_m : float
        How far the face stands above the base plane. Metres.
    """

    name: ClassVar[str] = "plane"
    may_leave_field: ClassVar[bool] = True

    height_m: float

    @classmethod
    def of_size(cls, size_m: float) -> Self:
        return cls(size_m)

    @classmethod
    def drawn(cls, chance: Chance) -> Drawn:
        depth_m = chance.depth_m(chance.size_m)
        return cls(GOES_ON * depth_m).at_random(chance, depth_m, np.inf, np.inf)

    def rise(self, x: NDArray[np.float64], y: NDArray[np.float64]) -> NDArray[np.float64]:
        return np.ones(np.broadcast(x, y).shape)
