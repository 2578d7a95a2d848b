"""The end face of a square pillar."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from varishold.solids.body import Part
from varishold.solids.upright import Pillar

__all__ = ["SquarePillar"]


@dataclass(frozen=True)
class SquarePillar(Pillar):
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

    def rise(self, x: NDArray[np.float64], y: NDArray[np.float64]) -> NDArray[np.float64]:
        return (np.maximum(np.abs(x), np.abs(y)) <= self.breadth_m / 2).astype(np.float64)

    def body(self) -> tuple[Part, ...]:
        return (Part.box(self.breadth_m, self.breadth_m, self.height_m),)
