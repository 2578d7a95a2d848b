"""What the prisms on a regular polygon have in common."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Self

import numpy as np
from numpy.typing import NDArray

from varishold.solids.body import Part, regular_polygon
from varishold.solids.solid import Solid

__all__ = ["RegularPrism"]


@dataclass(frozen=True)
class RegularPrism(Solid):
    """An upright prism on a regular polygon.

    Parameters
    ----------
    breadth_m : float
        Size: from a side to the side or corner opposite. Metres.
    height_m : float
        How far the face stands above the base plane. Metres.
    """

    #: Number of sides of the face.
    sides: ClassVar[int]

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
        corners = self._corners()
        x_m, y_m = 2 * np.abs(corners).max(axis=0)
        return float(x_m), float(y_m)

    @property
    def side_distance_m(self) -> float:
        """Distance of each side from the middle, metres."""
        opposite = 1.0 if self.sides % 2 == 0 else 1.0 / np.cos(np.pi / self.sides)
        return float(self.breadth_m / (1.0 + opposite))

    def _corners(self) -> NDArray[np.float64]:
        # One side stands across -x, so that an unturned prism shows a flat side to a palm.
        radius = self.side_distance_m / np.cos(np.pi / self.sides)
        return regular_polygon(self.sides, radius, turn_rad=np.pi + np.pi / self.sides)

    def height(self, x: NDArray[np.float64], y: NDArray[np.float64]) -> NDArray[np.float64]:
        angle = np.pi + 2 * np.pi * np.arange(self.sides) / self.sides
        reach = np.cos(angle) * np.asarray(x)[..., None] + np.sin(angle) * np.asarray(y)[..., None]
        return np.where(reach.max(axis=-1) <= self.side_distance_m, self.height_m, 0.0)

    def body(self) -> tuple[Part, ...]:
        return (Part.prism(self._corners(), self.height_m),)
