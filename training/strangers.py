"""Faces that have no name: what recognition should call unknown, made from random parts without end.

No list of shapes is ever complete. So strangers are built by chance: unions and differences of random parts, blobs cut
from smooth random
fields, strokes, repeated patterns, stacks and steps, each flat, domed, peaked or leaning.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from varishold.solids import pad_points

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]
Maker = Callable[[np.random.Generator, Array, Array], Array]


def _polygon(x: Array, y: Array, corners: Array) -> Mask:
    """Return whether points lie inside the polygon (n, 2), by the even-odd rule."""
    inside = np.zeros(x.shape, dtype=bool)
    for (ax, ay), (bx, by) in zip(corners, np.roll(corners, -1, axis=0), strict=True):
        if ay == by:
            continue
        crosses = (ay > y) != (by > y)
        inside ^= crosses & (x < (bx - ax) * (y - ay) / (by - ay) + ax)
    return inside


def _turned(rng: np.random.Generator, x: Array, y: Array) -> tuple[Array, Array]:
    a = rng.uniform(-np.pi, np.pi)
    return np.cos(a) * x + np.sin(a) * y, np.cos(a) * y - np.sin(a) * x


def _part(rng: np.random.Generator, x: Array, y: Array, reach: float = 0.5) -> Mask:
    """One random part: a disc, a box, a triangle, a bar or a half disc."""
    cx, cy = rng.uniform(-0.55, 0.55, 2) * reach
    wide = reach * rng.uniform(0.25, 0.8)
    u, v = _turned(rng, x - cx, y - cy)
    kind = int(rng.integers(5))
    if kind == 0:
        return np.asarray(np.hypot(u, v / rng.uniform(0.5, 1.0)) <= wide)
    if kind == 1:
        return np.asarray((np.abs(u) <= wide) & (np.abs(v) <= wide * rng.uniform(0.3, 1.0)))
    if kind == 2:
        angle = rng.uniform(0, 2 * np.pi) + np.cumsum(rng.uniform(1.4, 2.6, 3))
        return _polygon(u, v, 1.3 * wide * np.stack([np.cos(angle), np.sin(angle)], axis=1))
    if kind == 3:
        return np.asarray((np.abs(u) <= reach * rng.uniform(0.5, 1.0)) & (np.abs(v) <= reach * rng.uniform(0.12, 0.3)))
    return np.asarray((np.hypot(u, v) <= wide) & (v > rng.uniform(-0.3, 0.3) * wide))


def _union(rng: np.random.Generator, x: Array, y: Array) -> Array:
    mask = _part(rng, x, y)
    for _ in range(int(rng.integers(1, 5))):
        mask = mask | _part(rng, x, y)
    return mask.astype(np.float64)


def _difference(rng: np.random.Generator, x: Array, y: Array) -> Array:
    kind = int(rng.integers(3))
    if kind == 0:
        mask = np.hypot(x, y) <= 0.5
    elif kind == 1:
        mask = (np.abs(x) <= 0.45) & (np.abs(y) <= 0.45 * rng.uniform(0.5, 1.0))
    else:
        mask = _part(rng, x, y) | _part(rng, x, y)
    for _ in range(int(rng.integers(1, 4))):
        mask = mask & ~_part(rng, x, y, reach=rng.uniform(0.25, 0.55))
    return mask.astype(np.float64)


def _field(rng: np.random.Generator, x: Array, y: Array, waves: int = 14) -> Array:
    """A smooth random field on the unit square."""
    finest = rng.uniform(1.2, 3.5)
    total = np.zeros(x.shape)
    for _ in range(waves):
        k = rng.normal(0, finest, 2)
        total += rng.normal() * np.cos(2 * np.pi * (k[0] * x + k[1] * y) + rng.uniform(0, 2 * np.pi))
    return total


def _blob(rng: np.random.Generator, x: Array, y: Array) -> Array:
    field = _field(rng, x, y) + rng.uniform(1.0, 4.0) * (1 - 6 * (x * x + y * y))
    return ((field > rng.uniform(-1.0, 1.5)) & (np.hypot(x, y) < 0.6)).astype(np.float64)


def _relief(rng: np.random.Generator, x: Array, y: Array) -> Array:
    field = _field(rng, x, y)
    inside = np.hypot(x, y) if rng.random() < 0.5 else np.maximum(np.abs(x), np.abs(y))
    fade = np.clip((0.5 - inside) / rng.uniform(0.03, 0.3), 0.0, 1.0)
    field = (field - field.min()) / max(float(np.ptp(field)), 1e-9)
    return field * fade


def _lumps(rng: np.random.Generator, x: Array, y: Array) -> Array:
    total = np.zeros(x.shape)
    for _ in range(int(rng.integers(2, 9))):
        cx, cy = rng.uniform(-0.42, 0.42, 2)
        wide = rng.uniform(0.05, 0.18)
        total = np.maximum(total, 0) + rng.uniform(0.4, 1.0) * np.exp(-((x - cx) ** 2 + (y - cy) ** 2) / (2 * wide**2))
    return total / max(float(total.max()), 1e-9)


def _strokes(rng: np.random.Generator, x: Array, y: Array) -> Array:
    """A letter that no alphabet has: straight strokes and arcs of one breadth."""
    half = rng.uniform(0.05, 0.13)
    near = np.full(x.shape, np.inf)
    at = rng.uniform(-0.45, 0.45, 2)
    for _ in range(int(rng.integers(2, 6))):
        to = rng.uniform(-0.45, 0.45, 2)
        if rng.random() < 0.3:
            radius = rng.uniform(0.15, 0.4)
            u, v = x - at[0] * 0.4, y - at[1] * 0.4
            begin, length = rng.uniform(-np.pi, np.pi), rng.uniform(1.5, 5.0)
            along = np.mod(np.arctan2(v, u) - begin, 2 * np.pi)
            distance = np.where(along <= length, np.abs(np.hypot(u, v) - radius), np.inf)
        else:
            way = to - at
            t = np.clip(((x - at[0]) * way[0] + (y - at[1]) * way[1]) / max(float(way @ way), 1e-6), 0, 1)
            distance = np.hypot(x - at[0] - t * way[0], y - at[1] - t * way[1])
        near = np.minimum(near, distance)
        at = to if rng.random() < 0.7 else rng.uniform(-0.45, 0.45, 2)
    return (near <= half).astype(np.float64)


def _star(rng: np.random.Generator, x: Array, y: Array) -> Array:
    points = int(rng.integers(3, 9))
    inner = rng.uniform(0.2, 0.6) * 0.5
    angle = np.arange(2 * points) * np.pi / points
    radius = np.where(np.arange(2 * points) % 2 == 0, 0.5, inner)
    return _polygon(x, y, np.stack([radius * np.cos(angle), radius * np.sin(angle)], axis=1)).astype(np.float64)


def _flower(rng: np.random.Generator, x: Array, y: Array) -> Array:
    phi, r = np.arctan2(y, x), np.hypot(x, y)
    outline = 1.0
    for k in range(2, 8):
        outline = outline + rng.normal(0, 0.4 / k) * np.cos(k * phi + rng.uniform(0, 2 * np.pi))
    outline = outline + rng.uniform(0.1, 0.35) * np.cos(int(rng.integers(2, 8)) * phi)
    return (r <= 0.35 * np.maximum(outline, 0.15)).astype(np.float64)


def _ring(rng: np.random.Generator, x: Array, y: Array) -> Array:
    inner = rng.uniform(0.3, 0.8) * 0.5
    v = y * rng.uniform(1.0, 1.6)
    r = np.hypot(x, v) if rng.random() < 0.6 else np.maximum(np.abs(x), np.abs(v))
    if rng.random() < 0.3:
        middle, half = (0.5 + inner) / 2, (0.5 - inner) / 2
        return np.sqrt(np.maximum(1 - ((r - middle) / half) ** 2, 0.0))
    ring = (r <= 0.5) & (r >= inner)
    if rng.random() < 0.4:
        ring &= np.mod(np.arctan2(y, x), 2 * np.pi) > rng.uniform(0.3, 3.5)
    return ring.astype(np.float64)


def _pattern(rng: np.random.Generator, x: Array, y: Array) -> Array:
    """Bars, dots, checks or rings that repeat."""
    period = rng.uniform(0.2, 0.5)
    duty = rng.uniform(0.3, 0.7)
    kind = int(rng.integers(5))
    px, py = rng.uniform(0, 1, 2)
    a, b = np.mod(x / period + px, 1.0), np.mod(y / period + py, 1.0)
    if kind == 0:
        made = a < duty
    elif kind == 1:
        made = np.hypot(a - 0.5, b - 0.5) < 0.5 * np.sqrt(duty)
    elif kind == 2:
        made = (a < 0.5) ^ (b < 0.5)
    elif kind == 3:
        made = np.mod(np.hypot(x, y) / period + px, 1.0) < duty
    else:
        phi = np.arctan2(y, x)
        made = np.mod(np.hypot(x, y) / period + phi / (2 * np.pi), 1.0) < duty
    if rng.random() < 0.25:
        smooth = 0.5 + 0.5 * np.cos(2 * np.pi * a) * (1.0 if kind != 1 else np.cos(2 * np.pi * b))
        made = smooth
    inside = np.hypot(x, y) <= 0.5 if rng.random() < 0.5 else np.maximum(np.abs(x), np.abs(y)) <= 0.45
    return np.asarray(made, dtype=np.float64) * inside


def _ragged(rng: np.random.Generator, x: Array, y: Array) -> Array:
    corners = int(rng.integers(5, 10))
    angle = np.sort(rng.uniform(0, 2 * np.pi, corners))
    radius = rng.uniform(0.15, 0.5, corners)
    shape = _polygon(x, y, np.stack([radius * np.cos(angle), radius * np.sin(angle)], axis=1))
    return shape * (1 + rng.uniform(-0.8, 0.8) * x)


def _stack(rng: np.random.Generator, x: Array, y: Array) -> Array:
    """Parts on parts, or stairs."""
    if rng.random() < 0.4:
        steps = int(rng.integers(2, 5))
        stairs = np.floor((x + 0.5) * steps + rng.uniform(0, 1)) / steps
        inside = (np.abs(x) <= 0.48) & (np.abs(y) <= rng.uniform(0.2, 0.48))
        return np.clip(stairs + 0.15, 0.1, None) * inside
    total = np.zeros(x.shape)
    for _ in range(int(rng.integers(2, 4))):
        total = np.maximum(total, _part(rng, x, y) * rng.uniform(0.35, 1.0))
    return total


def _dented(rng: np.random.Generator, x: Array, y: Array) -> Array:
    """A bowl, a saddle, a torus, an egg, or a body whose apex lies aside."""
    kind = int(rng.integers(6))
    inside = np.hypot(x, y * rng.uniform(1.0, 1.8)) <= 0.5
    if kind == 0:
        return (rng.uniform(0.0, 0.6) + 4 * (x * x + y * y) * rng.uniform(0.6, 1.0)) * inside
    if kind == 1:
        return np.clip(0.5 + 2 * (x * x - y * y) * rng.uniform(0.6, 1.2), 0, None) * inside
    if kind == 2:
        mean, thick = rng.uniform(0.2, 0.35), rng.uniform(0.1, 0.18)
        return np.sqrt(np.maximum(1 - ((np.hypot(x, y) - mean) / thick) ** 2, 0.0))
    if kind == 3:
        ratio = rng.uniform(1.5, 2.6)
        return np.maximum(1 - 4 * (x * x + (y * ratio) ** 2), 0.0) ** rng.choice([0.5, 1.0])
    if kind == 4:
        ax, ay = rng.uniform(-0.3, 0.3, 2)
        ax, ay = (ax + 0.15 * np.sign(ax), ay)
        rim = np.hypot(x, y)
        away = np.hypot(x - ax, y - ay)
        return np.clip((0.5 - rim) / np.maximum(0.5 - rim + away, 1e-6), 0, None)
    sides = int(rng.choice([3, 5, 6]))
    angle = 2 * np.pi * np.arange(sides) / sides
    far = np.max([x * np.cos(a) + y * np.sin(a) for a in angle], axis=0)
    return np.maximum(1 - far / (0.5 * np.cos(np.pi / sides)), 0.0)


def _tower(rng: np.random.Generator, x: Array, y: Array) -> Array:
    """Two or three flat steps, each on the last and narrower: discs or boxes, in the middle or aside."""
    steps = int(rng.integers(2, 4))
    tops = np.cumsum(rng.uniform(0.5, 1.5, steps))
    total = np.zeros(x.shape)
    cx, cy, half = 0.0, 0.0, 0.5
    alike, disc = rng.random() < 0.7, rng.random() < 0.5
    middle = rng.random() < 0.6
    for top in tops / tops[-1]:
        u, v = x - cx, y - cy
        inside = np.hypot(u, v) <= half if disc else np.maximum(np.abs(u), np.abs(v)) <= 0.9 * half
        total = np.where(inside, top, total)
        narrower = half * rng.uniform(0.35, 0.72)
        if not middle:
            aside = rng.uniform(-1.0, 1.0, 2) * 0.7 * (half - narrower)
            cx, cy = cx + aside[0], cy + aside[1]
        half = narrower
        disc = disc if alike else rng.random() < 0.5
    return total


def _polygon_face(rng: np.random.Generator, x: Array, y: Array) -> Array:
    """A flat pentagon, trapezoid, kite, rhombus, bow or leaning block."""
    kind = int(rng.integers(5))
    if kind == 0:
        angle = 2 * np.pi * (np.arange(5) + rng.uniform(-0.08, 0.08, 5)) / 5
        corners = 0.5 * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    elif kind == 1:
        high, top = rng.uniform(0.25, 0.48), rng.uniform(0.15, 0.62) * 0.48
        lean = rng.uniform(-0.3, 0.3) * (0.48 - top)
        corners = np.array([[-0.48, -high], [0.48, -high], [lean + top, high], [lean - top, high]])
    elif kind == 2:
        side, at = rng.uniform(0.2, 0.42), rng.uniform(-0.25, 0.25)
        corners = np.array([[-0.5, 0.0], [at, -side], [0.5, 0.0], [at, side]])
    elif kind == 3:
        high, neck, at = rng.uniform(0.25, 0.48), rng.uniform(0.03, 0.2), rng.uniform(-0.1, 0.1)
        corners = np.array([[-0.48, -high], [at, -neck], [0.48, -high], [0.48, high], [at, neck], [-0.48, high]])
    else:
        high, lean = rng.uniform(0.2, 0.4), rng.uniform(0.15, 0.35)
        corners = np.array([[-0.5, -high], [0.5 - lean, -high], [0.5, high], [lean - 0.5, high]])
    return _polygon(x, y, corners).astype(np.float64)


def _body(rng: np.random.Generator, x: Array, y: Array) -> tuple[Callable[[Array | float], Array], Array]:
    """Return the profile of a body that has a name, flat, peaked, domed or cut off, and where each point stands in it.

    The profile is a function of how far in from the outline a point lies, 0 at the outline and 1 in the middle.
    """
    v = y * (1.0 if rng.random() < 0.6 else rng.uniform(1.2, 2.2))
    rho = np.hypot(x, v) if rng.random() < 0.55 else np.maximum(np.abs(x), np.abs(v)) / 0.9
    top = rng.uniform(0.3, 0.7)
    profiles: list[Callable[[Array | float], Array]] = [
        lambda t: np.asarray(t, dtype=np.float64) > 0,
        lambda t: np.asarray(t),
        lambda t: np.sqrt(1 - (1 - np.asarray(t)) ** 2),
        lambda t: np.minimum(np.asarray(t) / top, 1.0),
    ]
    return profiles[int(rng.choice(4, p=(0.4, 0.2, 0.2, 0.2)))], np.maximum(1 - 2 * rho, 0.0)


def _hollowed(rng: np.random.Generator, x: Array, y: Array) -> Array:
    """A body that has a name, with a hollow in its middle, or a groove or two across."""
    profile, inward = _body(rng, x, y)
    body, deep = profile(inward) * 1.0, rng.uniform(0.35, 1.0)
    if rng.random() < 0.5:
        wide = rng.uniform(0.35, 0.75)
        bowl = np.maximum(inward - (1 - wide), 0.0) / wide
        hollow = bowl ** rng.uniform(0.5, 1.5) if rng.random() < 0.6 else (bowl > 0) * 1.0
        # It reaches down from the height of its rim, whatever stood there.
        return np.where(bowl > 0, float(profile(1 - wide)) * (1 - deep * hollow), body)
    u, _ = _turned(rng, x, y)
    for _ in range(int(rng.integers(1, 3))):
        half, at = rng.uniform(0.06, 0.13), rng.uniform(-0.2, 0.2)
        body = np.where(np.abs(u - at) < half, np.minimum(body, (1 - deep) * profile(inward)), body)
    return body


def _rippled(rng: np.random.Generator, x: Array, y: Array) -> Array:
    """A body that has a name, with ridges across, or a flat one with rings about its middle."""
    profile, inward = _body(rng, x, y)
    rings = rng.random() < 0.5
    along = 0.5 * (1 - inward) if rings else _turned(rng, x, y)[0]
    wave = 0.5 + 0.5 * np.cos(2 * np.pi * (rng.uniform(2.0, 4.0) * along + rng.uniform(0, 1)))
    body = (inward > 0) * 1.0 if rings else profile(inward)
    return np.asarray(body * (1 - rng.uniform(0.25, 0.7) * wave))


#: Every way to make a stranger: a function of (rng, x, y) on the square of side 1, about 1 high.
STRANGERS: dict[str, Maker] = {
    "union": _union,
    "difference": _difference,
    "blob": _blob,
    "relief": _relief,
    "lumps": _lumps,
    "strokes": _strokes,
    "star": _star,
    "flower": _flower,
    "ring": _ring,
    "pattern": _pattern,
    "ragged": _ragged,
    "stack": _stack,
    "dented": _dented,
    "tower": _tower,
    "polygon": _polygon_face,
    "hollowed": _hollowed,
    "rippled": _rippled,
}

# What is told from a named body by parts of it alone, and the breadth in taxels from which on these are seen.
_FINE, _SEEN = ("hollowed", "rippled"), 11.0

# Shapes that are flat unless something is made of them.
_FLAT = ("union", "difference", "blob", "strokes", "star", "flower", "ring", "ragged")


def _simple(mask: Mask) -> bool:
    """Tell whether a flat face is, near enough, a disc, a box or a bar: these have names."""
    area = float(mask.sum())
    if area < 12:
        return True
    y, x = np.nonzero(mask)
    covariance = np.cov(np.stack([x, y]).astype(np.float64))
    root = np.sqrt(max(float(np.linalg.det(covariance)), 1e-12))
    # Discs and ellipses have 4 pi root / area = 1, boxes and bars pi / 3; both are filled and have no notch.
    fullness = 4 * np.pi * root / area
    if fullness > 1.12:
        return False
    values, axes = np.linalg.eigh(covariance)
    centred = np.stack([x - x.mean(), y - y.mean()])
    across = axes.T @ centred
    ellipse = float(((across[0] ** 2 / (4 * values[0]) + across[1] ** 2 / (4 * values[1])) <= 1.0).mean())
    best_box = 0.0
    for a in np.linspace(0, np.pi / 2, 12, endpoint=False):
        u, v = np.cos(a) * centred[0] + np.sin(a) * centred[1], np.cos(a) * centred[1] - np.sin(a) * centred[0]
        best_box = max(best_box, area / max((np.ptp(u) + 1) * (np.ptp(v) + 1), 1.0))
    return ellipse > 0.955 or best_box > 0.93


def stranger_face(
    rng: np.random.Generator, shape: tuple[int, int], size: tuple[float, float], *, per_taxel: int = 6, kind: str = ""
) -> Array:
    """Return the height map of a stranger on a pad of unit pitch, `per_taxel` samples along a taxel's side.

    Parameters
    ----------
    rng : numpy.random.Generator
    shape : (int, int)
        Rows and columns of taxels.
    size : (float, float)
        Range of the face's breadth, taxels; it is placed so that it stays in the field, or mostly.
    per_taxel : int
    kind : str
        A key of `STRANGERS`; default: any.

    Returns
    -------
    ndarray of shape (rows * per_taxel, cols * per_taxel), float64
        Heights from 0 to 1.
    """
    x, y = pad_points(shape, 1.0, per_taxel=per_taxel)
    while True:
        name = kind or str(rng.choice(list(STRANGERS)))
        breadth = rng.uniform(max(size[0], 0.5 * size[1]), 1.1 * size[1])
        if name in _FINE and breadth < _SEEN:
            continue
        free_y, free_x = (max((n - breadth) / 2, 0.0) for n in shape)
        out = 1.15 if rng.random() < 0.15 else 1.0
        yaw = rng.uniform(-np.pi, np.pi)
        dx = (x - rng.uniform(-free_x, free_x) * out) / breadth
        dy = (y - rng.uniform(-free_y, free_y) * out) / breadth
        c, s = np.cos(yaw), np.sin(yaw)
        u, v = c * dx + s * dy, c * dy - s * dx
        face = STRANGERS[name](rng, u, v)
        mask = face > 0.02
        # Strangers of hardly any taxels are nobody's.
        if mask.sum() < 9 * per_taxel**2 * min(1.0, (size[0] / 4) ** 2):
            continue
        if name in _FLAT and _simple(mask):
            continue
        way = rng.random()
        if name in _FLAT and way < 0.15:
            face = face * np.maximum(1 - rng.uniform(0.5, 2.5) * (u**2 + v**2), 0.05)
        elif name in _FLAT and way < 0.27:
            depth = ndimage.distance_transform_edt(mask)
            face = (depth / max(float(depth.max()), 1e-9)) ** rng.uniform(0.5, 1.2)
        elif way < 0.33:
            a = rng.uniform(-np.pi, np.pi)
            face = np.maximum(face * (1 + rng.uniform(0.2, 0.9) * (np.cos(a) * u + np.sin(a) * v)), 0.0)
        top = float(face.max())
        if not top > 0:
            continue
        return np.asarray(face / top)
