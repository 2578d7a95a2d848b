"""A cone's tip."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from varishold.solids.upright import Disc, Tip

__all__ = ["Cone"]


@dataclass(frozen=True)
class Cone(Disc, Tip):
    """A circular cone, tip toward the skin.

    Parameters
    ----------
    diameter_m : float
        Diameter of the base. Metres.
    height_m : float
        Height of the tip above the base plane. Metres.
    """

    name: ClassVar[str] = "cone"

    diameter_m: float
    height_m: float
