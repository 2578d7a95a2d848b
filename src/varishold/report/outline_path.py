"""Outline polygons as compact SVG paths: thinned, rounded to whole hundredths, written as steps."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

__all__ = ["UNITS_PER_TAXEL", "path_data", "thinned"]

#: Paths are written in this many whole steps to a taxel.
UNITS_PER_TAXEL = 50
# Passes of thinning; each may move the outline by its share of the tolerance.
_PASSES = 5


def thinned(polygon: NDArray[np.float64], tolerance: float) -> NDArray[np.float64]:
    """Leave out the vertices that a closed polygon does not need.

    In each of a few passes, vertices near the chord of their two neighbours go, never two neighbours at once;
    a pass moves the outline by no more than its share of the tolerance.

    Parameters
    ----------
    polygon : ndarray of shape (n, 2), float64
        Its vertices in order, the last joined to the first.
    tolerance : float
        Largest distance of a left-out vertex from the new outline.

    Returns
    -------
    ndarray of shape (m, 2), float64
        m <= n of the vertices, in their order.
    """
    if len(polygon) > 1 and np.array_equal(polygon[0], polygon[-1]):
        polygon = polygon[:-1]
    share = tolerance / _PASSES
    for _ in range(_PASSES):
        n = len(polygon)
        if n <= 6:
            break
        ring = np.concatenate([polygon[-1:], polygon, polygon[:1]])
        chord = ring[2:] - ring[:-2]
        off = polygon - ring[:-2]
        along = (off * chord).sum(axis=1) / np.maximum((chord**2).sum(axis=1), 1e-300)
        away = off - np.clip(along, 0.0, 1.0)[:, None] * chord
        spare = (away**2).sum(axis=1) <= share * share
        # Of a run of spare vertices every second goes; the ring's first never does, so that its ends stay apart.
        place = np.arange(n)
        run = place - np.maximum.accumulate(np.where(spare, -1, place))
        gone = spare & (run % 2 == 1)
        gone[0] = False
        if not gone.any():
            break
        polygon = polygon[~gone]
    return polygon


def path_data(polygons: Sequence[NDArray[np.float64]], *, scale: float = UNITS_PER_TAXEL) -> str:
    """Write closed polygons as the data of one SVG path, in whole steps.

    Parameters
    ----------
    polygons : sequence of ndarray of shape (n, 2), float64
        Vertices (x, y) in drawing units.
    scale : float
        Steps to a drawing unit.

    Returns
    -------
    str
        One absolute start and relative lines for each polygon.

    Examples
    --------
    >>> path_data([np.array([[0.0, 0.0], [2.0, 0.0], [2.0, 1.0]])], scale=10)
    'M0 0l20 0 0 10z'
    """
    written = []
    for polygon in polygons:
        at = np.round(polygon * scale).astype(np.int64)
        steps = np.diff(at, axis=0)
        steps = steps[(steps != 0).any(axis=1)]
        if len(steps) < 2:
            continue
        line = " ".join(f"{x} {y}" for x, y in steps.tolist()).replace(" -", "-")
        written.append(f"M{at[0, 0]} {at[0, 1]}l{line}z")
    return "".join(written)
