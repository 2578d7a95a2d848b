"""A cone's tip."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Self

import numpy as np
from numpy.typing import NDArray

from varishold.solids.body import Part, regular_polygon
from varishold.solids.solid import Solid

__all__ = ["Cone"]


@dataclass(frozen=True)
class Cone(Solid):
    """A circular cone, tip toward the skin.

    Parameters
    ----------
    diameter_m : float
        Diameter of the base. Metres.
    height_m : float
        Height of the tip above the base plane. Metres.
    """

    name: ClassVar[str] = "cone"

    diameter_m: float
    height_m: float

    @classmethod
    def of_size(cls, size_m: float) -> Self:
        return cls(size_m, 0.5 * size_m)

    @property
    def top_m(self) -> float:
        return self.height_m

    @property
    def base_m(self) -> tuple[float, float]:
        return self.diameter_m, self.diameter_m

    def height(self, x: NDArray[np.float64], y: NDArray[np.float64]) -> NDArray[np.float64]:
        return self.height_m * np.maximum(1 - np.hypot(x, y) / (self.diameter_m / 2), 0.0)

    def body(self) -> tuple[Part, ...]:
        return (Part.prism(regular_polygon(48, self.diameter_m / 2), self.height_m, top_scale=0.0),)
