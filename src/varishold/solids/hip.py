"""A hip roof."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Self

import numpy as np
from numpy.typing import NDArray

from varishold.solids.solid import Solid

__all__ = ["Hip"]


@dataclass(frozen=True)
class Hip(Solid):
    """A hip roof: four sides of equal slope that meet in a crest shorter than the base.

    Parameters
    ----------
    length_m : float
        Longer side of the base; the crest is `length_m - breadth_m` long. Metres.
    breadth_m : float
        Shorter side of the base. Metres.
    height_m : float
        Height of the crest above the base plane. Metres.
    """

    name: ClassVar[str] = "hip"

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
        inward = np.minimum(self.length_m / 2 - np.abs(x), self.breadth_m / 2 - np.abs(y))
        return self.height_m * np.maximum(inward / (self.breadth_m / 2), 0.0)
