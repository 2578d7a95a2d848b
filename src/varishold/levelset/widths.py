"""Widths of sections by their support function, in 16 directions.

Only the outermost crossing of a grid line can be a corner of a section's convex hull: the rightmost and
leftmost of each row, the lowest and highest of each column. As sections nest, a line's outermost taxel only
moves outward as the threshold falls, so each line is walked once for all thresholds. A crossing to the right
counts only for directions that point to the right: for the others, the taxel to its left reaches farther.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

__all__ = ["COS", "DIRECTIONS", "N_DIRECTIONS", "SIN", "side_widths"]

N_DIRECTIONS = 16

#: Angles of the directions in which widths are taken, radians from +x toward +y.
DIRECTIONS = np.arange(N_DIRECTIONS) * (math.pi / N_DIRECTIONS)

# The 32 directions around the circle.
COS = np.cos(np.arange(2 * N_DIRECTIONS) * (math.pi / N_DIRECTIONS))
SIN = np.sin(np.arange(2 * N_DIRECTIONS) * (math.pi / N_DIRECTIONS))
# The axes exactly, so that a square's width is its breadth to the last bit.
COS[[8, 24]] = 0.0
SIN[[0, 16]] = 0.0


@njit(cache=True, nogil=True)
def _raise(support, reach, first, last, centre, across, along_sin):  # type: ignore[no-untyped-def]
    """Raise the supports of one contact by a line's outermost points at the thresholds first..last - 1.

    The line stands at `across`; its points lie at reach[i] along it. `centre` is the direction along which
    they are outermost.
    """
    for d in range(centre - 7, centre + 8):
        j = d % (2 * N_DIRECTIONS)
        if along_sin:
            along, offset = SIN[j], across * COS[j]
        else:
            along, offset = COS[j], across * SIN[j]
        row = support[j]
        for i in range(first, last):
            s = reach[i] * along + offset
            row[i] = s if s > row[i] else row[i]


@njit(cache=True, nogil=True)
def _walk(v, label, enters, k, end, t, start, stride, count, positions, at, step, reach):  # type: ignore[no-untyped-def]
    """Walk a line inward and write the outermost point at each threshold; return the first threshold.

    The line's taxels are start, start + stride, ...; `positions[at]`, `positions[at + step]`, ... are theirs.
    """
    seen = end
    for i in range(count):
        p = start + i * stride
        if label[p] != k or enters[p] >= seen:
            continue
        first = enters[p]
        here = positions[at + i * step]
        if i == 0:
            for j in range(first, seen):
                reach[j] = here
        else:
            beyond = p - stride
            if v[beyond] == -np.inf:
                for j in range(first, seen):
                    reach[j] = here
            else:
                slope = (positions[at + (i - 1) * step] - here) / (v[p] - v[beyond])
                for j in range(first, seen):
                    reach[j] = here + (v[p] - t[j]) * slope
        seen = first
        if seen == 0:
            break
    return seen


@njit(cache=True, nogil=True)
def side_widths(v, width, height, label, enters, places, t, xs, ys, support):  # type: ignore[no-untyped-def]
    """Raise the supports of every contact by the outermost crossings of its rows and columns.

    Parameters
    ----------
    v, label, enters : ndarray of shape (height * width,)
        The padded frame, each taxel's contact, and the threshold at which it comes in.
    width, height : int
        Of the padded frame.
    places : ndarray of shape (n_contacts, 9), int64
        As in `kernel.sections`.
    t : ndarray of shape (n_contacts, n), float64
        Falling thresholds.
    xs, ys : ndarray, float64
        Positions of columns and rows.
    support : ndarray of shape (n_contacts, 32, n), float64
        Raised in place: max of x cos + y sin, in 32 directions around the circle.
    """
    n = t.shape[1]
    reach = np.empty(n, np.float64)
    for k in range(places.shape[0]):
        end = places[k, 8]
        top, bottom = places[k, 2] - 1, places[k, 3] + 1
        left, right = places[k, 4] - 1, places[k, 5] + 1
        for r in range(top, bottom + 1):
            start = r * width
            count = right - left + 1
            first = _walk(v, label, enters, k, end, t[k], start + right, -1, count, xs, right, -1, reach)
            if first < end:
                _raise(support[k], reach, first, end, 0, ys[r], False)
                _walk(v, label, enters, k, end, t[k], start + left, 1, count, xs, left, 1, reach)
                _raise(support[k], reach, first, end, 16, ys[r], False)
        for c in range(left, right + 1):
            start = c
            count = bottom - top + 1
            first = _walk(v, label, enters, k, end, t[k], bottom * width + c, -width, count, ys, bottom, -1, reach)
            if first < end:
                _raise(support[k], reach, first, end, 8, xs[c], True)
                _walk(v, label, enters, k, end, t[k], top * width + c, width, count, ys, top, 1, reach)
                _raise(support[k], reach, first, end, 24, xs[c], True)
