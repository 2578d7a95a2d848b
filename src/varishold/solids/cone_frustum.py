"""A frustum of a cone."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Self

import numpy as np
from numpy.typing import NDArray

from varishold.solids.body import Part, regular_polygon
from varishold.solids.solid import Solid

__all__ = ["ConeFrustum"]


@dataclass(frozen=True)
class ConeFrustum(Solid):
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

    diameter_m: float
    top_diameter_m: float
    height_m: float

    @classmethod
    def of_size(cls, size_m: float) -> Self:
        return cls(size_m, 0.45 * size_m, 0.3 * size_m)

    @property
    def top_m(self) -> float:
        return self.height_m

    @property
    def base_m(self) -> tuple[float, float]:
        return self.diameter_m, self.diameter_m

    def height(self, x: NDArray[np.float64], y: NDArray[np.float64]) -> NDArray[np.float64]:
        run = (self.diameter_m - self.top_diameter_m) / 2
        return self.height_m * np.clip((self.diameter_m / 2 - np.hypot(x, y)) / run, 0.0, 1.0)

    def body(self) -> tuple[Part, ...]:
        base = regular_polygon(48, self.diameter_m / 2)
        return (Part.prism(base, self.height_m, top_scale=self.top_diameter_m / self.diameter_m),)
