"""Faces of pressed objects, drawn for measuring alone: nothing here is shared with what draws the training frames.

A face is its gap: how far the surface lies behind the object's foremost point, over (x, y) in taxels. All of it
scales with the breadth b of the form, which is what the sizes below give.

- Round and square forms: b of 8 to 22 taxels on a pad of 32, 5 to 11 on one of 16. Oblong forms: breadth 4.5 to
  11 (3 to 5.5), length 1.5 to 3.5 times that, at most 26 (13).
- Pressed .15 to .35 b deep at the foremost point; a ball .1 to .45 of the contact's diameter.
- Frustums: the top is .4 to .65 of the base; a hip's ridge line .4 to .65 of its length; an edge is a half plane
  or a wedge in turns.
- Tilt of t degrees: the face turns about its foremost point, about an axis in the pad of random direction, the
  foremost point staying as deep; gaps grow by tan(t) times the distance from the axis. Walls stay upright.
- Rounded by q: where the face bends, it bends on a circle of radius q b (the rim of a face, the shoulder of a
  frustum, the tip of a cone, the line of a ridge). The outline in plan stays. Balls, lying cylinders (but for
  their ends) and planes have nothing to round.
- Cut by q: the share q of the contact's area lies beyond one border of the pad, somewhere along it. Edges and
  planes are cut as they are, and enter those rows uncut.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

__all__ = ["ENDLESS", "KINDS", "Change", "Face", "draw_face"]

#: Kinds in the order of their seeds.
KINDS = (
    "cylinder",
    "square pillar",
    "rectangular pillar",
    "frustum of a cone",
    "frustum of a pyramid",
    "sphere",
    "cone",
    "pyramid",
    "ridge",
    "hip",
    "lying cylinder",
    "edge",
    "plane",
)
ENDLESS = ("edge", "plane")
_OBLONG = ("rectangular pillar", "ridge", "hip", "lying cylinder")
_TAPERS = ("frustum of a cone", "frustum of a pyramid", "sphere", "cone", "pyramid", "ridge", "hip", "lying cylinder")
# A face is looked for its extent at so many points a side.
_PROBES = 121
# At least this much of the pad's side stays free beside a contact that is not cut.
_MARGIN = 1.0

Floats = NDArray[np.float64]
Gap = Callable[[Floats, Floats], Floats]


@dataclass(frozen=True)
class Change:
    """What is done to the form and its place: tilt in degrees, rounding and cut as shares."""

    tilt: float = 0.0
    rounding: float = 0.0
    cut: float = 0.0

    @property
    def key(self) -> str:
        """Its name in the names of files."""
        return f"tilt{self.tilt:g}-round{self.rounding:g}-cut{self.cut:g}"


@dataclass(frozen=True)
class Face:
    """A face in its place on the pad.

    Parameters
    ----------
    kind : str
        One of `KINDS`.
    gap : callable
        Gap in taxels at (x, y) from the pad's centre; inf where the object has no face.
    depth : float
        How deep the foremost point is pressed, in taxels.
    breadth : float
        In taxels.
    """

    kind: str
    gap: Gap
    depth: float
    breadth: float


def _rim(inside: Floats, radius: float) -> Floats:
    """Return the gap of a face's rounded rim, by the distance inside its outline; inf outside."""
    gap = np.zeros_like(inside)
    if radius > 0:
        left = np.clip(radius - inside, 0.0, radius)
        # Where both are one number their squares may differ by rounding.
        gap = radius - np.sqrt(np.maximum(radius**2 - left**2, 0.0))
    return np.where(inside >= 0, gap, np.inf)


def _flank(out: Floats, top: float, slope: float, radius: float) -> Floats:
    """Return the gap of a flat top of half breadth `top` and a flank, by the distance from the centre."""
    if radius <= 0:
        return slope * np.maximum(out - top, 0.0)
    angle = np.arctan(slope)
    bend = radius * np.tan(angle / 2)
    begin = max(top - bend, 0.0)
    along = np.maximum(out - begin, 0.0)
    last = radius * np.sin(angle)
    circle = radius - np.sqrt(np.maximum(radius**2 - np.minimum(along, last) ** 2, 0.0))
    return np.asarray(np.where(along <= last, circle, radius * (1 - np.cos(angle)) + slope * (along - last)))


def _ball(out: Floats, radius: float) -> Floats:
    return np.where(out < radius, radius - np.sqrt(np.maximum(radius**2 - out**2, 0.0)), np.inf)


def _form(rng: np.random.Generator, kind: str, index: int, side: int, grow: float, rounding: float) -> Face:
    """Return a form around the origin, unturned."""
    unit = side / 32
    oblong = kind in _OBLONG
    low, high = (4.5, 11.0) if oblong else (8.0, 22.0)
    if side < 32:
        low = low * unit + 0.75 if oblong else low * unit + 1.0
        high = high * unit
    breadth = float(rng.uniform(low, high))
    length = min(float(rng.uniform(1.5, 3.5)) * breadth, 26.0 * unit)
    length = max(length, 1.5 * breadth)
    depth = float(rng.uniform(0.15, 0.35)) * breadth
    share, ball_depth = float(rng.uniform(0.4, 0.65)), float(rng.uniform(0.1, 0.45))
    at = float(rng.uniform(-0.3, 0.3)) * side
    if kind in _TAPERS:
        breadth, length, depth = grow * breadth, grow * length, grow * depth
    half, long = breadth / 2, length / 2
    rho = rounding * breadth
    gap: Gap
    if kind == "cylinder":
        gap = lambda x, y: _rim(half - np.hypot(x, y), rho)  # noqa: E731
    elif kind == "square pillar":
        gap = lambda x, y: _rim(half - np.maximum(abs(x), abs(y)), rho)  # noqa: E731
    elif kind == "rectangular pillar":
        gap = lambda x, y: _rim(np.minimum(long - abs(x), half - abs(y)), rho)  # noqa: E731
    elif kind == "frustum of a cone":
        slope = depth / (half * (1 - share))
        gap = lambda x, y: _flank(np.hypot(x, y), share * half, slope, rho)  # noqa: E731
    elif kind == "frustum of a pyramid":
        slope = depth / (half * (1 - share))
        gap = lambda x, y: _flank(np.maximum(abs(x), abs(y)), share * half, slope, rho)  # noqa: E731
    elif kind == "sphere":
        depth = ball_depth * breadth
        radius = (half**2 + depth**2) / (2 * depth)
        gap = lambda x, y: _ball(np.hypot(x, y), radius)  # noqa: E731
    elif kind == "cone":
        gap = lambda x, y: _flank(np.hypot(x, y), 0.0, depth / half, rho)  # noqa: E731
    elif kind == "pyramid":
        gap = lambda x, y: _flank(np.maximum(abs(x), abs(y)), 0.0, depth / half, rho)  # noqa: E731
    elif kind == "ridge":
        gap = lambda x, y: _flank(abs(y), 0.0, depth / half, rho) + _rim(long - abs(x), rho)  # noqa: E731
    elif kind == "hip":
        top = share * long
        steep = depth / (long - top)
        gap = lambda x, y: np.maximum(  # noqa: E731
            _flank(abs(y), 0.0, depth / half, rho), _flank(np.maximum(abs(x) - top, 0.0), 0.0, steep, 0.0)
        )
    elif kind == "lying cylinder":
        depth = ball_depth * breadth
        radius = (half**2 + depth**2) / (2 * depth)
        gap = lambda x, y: _ball(abs(y), radius) + _rim(long - abs(x), rho)  # noqa: E731
    elif kind == "edge" and index % 2 == 0:
        gap = lambda x, y: _rim(x - at, rho)  # noqa: E731
    elif kind == "edge":
        gap = lambda x, y: _flank(abs(x - 0.6 * at), 0.0, depth / half, rho)  # noqa: E731
    else:
        gap = lambda x, y: np.zeros_like(x)  # noqa: E731
    return Face(kind, gap, depth, breadth)


def draw_face(
    seed: tuple[int, ...], kind: str, index: int, side: int, change: Change, grow: float = 1.0
) -> Face | None:
    """Return the face of one frame in its place, or None where the draw does not fit on the pad.

    The same seed gives the same object at the same place, whatever the tilt and the rounding.

    Parameters
    ----------
    seed : tuple of int
    kind : str
        One of `KINDS`.
    index : int
        Which of the kind's frames; half plane and wedge take turns.
    side : int
        Taxels a side of the pad.
    change : Change
    grow : float
        Lateral scale of forms that touch on less than they overlap, as they do on elastic skins.
    """
    rng = np.random.default_rng(seed)
    form = _form(rng, kind, index, side, grow, change.rounding)
    turn, leans, which, along, off_x, off_y = rng.uniform(0, 1, 6)
    turn, leans = 2 * np.pi * turn, 2 * np.pi * leans
    slope = np.tan(np.radians(change.tilt))

    def turned(x: Floats, y: Floats) -> Floats:
        u, v = x * np.cos(turn) + y * np.sin(turn), y * np.cos(turn) - x * np.sin(turn)
        return np.asarray(form.gap(u, v) + slope * (x * np.cos(leans) + y * np.sin(leans)))

    if kind in ENDLESS:
        return Face(kind, turned, form.depth, form.breadth)
    reach = 1.3 * side
    grid = np.linspace(-reach, reach, _PROBES * 2)
    x, y = np.meshgrid(grid, grid)
    touched = turned(x, y) < form.depth
    xs, ys = x[touched], y[touched]
    if change.cut > 0:
        shift = _cut(xs, ys, side, change.cut, int(4 * which), along)
    else:
        shift = _inside(xs, ys, side, off_x, off_y)
    if shift is None:
        return None
    dx, dy = shift
    return Face(kind, lambda x, y: turned(x - dx, y - dy), form.depth, form.breadth)


def _inside(xs: Floats, ys: Floats, side: int, off_x: float, off_y: float) -> tuple[float, float] | None:
    """Return a shift that puts all touched points on the pad."""
    edge = side / 2 - _MARGIN
    low, high = np.array([-edge - xs.min(), -edge - ys.min()]), np.array([edge - xs.max(), edge - ys.max()])
    if np.any(low > high):
        return None
    dx, dy = low + (high - low) * np.array([off_x, off_y])
    return float(dx), float(dy)


def _cut(xs: Floats, ys: Floats, side: int, share: float, border: int, along: float) -> tuple[float, float] | None:
    """Return a shift that puts `share` of the touched points beyond one border."""
    across, beside = ((xs, ys), (-xs, ys), (ys, xs), (-ys, xs))[border]
    out = side / 2 - float(np.quantile(across, 1 - share))
    edge = side / 2 - _MARGIN
    low, high = -edge - beside.min(), edge - beside.max()
    if low > high:
        return None
    slide = float(low + (high - low) * along)
    return ((out, slide), (-out, slide), (slide, out), (slide, -out))[border]
