"""A gabled ridge."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Self

import numpy as np
from numpy.typing import NDArray

from varishold.solids.solid import Solid

__all__ = ["Ridge"]


@dataclass(frozen=True)
class Ridge(Solid):
    """A gabled roof: its crest runs the whole length, its ends are upright.

    Parameters
    ----------
    length_m : float
        Length of the crest and of the base. Metres.
    breadth_m : float
        Breadth of the base across the crest. Metres.
    height_m : float
        Height of the crest above the base plane. Metres.
    """

    name: ClassVar[str] = "ridge"

    length_m: float
    breadth_m: float
    height_m: float

    @classmethod
    def of_size(cls, size_m: float) -> Self:
        return cls(1.8 * size_m, size_m, 0.5 * size_m)

    @property
    def top_m(self) -> float:
        return self.height_m

    @property
    def base_m(self) -> tuple[float, float]:
        return self.length_m, self.breadth_m

    def height(self, x: NDArray[np.float64], y: NDArray[np.float64]) -> NDArray[np.float64]:
        slope = self.height_m * np.maximum(1 - np.abs(y) / (self.breadth_m / 2), 0.0)
        return np.where(np.abs(x) <= self.length_m / 2, slope, 0.0)
