"""A pyramid's tip."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from varishold.solids.upright import Square, Tip

__all__ = ["Pyramid"]


@dataclass(frozen=True)
class Pyramid(Square, Tip):
    """A square pyramid, tip toward the skin.

    Parameters
    ----------
    breadth_m : float
        Side of the base. Metres.
    height_m : float
        Height of the tip above the base plane. Metres.
    """

    name: ClassVar[str] = "pyramid"

    breadth_m: float
    height_m: float
