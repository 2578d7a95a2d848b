"""An ellipsoid's cap."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Self

import numpy as np
from numpy.typing import NDArray

from varishold.solids.body import Part
from varishold.solids.solid import Solid

__all__ = ["Ellipsoid"]


@dataclass(frozen=True)
class Ellipsoid(Solid):
    """An ellipsoid of three different axes, of which the half above its equator can touch.

    Parameters
    ----------
    length_m, breadth_m, height_m : float
        Axes along its own x, y and z; its size is its breadth. Metres.
    """

    name: ClassVar[str] = "ellipsoid"

    length_m: float
    breadth_m: float
    height_m: float

    @classmethod
    def of_size(cls, size_m: float) -> Self:
        return cls(1.5 * size_m, size_m, 0.8 * size_m)

    @property
    def top_m(self) -> float:
        return self.height_m / 2

    def height(self, x: NDArray[np.float64], y: NDArray[np.float64]) -> NDArray[np.float64]:
        r2 = (2 * x / self.length_m) ** 2 + (2 * y / self.breadth_m) ** 2
        return self.height_m / 2 * np.sqrt(np.maximum(1 - r2, 0.0))

    def body(self) -> tuple[Part, ...]:
        return (Part.ellipsoid(self.length_m, self.breadth_m, self.height_m),)
