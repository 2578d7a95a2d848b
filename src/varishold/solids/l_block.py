"""A block with the section of an L."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from varishold.solids.body import Part
from varishold.solids.raised import Standing

__all__ = ["LBlock"]


@dataclass(frozen=True)
class LBlock(Standing):
    """An upright square pillar that lacks a quarter, that of its own +x and +y.

    Parameters
    ----------
    breadth_m : float
        Size: breadth of the whole square. Metres.
    height_m : float
        How far the face stands above the base plane. Metres.
    """

    name: ClassVar[str] = "L-block"

    breadth_m: float
    height_m: float

    def rise(self, x: NDArray[np.float64], y: NDArray[np.float64]) -> NDArray[np.float64]:
        inside = np.maximum(np.abs(x), np.abs(y)) <= self.breadth_m / 2
        return (inside & ~((x > 0) & (y > 0))).astype(np.float64)

    def body(self) -> tuple[Part, ...]:
        quarter, half, tall = self.breadth_m / 4, self.breadth_m / 2, self.height_m / 2
        return (
            Part("box", (half, quarter, tall), (0.0, -quarter, tall)),
            Part("box", (quarter, quarter, tall), (-quarter, quarter, tall)),
        )
