"""A straight wedge without ends."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Self

import numpy as np
from numpy.typing import NDArray

from varishold.solids.solid import Solid

__all__ = ["Wedge"]


@dataclass(frozen=True)
class Wedge(Solid):
    """A wedge whose crest runs along x and leaves the field at both ends.

    Parameters
    ----------
    breadth_m : float
        Breadth of the base across the crest. Metres.
    height_m : float
        Height of the crest above the base plane. Metres.
    """

    name: ClassVar[str] = "edge"

    breadth_m: float
    height_m: float

    @classmethod
    def of_size(cls, size_m: float) -> Self:
        return cls(size_m, 0.5 * size_m)

    @property
    def top_m(self) -> float:
        return self.height_m

    @property
    def base_m(self) -> tuple[float, float]:
        return np.inf, self.breadth_m

    def height(self, x: NDArray[np.float64], y: NDArray[np.float64]) -> NDArray[np.float64]:
        return self.height_m * np.maximum(1 - np.abs(y) / (self.breadth_m / 2), 0.0) + 0.0 * x
