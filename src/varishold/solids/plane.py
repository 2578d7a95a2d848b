"""A flat face larger than any pad."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from varishold.solids.raised import Endless

__all__ = ["Plane"]


@dataclass(frozen=True)
class Plane(Endless):
    """A flat face without borders.

    Parameters
    ----------
    height_m : float
        How far the face stands above the base plane. Metres.
    """

    name: ClassVar[str] = "plane"

    height_m: float

    def rise(self, x: NDArray[np.float64], y: NDArray[np.float64]) -> NDArray[np.float64]:
        return np.ones(np.broadcast(x, y).shape)
