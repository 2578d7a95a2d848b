"""A cylinder that lies on its side."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Self

import numpy as np
from numpy.typing import NDArray

from varishold.solids.chance import Chance
from varishold.solids.solid import Drawn, Solid

__all__ = ["LyingCylinder"]


@dataclass(frozen=True)
class LyingCylinder(Solid):
    """A cylinder that lies on its side, its axis along x.

    Parameters
    ----------
    diameter_m : float
        Diameter of the cylinder. Metres.
    length_m : float
        Length of the cylinder. Metres.
    """

    name: ClassVar[str] = "lying cylinder"
    may_leave_field: ClassVar[bool] = True

    diameter_m: float
    length_m: float

    @classmethod
    def of_size(cls, size_m: float) -> Self:
        return cls(size_m, 4 * size_m)

    @classmethod
    def drawn(cls, chance: Chance) -> Drawn:
        depth_m, diameter_m = chance.cap()
        # A third leave the field at both ends; of the rest some end inside it.
        leaves = chance.rng.random() < 1 / 3
        length_m = 4 * max(chance.field_m) if leaves else float(chance.rng.uniform(1.3, 3.0)) * chance.size_m
        return cls(diameter_m, length_m).at_random(chance, depth_m, length_m, chance.size_m)

    @property
    def top_m(self) -> float:
        return self.diameter_m / 2

    def height(self, x: NDArray[np.float64], y: NDArray[np.float64]) -> NDArray[np.float64]:
        arch = np.sqrt(np.maximum((self.diameter_m / 2) ** 2 - y * y, 0.0))
        return np.where(np.abs(x) <= self.length_m / 2, arch, 0.0)
