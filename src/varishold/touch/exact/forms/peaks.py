"""Faces that fall off on all sides alike: cone, pyramid, sphere and the frustums."""

from __future__ import annotations

from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from varishold.touch.exact.form import Form, Grid, Start, constant, turned
from varishold.touch.exact.slopes import Slopes

__all__ = ["Cap", "RoundFrustum", "RoundTip", "SquareFrustum", "SquareTip", "SteepCap"]

Floats = NDArray[np.float64]

# Where a slope's face would meet the free skin lies beyond the contact, because the skin sinks around it.
_BEYOND = 1.15
_TOP = 0.45
_STEEPNESS = 0.2
# Cosine squared of the latitude from which on a sphere counts as upright.
_EQUATOR = 0.01


def _farther(u: Slopes, v: Slopes, yaw: Slopes, grid: Grid) -> Slopes:
    """Return max(|u|, |v|), averaged over each cell."""
    width = grid.across(float(np.cos(yaw.value)), float(np.sin(yaw.value)))
    return u.magnitude(width).greater(v.magnitude(width), width)


def _cut(out: Slopes, base: Slopes, top: Slopes, width: float) -> Slopes:
    """Return the height of a slope from the contact line at `base` up to a flat top at `top`, both half sizes."""
    run = base - top
    return 1.0 - (out - top).above_zero(width) / run


class RoundTip(Form):
    """A cone."""

    key = "cone"
    names: ClassVar = ("x", "y", "diameter")

    def start(self, start: Start) -> Floats:
        return np.array([start.x, start.y, _BEYOND * 1.128 * start.breadth])

    def wanted_and_covered(self, q: tuple[Slopes, ...], grid: Grid) -> tuple[Slopes, Slopes]:
        x, y, diameter = q
        return 1.0 - grid.radius(grid.x - x, grid.y - y) / (diameter / 2), constant(1.0, 3)


class Cap(Form):
    """A sphere, nearly a paraboloid where it touches."""

    key = "sphere"
    names: ClassVar = ("x", "y", "diameter")

    def start(self, start: Start) -> Floats:
        return np.array([start.x, start.y, _BEYOND * 1.128 * start.breadth])

    def wanted_and_covered(self, q: tuple[Slopes, ...], grid: Grid) -> tuple[Slopes, Slopes]:
        x, y, diameter = q
        dx, dy = grid.x - x, grid.y - y
        return 1.0 - (dx * dx + dy * dy) / (diameter * diameter / 4), constant(1.0, 3)


class SteepCap(Form):
    """A sphere pressed in so deep that it is no paraboloid.

    `steepness` is the square of the contact line's radius over the sphere's.
    """

    key = "sphere"
    names: ClassVar = ("x", "y", "diameter", "steepness")

    def start(self, start: Start) -> Floats:
        return np.array([start.x, start.y, _BEYOND * 1.128 * start.breadth, _STEEPNESS])

    def wanted_and_covered(self, q: tuple[Slopes, ...], grid: Grid) -> tuple[Slopes, Slopes]:
        x, y, diameter, steepness = q
        dx, dy = grid.x - x, grid.y - y
        square = (dx * dx + dy * dy) / (diameter * diameter / 4) * steepness
        # Past the equator the face falls straight down; it touches nothing there.
        above = 1.0 - square
        there = above.value > _EQUATOR
        cosine = Slopes(np.where(there, above.value, _EQUATOR), above.by * there).sqrt()
        line = (1.0 - steepness).sqrt()
        return (cosine - line) / (1.0 - line), constant(1.0, 4)


class SquareTip(Form):
    """A pyramid."""

    key = "pyramid"
    names: ClassVar = ("x", "y", "yaw", "breadth")

    def start(self, start: Start) -> Floats:
        return np.array([start.x, start.y, start.square_yaw, _BEYOND * start.breadth])

    def wanted_and_covered(self, q: tuple[Slopes, ...], grid: Grid) -> tuple[Slopes, Slopes]:
        x, y, yaw, breadth = q
        return 1.0 - _farther(*turned(x, y, yaw, grid), yaw, grid) / (breadth / 2), constant(1.0, 4)


class RoundFrustum(Form):
    """A frustum of a cone."""

    key = "cone-frustum"
    names: ClassVar = ("x", "y", "diameter", "top_share")

    def start(self, start: Start) -> Floats:
        return np.array([start.x, start.y, _BEYOND * 1.128 * start.breadth, _TOP])

    def wanted_and_covered(self, q: tuple[Slopes, ...], grid: Grid) -> tuple[Slopes, Slopes]:
        x, y, diameter, share = q
        r = grid.radius(grid.x - x, grid.y - y)
        width = np.sqrt(grid.width * grid.height)
        return _cut(r, diameter / 2, share * diameter / 2, width), constant(1.0, 4)


class SquareFrustum(Form):
    """A frustum of a pyramid."""

    key = "pyramid-frustum"
    names: ClassVar = ("x", "y", "yaw", "breadth", "top_share")

    def start(self, start: Start) -> Floats:
        return np.array([start.x, start.y, start.square_yaw, _BEYOND * start.breadth, _TOP])

    def wanted_and_covered(self, q: tuple[Slopes, ...], grid: Grid) -> tuple[Slopes, Slopes]:
        x, y, yaw, breadth, share = q
        out = _farther(*turned(x, y, yaw, grid), yaw, grid)
        width = grid.across(float(np.cos(yaw.value)), float(np.sin(yaw.value)))
        return _cut(out, breadth / 2, share * breadth / 2, width), constant(1.0, 5)
