"""A cylinder that lies on its side."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Self

import numpy as np
from numpy.typing import NDArray

from varishold.solids.solid import Solid

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

    diameter_m: float
    length_m: float

    @classmethod
    def of_size(cls, size_m: float) -> Self:
        return cls(size_m, 4 * size_m)

    @property
    def top_m(self) -> float:
        return self.diameter_m / 2

    @property
    def base_m(self) -> tuple[float, float]:
        return self.length_m, self.diameter_m

    def height(self, x: NDArray[np.float64], y: NDArray[np.float64]) -> NDArray[np.float64]:
        arch = np.sqrt(np.maximum((self.diameter_m / 2) ** 2 - y * y, 0.0))
        return np.where(np.abs(x) <= self.length_m / 2, arch, 0.0)
