"""A pyramid's tip."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Self

import numpy as np
from numpy.typing import NDArray

from varishold.solids.body import Part, regular_polygon
from varishold.solids.solid import Solid

__all__ = ["Pyramid"]


@dataclass(frozen=True)
class Pyramid(Solid):
    """A square pyramid, tip toward the skin.

    Parameters
    ----------
    breadth_m : float
        Side of the base. Metres.
    height_m : float
        Height of the tip above the base plane. Metres.
    """

    name: ClassVar[str] = "pyramid"

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
        return self.breadth_m, self.breadth_m

    def height(self, x: NDArray[np.float64], y: NDArray[np.float64]) -> NDArray[np.float64]:
        return self.height_m * np.maximum(1 - np.maximum(np.abs(x), np.abs(y)) / (self.breadth_m / 2), 0.0)

    def body(self) -> tuple[Part, ...]:
        base = regular_polygon(4, self.breadth_m / np.sqrt(2), turn_rad=np.pi / 4)
        return (Part.prism(base, self.height_m, top_scale=0.0),)
