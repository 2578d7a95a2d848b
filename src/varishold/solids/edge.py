"""The straight border of a flat face."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from varishold.solids.raised import Endless

__all__ = ["Edge"]


@dataclass(frozen=True)
class Edge(Endless):
    """A flat face whose one straight border runs along y through the solid's origin; the face lies at x < 0.

    Parameters
    ----------
    height_m : float
        How far the face stands above the base plane. Metres.
    """

    name: ClassVar[str] = "edge"

    height_m: float

    def rise(self, x: NDArray[np.float64], y: NDArray[np.float64]) -> NDArray[np.float64]:
        return (x <= 0) + 0.0 * y
