"""The end face of an upright cylinder."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Self

import numpy as np
from numpy.typing import NDArray

from varishold.solids.body import Part
from varishold.solids.solid import Solid

__all__ = ["Cylinder"]


@dataclass(frozen=True)
class Cylinder(Solid):
    """A cylinder that stands on its end: a flat circular face.

    Parameters
    ----------
    diameter_m : float
        Diameter of the face. Metres.
    height_m : float
        How far the face stands above the base plane. Metres.
    """

    name: ClassVar[str] = "cylinder"

    diameter_m: float
    height_m: float

    @classmethod
    def of_size(cls, size_m: float) -> Self:
        return cls(size_m, size_m)

    @property
    def top_m(self) -> float:
        return self.height_m

    @property
    def base_m(self) -> tuple[float, float]:
        return self.diameter_m, self.diameter_m

    def height(self, x: NDArray[np.float64], y: NDArray[np.float64]) -> NDArray[np.float64]:
        return np.where(x * x + y * y <= (self.diameter_m / 2) ** 2, self.height_m, 0.0)

    def body(self) -> tuple[Part, ...]:
        return (Part.cylinder(self.diameter_m, self.height_m),)
