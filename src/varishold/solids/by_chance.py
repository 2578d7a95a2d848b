"""A thing that is drawn by chance, and which nobody has a name for."""

from __future__ import annotations

from abc import abstractmethod
from dataclasses import dataclass
from functools import cached_property
from typing import Self

import numpy as np
from numpy.typing import NDArray

from varishold.solids.body import Part
from varishold.solids.body_height import height_of, top_of
from varishold.solids.solid import Solid

__all__ = ["DrawnByChance", "prism_corners", "turn_by"]


@dataclass(frozen=True)
class DrawnByChance(Solid):
    """A thing of hulls: its number draws them, and they are moved to the middle of the base plane and scaled.

    Its face is told from above only roughly; it is made to be gripped, and to be none of the solids that have names.

    Parameters
    ----------
    breadth_m : float
        Size: its breadth along its own y. Metres.
    number : int
        Which of all of its kind it is.
    """

    breadth_m: float
    number: int = 1

    @classmethod
    def of_size(cls, size_m: float) -> Self:
        return cls(size_m)

    @property
    def top_m(self) -> float:
        return top_of(self.body())

    def height(self, x: NDArray[np.float64], y: NDArray[np.float64]) -> NDArray[np.float64]:
        return height_of(self.body(), x, y)

    def body(self) -> tuple[Part, ...]:
        return self._parts

    @abstractmethod
    def drawn_hulls(self) -> list[NDArray[np.float64]]:
        """Return the corners of each hull, shape (n, 3), in any place and of any size.

        :meta private:
        """

    @cached_property
    def _parts(self) -> tuple[Part, ...]:
        parts = self.drawn_hulls()
        everything = np.vstack(parts)
        low, high = everything.min(axis=0), everything.max(axis=0)
        shift = np.array([(low[0] + high[0]) / 2, (low[1] + high[1]) / 2, low[2]])
        scale = self.breadth_m / (high[1] - low[1])
        return tuple(Part.hull((corners - shift) * scale) for corners in parts)


def turn_by(turn_rad: float) -> NDArray[np.float64]:
    """Return the matrix (2, 2) that turns the rows of a section (n, 2) from x to y: ``section @ turn_by(turn_rad)``."""
    c, s = np.cos(turn_rad), np.sin(turn_rad)
    return np.array([[c, s], [-s, c]])


def prism_corners(
    section: NDArray[np.float64], tall: float, *, start: float = 0.0, top: float = 1.0
) -> NDArray[np.float64]:
    """Return the corners (2 n, 3) of a section (n, 2) at the height `start` and, `top` times as large, on top."""
    low = np.column_stack([section, np.full(len(section), start)])
    return np.vstack([low, np.column_stack([section * top, np.full(len(section), start + tall)])])
