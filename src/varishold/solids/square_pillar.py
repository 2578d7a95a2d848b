"""The end face of a square pillar."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Self

import numpy as np
from numpy.typing import NDArray

from varishold.solids.body import Part
from varishold.solids.solid import Solid

__all__ = ["SquarePillar"]


@dataclass(frozen=True)
class SquarePillar(Solid):
    """A square pillar that stands on its end: a flat square face.

    Parameters
    ----------
    breadth_m : float
        Side of the face. Metres.
    height_m : float
        How far the face stands above the base plane. Metres.
    """

    name: ClassVar[str] = "square pillar"

    breadth_m: float
    height_m: float

    @classmethod
    def of_size(cls, size_m: float) -> Self:
        return cls(size_m, size_m)

    @property
    def top_m(self) -> float:
        return self.height_m

    @property
    def base_m(self) -> tuple[float, float]:
        return self.breadth_m, self.breadth_m

    def height(self, x: NDArray[np.float64], y: NDArray[np.float64]) -> NDArray[np.float64]:
        half = self.breadth_m / 2
        return np.where((np.abs(x) <= half) & (np.abs(y) <= half), self.height_m, 0.0)

    def body(self) -> tuple[Part, ...]:
        return (Part.box(self.breadth_m, self.breadth_m, self.height_m),)
