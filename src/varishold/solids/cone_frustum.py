"""A frustum of a cone."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Self

import numpy as np
from numpy.typing import NDArray

from varishold.solids.body import Part, regular_polygon
from varishold.solids.chance import GOES_ON, Chance
from varishold.solids.raised import GRIP_HEIGHT_M, Raised
from varishold.solids.solid import Drawn

__all__ = ["ConeFrustum"]


@dataclass(frozen=True)
class ConeFrustum(Raised):
    """A cone whose tip is cut off level.

    Parameters
    ----------
    diameter_m : float
        Diameter of the base. Metres.
    top_diameter_m : float
        Diameter of the flat top. Metres.
    height_m : float
        Height of the top above the base plane. Metres.
    """

    name: ClassVar[str] = "frustum of a cone"
    round: ClassVar[bool] = True

    diameter_m: float
    top_diameter_m: float
    height_m: float

    @classmethod
    def of_size(cls, size_m: float) -> Self:
        return cls(size_m, 0.45 * size_m, 0.3 * size_m)

    @classmethod
    def to_grip(cls, size_m: float) -> Self:
        return cls(size_m, 0.6 * size_m, GRIP_HEIGHT_M)

    @classmethod
    def drawn(cls, chance: Chance) -> Drawn:
        size_m, top_m = chance.size_m, chance.size_m * chance.top
        depth_m = chance.depth_m(size_m)
        base_m = size_m + (GOES_ON - 1) * size_m * (1 - chance.top)
        return cls(base_m, top_m, GOES_ON * depth_m).at_random(chance, depth_m, size_m, size_m)

    def true_size_m(self, contact_m: tuple[float, float]) -> tuple[float, float]:
        return self.top_diameter_m, self.top_diameter_m

    def rise(self, x: NDArray[np.float64], y: NDArray[np.float64]) -> NDArray[np.float64]:
        run = (self.diameter_m - self.top_diameter_m) / 2
        return (self.diameter_m / 2 - np.hypot(x, y)) / run

    def body(self) -> tuple[Part, ...]:
        base = regular_polygon(48, self.diameter_m / 2)
        return (Part.prism(base, self.height_m, top_scale=self.top_diameter_m / self.diameter_m),)
