"""Marching squares on a contact's window, for all thresholds at once.

A window holds a contact's taxels and one more on every side, row by row. `enters` is the index of the first
threshold below a taxel's value, the contact's number of thresholds where it never comes in.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from varishold.levelset.green import add_outline

__all__ = ["OUTLINE_SEGMENTS", "add_cells"]


def _outline_segments() -> NDArray[np.int8]:
    """Return the sides through which outline segments run, for each pattern of a cell's corners.

    Corners (bits of the pattern) and the sides after them run from x to y. Entry [joined, pattern, segment] is
    (leave, enter): the segment starts on the side by which a walk around the section leaves it and ends where
    the walk comes back, so the section is on its left. Saddles (patterns 5 and 10) have two segments.
    """
    table = np.zeros((2, 16, 2, 2), np.int8)
    for pattern in range(1, 15):
        inside = [bool(pattern >> j & 1) for j in range(4)]
        leave = [j for j in range(4) if inside[j] and not inside[(j + 1) % 4]]
        enter = [j for j in range(4) if not inside[j] and inside[(j + 1) % 4]]
        for joined in (0, 1):
            for segment, side in enumerate(leave):
                # Joined corners are walked from one to the other, separate ones around each alone.
                step = 1 if joined or len(leave) == 1 else 3
                back = (side + step) % 4 if len(leave) == 2 else enter[0]
                table[joined, pattern, segment] = side, back
    return table


#: Sides by which the outline leaves and enters; shape (2, 16, 2, 2).
OUTLINE_SEGMENTS = _outline_segments()


@njit(cache=True, nogil=True, error_model="numpy", fastmath={"contract"})
def _add_cell(sums, t, x, y, v, enters, first, last):  # type: ignore[no-untyped-def]
    """Add a cell's segments at the thresholds first..last - 1; its four corners run from x to y."""
    i = first
    while i < last:
        stop = last
        pattern = 0
        for j in range(4):
            if enters[j] <= i:
                pattern |= 1 << j
            elif enters[j] < stop:
                stop = enters[j]
        joined, n_segments = 0, 1
        if pattern == 5 or pattern == 10:
            n_segments = 2
            four_means = (v[0] + v[1]) + (v[3] + v[2])
            j = i
            while j < stop and not 4.0 * t[j] < four_means:
                j += 1
            if j == i:
                joined = 1
            else:
                stop = j
        for segment in range(n_segments):
            a = OUTLINE_SEGMENTS[joined, pattern, segment, 0]
            c = OUTLINE_SEGMENTS[joined, pattern, segment, 1]
            b, d = (a + 1) & 3, (c + 1) & 3
            va, vc = v[a], v[c]
            xa, ya, xc, yc = x[a], y[a], x[c], y[c]
            over_a, over_c = 1.0 / (va - v[b]), 1.0 / (vc - v[d])
            dxa, dya = (x[b] - xa) * over_a, (y[b] - ya) * over_a
            dxc, dyc = (x[d] - xc) * over_c, (y[d] - yc) * over_c
            levels, out = t[i:stop], sums[i:stop]
            for j in range(levels.size):
                fa, fc = va - levels[j], vc - levels[j]
                add_outline(out, j, xa + fa * dxa, ya + fa * dya, xc + fc * dxc, yc + fc * dyc)
        i = stop


@njit(cache=True, nogil=True, error_model="numpy", fastmath={"contract"})
def add_cells(v, enters, xs, ys, t, sums):  # type: ignore[no-untyped-def]
    """Add all whole cells' outline segments to a contact's sums.

    Parameters
    ----------
    v : ndarray of shape (height, width), float64
        Values in the window; -inf where there is no taxel.
    enters : ndarray of shape (height, width), int32
        Index of the first threshold at which a taxel is in.
    xs, ys : ndarray of shape (width,) and (height,), float64
        Positions, from the point that the moments shall refer to.
    t : ndarray of shape (n,), float64
        Falling thresholds.
    sums : ndarray of shape (n, N_SUMS), float64
        Added to.
    """
    height, width = v.shape
    x, y, corner = np.empty(4), np.empty(4), np.empty(4)
    enter = np.empty(4, np.int32)
    for r in range(height - 1):
        y[0] = y[1] = ys[r]
        y[2] = y[3] = ys[r + 1]
        e1, e2 = enters[r, 0], enters[r + 1, 0]
        for c in range(width - 1):
            e0, e3 = e1, e2
            e1, e2 = enters[r, c + 1], enters[r + 1, c + 1]
            first = min(min(e0, e1), min(e2, e3))
            last = max(max(e0, e1), max(e2, e3))
            if first == last:
                continue
            corner[0], corner[1], corner[2], corner[3] = v[r, c], v[r, c + 1], v[r + 1, c + 1], v[r + 1, c]
            if min(min(corner[0], corner[1]), min(corner[2], corner[3])) == -np.inf:
                continue
            enter[0], enter[1], enter[2], enter[3] = e0, e1, e2, e3
            x[0] = x[3] = xs[c]
            x[1] = x[2] = xs[c + 1]
            _add_cell(sums, t, x, y, corner, enter, first, last)
