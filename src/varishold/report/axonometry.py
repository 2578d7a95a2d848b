"""V(x, y) as its slices, stacked: eq. [4], V = sum of X_i times delta theta_i, drawn as a solid.

Every slice is a slab as thick as the step of the threshold, seen from above in parallel projection. Sections
nest, so that painting them from the lowest up hides what must be hidden.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from markupsafe import Markup
from numpy.typing import NDArray

from varishold.report.colours import darker
from varishold.report.outline_path import path_data
from varishold.report.screen import SCREEN_HEIGHT, SCREEN_WIDTH, screen
from varishold.report.section_stack import SectionStack

__all__ = ["AZIMUTH", "ELEVATION", "View", "stacked_slices", "view_of"]

#: The first look: from the lower left, well above the pad (radians).
AZIMUTH, ELEVATION = -0.55, 0.62
# Height of the whole stack over the geometric mean of its window's sides.
_STACK_HEIGHT = 0.62
# Walls are shaded in this many tones, from away from the light to toward it.
_TONES = 5
_DARKEST, _LIGHTEST = 0.38, 0.78
_LIGHT_FROM = (-0.8, 0.6)
# Whole steps to a screen unit in which the paths are written.
_STEPS = 10


@dataclass(frozen=True)
class View:
    """A parallel projection of the window and what stands on it.

    Parameters
    ----------
    middle : (float, float)
        The window's middle, drawing units.
    azimuth, elevation : float
        Turn of the pad and angle of the eye above it, radians.
    scale : float
        Screen units to a drawing unit.
    top : float
        Height of the stack, drawing units.
    """

    middle: tuple[float, float]
    azimuth: float
    elevation: float
    scale: float
    top: float

    def project(self, x: NDArray[np.float64], y: NDArray[np.float64], height: float) -> NDArray[np.float64]:
        """Return the screen places (n, 2) of points at one height (0 to 1)."""
        c, s = math.cos(self.azimuth), math.sin(self.azimuth)
        dx, dy = x - self.middle[0], y - self.middle[1]
        across, near = dx * c - dy * s, dx * s + dy * c
        up = self.top * (height - 0.5) * math.cos(self.elevation)
        return np.stack(
            [
                SCREEN_WIDTH / 2 + self.scale * across,
                SCREEN_HEIGHT / 2 + self.scale * (near * math.sin(self.elevation) - up),
            ],
            axis=-1,
        )

    def sink(self, height: float) -> float:
        """Return how far down the screen a point goes that sinks by a height (0 to 1)."""
        return self.scale * self.top * height * math.cos(self.elevation)


def view_of(stack: SectionStack, *, azimuth: float = AZIMUTH, elevation: float = ELEVATION) -> View:
    """Return the view that shows the whole stack, however it is turned."""
    left, top, wide, high = stack.window
    across = math.hypot(wide, high)
    height = _STACK_HEIGHT * math.sqrt(wide * high)
    tall = across * math.sin(ELEVATION) + height * math.cos(ELEVATION)
    scale = min((SCREEN_WIDTH - 12) / across, (SCREEN_HEIGHT - 20) / tall)
    return View((left + wide / 2, top + high / 2), azimuth, elevation, scale, height)


def stacked_slices(stack: SectionStack, *, label: str) -> Markup:
    """Draw a contact's slices as stacked slabs.

    Parameters
    ----------
    stack : SectionStack
        The contact.
    label : str
        Description for those who cannot see it.
    """
    view = view_of(stack)
    body = [_ground(stack, view)]
    for i in range(len(stack) - 1, -1, -1):
        below = float(stack.height[i + 1]) if i + 1 < len(stack) else 0.0
        body.append(_slab(stack, view, i, below))
    return screen(f'<g class="turn" transform="scale({1 / _STEPS:g})">{"".join(body)}</g>', label=label, kind="solid")


def _ground(stack: SectionStack, view: View) -> str:
    left, top, wide, high = stack.window
    x = np.array([left, left + wide, left + wide, left])
    y = np.array([top, top, top + high, top + high])
    corners = view.project(x, y, 0.0)
    west = int(np.argmin(corners[:, 0]))
    foot, head = corners[west], view.project(x[west : west + 1], y[west : west + 1], 1.0)[0]
    lines = []
    rows, cols = stack.taxels
    every = max(1, round(max(rows.stop - rows.start, cols.stop - cols.start) / 10))
    for k in range(cols.start, cols.stop + 1):
        if k % every == 0:
            at = k * stack.step[0]
            lines.append(view.project(np.array([at, at]), np.array([top, top + high]), 0.0))
    for k in range(rows.start, rows.stop + 1):
        if k % every == 0:
            at = k * stack.step[1]
            lines.append(view.project(np.array([left, left + wide]), np.array([at, at]), 0.0))
    axis = np.stack([foot, head])
    return (
        f'<path class="ground" d="{path_data([corners], scale=_STEPS)}"/>'
        f'<path class="grid" d="{"".join(_line(line) for line in lines)}"/><path class="axis" d="{_line(axis)}"/>'
        f'<g transform="scale({_STEPS})"><text x="{foot[0] - 6:.1f}" y="{foot[1]:.1f}" text-anchor="end">δ</text>'
        f'<text x="{head[0] - 6:.1f}" y="{head[1] + 4:.1f}" text-anchor="end">θ₁</text></g>'
    )


def _slab(stack: SectionStack, view: View, i: int, below: float) -> str:
    walls: dict[int, list[NDArray[np.float64]]] = {}
    rims = []
    sink = view.sink(float(stack.height[i]) - below)
    for polygon in stack.outlines[i]:
        high = view.project(polygon[:, 0], polygon[:, 1], float(stack.height[i]))
        rims.append(high)
        tone = _tones(polygon, view)
        closed = np.concatenate([high, high[:1]])
        for first, last in _runs(tone):
            edge = closed[first : last + 2]
            strip = np.concatenate([edge, edge[::-1] + np.array([0.0, sink])])
            walls.setdefault(int(tone[first]), []).append(strip)
    drawn = []
    for index in sorted(walls):
        colour = darker(stack.colours[i], _DARKEST + (_LIGHTEST - _DARKEST) * index / (_TONES - 1))
        drawn.append(f'<path fill="{colour}" stroke="{colour}" d="{path_data(walls[index], scale=_STEPS)}"/>')
    drawn.append(f'<path class="rim" fill="{stack.colours[i]}" d="{path_data(rims, scale=_STEPS)}"/>')
    return f'<g data-i="{i}">{"".join(drawn)}</g>'


def _tones(polygon: NDArray[np.float64], view: View) -> NDArray[np.int64]:
    """Return the tone of the wall below each edge, -1 where it faces away."""
    edge = np.concatenate([polygon[1:], polygon[:1]]) - polygon
    size = np.maximum(np.hypot(edge[:, 0], edge[:, 1]), 1e-12)
    out_x, out_y = edge[:, 1] / size, -edge[:, 0] / size
    c, s = math.cos(view.azimuth), math.sin(view.azimuth)
    across, near = out_x * c - out_y * s, out_x * s + out_y * c
    light = np.clip(across * _LIGHT_FROM[0] + near * _LIGHT_FROM[1], 0.0, 1.0)
    return np.where(near > 0, np.round(light * (_TONES - 1)), -1).astype(np.int64)


def _runs(tone: NDArray[np.int64]) -> list[tuple[int, int]]:
    """Return (first, last) of each run of edges of one tone that faces the eye."""
    turns = [0, *(np.flatnonzero(tone[1:] != tone[:-1]) + 1).tolist(), len(tone)]
    return [(a, b - 1) for a, b in pairwise(turns) if tone[a] >= 0]


def _line(points: NDArray[np.float64]) -> str:
    """Write points as a path in whole steps."""
    return "M" + "L".join(f"{x:.0f} {y:.0f}" for x, y in (points * _STEPS).tolist())
