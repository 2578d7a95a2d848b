"""A frustum of a pyramid."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from varishold.solids.upright import Frustum, Square

__all__ = ["PyramidFrustum"]


@dataclass(frozen=True)
class PyramidFrustum(Square, Frustum):
    """A square pyramid whose tip is cut off level.

    Parameters
    ----------
    breadth_m : float
        Side of the base. Metres.
    top_breadth_m : float
        Side of the flat top. Metres.
    height_m : float
        Height of the top above the base plane. Metres.
    """

    name: ClassVar[str] = "frustum of a pyramid"

    breadth_m: float
    top_breadth_m: float
    height_m: float
