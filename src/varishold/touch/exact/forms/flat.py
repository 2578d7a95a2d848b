"""Flat faces: pillars, the edge and the plane."""

from __future__ import annotations

from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from varishold.touch.exact.form import Form, Grid, Start, constant, turned
from varishold.touch.exact.slopes import Slopes

__all__ = ["Border", "Disc", "Everywhere", "Rectangle", "Square", "within"]

Floats = NDArray[np.float64]

# A side nearer than this to the field's border is not seen: with fewer than three sides a rectangle is a part
# of an edge or a plane, whose face may end where the skin does.
# A disc that is cut in a corner still shows two of its four quarters' ends.
_RIM = 0.25
_SIDES, _QUARTERS = 3, 2


def within(u: Slopes, half: Slopes, c: Slopes, s: Slopes, grid: Grid) -> Slopes:
    """Return the share of each cell between two parallel borders, `half` away from u = 0 on either side."""
    cos, sin = float(c.value), float(s.value)
    return grid.covered(half - u, cos, sin) + grid.covered(half + u, cos, sin) - 1.0


def _sides_inside(x: float, y: float, yaw: float, length: float, breadth: float, width: float, height: float) -> int:
    """Return how many of a rectangle's sides have their middle inside the window."""
    c, s = np.cos(yaw), np.sin(yaw)
    u = np.array([length / 2, -length / 2, 0.0, 0.0])
    v = np.array([0.0, 0.0, breadth / 2, -breadth / 2])
    at_x, at_y = x + c * u - s * v, y + s * u + c * v
    return int(np.sum((np.abs(at_x) < width / 2 - _RIM) & (np.abs(at_y) < height / 2 - _RIM)))


class Disc(Form):
    """The flat end of a cylinder."""

    key = "cylinder"
    names: ClassVar = ("x", "y", "diameter")

    def start(self, start: Start) -> Floats:
        return np.array([start.x, start.y, 1.128 * start.breadth])

    def wanted_and_covered(self, q: tuple[Slopes, ...], grid: Grid) -> tuple[Slopes, Slopes]:
        x, y, diameter = q
        dx, dy = grid.x - x, grid.y - y
        r = grid.radius(dx, dy)
        return constant(1.0, 3), grid.covered(diameter / 2 - r, dx.value / r.value, dy.value / r.value)

    def possible(self, q: Floats, width: float, height: float) -> bool:
        x, y, diameter = q.tolist()
        return _sides_inside(x, y, 0.0, diameter, diameter, width, height) >= _QUARTERS


class Square(Form):
    """The flat end of a square pillar."""

    key = "square-pillar"
    names: ClassVar = ("x", "y", "yaw", "breadth")

    def start(self, start: Start) -> Floats:
        return np.array([start.x, start.y, start.square_yaw, start.breadth])

    def wanted_and_covered(self, q: tuple[Slopes, ...], grid: Grid) -> tuple[Slopes, Slopes]:
        x, y, yaw, breadth = q
        u, v = turned(x, y, yaw, grid)
        c, s = yaw.cos(), yaw.sin()
        return constant(1.0, 4), within(u, breadth / 2, c, s, grid) * within(v, breadth / 2, s, c, grid)

    def possible(self, q: Floats, width: float, height: float) -> bool:
        x, y, yaw, breadth = q.tolist()
        return _sides_inside(x, y, yaw, breadth, breadth, width, height) >= _SIDES


class Rectangle(Form):
    """The flat end of a rectangular pillar."""

    key = "rectangular-pillar"
    names: ClassVar = ("x", "y", "yaw", "length", "breadth")

    def start(self, start: Start) -> Floats:
        return np.array([start.x, start.y, start.yaw, start.long, start.short])

    def wanted_and_covered(self, q: tuple[Slopes, ...], grid: Grid) -> tuple[Slopes, Slopes]:
        x, y, yaw, length, breadth = q
        u, v = turned(x, y, yaw, grid)
        c, s = yaw.cos(), yaw.sin()
        return constant(1.0, 5), within(u, length / 2, c, s, grid) * within(v, breadth / 2, s, c, grid)

    def possible(self, q: Floats, width: float, height: float) -> bool:
        x, y, yaw, length, breadth = q.tolist()
        return _sides_inside(x, y, yaw, length, breadth, width, height) >= _SIDES


class Border(Form):
    """A flat face with one straight border; it lies against the direction `yaw`, `offset` from the middle."""

    key = "edge"
    names: ClassVar = ("offset", "yaw")

    def start(self, start: Start) -> Floats:
        # The border lies half a breadth from the middle of the contact, downhill.
        c, s = np.cos(start.descent), np.sin(start.descent)
        return np.array([start.x * c + start.y * s + start.reach(c, s), start.descent])

    def wanted_and_covered(self, q: tuple[Slopes, ...], grid: Grid) -> tuple[Slopes, Slopes]:
        offset, yaw = q
        c, s = yaw.cos(), yaw.sin()
        inward = offset - c * grid.x - s * grid.y
        return constant(1.0, 2), grid.covered(inward, float(c.value), float(s.value))

    def possible(self, q: Floats, width: float, height: float) -> bool:
        offset, yaw = q.tolist()
        # Half a taxel beyond the border in some corner, or there is no border to be seen.
        return bool(abs(np.cos(yaw)) * width / 2 + abs(np.sin(yaw)) * height / 2 - offset > 2 * _RIM)


class Everywhere(Form):
    """A flat face without borders."""

    key = "plane"
    names: ClassVar = ()

    def start(self, start: Start) -> Floats:
        return np.zeros(0)

    def wanted_and_covered(self, q: tuple[Slopes, ...], grid: Grid) -> tuple[Slopes, Slopes]:
        return constant(1.0, 0), constant(1.0, 0)
