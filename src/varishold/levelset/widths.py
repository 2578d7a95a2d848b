"""Widths of sections by their support function, in 16 directions.

Only the outermost crossing of a grid line can be a corner of a section's convex hull: the rightmost and
leftmost of each row, the lowest and highest of each column. As sections nest, a line's outermost taxel only
moves outward as the threshold falls, so each line is walked once for all thresholds. A crossing to the right
counts only for directions that point to the right: for the others, the taxel to its left reaches farther.
"""

from __future__ import annotations

import math

import numpy as np

from varishold.files.compiling import njit

__all__ = ["COS", "DIRECTIONS", "GROUP", "N_DIRECTIONS", "SIN", "add_supports"]

N_DIRECTIONS = 16
# Levels that are done at once by vector instructions.
GROUP = 16

#: Angles of the directions in which widths are taken, radians from +x toward +y.
DIRECTIONS = np.arange(N_DIRECTIONS) * (math.pi / N_DIRECTIONS)

# The 32 directions around the circle, the axes exactly, so that a square's width is its breadth to the last bit.
COS = np.cos(np.arange(2 * N_DIRECTIONS) * (math.pi / N_DIRECTIONS))
SIN = np.sin(np.arange(2 * N_DIRECTIONS) * (math.pi / N_DIRECTIONS))
COS[[8, 24]] = 0.0
SIN[[0, 16]] = 0.0


@njit(cache=True, nogil=True, error_model="numpy")
def _walk(v, t, enters, earliest, latest, position, start, stride, count, at, step, reach):  # type: ignore[no-untyped-def]
    """Walk a line of the window inward and write the outermost point at each threshold.

    `v` and `enters` are flat, the line's taxels are start, start + stride, ...; their positions are
    position[at], position[at + step], ... `earliest` is where the line's first taxel comes in.
    """
    seen = latest
    p, a = start, at
    for i in range(count):
        first = enters[p]
        if first < seen:
            here = position[a]
            if i == 0 or v[p - stride] == -np.inf:
                for j in range(first, seen):
                    reach[j] = here
            else:
                slope = (position[a - step] - here) / (v[p] - v[p - stride])
                top = v[p]
                for j in range(first, seen):
                    reach[j] = here + (top - t[j]) * slope
            seen = first
            if seen == earliest:
                break
        p += stride
        a += step


@njit(cache=True, nogil=True, error_model="numpy")
def _raise(support, reach, first, last, centre, along, across, place):  # type: ignore[no-untyped-def]
    """Raise the supports around the direction `centre` by a line's outermost points.

    The line stands at `place`; a point's support is reach * along[direction] + place * across[direction].
    """
    # Slices that start at 0 and whole groups of levels (both arrays are longer than the thresholds by one
    # group) let vector instructions do all of the work.
    last = first + (last - first + GROUP - 1) // GROUP * GROUP
    points = reach[first:last]
    for d in range(centre - 7, centre + 8):
        j = d & (2 * N_DIRECTIONS - 1)
        slope, offset = along[j], place * across[j]
        row = support[j, first:last]
        for i in range(points.size):
            s = points[i] * slope + offset
            row[i] = s if s > row[i] else row[i]


@njit(cache=True, nogil=True, error_model="numpy")
def add_supports(v, enters, xs, ys, t, support):  # type: ignore[no-untyped-def]
    """Raise a contact's supports by the outermost crossings of its window's rows and columns.

    Parameters
    ----------
    v, enters, xs, ys, t
        As in `cells.add_cells`.
    support : ndarray of shape (32, n + GROUP), float64
        Raised in place: max of x cos + y sin, in 32 directions around the circle.
    """
    height, width = v.shape
    latest = t.size
    reach = np.zeros(support.shape[1])
    values, when = v.ravel(), enters.ravel()
    column_earliest = np.full(width, np.int32(latest))
    for r in range(height):
        row = enters[r]
        earliest = row[0]
        for c in range(width):
            earliest = min(earliest, row[c])
            column_earliest[c] = min(column_earliest[c], row[c])
        if earliest == latest:
            continue
        for side in range(2):
            at = (width - 1) * (1 - side)
            step = 2 * side - 1
            _walk(values, t, when, earliest, latest, xs, r * width + at, step, width, at, step, reach)
            _raise(support, reach, earliest, latest, 16 * side, COS, SIN, ys[r])
    for c in range(width):
        earliest = column_earliest[c]
        if earliest == latest:
            continue
        for side in range(2):
            at = (height - 1) * (1 - side)
            step = 2 * side - 1
            _walk(values, t, when, earliest, latest, ys, at * width + c, step * width, height, at, step, reach)
            _raise(support, reach, earliest, latest, 8 + 16 * side, SIN, COS, xs[c])
