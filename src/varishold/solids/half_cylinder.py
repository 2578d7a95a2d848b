"""A cylinder cut in half along its axis."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from varishold.solids.body import Part
from varishold.solids.raised import Standing

__all__ = ["HalfCylinder"]

# Corners of the half circle of its body.
_CORNERS = 25


@dataclass(frozen=True)
class HalfCylinder(Standing):
    """An upright half cylinder; its flat side looks along its own -x.

    Parameters
    ----------
    diameter_m : float
        Size: breadth of its flat side. Metres.
    height_m : float
        How far the face stands above the base plane. Metres.
    """

    name: ClassVar[str] = "half cylinder"

    diameter_m: float
    height_m: float

    def rise(self, x: NDArray[np.float64], y: NDArray[np.float64]) -> NDArray[np.float64]:
        radius = self.diameter_m / 2
        from_side = x + radius / 2
        return ((from_side >= 0) & (from_side * from_side + y * y <= radius * radius)).astype(np.float64)

    def body(self) -> tuple[Part, ...]:
        radius = self.diameter_m / 2
        angle = np.linspace(-np.pi / 2, np.pi / 2, _CORNERS)
        section = radius * np.column_stack([np.cos(angle) - 0.5, np.sin(angle)])
        return (Part.prism(section, self.height_m),)
