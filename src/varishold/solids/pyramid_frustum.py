"""A frustum of a pyramid."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Self

import numpy as np
from numpy.typing import NDArray

from varishold.solids.body import Part, regular_polygon
from varishold.solids.chance import GOES_ON, Chance
from varishold.solids.raised import GRIP_HEIGHT_M, Raised
from varishold.solids.solid import Drawn

__all__ = ["PyramidFrustum"]


@dataclass(frozen=True)
class PyramidFrustum(Raised):
    """A square pyramid whose tip is cut off level.

    Parameters
    ----------
    breadth_m : float
        Side of the base. Metres.
    top_breadth_m : float
        Side of the flat top. Metres.
    height_m : float
        Height of the top above the base plane. Metres.
    """

    name: ClassVar[str] = "frustum of a pyramid"

    breadth_m: float
    top_breadth_m: float
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
        return self.top_breadth_m, self.top_breadth_m

    def rise(self, x: NDArray[np.float64], y: NDArray[np.float64]) -> NDArray[np.float64]:
        run = (self.breadth_m - self.top_breadth_m) / 2
        return (self.breadth_m / 2 - np.maximum(np.abs(x), np.abs(y))) / run

    def body(self) -> tuple[Part, ...]:
        base = regular_polygon(4, self.breadth_m / np.sqrt(2), turn_rad=np.pi / 4)
        return (Part.prism(base, self.height_m, top_scale=self.top_breadth_m / self.breadth_m),)
