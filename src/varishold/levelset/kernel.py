"""The one pass: every contact's sections at all thresholds at once.

Green's theorem turns areas and moments into sums over outline segments. A cell between four taxel centres is
crossed only at the thresholds between its lowest and its highest corner, so the work is one visit to each
cell plus one short sum for each crossed segment; a cell that is covered wholly costs nothing at any
threshold, because the shared borders of neighbouring cells cancel.

Arrays are flat views of a frame padded by one taxel on every side, as in `merge_tree`.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from varishold.levelset.border import border_cells, gap_events
from varishold.levelset.green import N_SUMS, add_outline
from varishold.levelset.merge_tree import merge_tree
from varishold.levelset.widths import COS, N_DIRECTIONS, SIN, side_widths

__all__ = ["WIDTHS", "sections"]

# Bins of the table that guesses where a value stands among uneven thresholds.
_BINS = 256
# So many numbers a threshold stand before the widths in `measures`.
WIDTHS = 9


@njit(cache=True, nogil=True, inline="always")
def _edge(e, x0, y0, x1, y1, v0, v1, v2, v3):  # type: ignore[no-untyped-def]
    """Return start, direction per unit of value, and start value of a cell's edge, counter-clockwise."""
    if e == 0:
        return x0, y0, (x1 - x0) / (v0 - v1), 0.0, v0
    if e == 1:
        return x1, y0, 0.0, (y1 - y0) / (v1 - v2), v1
    if e == 2:
        return x1, y1, (x0 - x1) / (v2 - v3), 0.0, v2
    return x0, y1, 0.0, (y0 - y1) / (v3 - v0), v3


@njit(cache=True, nogil=True)
def _add_cell(sums, base, t, x0, y0, x1, y1, v0, v1, v2, v3, l0, l1, l2, l3, first, last):  # type: ignore[no-untyped-def]
    """Add a cell's segments at the thresholds first..last - 1; corner j is in from threshold l_j on."""
    i = first
    while i < last:
        stop = last
        mask = 0
        if l0 <= i:
            mask |= 1
        elif l0 < stop:
            stop = l0
        if l1 <= i:
            mask |= 2
        elif l1 < stop:
            stop = l1
        if l2 <= i:
            mask |= 4
        elif l2 < stop:
            stop = l2
        if l3 <= i:
            mask |= 8
        elif l3 < stop:
            stop = l3
        if mask == 5 or mask == 10:
            mean = 0.25 * ((v0 + v1) + (v3 + v2))
            ax, ay, adx, ady, av = _edge(0, x0, y0, x1, y1, v0, v1, v2, v3)
            bx, by, bdx, bdy, bv = _edge(1, x0, y0, x1, y1, v0, v1, v2, v3)
            cx, cy, cdx, cdy, cv = _edge(2, x0, y0, x1, y1, v0, v1, v2, v3)
            dx, dy, ddx, ddy, dv = _edge(3, x0, y0, x1, y1, v0, v1, v2, v3)
            for j in range(i, stop):
                level = t[j]
                px, py = ax + (av - level) * adx, ay + (av - level) * ady
                qx, qy = bx + (bv - level) * bdx, by + (bv - level) * bdy
                rx, ry = cx + (cv - level) * cdx, cy + (cv - level) * cdy
                sx, sy = dx + (dv - level) * ddx, dy + (dv - level) * ddy
                k = base + j
                joined = mean > level
                if mask == 5:
                    if joined:
                        add_outline(sums, k, px, py, qx, qy)
                        add_outline(sums, k, rx, ry, sx, sy)
                    else:
                        add_outline(sums, k, px, py, sx, sy)
                        add_outline(sums, k, rx, ry, qx, qy)
                elif joined:
                    add_outline(sums, k, qx, qy, rx, ry)
                    add_outline(sums, k, sx, sy, px, py)
                else:
                    add_outline(sums, k, qx, qy, px, py)
                    add_outline(sums, k, sx, sy, rx, ry)
        else:
            # Leaves the section through the edge after its last corner, comes back before its first.
            if mask == 1 or mask == 9 or mask == 13:
                leave = 0
            elif mask == 2 or mask == 3 or mask == 11:
                leave = 1
            elif mask == 4 or mask == 6 or mask == 7:
                leave = 2
            else:
                leave = 3
            if mask == 2 or mask == 6 or mask == 14:
                enter = 0
            elif mask == 4 or mask == 12 or mask == 13:
                enter = 1
            elif mask == 8 or mask == 9 or mask == 11:
                enter = 2
            else:
                enter = 3
            ax, ay, adx, ady, av = _edge(leave, x0, y0, x1, y1, v0, v1, v2, v3)
            bx, by, bdx, bdy, bv = _edge(enter, x0, y0, x1, y1, v0, v1, v2, v3)
            for j in range(i, stop):
                level = t[j]
                add_outline(
                    sums,
                    base + j,
                    ax + (av - level) * adx,
                    ay + (av - level) * ady,
                    bx + (bv - level) * bdx,
                    by + (bv - level) * bdy,
                )
        i = stop


@njit(cache=True, nogil=True, inline="always")
def _first_below(t, n, value, top, scale, guess):  # type: ignore[no-untyped-def]
    """Return how many of the falling thresholds t[:n] are not below the value, that is, where it comes in."""
    b = int((top - value) * scale)
    i = guess[min(max(b, 0), guess.size - 1)]
    if i > n:
        i = n
    while i > 0 and t[i - 1] < value:
        i -= 1
    while i < n and not t[i] < value:
        i += 1
    return i


@njit(cache=True, nogil=True)
def _guesses(t, n):  # type: ignore[no-untyped-def]
    """Return a table from a value's bin between the thresholds' ends to a threshold near it."""
    guess = np.empty(_BINS, np.int64)
    scale = _BINS / (t[0] - t[n - 1]) if t[0] > t[n - 1] else 0.0
    i = 0
    for b in range(_BINS):
        value = t[0] - (b + 0.5) / scale if scale > 0 else t[0]
        while i < n and not t[i] < value:
            i += 1
        guess[b] = i
    return guess, scale


@njit(cache=True, nogil=True)
def sections(v, width, height, floor, thresholds, n_even, xs, ys, ghosts):  # type: ignore[no-untyped-def]
    """Find the contacts of a padded frame and measure all their sections.

    Parameters
    ----------
    v : ndarray of shape (height * width,), float64
        The padded frame, -inf where there is no taxel, the rim among them. The rim is overwritten if
        `ghosts`.
    width, height : int
        Of the padded frame.
    floor : float
        Contacts are parts of {V > floor}.
    thresholds : ndarray of shape (n,), float64
        Falling, the same for every contact; not read if `n_even` > 0.
    n_even : int
        So many thresholds per contact, evenly from its peak to its end at half steps; 0 for `thresholds`.
    xs, ys : ndarray of shape (width,) and (height,), float64
        Positions of the padded frame's columns and rows; the outermost stand half a taxel outside.
    ghosts : bool
        True if every taxel within the rim exists. Then the rim takes its neighbours' values and its cells,
        half a taxel wide, are cells like the others; else `border_cells` does the cells that lack a corner.

    Returns
    -------
    label : ndarray of shape (height * width,), int32
        Each taxel's contact or -1.
    places : ndarray of shape (n_contacts, 9), int64
        Peak's row and column, first and last row and column, number of taxels, touched borders (bits: left,
        right, top, bottom), number of thresholds not below the contact's end.
    values : ndarray of shape (n_contacts, 2), float64
        Peak and end.
    order : ndarray of shape (n_contacts,), int64
        The contacts by falling area of their lowest section, then by falling number of taxels.
    measures : ndarray of shape (n_contacts, 25 * n), float64
        One after the other, each in one piece: n thresholds, areas, perimeters, centroids (x, y), covariances
        (xx, xy, yx, yy), widths in 16 directions. All but the thresholds are NaN below the contact's end.
    counts : ndarray of shape (n_contacts, 2, n), int64
        Parts and holes.
    """
    label = np.empty(v.size, np.int32)
    peak_at, ends, event_at, event_value, event_parts, event_holes = merge_tree(v, width, height, floor, label)
    n_contacts = peak_at.size
    n = n_even if n_even > 0 else thresholds.size
    places = np.empty((n_contacts, 9), np.int64)
    values = np.empty((n_contacts, 2), np.float64)
    measures = np.empty((n_contacts, (WIDTHS + N_DIRECTIONS) * n), np.float64)
    counts = np.zeros((n_contacts, 2, n), np.int64)
    order = np.arange(n_contacts)
    if n_contacts == 0:
        return label, places, values, order, measures, counts

    # Thresholds.
    t = np.empty((n_contacts, n), np.float64)
    scale = np.empty(n_contacts, np.float64)
    if n_even > 0:
        guess = np.arange(1, n + 1)
        spread = 0.0
    else:
        guess, spread = _guesses(thresholds, n)
    for k in range(n_contacts):
        peak = v[peak_at[k]]
        values[k, 0], values[k, 1] = peak, ends[k]
        used = n
        if n_even > 0:
            step = (peak - ends[k]) / n
            for i in range(n):
                t[k, i] = peak - (i + 0.5) * step
            scale[k] = 1.0 / step if step > 1e-300 else 0.0
        else:
            for i in range(n):
                t[k, i] = thresholds[i]
            scale[k] = spread
            while used > 0 and thresholds[used - 1] < ends[k]:
                used -= 1
        places[k, 0], places[k, 1] = peak_at[k] // width, peak_at[k] % width
        places[k, 2], places[k, 3], places[k, 4], places[k, 5] = height, 0, width, 0
        places[k, 6], places[k, 7], places[k, 8] = 0, 0, used

    # Where each taxel comes in.
    enters = np.empty(v.size, np.int32)
    missing = -np.inf
    for p in range(width):
        enters[p] = n
        enters[v.size - 1 - p] = n
    for r in range(1, height - 1):
        enters[r * width] = n
        enters[(r + 1) * width - 1] = n
        for c in range(1, width - 1):
            p = r * width + c
            k = label[p]
            if k < 0:
                enters[p] = n
                continue
            place = places[k]
            enters[p] = _first_below(t[k], place[8], v[p], t[k, 0], scale[k], guess)
            place[2], place[3] = min(place[2], r), max(place[3], r)
            place[4], place[5] = min(place[4], c), max(place[5], c)
            place[6] += 1
            if v[p - 1] == missing:
                place[7] |= 1
            if v[p + 1] == missing:
                place[7] |= 2
            if v[p - width] == missing:
                place[7] |= 4
            if v[p + width] == missing:
                place[7] |= 8

    # Parts and holes.
    for e in range(event_at.size):
        k = label[event_at[e]]
        if k >= 0 and event_value[e] > ends[k]:
            i = _first_below(t[k], places[k, 8], event_value[e], t[k, 0], scale[k], guess)
            if i < places[k, 8]:
                counts[k, 0, i] += event_parts[e]
                counts[k, 1, i] += event_holes[e]
    if not ghosts:
        gap_events(v, width, height, label, enters, places, counts)
    for k in range(n_contacts):
        for j in range(2):
            for i in range(1, places[k, 8]):
                counts[k, j, i] += counts[k, j, i - 1]

    if ghosts:
        _fill_rim(v, width, height, label, enters)

    sums = np.zeros((n_contacts * n, N_SUMS), np.float64)
    _add_cells(v, width, height, label, enters, places, t, xs, ys, sums, ghosts)
    supports = np.full((n_contacts, 2 * N_DIRECTIONS, n), missing)
    if ghosts:
        _add_faces(v, width, height, label, enters, places, t, xs, ys, sums)
    else:
        border_cells(v, width, height, label, enters, places, t, xs, ys, sums, supports, COS, SIN)
    side_widths(v, width, height, label, enters, places, t, xs, ys, supports)

    for k in range(n_contacts):
        _finish(measures[k], sums[k * n : (k + 1) * n], counts[k], supports[k], t[k], places[k], xs, ys)
    lowest_area = np.zeros(n_contacts)
    for k in range(n_contacts):
        if places[k, 8] > 0:
            lowest_area[k] = measures[k, n + places[k, 8] - 1]
        i = k
        while i > 0 and (
            lowest_area[order[i - 1]] < lowest_area[k]
            or (lowest_area[order[i - 1]] == lowest_area[k] and places[order[i - 1], 6] < places[k, 6])
        ):
            order[i] = order[i - 1]
            i -= 1
        order[i] = k
    return label, places, values, order, measures, counts


@njit(cache=True, nogil=True)
def _finish(out, sums, counts, support, t, place, xs, ys):  # type: ignore[no-untyped-def]
    """Write a contact's measures from its sums and supports."""
    n = t.size
    x, y = xs[place[1]], ys[place[0]]
    out[:n] = t
    area, perimeter = out[n : 2 * n], out[2 * n : 3 * n]
    centroid, covariance = out[3 * n : 5 * n].reshape(n, 2), out[5 * n : 9 * n].reshape(n, 4)
    width = out[WIDTHS * n :].reshape(n, N_DIRECTIONS)
    for i in range(n):
        if i >= place[8]:
            area[i], perimeter[i] = np.nan, np.nan
            centroid[i], covariance[i], width[i] = np.nan, np.nan, np.nan
            continue
        s = sums[i]
        if counts[0, i] == 0 or not s[0] > 0.0:
            area[i], perimeter[i] = 0.0, 0.0
            centroid[i], covariance[i], width[i] = np.nan, np.nan, 0.0
            continue
        area[i], perimeter[i] = s[0], s[6]
        mx, my = s[1] / s[0], s[2] / s[0]
        centroid[i, 0], centroid[i, 1] = x + mx, y + my
        covariance[i, 0] = s[3] / s[0] - mx * mx
        covariance[i, 1] = s[4] / s[0] - mx * my
        covariance[i, 2] = covariance[i, 1]
        covariance[i, 3] = s[5] / s[0] - my * my
        for j in range(N_DIRECTIONS):
            width[i, j] = support[j, i] + support[j + N_DIRECTIONS, i]


@njit(cache=True, nogil=True)
def _fill_rim(v, width, height, label, enters):  # type: ignore[no-untyped-def]
    """Give the rim its neighbours' values, labels and thresholds: V is constant over the outer half taxels."""
    for r in range(1, height - 1):
        p, q = r * width, (r + 1) * width - 1
        v[p], label[p], enters[p] = v[p + 1], label[p + 1], enters[p + 1]
        v[q], label[q], enters[q] = v[q - 1], label[q - 1], enters[q - 1]
    last = (height - 1) * width
    for c in range(width):
        v[c], label[c], enters[c] = v[width + c], label[width + c], enters[width + c]
        p, q = last + c, last - width + c
        v[p], label[p], enters[p] = v[q], label[q], enters[q]


@njit(cache=True, nogil=True)
def _add_cells(v, width, height, label, enters, places, t, xs, ys, sums, ghosts):  # type: ignore[no-untyped-def]
    """Add every whole cell's segments to the sums of the contacts at its corners."""
    n = t.shape[1]
    missing = -np.inf
    first_row, last_row, first_col, last_col = height, 0, width, 0
    for k in range(places.shape[0]):
        first_row, last_row = min(first_row, places[k, 2]), max(last_row, places[k, 3])
        first_col, last_col = min(first_col, places[k, 4]), max(last_col, places[k, 5])
    for r in range(first_row - 1, last_row + 1):
        for c in range(first_col - 1, last_col + 1):
            p = r * width + c
            p1, p2, p3 = p + 1, p + width + 1, p + width
            e0, e1, e2, e3 = enters[p], enters[p1], enters[p2], enters[p3]
            lowest = min(min(e0, e1), min(e2, e3))
            if lowest == n:
                continue
            highest = max(max(e0, e1), max(e2, e3))
            k0, k1, k2, k3 = label[p], label[p1], label[p2], label[p3]
            if lowest == highest and k0 == k1 and k0 == k2 and k0 == k3:
                continue
            v0, v1, v2, v3 = v[p], v[p1], v[p2], v[p3]
            if not ghosts and min(min(v0, v1), min(v2, v3)) == missing:
                continue
            for corner in range(4):
                if corner == 0:
                    k = k0
                elif corner == 1:
                    k = k1
                    if k == k0:
                        continue
                elif corner == 2:
                    k = k2
                    if k in (k0, k1):
                        continue
                else:
                    k = k3
                    if k in (k0, k1, k2):
                        continue
                if k < 0:
                    continue
                end = np.int32(places[k, 8])
                l0 = min(e0, end) if k0 == k else end
                l1 = min(e1, end) if k1 == k else end
                l2 = min(e2, end) if k2 == k else end
                l3 = min(e3, end) if k3 == k else end
                first = min(min(l0, l1), min(l2, l3))
                last = max(max(l0, l1), max(l2, l3))
                if first == last:
                    continue
                x, y = xs[places[k, 1]], ys[places[k, 0]]
                _add_cell(
                    sums,
                    k * n,
                    t[k],
                    xs[c] - x,
                    ys[r] - y,
                    xs[c + 1] - x,
                    ys[r + 1] - y,
                    v0,
                    v1,
                    v2,
                    v3,
                    l0,
                    l1,
                    l2,
                    l3,
                    first,
                    last,
                )


@njit(cache=True, nogil=True, inline="always")
def _add_face(sums, i, x, y0, y1, sign):  # type: ignore[no-untyped-def]
    """Add a stretch of a vertical border, the same line integrals as for a segment but no perimeter."""
    d1, d2, d3 = sign * (y1 - y0), sign * (y1 * y1 - y0 * y0), sign * (y1 * y1 * y1 - y0 * y0 * y0)
    sums[i, 0] += x * d1
    sums[i, 1] += 0.5 * x * x * d1
    sums[i, 2] += 0.5 * x * d2
    sums[i, 3] += x * x * x * d1 / 3.0
    sums[i, 4] += 0.25 * x * x * d2
    sums[i, 5] += x * d3 / 3.0


@njit(cache=True, nogil=True)
def _add_faces(v, width, height, label, enters, places, t, xs, ys, sums):  # type: ignore[no-untyped-def]
    """Close the sections along the left and the right border of the pad."""
    n = t.shape[1]
    for k in range(places.shape[0]):
        end = places[k, 8]
        x0, y0 = xs[places[k, 1]], ys[places[k, 0]]
        for side in range(2):
            if not places[k, 7] & (1 << side):
                continue
            c = side * (width - 1)
            x = xs[c] - x0
            sign = 2.0 * side - 1.0
            full = np.zeros((n + 1, N_SUMS))
            for r in range(places[k, 2] - 1, places[k, 3] + 1):
                p, q = r * width + c, (r + 1) * width + c
                lp = min(enters[p], end) if label[p] == k else end
                lq = min(enters[q], end) if label[q] == k else end
                a, b = ys[r] - y0, ys[r + 1] - y0
                _add_face(full, max(lp, lq), x, a, b, sign)
                for i in range(lp, lq):
                    _add_face(sums, k * n + i, x, a, a + (b - a) * (v[p] - t[k, i]) / (v[p] - v[q]), sign)
                for i in range(lq, lp):
                    _add_face(sums, k * n + i, x, b + (a - b) * (v[q] - t[k, i]) / (v[q] - v[p]), b, sign)
            for i in range(end):
                for j in range(6):
                    full[i + 1, j] += full[i, j]
                    sums[k * n + i, j] += full[i, j]
