"""What the prisms on a regular polygon have in common."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from varishold.solids.body import Part, regular_polygon
from varishold.solids.raised import Standing

__all__ = ["RegularPrism"]


@dataclass(frozen=True)
class RegularPrism(Standing):
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

    @property
    def side_distance_m(self) -> float:
        """Distance of each side from the middle, metres."""
        opposite = 1.0 if self.sides % 2 == 0 else 1.0 / np.cos(np.pi / self.sides)
        return float(self.breadth_m / (1.0 + opposite))

    def _corners(self) -> NDArray[np.float64]:
        # One side stands across -x, so that an unturned prism shows a flat side to a palm.
        radius = self.side_distance_m / np.cos(np.pi / self.sides)
        return regular_polygon(self.sides, radius, turn_rad=np.pi + np.pi / self.sides)

    def rise(self, x: NDArray[np.float64], y: NDArray[np.float64]) -> NDArray[np.float64]:
        angle = np.pi + 2 * np.pi * np.arange(self.sides) / self.sides
        reach = np.cos(angle) * np.asarray(x)[..., None] + np.sin(angle) * np.asarray(y)[..., None]
        return np.where(reach.max(axis=-1) <= self.side_distance_m, 1.0, 0.0)

    def body(self) -> tuple[Part, ...]:
        return (Part.prism(self._corners(), self.height_m),)
