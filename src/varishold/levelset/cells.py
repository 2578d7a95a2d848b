"""Marching squares on a contact's window, for all thresholds at once.

A window holds a contact's taxels and one more on every side, row by row. `enters` is the index of the first
threshold below a taxel's value, the contact's number of thresholds where it never comes in.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from varishold.files.compiling import njit
from varishold.levelset.green import S_AREA, S_LENGTH, S_X, S_XX, S_XY, S_Y, S_YY, add_outline

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


# Levels that are worked on side by side, one vector instruction for all.
LANES = 4

#: Sides by which the outline leaves and enters; shape (2, 16, 2, 2).
OUTLINE_SEGMENTS = _outline_segments()


@njit(cache=True, nogil=True, error_model="numpy", fastmath={"contract"})
def _add_saddle(sums, t, x, y, v, enters, first, last):  # type: ignore[no-untyped-def]
    """Add the segments of a cell that is a saddle at some of the thresholds first..last - 1, one by one.

    Its four corners run from x to y.
    """
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
            over_a, over_c = 1.0 / (va - v[b]), 1.0 / (vc - v[d])
            for j in range(i, stop):
                fa, fc = (va - t[j]) * over_a, (vc - t[j]) * over_c
                px, py = x[a] + fa * (x[b] - x[a]), y[a] + fa * (y[b] - y[a])
                qx, qy = x[c] + fc * (x[d] - x[c]), y[c] + fc * (y[d] - y[c])
                add_outline(sums, j, px, py, qx, qy)
        i = stop


@njit(cache=True, nogil=True, error_model="numpy", fastmath={"contract"})
def _add_cell(lanes, start, stop, x0, y0, x1, y1, v0, v1, v2, v3, w0, w1, w2, w3):  # type: ignore[no-untyped-def]
    """Add a cell's one segment per level, for the groups start..stop - 1 of levels.

    The corners run from x to y, as do the sides after them; w is v, or -inf where the corner is another contact's.
    """
    # How far crossings run for a unit of V: above, below, on the left and on the right.
    above, below = (x1 - x0) / (v0 - v1), (x1 - x0) / (v3 - v2)
    left, right = (y1 - y0) / (v0 - v3), (y1 - y0) / (v1 - v2)
    for g in range(start, stop):
        for i in range(LANES):
            t = lanes[g, i]
            in0, in1, in2, in3 = w0 > t, w1 > t, w2 > t, w3 > t
            xa, xb = x0 + (v0 - t) * above, x0 + (v3 - t) * below
            yl, yr = y0 + (v0 - t) * left, y0 + (v1 - t) * right
            # The outline leaves by the side that begins inside and comes back by the one that ends inside;
            # written without branches, for vectors.
            px = xa if in0 & (not in1) else (xb if in2 & (not in3) else (x1 if in1 & (not in2) else x0))
            py = yr if in1 & (not in2) else (yl if in3 & (not in0) else (y0 if in0 & (not in1) else y1))
            qx = xa if in1 & (not in0) else (xb if in3 & (not in2) else (x1 if in2 & (not in1) else x0))
            qy = yr if in2 & (not in1) else (yl if in0 & (not in3) else (y0 if in1 & (not in0) else y1))
            crossed = (in0 | in1 | in2 | in3) & (not (in0 & in1 & in2 & in3))
            # In twice the middle and the whole length; the powers of two are taken out at the end.
            x, y = px + qx, py + qy
            hx, hy = qx - px if crossed else 0.0, qy - py if crossed else 0.0
            square, third, cross = x * x, hx * hx * (1.0 / 3.0), hx * hy * (1.0 / 3.0)
            sides = hy * (square + third)
            lanes[g, 1 * LANES + i] += hy * x
            lanes[g, 2 * LANES + i] += sides
            lanes[g, 3 * LANES + i] += hy * (x * y + cross)
            lanes[g, 4 * LANES + i] += hy * x * (square * (1.0 / 3.0) + third)
            lanes[g, 5 * LANES + i] += y * sides + 2.0 * hy * x * cross
            lanes[g, 6 * LANES + i] += hy * (x * (y * y + hy * hy * (1.0 / 3.0)) + 2.0 * y * cross)
            lanes[g, 7 * LANES + i] += math.sqrt(hx * hx + hy * hy)


@njit(cache=True, nogil=True, error_model="numpy")
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
    end = t.size
    # Thresholds and sums of so many levels at a time stand side by side, one vector each.
    lanes = np.zeros(((end + LANES - 1) // LANES, 8 * LANES))
    for i in range(end):
        lanes[i // LANES, i % LANES] = t[i]
    x, y, corner = np.empty(4), np.empty(4), np.empty(4)
    enter = np.empty(4, np.int64)
    for r in range(height - 1):
        e1, e2 = enters[r, 0], enters[r + 1, 0]
        v1, v2 = v[r, 0], v[r + 1, 0]
        for c in range(width - 1):
            e0, e3, v0, v3 = e1, e2, v1, v2
            e1, e2 = enters[r, c + 1], enters[r + 1, c + 1]
            v1, v2 = v[r, c + 1], v[r + 1, c + 1]
            first = min(min(e0, e1), min(e2, e3))
            last = max(max(e0, e1), max(e2, e3))
            if first == last or min(min(v0, v1), min(v2, v3)) == -np.inf:
                continue
            if max(e0, e2) < min(e1, e3) or max(e1, e3) < min(e0, e2):
                corner[0], corner[1], corner[2], corner[3] = v0, v1, v2, v3
                enter[0], enter[1], enter[2], enter[3] = e0, e1, e2, e3
                x[0], x[1], x[2], x[3] = xs[c], xs[c + 1], xs[c + 1], xs[c]
                y[0], y[1], y[2], y[3] = ys[r], ys[r], ys[r + 1], ys[r + 1]
                _add_saddle(sums, t, x, y, corner, enter, first, last)
                continue
            w0, w1 = v0 if e0 < end else -np.inf, v1 if e1 < end else -np.inf
            w2, w3 = v2 if e2 < end else -np.inf, v3 if e3 < end else -np.inf
            start, stop = first // LANES, (last + LANES - 1) // LANES
            _add_cell(
                lanes, start, stop, xs[c], ys[r], xs[c + 1], ys[r + 1], v0, v1, v2, v3, w0, w1, w2, w3
            )  # fmt: skip
    for i in range(end):
        g, j = i // LANES, i % LANES
        sums[i, S_AREA] += 0.5 * lanes[g, 1 * LANES + j]
        sums[i, S_X] += 0.125 * lanes[g, 2 * LANES + j]
        sums[i, S_Y] += 0.25 * lanes[g, 3 * LANES + j]
        sums[i, S_XX] += 0.125 * lanes[g, 4 * LANES + j]
        sums[i, S_XY] += 0.0625 * lanes[g, 5 * LANES + j]
        sums[i, S_YY] += 0.125 * lanes[g, 6 * LANES + j]
        sums[i, S_LENGTH] += lanes[g, 7 * LANES + j]
