"""Cells at the border of a field that is no rectangle: those that lack one to three corners.

The region R is the union of the taxels' rectangles. Between the centres of neighbouring taxels V is
interpolated; from a centre outward to the border of R it is constant across the border. So a cell with two
neighbouring corners is half a cell, one with a single corner a quarter, one with three corners a triangle
between the centres and two small triangles out to the border, all of them cut by straight lines.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from varishold.levelset.green import N_SUMS, add_line, add_outline

__all__ = ["border_cells", "gap_events"]


@njit(cache=True, nogil=True)
def _cut(px, py, pv, pk, pb, m, k, first, end, t, sums, base, full, support, cos, sin, x, y):  # type: ignore[no-untyped-def]
    """Add a convex piece of m corners to the sums of contact k.

    Corner j is at (px, py), has the value pv and the contact pk; pb tells whether the side that starts there
    lies on the border. `full` takes what stays the same from the threshold on at which all corners are in.
    """
    whole = end
    lowest = pv[0]
    belongs = True
    for j in range(m):
        lowest = min(lowest, pv[j])
        belongs = belongs and pk[j] == k
    if belongs:
        whole = first
        while whole < end and not lowest > t[whole]:
            whole += 1
    for i in range(first, whole):
        level = t[i]
        crossed = 0
        lx, ly, ex, ey = 0.0, 0.0, 0.0, 0.0
        for j in range(m):
            a = j
            b = j + 1 if j + 1 < m else 0
            a_in = pk[a] == k and pv[a] > level
            b_in = pk[b] == k and pv[b] > level
            if a_in:
                _reach(support, i, px[a] + x, py[a] + y, cos, sin)
            if a_in and b_in:
                if pb[a]:
                    add_line(sums, base + i, px[a], py[a], px[b], py[b])
            elif a_in != b_in:
                f = (pv[a] - level) / (pv[a] - pv[b])
                qx, qy = px[a] + f * (px[b] - px[a]), py[a] + f * (py[b] - py[a])
                _reach(support, i, qx + x, qy + y, cos, sin)
                crossed += 1
                if a_in:
                    lx, ly = qx, qy
                    if pb[a]:
                        add_line(sums, base + i, px[a], py[a], qx, qy)
                else:
                    ex, ey = qx, qy
                    if pb[a]:
                        add_line(sums, base + i, qx, qy, px[b], py[b])
        if crossed == 2:
            add_outline(sums, base + i, lx, ly, ex, ey)
    if whole < end:
        for j in range(m):
            b = j + 1 if j + 1 < m else 0
            _reach(support, whole, px[j] + x, py[j] + y, cos, sin)
            if pb[j]:
                add_line(full, whole, px[j], py[j], px[b], py[b])


@njit(cache=True, nogil=True)
def _reach(support, i, x, y, cos, sin):  # type: ignore[no-untyped-def]
    for d in range(cos.size):
        s = x * cos[d] + y * sin[d]
        if s > support[d, i]:
            support[d, i] = s


@njit(cache=True, nogil=True)
def border_cells(v, width, height, label, enters, places, t, xs, ys, sums, support, cos, sin):  # type: ignore[no-untyped-def]
    """Add the cells that lack corners to the sums and supports of their contacts.

    Parameters are those of `widths.side_widths`, with `sums` of shape (n_contacts * n, N_SUMS) and the 32
    directions' `cos` and `sin`.
    """
    n = t.shape[1]
    missing = -np.inf
    px, py, pv = np.empty(4), np.empty(4), np.empty(4)
    pk = np.empty(4, np.int32)
    pb = np.empty(4, np.bool_)
    at = np.empty(4, np.int64)
    cx, cy = np.empty(4), np.empty(4)
    # Middles of the four sides.
    mx, my = np.empty(4), np.empty(4)
    full = np.zeros((places.shape[0], n + 1, N_SUMS))
    touched = False
    for r in range(height - 1):
        # Beyond the rim's half taxel there is nothing to halve.
        middle_y = ys[0] if r == 0 else (ys[r + 1] if r == height - 2 else 0.5 * (ys[r] + ys[r + 1]))
        for c in range(width - 1):
            p = r * width + c
            at[0], at[1], at[2], at[3] = p, p + 1, p + width + 1, p + width
            present, last_present, last_missing = 0, 0, 0
            labelled = False
            for j in range(4):
                if v[at[j]] == missing:
                    last_missing = j
                else:
                    present += 1
                    last_present = j
                    labelled = labelled or label[at[j]] >= 0
            if present == 4 or not labelled:
                continue
            touched = True
            middle_x = xs[0] if c == 0 else (xs[c + 1] if c == width - 2 else 0.5 * (xs[c] + xs[c + 1]))
            for corner in range(4):
                k = label[at[corner]]
                if k < 0:
                    continue
                seen = False
                for j in range(corner):
                    seen = seen or label[at[j]] == k
                if seen:
                    continue
                x, y = xs[places[k, 1]], ys[places[k, 0]]
                end = places[k, 8]
                cx[0] = cx[3] = xs[c] - x
                cx[1] = cx[2] = xs[c + 1] - x
                cy[0] = cy[1] = ys[r] - y
                cy[2] = cy[3] = ys[r + 1] - y
                hx, hy = middle_x - x, middle_y - y
                mx[0] = mx[2] = hx
                my[1] = my[3] = hy
                my[0], mx[1], my[2], mx[3] = cy[0], cx[1], cy[2], cx[3]
                if present == 1 or (present == 2 and v[at[(last_present + 2) % 4]] != missing):
                    for j in range(4):
                        if v[at[j]] == missing or label[at[j]] != k:
                            continue
                        before = (j + 3) % 4
                        px[0], py[0], px[1], py[1] = cx[j], cy[j], mx[j], my[j]
                        px[2], py[2], px[3], py[3] = hx, hy, mx[before], my[before]
                        pv[:] = v[at[j]]
                        pk[:] = k
                        pb[0], pb[1], pb[2], pb[3] = False, True, True, False
                        first = min(enters[at[j]], end)
                        _cut(
                            px, py, pv, pk, pb, 4, k, first, end, t[k], sums, k * n, full[k], support[k], cos, sin, x, y
                        )
                elif present == 2:
                    a = last_present
                    if v[at[(a + 1) % 4]] == missing:
                        a = (a + 3) % 4
                    b = (a + 1) % 4
                    after, before = b, (a + 3) % 4
                    px[0], py[0], px[1], py[1] = cx[a], cy[a], cx[b], cy[b]
                    px[2], py[2], px[3], py[3] = mx[after], my[after], mx[before], my[before]
                    pv[0] = pv[3] = v[at[a]]
                    pv[1] = pv[2] = v[at[b]]
                    pk[0] = pk[3] = label[at[a]]
                    pk[1] = pk[2] = label[at[b]]
                    pb[0], pb[1], pb[2], pb[3] = False, False, True, False
                    first = end
                    if label[at[a]] == k:
                        first = min(first, enters[at[a]])
                    if label[at[b]] == k:
                        first = min(first, enters[at[b]])
                    _cut(px, py, pv, pk, pb, 4, k, first, end, t[k], sums, k * n, full[k], support[k], cos, sin, x, y)
                else:
                    d = last_missing
                    b, a, g = (d + 1) % 4, (d + 2) % 4, (d + 3) % 4
                    first = end
                    for j in range(1, 4):
                        q = at[(d + j) % 4]
                        if label[q] == k:
                            first = min(first, enters[q])
                    centre = 0.5 * (v[at[b]] + v[at[g]])
                    # Where the centre is in, the higher of its two neighbours is.
                    centre_k = label[at[b]] if v[at[b]] >= v[at[g]] else label[at[g]]
                    px[0], py[0], pv[0], pk[0] = cx[b], cy[b], v[at[b]], label[at[b]]
                    px[1], py[1], pv[1], pk[1] = cx[a], cy[a], v[at[a]], label[at[a]]
                    px[2], py[2], pv[2], pk[2] = cx[g], cy[g], v[at[g]], label[at[g]]
                    pb[:] = False
                    _cut(px, py, pv, pk, pb, 3, k, first, end, t[k], sums, k * n, full[k], support[k], cos, sin, x, y)
                    px[0], py[0], pv[0], pk[0] = cx[g], cy[g], v[at[g]], label[at[g]]
                    px[1], py[1], pv[1], pk[1] = mx[g], my[g], v[at[g]], label[at[g]]
                    px[2], py[2], pv[2], pk[2] = hx, hy, centre, centre_k
                    pb[0], pb[1], pb[2] = False, True, False
                    _cut(px, py, pv, pk, pb, 3, k, first, end, t[k], sums, k * n, full[k], support[k], cos, sin, x, y)
                    px[0], py[0], pv[0], pk[0] = cx[b], cy[b], v[at[b]], label[at[b]]
                    px[1], py[1], pv[1], pk[1] = hx, hy, centre, centre_k
                    px[2], py[2], pv[2], pk[2] = mx[d], my[d], v[at[b]], label[at[b]]
                    pb[0], pb[1], pb[2] = False, True, False
                    _cut(px, py, pv, pk, pb, 3, k, first, end, t[k], sums, k * n, full[k], support[k], cos, sin, x, y)
    if not touched:
        return
    for k in range(places.shape[0]):
        for i in range(places[k, 8]):
            for j in range(N_SUMS):
                full[k, i + 1, j] += full[k, i, j]
                sums[k * n + i, j] += full[k, i, j]
        # Sections nest, and so do their supports.
        for d in range(cos.size):
            for i in range(1, places[k, 8]):
                support[k, d, i] = max(support[k, d, i], support[k, d, i - 1])


@njit(cache=True, nogil=True)
def gap_events(v, width, height, label, enters, places, counts):  # type: ignore[no-untyped-def]
    """Take back a hole where it is nothing but a gap of the field: where all taxels around the gap are in."""
    missing = -np.inf
    seen = np.zeros(v.size, np.bool_)
    stack = np.empty(v.size, np.int64)
    for source in range(v.size):
        # The first missing taxel is the rim's, and its gap is the outside.
        if seen[source] or v[source] != missing:
            continue
        stack[0], depth = source, 1
        seen[source] = True
        contact, latest, one = -2, 0, True
        while depth > 0:
            depth -= 1
            p = stack[depth]
            row, col = p // width, p % width
            for dr in range(-1, 2):
                for dc in range(-1, 2):
                    r, c = row + dr, col + dc
                    if r < 0 or c < 0 or r >= height or c >= width:
                        continue
                    q = r * width + c
                    if v[q] == missing:
                        if not seen[q]:
                            seen[q] = True
                            stack[depth] = q
                            depth += 1
                    elif dr == 0 or dc == 0:
                        if contact == -2:
                            contact = label[q]
                        one = one and label[q] == contact
                        latest = max(latest, enters[q])
        if source > 0 and one and contact >= 0 and latest < places[contact, 8]:
            counts[contact, 1, latest] -= 1
