"""A box: a pillar of three different lengths."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Self

from varishold.solids.raised import GRIP_HEIGHT_M
from varishold.solids.rectangular_pillar import RectangularPillar

__all__ = ["Box"]


@dataclass(frozen=True)
class Box(RectangularPillar):
    """A box that stands on its end; its size is its shorter breadth, and its sides are as 1.4 to 1.

    Parameters
    ----------
    length_m : float
        Longer side of the face. Metres.
    breadth_m : float
        Shorter side of the face. Metres.
    height_m : float
        How far the face stands above the base plane. Metres.
    """

    name: ClassVar[str] = "box"

    @classmethod
    def of_size(cls, size_m: float) -> Self:
        return cls(1.4 * size_m, size_m, GRIP_HEIGHT_M)

    @classmethod
    def to_lie(cls, size_m: float, aspects: tuple[float, float]) -> Self:
        return cls(aspects[1] * size_m, size_m, aspects[0] * size_m)
