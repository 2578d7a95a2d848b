"""The end face of an upright cylinder."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from varishold.solids.body import Part
from varishold.solids.upright import Pillar

__all__ = ["Cylinder"]


@dataclass(frozen=True)
class Cylinder(Pillar):
    """A cylinder that stands on its end: a flat circular face.

    Parameters
    ----------
    diameter_m : float
        Diameter of the face. Metres.
    height_m : float
        How far the face stands above the base plane. Metres.
    """

    name: ClassVar[str] = "cylinder"
    round: ClassVar[bool] = True

    diameter_m: float
    height_m: float

    def rise(self, x: NDArray[np.float64], y: NDArray[np.float64]) -> NDArray[np.float64]:
        return (x * x + y * y <= (self.diameter_m / 2) ** 2).astype(np.float64)

    def body(self) -> tuple[Part, ...]:
        return (Part.cylinder(self.diameter_m, self.height_m),)
