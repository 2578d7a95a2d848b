"""A frustum of a pyramid."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Self

import numpy as np
from numpy.typing import NDArray

from varishold.solids.body import Part, regular_polygon
from varishold.solids.solid import Solid

__all__ = ["PyramidFrustum"]


@dataclass(frozen=True)
class PyramidFrustum(Solid):
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

    @property
    def top_m(self) -> float:
        return self.height_m

    @property
    def base_m(self) -> tuple[float, float]:
        return self.breadth_m, self.breadth_m

    def height(self, x: NDArray[np.float64], y: NDArray[np.float64]) -> NDArray[np.float64]:
        run = (self.breadth_m - self.top_breadth_m) / 2
        inward = self.breadth_m / 2 - np.maximum(np.abs(x), np.abs(y))
        return self.height_m * np.clip(inward / run, 0.0, 1.0)

    def body(self) -> tuple[Part, ...]:
        base = regular_polygon(4, self.breadth_m / np.sqrt(2), turn_rad=np.pi / 4)
        return (Part.prism(base, self.height_m, top_scale=self.top_breadth_m / self.breadth_m),)
