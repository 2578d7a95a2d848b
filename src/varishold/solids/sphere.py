"""A sphere's cap."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Self

import numpy as np
from numpy.typing import NDArray

from varishold.solids.body import Part
from varishold.solids.chance import Chance
from varishold.solids.solid import Drawn, Solid

__all__ = ["Sphere"]


@dataclass(frozen=True)
class Sphere(Solid):
    """A sphere, of which the half above its equator can touch.

    Parameters
    ----------
    diameter_m : float
        Diameter of the sphere. Metres.
    """

    name: ClassVar[str] = "sphere"
    round: ClassVar[bool] = True

    diameter_m: float

    @classmethod
    def of_size(cls, size_m: float) -> Self:
        return cls(size_m)

    @classmethod
    def drawn(cls, chance: Chance) -> Drawn:
        depth_m, diameter_m = chance.cap()
        return cls(diameter_m).at_random(chance, depth_m, chance.size_m, chance.size_m)

    @property
    def top_m(self) -> float:
        return self.diameter_m / 2

    def height(self, x: NDArray[np.float64], y: NDArray[np.float64]) -> NDArray[np.float64]:
        return np.sqrt(np.maximum((self.diameter_m / 2) ** 2 - x * x - y * y, 0.0))

    def body(self) -> tuple[Part, ...]:
        return (Part.ellipsoid(self.diameter_m, self.diameter_m, self.diameter_m),)
