"""The straight border of a flat face."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Self

import numpy as np
from numpy.typing import NDArray

from varishold.solids.solid import Solid

__all__ = ["Edge"]


@dataclass(frozen=True)
class Edge(Solid):
    """A flat face whose one straight border runs along y through the solid's origin; the face lies at x < 0.

    Parameters
    ----------
    height_m : float
        How far the face stands above the base plane. Metres.
    """

    name: ClassVar[str] = "edge"

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
        return np.where(x <= 0, self.height_m, 0.0) + 0.0 * y
