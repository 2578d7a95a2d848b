"""The end face of a hexagonal prism."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from varishold.solids.prism import RegularPrism

__all__ = ["HexagonalPrism"]


@dataclass(frozen=True)
class HexagonalPrism(RegularPrism):
    """An upright prism on a regular polygon of 6 sides.

    Parameters
    ----------
    breadth_m : float
        Size: from a side to the side or corner opposite. Metres.
    height_m : float
        How far the face stands above the base plane. Metres.
    """

    name: ClassVar[str] = "hexagonal prism"
    sides: ClassVar[int] = 6
