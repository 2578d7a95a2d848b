"""Faces that have no name: what recognition should call unknown, as height maps over a pad."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from varishold.solids import pad_points

Array = NDArray[np.float64]


def _polygon(x: Array, y: Array, corners: Array) -> Array:
    """Return 1 inside the polygon (n, 2), 0 outside, by the even-odd rule."""
    inside = np.zeros(x.shape, dtype=bool)
    for (ax, ay), (bx, by) in zip(corners, np.roll(corners, -1, axis=0), strict=True):
        if ay == by:
            continue
        crosses = (ay > y) != (by > y)
        inside ^= crosses & (x < (bx - ax) * (y - ay) / (by - ay) + ax)
    return inside.astype(np.float64)


def _l_shape(rng: np.random.Generator, x: Array, y: Array) -> Array:
    arm, other = rng.uniform(0.25, 0.45, 2)
    lo = -0.5
    corners = np.array([[lo, lo], [0.5, lo], [0.5, lo + arm], [lo + other, lo + arm], [lo + other, 0.5], [lo, 0.5]])
    return _polygon(x, y, corners)


def _t_or_cross(rng: np.random.Generator, x: Array, y: Array) -> Array:
    width = rng.uniform(0.22, 0.38) / 2
    bar = (np.abs(y if rng.random() < 0.5 else y - 0.5 + width) <= width) & (np.abs(x) <= 0.5)
    return (bar | ((np.abs(x) <= width) & (np.abs(y) <= 0.5))).astype(np.float64)


def _star(rng: np.random.Generator, x: Array, y: Array) -> Array:
    points = int(rng.integers(4, 8))
    inner = rng.uniform(0.3, 0.55) * 0.5
    angle = np.arange(2 * points) * np.pi / points
    radius = np.where(np.arange(2 * points) % 2 == 0, 0.5, inner)
    return _polygon(x, y, np.stack([radius * np.cos(angle), radius * np.sin(angle)], axis=1))


def _ring(rng: np.random.Generator, x: Array, y: Array) -> Array:
    inner = rng.uniform(0.35, 0.75) * 0.5
    r = np.hypot(x, y)
    if rng.random() < 0.4:
        r = np.maximum(np.abs(x), np.abs(y))
    flat = ((r <= 0.5) & (r >= inner)).astype(np.float64)
    if rng.random() < 0.3:
        middle, half = (0.5 + inner) / 2, (0.5 - inner) / 2
        return np.sqrt(np.maximum(1 - ((r - middle) / half) ** 2, 0.0))
    return flat


def _crescent(rng: np.random.Generator, x: Array, y: Array) -> Array:
    shift, inner = rng.uniform(0.15, 0.35), rng.uniform(0.3, 0.45)
    return ((np.hypot(x, y) <= 0.5) & (np.hypot(x - shift, y) > inner)).astype(np.float64)


def _two_blobs(rng: np.random.Generator, x: Array, y: Array) -> Array:
    apart, high = rng.uniform(0.25, 0.34), rng.uniform(0.55, 1.0)
    wide = rng.uniform(0.15, 0.25)
    first = np.maximum(1 - ((x - apart) ** 2 + y**2) / wide**2, 0.0)
    second = high * np.maximum(1 - ((x + apart) ** 2 + y**2) / wide**2, 0.0)
    bridge = rng.uniform(0.5, 0.8) * high * ((np.abs(x) <= apart) & (np.abs(y) <= wide * 0.7))
    return np.maximum(np.maximum(first, second), bridge)


def _ragged(rng: np.random.Generator, x: Array, y: Array) -> Array:
    corners = int(rng.integers(5, 9))
    angle = np.sort(rng.uniform(0, 2 * np.pi, corners))
    radius = rng.uniform(0.15, 0.5, corners)
    shape = _polygon(x, y, np.stack([radius * np.cos(angle), radius * np.sin(angle)], axis=1))
    return shape * (1 + rng.uniform(-0.8, 0.8) * x)


def _lumps(rng: np.random.Generator, x: Array, y: Array) -> Array:
    """A sum of a few bumps: a smooth random field."""
    total = np.zeros(x.shape)
    for _ in range(int(rng.integers(4, 9))):
        cx, cy = rng.uniform(-0.45, 0.45, 2)
        wide = rng.uniform(0.06, 0.16)
        total += rng.uniform(0.4, 1.0) * np.exp(-((x - cx) ** 2 + (y - cy) ** 2) / (2 * wide**2))
    return total / total.max()


#: Every kind of stranger: a function of (rng, x, y) on the square of side 1, at most 1 high.
STRANGERS: dict[str, Callable[[np.random.Generator, Array, Array], Array]] = {
    "l-shape": _l_shape,
    "cross": _t_or_cross,
    "star": _star,
    "ring": _ring,
    "crescent": _crescent,
    "two-blobs": _two_blobs,
    "ragged": _ragged,
    "lumps": _lumps,
}


def stranger_height(
    rng: np.random.Generator,
    kind: str,
    shape: tuple[int, int],
    size: tuple[float, float],
    *,
    per_taxel: int = 6,
) -> Array:
    """Return the height map of a stranger on a pad of unit pitch, `per_taxel` samples along a taxel's side.

    Parameters
    ----------
    rng : numpy.random.Generator
    kind : str
        A key of `STRANGERS`.
    shape : (int, int)
        Rows and columns of taxels.
    size : (float, float)
        Range of the face's breadth, taxels; it is placed so that it stays in the field.

    Returns
    -------
    ndarray of shape (rows * per_taxel, cols * per_taxel), float64
        Heights from 0 to about 1.
    """
    x, y = pad_points(shape, 1.0, per_taxel=per_taxel)
    breadth = rng.uniform(*size)
    free_y, free_x = (max((n - breadth) / 2, 0.0) for n in shape)
    yaw = rng.uniform(-np.pi, np.pi)
    dx, dy = (x - rng.uniform(-free_x, free_x)) / breadth, (y - rng.uniform(-free_y, free_y)) / breadth
    c, s = np.cos(yaw), np.sin(yaw)
    face = STRANGERS[kind](rng, c * dx + s * dy, c * dy - s * dx)
    if rng.random() < 0.3:
        # Some are domed rather than flat, so that not only an outline tells a stranger.
        face = face * np.maximum(1 - rng.uniform(0.5, 1.5) * (dx**2 + dy**2), 0.05)
    return face
