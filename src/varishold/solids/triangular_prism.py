"""The end face of a triangular prism."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from varishold.solids.prism import RegularPrism

__all__ = ["TriangularPrism"]


@dataclass(frozen=True)
class TriangularPrism(RegularPrism):
    """An upright prism on a regular polygon of 3 sides.

    Parameters
    ----------
    breadth_m : float
        Size: from a side to the side or corner opposite. Metres.
    height_m : float
        How far the face stands above the base plane. Metres.
    """

    name: ClassVar[str] = "triangular prism"
    sides: ClassVar[int] = 3
