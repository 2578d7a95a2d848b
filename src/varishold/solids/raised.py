"""What all faces with a height of their own have in common."""

from __future__ import annotations

from abc import abstractmethod

import numpy as np
from numpy.typing import NDArray

from varishold.solids.solid import Solid

__all__ = ["GRIP_HEIGHT_M", "Raised"]

#: Height of an upright object for a hand: the palm's height and a margin above and below it. Metres.
GRIP_HEIGHT_M = 0.16


class Raised(Solid):
    """A face that rises from the base plane to `height_m`, the last of its fields."""

    height_m: float

    @property
    def top_m(self) -> float:
        return self.height_m

    @abstractmethod
    def rise(self, x: NDArray[np.float64], y: NDArray[np.float64]) -> NDArray[np.float64]:
        """Height at points of the solid's own axes in parts of `height_m`; it is cut to between 0 and 1."""

    def height(self, x: NDArray[np.float64], y: NDArray[np.float64]) -> NDArray[np.float64]:
        return self.height_m * np.clip(self.rise(x, y), 0.0, 1.0)
