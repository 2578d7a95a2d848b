"""Drawn faces: every kind of surface with the poses and the wear that real ones have.

A face is drawn in taxels: it leans, its edges are rounded, the border of the pad cuts it, its bars are long, its caps
shallow, the pad under it is curved, and its two pitches differ. What is called by which name where taxels cannot tell:

- a body keeps its own name however much it is rounded, leans or is cut: where that makes it another's likeness, the
  probabilities spread;
- a plane that leans is a plane while it covers the field, and an edge once its border of contact crosses the field.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from training.strangers import stranger_face
from varishold.solids import pad_points

Array = NDArray[np.float64]

#: Kinds that are drawn, with weights: nameless pillars are rare among things that are touched, and unknown must hold
#: against every named kind.
WEIGHTS: dict[str, float] = {
    "cylinder": 1.0,
    "square-pillar": 1.0,
    "rectangular-pillar": 1.1,
    "cone-frustum": 1.0,
    "pyramid-frustum": 1.0,
    "sphere": 1.0,
    "cone": 1.0,
    "pyramid": 1.0,
    "ridge": 0.8,
    "hip": 0.8,
    "lying-cylinder": 1.0,
    "edge": 0.7,
    "wedge": 0.6,
    "plane": 0.7,
    "triangular-pillar": 0.25,
    "hexagonal-pillar": 0.15,
    "elliptic-pillar": 0.25,
    "stranger": 2.6,
}
_WALL = 1e3
UNBOUNDED = ("edge", "wedge", "plane")
_LONG = ("rectangular-pillar", "ridge", "hip")


@dataclass(frozen=True)
class Drawn:
    """One face as it is drawn, lengths in taxels.

    Parameters
    ----------
    key : str
        Its kind.
    long, short, depth : float
        Lengths of the contact at the contact line, and how much stands above that line.
    top : float
        A frustum's top over its base.
    rounding : float
        Radius of its rounded edges.
    tilt : (float, float)
        Slopes of the whole body along its own axes.
    curve : (float, float)
        Curvatures of the pad along its columns and rows, one over taxels.
    x, y, yaw : float
        Where it lies, from the pad's centre.
    stretch : float
        Ratio of the two pitches that nobody knows of.
    plan_rounded : bool
        Whether corners are rounded in plan too.
    """

    key: str
    long: float
    short: float
    depth: float
    top: float = 0.5
    rounding: float = 0.0
    tilt: tuple[float, float] = (0.0, 0.0)
    curve: tuple[float, float] = (0.0, 0.0)
    x: float = 0.0
    y: float = 0.0
    yaw: float = 0.0
    stretch: float = 1.0
    plan_rounded: bool = False


@dataclass(frozen=True)
class Face:
    """A face over a pad: the height of the body above the contact line, its highest point about 1.

    Parameters
    ----------
    height : ndarray of shape (rows * per_taxel, cols * per_taxel), float64
        Below the contact line it goes on, negative.
    key : str
        The kind that it is to be called.
    drawn : Drawn
    per_taxel : int
    top : float
        Height, in taxels, of the highest point over the pad, from the body's own top.
    """

    height: Array
    key: str
    drawn: Drawn
    per_taxel: int
    top: float = 0.0

    def over(self, shape: tuple[int, int]) -> Array:
        """Return the height over a pad of another shape with the same middle; a stranger has but its own."""
        if self.key == "stranger" or self.height.shape == (shape[0] * self.per_taxel, shape[1] * self.per_taxel):
            return self.height
        return _above(height_of(self.drawn, shape, self.per_taxel), self.top, self.drawn.depth)


def _above(height: Array, top: float, depth: float) -> Array:
    """Return heights above the contact line, `top` being 1."""
    return np.maximum((height - top) / depth + 1.0, -3.0)


def _smooth(x: Array | float, a: float) -> Array:
    """Return |x| rounded at zero over a length `a`, zero there."""
    return np.asarray(np.sqrt(np.square(x) + a * a) - a)


def _box_distance(u: Array, v: Array, half_u: float, half_v: float, inset: float) -> Array:
    """Return the distance inside a rectangle to its outline, its corners rounded by `inset`; negative outside."""
    du, dv = np.abs(u) - (half_u - inset), np.abs(v) - (half_v - inset)
    outside = np.hypot(np.maximum(du, 0.0), np.maximum(dv, 0.0))
    return np.asarray(inset - outside - np.minimum(np.maximum(du, dv), 0.0))


def _flat(distance: Array, radius: float) -> Array:
    """Return the drop of a flat face whose edge is rounded: 0 inside, a wall outside."""
    if radius <= 0.0:
        return np.where(distance > 0.0, 0.0, _WALL)
    inward = np.clip(radius - distance, 0.0, radius)
    return np.where(distance > 0.0, radius - np.sqrt(np.maximum(radius * radius - inward * inward, 0.0)), _WALL)


def _polygon_distance(u: Array, v: Array, sides: int, inner: float) -> Array:
    angles = 2 * np.pi * np.arange(sides) / sides
    return np.asarray(np.min([inner - (u * np.cos(a) + v * np.sin(a)) for a in angles], axis=0))


def _drop(d: Drawn, u: Array, v: Array) -> Array:
    """Return how far the face lies below its top."""
    half, r = d.long / 2, d.rounding
    slope = d.depth / max(d.short / 2, 1e-9)
    if d.key == "cylinder":
        return _flat(half - np.hypot(u, v), r)
    if d.key in ("square-pillar", "rectangular-pillar"):
        inset = min(r, d.short / 2) if d.plan_rounded else 0.0
        return _flat(_box_distance(u, v, half, d.short / 2, inset), min(r, d.short / 2))
    if d.key in ("cone-frustum", "pyramid-frustum"):
        slope = d.depth / (half * (1 - d.top))
        a = r * 0.5
        rho = np.hypot(u, v) if d.key == "cone-frustum" else _corner(u, v, a if d.plan_rounded else 0.0)
        x = rho - half * d.top
        return slope * (0.5 * (x + np.sqrt(x * x + a * a)) if a > 0 else np.maximum(x, 0.0))
    if d.key == "cone":
        return slope * _smooth(np.hypot(u, v), 0.5 * r)
    if d.key == "pyramid":
        a = 0.5 * r
        return slope * _smooth(_corner(u, v, a if d.plan_rounded else 0.0), a)
    if d.key in ("sphere", "lying-cylinder"):
        breadth = d.long if d.key == "sphere" else d.short
        radius = (breadth * breadth / 4 + d.depth * d.depth) / (2 * d.depth)
        across = u * u + v * v if d.key == "sphere" else v * v
        drop = np.where(across < radius * radius, radius - np.sqrt(np.maximum(radius * radius - across, 0.0)), _WALL)
        if d.key == "lying-cylinder":
            drop = np.maximum(drop, _flat(half - np.abs(u), min(r, half)))
        return drop
    if d.key == "ridge":
        return np.maximum(slope * _smooth(v, 0.5 * r), _flat(half - np.abs(u), min(r, half)))
    if d.key == "hip":
        x = np.maximum(np.abs(u) - (d.long - d.short) / 2, 0.0)
        return slope * _smooth(np.maximum(np.abs(v), x), 0.5 * r)
    if d.key == "edge":
        return _flat(-v, r)
    if d.key == "wedge":
        return slope * _smooth(v, 0.5 * r)
    if d.key == "plane":
        return np.zeros(u.shape)
    if d.key == "elliptic-pillar":
        across = np.hypot(u / half, v / (d.short / 2))
        return _flat((1 - across) * d.short / 2, min(r, d.short / 2))
    sides = 3 if d.key == "triangular-pillar" else 6
    inner = half * np.cos(np.pi / sides)
    return _flat(_polygon_distance(u, v, sides, float(inner)), min(r, float(inner)))


def _corner(u: Array, v: Array, a: float) -> Array:
    """Return the larger of |u| and |v|, the corner between them rounded over a length `a`."""
    p, q = np.abs(u), np.abs(v)
    if a <= 0.0:
        return np.maximum(p, q)
    return np.asarray(0.5 * (p + q + np.sqrt((p - q) ** 2 + a * a)) - 0.25 * a)


def height_of(d: Drawn, shape: tuple[int, int], per_taxel: int) -> Array:
    """Return the heights of a drawn face over the pad, `per_taxel` points along a taxel's side, its top at 0."""
    x, y = pad_points(shape, 1.0, per_taxel=per_taxel)
    root = np.sqrt(d.stretch)
    dx, dy = (x - d.x) * root, (y - d.y) / root
    c, s = np.cos(d.yaw), np.sin(d.yaw)
    u, v = c * dx + s * dy, c * dy - s * dx
    h = -_drop(d, u, v)
    if d.tilt != (0.0, 0.0):
        h = h + d.tilt[0] * u + d.tilt[1] * v
    if d.curve != (0.0, 0.0):
        h = h - 0.5 * (d.curve[0] * dx * dx + d.curve[1] * dy * dy)
    return h


def _log(rng: np.random.Generator, low: float, high: float) -> float:
    return float(np.exp(rng.uniform(np.log(low), np.log(high))))


def _rounded(rng: np.random.Generator, d: Drawn) -> Drawn:
    most = 0.5 if rng.random() < 0.5 else 0.25
    breadth = min(d.short, 12.0) if d.key in UNBOUNDED else d.short
    radius = breadth * (_log(rng, 0.02, most) if rng.random() < 0.6 else rng.uniform(0.02, most))
    return replace(d, rounding=float(radius), plan_rounded=bool(rng.random() < 0.5))


def _leaning(rng: np.random.Generator, d: Drawn, field: float) -> Drawn:
    tilt = np.tan(np.radians(rng.uniform(0.5, 12.5)))
    reach = field if d.key in UNBOUNDED else d.long
    if rng.random() < 0.6:
        # Mostly the whole face still touches.
        tilt = min(tilt, rng.uniform(0.1, 1.0) * d.depth / reach)
    else:
        tilt = min(tilt, 3.0 * d.depth / reach)
    angle = rng.uniform(-np.pi, np.pi)
    return replace(d, tilt=(float(tilt * np.cos(angle)), float(tilt * np.sin(angle))))


def _bent(rng: np.random.Generator, d: Drawn, field: float) -> Drawn:
    reach = 0.5 * (field if d.key in UNBOUNDED else d.long)
    sag = d.depth * _log(rng, 0.03, 0.45) * (0.5 if d.key in UNBOUNDED else 1.0)
    curvature = 2 * sag / reach**2
    way = rng.random()
    return replace(
        d, curve=(curvature, curvature) if way < 0.4 else ((curvature, 0.0) if way < 0.7 else (0.0, curvature))
    )


def _cut(rng: np.random.Generator, d: Drawn, shape: tuple[int, int]) -> Drawn:
    """Shift a face that ends beyond a side of the pad, or two."""
    if d.key in UNBOUNDED:
        return d
    c, s = abs(np.cos(d.yaw)), abs(np.sin(d.yaw))
    round_ = d.key in ("cylinder", "cone", "cone-frustum", "sphere")
    half_x = d.long / 2 if round_ else (d.long * c + d.short * s) / 2
    half_y = d.long / 2 if round_ else (d.long * s + d.short * c) / 2
    x, y = d.x, d.y
    both = rng.random() < 0.2
    across = rng.random() < 0.5
    share = rng.uniform(0.03, 0.58) if rng.random() < 0.7 else rng.uniform(0.03, 0.3)
    if both:
        share *= 0.6
    if across or both:
        x = (shape[1] / 2 - half_x + 2 * half_x * share) * rng.choice([-1, 1])
    if not across or both:
        y = (shape[0] / 2 - half_y + 2 * half_y * share) * rng.choice([-1, 1])
    return replace(d, x=float(x), y=float(y))


def _pushed_out(rng: np.random.Generator, height: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return heights moved beyond a side of the pad, with a third of the body at most."""
    turned = np.rot90(height, int(rng.integers(4)))
    rows = np.flatnonzero((turned > 0.15 * turned.max()).any(axis=1))
    by = rows[0] + int(rng.uniform(0.03, 0.35) * len(rows))
    return np.concatenate([turned[by:], np.zeros_like(turned[:by])])


def draw_face(rng: np.random.Generator, key: str, shape: tuple[int, int], size: tuple[float, float]) -> Drawn:
    """Draw a plain face of the kind `key` that lies in the field as far as it can."""
    long = float(rng.uniform(*size))
    short = long
    steep = _log(rng, 0.03, 0.5)
    if key in _LONG:
        # Half are as stout as a brick, some are bars of eight to one.
        ratio = (
            rng.uniform(1.35, 3.0)
            if rng.random() < 0.7
            else _log(rng, 1.8, 8.0 if key == "rectangular-pillar" else 5.0)
        )
        if ratio > 3.0 and rng.random() < 0.7:
            long = min(max(long, rng.uniform(0.6, 1.0) * size[1]), 1.25 * size[1])
        short = max(long / ratio, 1.4)
        if long / short < 1.35:
            long = 1.35 * short
    elif key == "elliptic-pillar":
        short = long / rng.uniform(1.4, 2.8)
    yaw = float(rng.uniform(-np.pi / 2, np.pi / 2))
    height, width = shape
    if key == "lying-cylinder":
        # As narrow as other bars are, or as broad as they are long: breadth must not give a name away.
        short = long if rng.random() < 0.4 else max(long / float(rng.uniform(1.35, 3.5)), 1.4)
        leaves = rng.random() < 1 / 3
        long = 4.0 * max(shape) if leaves else float(rng.uniform(1.3, 3.5)) * short
    depth = min(steep * short, 0.5 * short if key in ("sphere", "lying-cylinder") else np.inf)
    d = Drawn(key, long, short, depth, top=float(rng.uniform(0.27, 0.64)), yaw=yaw)
    if key in UNBOUNDED or key == "lying-cylinder":
        reach = (0.25 if key != "edge" or rng.random() < 0.7 else 0.4) * min(shape)
        return replace(d, x=float(rng.uniform(-reach, reach)), y=float(rng.uniform(-reach, reach)))
    c, s = abs(np.cos(yaw)), abs(np.sin(yaw))
    half_x, half_y = (long * c + short * s) / 2, (long * s + short * c) / 2
    if key in ("cylinder", "cone", "cone-frustum", "sphere"):
        half_x = half_y = long / 2
    free_x, free_y = max(width / 2 - half_x, 0.0), max(height / 2 - half_y, 0.0)
    return replace(d, x=float(rng.uniform(-free_x, free_x)), y=float(rng.uniform(-free_y, free_y)))


_CHANCES: dict[str, float] = {"round": 0.17, "lean": 0.17, "bend": 0.05, "cut": 0.15, "stretch": 0.06}


def worn(rng: np.random.Generator, d: Drawn, shape: tuple[int, int], plain: float) -> Drawn:
    """Return the face as it is with chance `plain`, or rounded, leaning, cut, over a curved pad, stretched."""
    if rng.random() < plain:
        return d
    field = float(min(shape))
    ways: dict[str, Callable[[Drawn], Drawn]] = {
        "round": lambda f: _rounded(rng, f),
        "lean": lambda f: _leaning(rng, f, field),
        "bend": lambda f: _bent(rng, f, field),
        "cut": lambda f: _cut(rng, f, shape),
        "stretch": lambda f: replace(f, stretch=float(np.exp(rng.uniform(-1, 1) * np.log(1.27)))),
    }
    names = list(ways)
    weight = np.array([_CHANCES[name] for name in names])
    count = 1 if rng.random() < 0.75 else 2
    for name in rng.choice(names, size=count, replace=False, p=weight / weight.sum()):
        d = ways[str(name)](d)
    return d


def face_over(
    rng: np.random.Generator,
    key: str,
    shape: tuple[int, int],
    size: tuple[float, float],
    *,
    per_taxel: int,
    plain: float = 0.55,
    at_border: bool = False,
) -> Face:
    """Draw a face of the kind `key` over a pad of unit pitch, cut by its border or not; a few taxels of it touch."""
    while True:
        if key == "stranger":
            height = stranger_face(rng, shape, size, per_taxel=per_taxel)
            breadth = float(size[0])
            if at_border:
                height = _pushed_out(rng, height)
            return Face(height, key, Drawn(key, breadth, breadth, 1.0), per_taxel)
        d = draw_face(rng, key, shape, size)
        if at_border:
            d = _cut(rng, d, shape)
        d = worn(rng, d, shape, plain)
        h = height_of(d, shape, per_taxel)
        top = float(h.max())
        height = _above(h, top, d.depth)
        touching = float(np.count_nonzero(height > 0.15)) / per_taxel**2
        if touching < max(2.0, 0.06 * size[0] ** 2):
            continue
        called = key
        if key == "plane" and float(height.min()) <= 0.04:
            called = "edge"
        return Face(height, called, d, per_taxel, top)
