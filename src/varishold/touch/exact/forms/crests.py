"""Faces with a crest: ridge, hip, lying cylinder and the endless ones among them."""

from __future__ import annotations

from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from varishold.touch.exact.form import Form, Grid, Start, constant, turned
from varishold.touch.exact.forms.flat import within
from varishold.touch.exact.slopes import Slopes

__all__ = ["Arch", "EndlessArch", "EndlessGable", "Gable", "Hipped"]

Floats = NDArray[np.float64]

_BEYOND = 1.15


def _across(q: tuple[Slopes, ...], grid: Grid) -> tuple[Slopes, float]:
    """Return the distance from an endless crest, and a cell's reach across it."""
    offset, yaw = q[:2]
    c, s = yaw.cos(), yaw.sin()
    return c * grid.y - s * grid.x - offset, grid.across(float(s.value), float(c.value))


class Gable(Form):
    """A ridge, its gables upright."""

    key = "ridge"
    names: ClassVar = ("x", "y", "yaw", "length", "breadth")

    def start(self, start: Start) -> Floats:
        return np.array([start.x, start.y, start.yaw, start.long, _BEYOND * start.short])

    def wanted_and_covered(self, q: tuple[Slopes, ...], grid: Grid) -> tuple[Slopes, Slopes]:
        x, y, yaw, length, breadth = q
        u, v = turned(x, y, yaw, grid)
        c, s = yaw.cos(), yaw.sin()
        width = grid.across(float(s.value), float(c.value))
        return 1.0 - v.magnitude(width) / (breadth / 2), within(u, length / 2, c, s, grid)


class Hipped(Form):
    """A hip, which slopes at its ends as at its sides."""

    key = "hip"
    names: ClassVar = ("x", "y", "yaw", "length", "breadth")

    def start(self, start: Start) -> Floats:
        return np.array([start.x, start.y, start.yaw, _BEYOND * start.long, _BEYOND * start.short])

    def wanted_and_covered(self, q: tuple[Slopes, ...], grid: Grid) -> tuple[Slopes, Slopes]:
        x, y, yaw, length, breadth = q
        u, v = turned(x, y, yaw, grid)
        width = grid.across(float(np.cos(yaw.value)), float(np.sin(yaw.value)))
        end = u.magnitude(width) - (length - breadth) / 2
        return 1.0 - v.magnitude(width).greater(end, width) / (breadth / 2), constant(1.0, 5)


class Arch(Form):
    """A lying cylinder that ends within the field."""

    key = "lying-cylinder"
    names: ClassVar = ("x", "y", "yaw", "length", "breadth")

    def start(self, start: Start) -> Floats:
        return np.array([start.x, start.y, start.yaw, start.long, _BEYOND * start.short])

    def wanted_and_covered(self, q: tuple[Slopes, ...], grid: Grid) -> tuple[Slopes, Slopes]:
        x, y, yaw, length, breadth = q
        u, v = turned(x, y, yaw, grid)
        c, s = yaw.cos(), yaw.sin()
        return 1.0 - v * v / (breadth * breadth / 4), within(u, length / 2, c, s, grid)


class EndlessArch(Form):
    """A lying cylinder that leaves the field at both ends."""

    key = "lying-cylinder"
    names: ClassVar = ("offset", "yaw", "breadth")

    def start(self, start: Start) -> Floats:
        return np.array([start.crest, start.yaw, _BEYOND * start.short])

    def wanted_and_covered(self, q: tuple[Slopes, ...], grid: Grid) -> tuple[Slopes, Slopes]:
        v, _ = _across(q, grid)
        return 1.0 - v * v / (q[2] * q[2] / 4), constant(1.0, 3)


class EndlessGable(Form):
    """A wedge."""

    key = "wedge"
    names: ClassVar = ("offset", "yaw", "breadth")

    def start(self, start: Start) -> Floats:
        return np.array([start.crest, start.yaw, _BEYOND * start.short])

    def wanted_and_covered(self, q: tuple[Slopes, ...], grid: Grid) -> tuple[Slopes, Slopes]:
        v, width = _across(q, grid)
        return 1.0 - v.magnitude(width) / (q[2] / 2), constant(1.0, 3)
