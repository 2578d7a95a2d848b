"""A frustum of a cone."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from varishold.solids.upright import Disc, Frustum

__all__ = ["ConeFrustum"]


@dataclass(frozen=True)
class ConeFrustum(Disc, Frustum):
    """A cone whose tip is cut off level.

    Parameters
    ----------
    diameter_m : float
        Diameter of the base. Metres.
    top_diameter_m : float
        Diameter of the flat top. Metres.
    height_m : float
        Height of the top above the base plane. Metres.
    """

    name: ClassVar[str] = "frustum of a cone"

    diameter_m: float
    top_diameter_m: float
    height_m: float
