"""What chance gives to the drawing of a contact."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

__all__ = ["GOES_ON", "Chance"]

#: How far a sloped solid goes on below its contact line, as a multiple of the contact's depth, so that a skin that
#: piles up meets no end of it.
GOES_ON = 2.0


@dataclass(frozen=True)
class Chance:
    """The numbers from which a solid makes itself when it is drawn at random.

    Parameters
    ----------
    rng : numpy.random.Generator
        Source of whatever else the solid draws.
    field_m : (float, float)
        Height (along y) and width (along x) of the pad. Metres.
    size_m : float
        Diameter or breadth of the contact at the contact line, the longer one where there are two. Metres.
    aspect : float
        Long over short side of what is longer than broad.
    slope : float
        Depth over the contact's short side.
    top : float
        A frustum's top over its base at the contact line.
    yaw_rad : float
        Turn from +x toward +y.
    wanted_depth_m : float or None
        Depth to use instead of the one that the slope gives. Metres.
    """

    rng: np.random.Generator
    field_m: tuple[float, float]
    size_m: float
    aspect: float
    slope: float
    top: float
    yaw_rad: float
    wanted_depth_m: float | None = None

    def depth_m(self, short_m: float) -> float:
        """Return the depth of a contact whose short side is `short_m`."""
        return self.slope * short_m if self.wanted_depth_m is None else self.wanted_depth_m

    def cap(self) -> tuple[float, float]:
        """Return depth and diameter of a ball or a lying cylinder that the contact line cuts at `size_m`.

        Never deeper than its middle. Metres.
        """
        size = self.size_m
        depth = min(self.depth_m(size), size / 2)
        return depth, 2 * (size * size / 4 + depth * depth) / (2 * depth)
