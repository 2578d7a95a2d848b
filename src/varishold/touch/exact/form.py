"""What every fitted form has in common: parameters, and the face that they make over cells."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from varishold.skin.synthesis import CoarseFace
from varishold.touch.exact.slopes import Slopes, parameters

__all__ = ["Form", "Grid", "Start"]

Floats = NDArray[np.float64]

# Mean distance from a cell's middle, squared, in units of its side: rounds a cone's tip as a cell sees it.
_TIP = 0.1
# The middle of a disc has no normal; it lies too far inside to need one.
_NO_NORMAL = 1e-3


@dataclass(frozen=True)
class Grid:
    """Cells under a form; all lengths in taxels from the window's centre.

    Parameters
    ----------
    x, y : ndarray of shape (n_cells,), float64
        Middles of the cells.
    width, height : float
        Sides of a cell along x and y.
    """

    x: Floats
    y: Floats
    width: float
    height: float

    def across(self, c: float, s: float) -> float:
        """Return how far a cell reaches along the direction (c, s)."""
        return abs(c) * self.width + abs(s) * self.height

    def covered(self, inward: Slopes, c: Floats | float, s: Floats | float) -> Slopes:
        """Return the share of each cell on the inner side of a straight border.

        Parameters
        ----------
        inward : Slopes
            Distance of the cell's middle from the border, positive inside.
        c, s : float or ndarray
            Direction of the border's normal.
        """
        a, b = np.abs(c) * self.width, np.abs(s) * self.height
        long, short = np.maximum(np.maximum(a, b), _NO_NORMAL), np.maximum(np.minimum(a, b), 1e-6)
        d = np.abs(inward.value)
        rest = np.maximum((long + short) / 2 - d, 0.0)
        flank = rest < short
        far = np.where(flank, 1 - rest * rest / (2 * long * short), 0.5 + d / long)
        slope = np.where(flank, rest / (long * short), 1 / long)
        return inward.through(np.where(inward.value > 0, far, 1 - far), slope)

    def radius(self, dx: Slopes, dy: Slopes) -> Slopes:
        """Return the mean distance of each cell's points from a point."""
        return (dx * dx + dy * dy + _TIP * self.width * self.height).sqrt()


@dataclass(frozen=True)
class Start:
    """What the contact says before anything is fitted; lengths in taxels from the window's centre.

    Parameters
    ----------
    x, y : float
        Middle of the contact.
    long, short : float
        Sides of the rectangle that has the contact's second moments.
    yaw : float
        Direction of the long side.
    square_yaw : float
        Direction of a side, if it is a square.
    descent : float
        Direction in which the frame falls on the whole.
    """

    x: float
    y: float
    long: float
    short: float
    yaw: float
    square_yaw: float
    descent: float

    @property
    def crest(self) -> float:
        """Offset of the line along `yaw` through the middle."""
        return float(np.cos(self.yaw) * self.y - np.sin(self.yaw) * self.x)

    def reach(self, c: float, s: float) -> float:
        """Return how far the contact reaches from its middle along the direction (c, s)."""
        along = c * np.cos(self.yaw) + s * np.sin(self.yaw)
        across = s * np.cos(self.yaw) - c * np.sin(self.yaw)
        return float(0.5 * np.hypot(self.long * along, self.short * across))

    @property
    def breadth(self) -> float:
        """Side of the square that has the contact's area."""
        return float(np.sqrt(self.long * self.short))


class Form(ABC):
    """A form that can be fitted: one face for each set of parameters.

    Sizes are those at the contact line, where a stiff face would meet the free skin; the depth is 1.
    """

    #: Which of `varishold.touch.names.KINDS` it is.
    key: ClassVar[str]
    #: Names of the parameters; lengths in taxels, angles in radians.
    names: ClassVar[tuple[str, ...]]

    @abstractmethod
    def start(self, start: Start) -> Floats:
        """Return parameters to begin with."""

    @abstractmethod
    def wanted_and_covered(self, q: tuple[Slopes, ...], grid: Grid) -> tuple[Slopes, Slopes]:
        """Return how deep each cell would be pressed, as a share of the depth, and how much of it is covered."""

    def possible(self, q: Floats, width: float, height: float) -> bool:
        """Return whether the form would go by its own name in a window of this size, in taxels."""
        return True

    def face(self, q: Floats, grid: Grid) -> CoarseFace:
        """Return the face and its gradients."""
        wanted, covered = self.wanted_and_covered(parameters(q), grid)
        cells, count = grid.x.shape, (len(q), grid.x.size)
        return CoarseFace(
            wanted=np.ascontiguousarray(np.broadcast_to(wanted.value, cells)),
            covered=np.clip(np.broadcast_to(covered.value, cells), 0.0, 1.0),
            d_wanted=np.ascontiguousarray(np.broadcast_to(wanted.by, count)),
            d_covered=np.ascontiguousarray(np.broadcast_to(covered.by, count)),
        )


def constant(value: float, count: int) -> Slopes:
    """Return a value that depends on none of `count` parameters."""
    return Slopes(np.asarray(value), np.zeros((count, 1)))


def turned(x: Slopes, y: Slopes, yaw: Slopes, grid: Grid) -> tuple[Slopes, Slopes]:
    """Return each cell's middle along a form's own axes."""
    dx, dy, c, s = grid.x - x, grid.y - y, yaw.cos(), yaw.sin()
    return c * dx + s * dy, c * dy - s * dx
