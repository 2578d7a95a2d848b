"""Outlines that end at the pad's border, closed along it, so that a section can be filled."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

__all__ = ["close_outlines", "signed_area"]

# Ends this near the border, as a share of the pad's size, lie on it.
_ON_BORDER = 1e-9


def close_outlines(
    polylines: Sequence[NDArray[np.float64]], size: tuple[float, float], area: float
) -> list[NDArray[np.float64]]:
    """Close a section's outlines along the border of the pad.

    From the end of each open outline the border is followed, the pad on the left as the section is, to the next
    start. An end inside the pad, at a gap of the field, is joined to the nearest start inside it.

    Parameters
    ----------
    polylines : sequence of ndarray of shape (n, 2), float64
        Outlines (x, y) from the pad's corner, the section on their left; closed ones end where they start.
    size : (float, float)
        Width and height of the pad.
    area : float
        The section's area. It tells whether a section without a border of its own covers the pad.

    Returns
    -------
    list of ndarray of shape (m, 2), float64
        Polygons, the last vertex joined to the first; outer ones turn from +x toward +y, holes the other way.
    """
    closed: list[NDArray[np.float64]] = []
    left_open: list[_Open] = []
    for line in polylines:
        start, end = line[0].tolist(), line[-1].tolist()
        if start != end:
            left_open.append(_Open(line, start, end))
        elif len(line) > 3:
            closed.append(line[:-1])
    if left_open:
        return closed + _joined(left_open, size)
    width, height = size
    enclosed = sum(signed_area(polygon) for polygon in closed)
    if abs(enclosed + width * height - area) < abs(enclosed - area):
        closed.append(np.array([[0.0, 0.0], [width, 0.0], [width, height], [0.0, height]]))
    return closed


def signed_area(polygon: NDArray[np.float64]) -> float:
    """Return the area that a polygon encloses, positive where it turns from +x toward +y."""
    following = np.concatenate([polygon[1:], polygon[:1]])
    return 0.5 * float(polygon[:, 0] @ following[:, 1] - polygon[:, 1] @ following[:, 0])


class _Open(NamedTuple):
    """An outline that does not close, with its ends as plain numbers: pages draw thousands a second."""

    line: NDArray[np.float64]
    start: list[float]
    end: list[float]


def _joined(lines: list[_Open], size: tuple[float, float]) -> list[NDArray[np.float64]]:
    starts = [_along_border(line.start, size) for line in lines]
    following = [_next(line.end, lines, starts, size) for line in lines]
    polygons, left = [], dict.fromkeys(range(len(lines)))
    while left:
        i = next(iter(left))
        pieces = []
        while i in left:
            del left[i]
            pieces.append(lines[i].line)
            i, corners = following[i]
            if corners:
                pieces.append(np.array(corners))
        polygons.append(np.concatenate(pieces))
    return polygons


def _next(
    end: list[float], lines: list[_Open], starts: list[float | None], size: tuple[float, float]
) -> tuple[int, list[tuple[float, float]]]:
    """Return which outline goes on from an end, and the pad's corners on the way to it."""
    at = _along_border(end, size)
    around = 2 * (size[0] + size[1])
    if at is not None:
        ways = [math.inf if start is None else (start - at) % around for start in starts]
        least = min(ways)
        return ways.index(least), [] if least == math.inf else _corners(at, least, size)
    away = [math.dist(line.start, end) + (0.0 if s is None else around) for line, s in zip(lines, starts, strict=True)]
    return away.index(min(away)), []


def _along_border(point: list[float], size: tuple[float, float]) -> float | None:
    """Return how far along the border a point lies, from (0, 0) over (width, 0); None inside the pad."""
    x, y = point
    width, height = size
    near = _ON_BORDER * (width + height)
    if y <= near:
        return x
    if x >= width - near:
        return width + y
    if y >= height - near:
        return 2 * width + height - x
    if x <= near:
        return 2 * (width + height) - y
    return None


def _corners(at: float, way: float, size: tuple[float, float]) -> list[tuple[float, float]]:
    width, height = size
    around = 2 * (width + height)
    places = [(width, width, 0.0), (width + height, width, height), (around - height, 0.0, height), (around, 0.0, 0.0)]
    passed = [(ahead, x, y) for place, x, y in places if 0 < (ahead := (place - at) % around) < way]
    return [(x, y) for _, x, y in sorted(passed)]
