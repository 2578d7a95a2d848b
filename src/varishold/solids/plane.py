"""A flat face larger than any pad."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Self

import numpy as np
from numpy.typing import NDArray

from varishold.solids.solid import Solid

__all__ = ["Plane"]


@dataclass(frozen=True)
class Plane(Solid):
    """A flat face without borders.

    Parameters
    ----------
    height_m : float
        How far the face stands above the base plane. Metres.
    """

    name: ClassVar[str] = "plane"

    height_m: float

    @classmethod
    def of_size(cls, size_m: float) -> Self:
        return cls(size_m)

    @property
    def top_m(self) -> float:
        return self.height_m

    @property
    def base_m(self) -> tuple[float, float]:
        return np.inf, np.inf

    def height(self, x: NDArray[np.float64], y: NDArray[np.float64]) -> NDArray[np.float64]:
        return np.full(np.broadcast(x, y).shape, self.height_m)
