"""Where the phalanges of a hand lie, in the palm's frame."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

__all__ = ["Phalanges"]


@dataclass(frozen=True)
class Phalanges:
    """Each phalanx in the palm's frame, in the order of `Hand.parts`, without the palm.

    Parameters
    ----------
    parts : tuple of str
        Their names.
    start_m : ndarray of shape (n, 3)
        The near end of its middle line. Metres.
    along : ndarray of shape (n, 3)
        Unit vector from its near end to its far end.
    inward : ndarray of shape (n, 3)
        Unit vector to the side that it closes to.
    length_m, radius_m : ndarray of shape (n,)
        Metres.
    half_breadth_m : ndarray of shape (n,)
        How far it reaches beyond its radius across `along` and `inward`. Metres.
    opposed : ndarray of shape (n,), bool
        Which are of digits that close toward the fingers.
    """

    parts: tuple[str, ...]
    start_m: NDArray[np.float64]
    along: NDArray[np.float64]
    inward: NDArray[np.float64]
    length_m: NDArray[np.float64]
    radius_m: NDArray[np.float64]
    half_breadth_m: NDArray[np.float64]
    opposed: NDArray[np.bool_]

    @property
    def middle_m(self) -> NDArray[np.float64]:
        """The middle of each phalanx's inner side, shape (n, 3), metres: where a switch says "here"."""
        half = (self.length_m / 2)[:, None]
        return self.start_m + half * self.along + self.radius_m[:, None] * self.inward
