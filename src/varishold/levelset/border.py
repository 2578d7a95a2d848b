"""Cells at the border of a field that is no rectangle: those that lack one to three corners.

The region R is the union of the taxels' rectangles. Between the centres of neighbouring taxels V is
interpolated; from a centre outward to the border of R it is constant across the border. So a cell with two
neighbouring corners is half a cell, one with a single corner a quarter, one with three corners a triangle
between the centres and two small triangles out to the border, all of them cut by straight lines.
"""

from __future__ import annotations

import numpy as np

from varishold.files.compiling import njit
from varishold.levelset.green import N_SUMS, add_line, add_outline
from varishold.levelset.widths import COS, SIN

__all__ = ["add_border_cells", "gap_events"]

# Columns of a piece's corners: position, value, whether it belongs to the contact, and whether the side that
# starts there lies on the border.
_X, _Y, _V, _OURS, _BORDER = 0, 1, 2, 3, 4


@njit(cache=True, nogil=True, error_model="numpy")
def _reach(support, i, x, y):  # type: ignore[no-untyped-def]
    for d in range(support.shape[0]):
        support[d, i] = max(support[d, i], x * COS[d] + y * SIN[d])


@njit(cache=True, nogil=True, error_model="numpy")
def _cut(piece, m, first, t, sums, whole, support):  # type: ignore[no-untyped-def]
    """Add a convex piece of m corners to the sums from threshold `first` on.

    `whole` takes what stays the same from the threshold on at which all its corners are in.
    """
    end = t.size
    covered = end
    lowest, ours = np.inf, True
    for j in range(m):
        lowest = min(lowest, piece[j, _V])
        ours = ours and piece[j, _OURS] > 0
    if ours:
        covered = first
        while covered < end and not lowest > t[covered]:
            covered += 1
    for i in range(first, min(covered + 1, end)):
        into = whole if i == covered else sums
        level = t[i]
        crossed = 0
        leave_x, leave_y, enter_x, enter_y = 0.0, 0.0, 0.0, 0.0
        for a in range(m):
            b = a + 1 if a + 1 < m else 0
            xa, ya, va, xb, yb, vb = (
                piece[a, _X], piece[a, _Y], piece[a, _V], piece[b, _X], piece[b, _Y], piece[b, _V],
            )  # fmt: skip
            a_in = piece[a, _OURS] > 0 and va > level
            b_in = piece[b, _OURS] > 0 and vb > level
            if a_in:
                _reach(support, i, xa, ya)
            if a_in != b_in:
                f = (va - level) / (va - vb)
                x, y = xa + f * (xb - xa), ya + f * (yb - ya)
                _reach(support, i, x, y)
                crossed += 1
                if a_in:
                    leave_x, leave_y = x, y
                    xb, yb = x, y
                else:
                    enter_x, enter_y = x, y
                    xa, ya = x, y
            if (a_in or b_in) and piece[a, _BORDER] > 0:
                add_line(into, i, xa, ya, xb, yb)
        if crossed == 2:
            add_outline(sums, i, leave_x, leave_y, enter_x, enter_y)


@njit(cache=True, nogil=True, error_model="numpy")
def _set(pieces, piece, corner, x, y, v, ours, border):  # type: ignore[no-untyped-def]
    pieces[piece, corner, _X], pieces[piece, corner, _Y], pieces[piece, corner, _V] = x, y, v
    pieces[piece, corner, _OURS], pieces[piece, corner, _BORDER] = ours, border


@njit(cache=True, nogil=True, error_model="numpy")
def _pieces(pieces, sizes, corner, middle, hx, hy):  # type: ignore[no-untyped-def]
    """Divide a cell that lacks corners into convex pieces and return how many.

    `corner[j]` is (x, y, value, belongs to the contact) and `middle[j]` (x, y) half way on the side after it;
    (hx, hy) is the cell's centre. Corners run from x to y.
    """
    present, last, lacking = 0, 0, 0
    for j in range(4):
        if corner[j, _V] == -np.inf:
            lacking = j
        else:
            present += 1
            last = j
    if present == 3:
        b, a, g = (lacking + 1) & 3, (lacking + 2) & 3, (lacking + 3) & 3
        xb, yb, vb, ours_b = corner[b, _X], corner[b, _Y], corner[b, _V], corner[b, _OURS]
        xg, yg, vg, ours_g = corner[g, _X], corner[g, _Y], corner[g, _V], corner[g, _OURS]
        # Where the centre is in, the higher of its two neighbours is.
        centre, ours = 0.5 * (vb + vg), ours_b if vb >= vg else ours_g
        _set(pieces, 0, 0, xb, yb, vb, ours_b, 0.0)
        _set(pieces, 0, 1, corner[a, _X], corner[a, _Y], corner[a, _V], corner[a, _OURS], 0.0)
        _set(pieces, 0, 2, xg, yg, vg, ours_g, 0.0)
        _set(pieces, 1, 0, xg, yg, vg, ours_g, 0.0)
        _set(pieces, 1, 1, middle[g, _X], middle[g, _Y], vg, ours_g, 1.0)
        _set(pieces, 1, 2, hx, hy, centre, ours, 0.0)
        _set(pieces, 2, 0, xb, yb, vb, ours_b, 0.0)
        _set(pieces, 2, 1, hx, hy, centre, ours, 1.0)
        _set(pieces, 2, 2, middle[lacking, _X], middle[lacking, _Y], vb, ours_b, 0.0)
        sizes[0], sizes[1], sizes[2] = 3, 3, 3
        return 3
    if present == 2 and corner[(last + 2) & 3, _V] == -np.inf:
        a = last if corner[(last + 1) & 3, _V] > -np.inf else (last + 3) & 3
        b, c = (a + 1) & 3, (a + 3) & 3
        _set(pieces, 0, 0, corner[a, _X], corner[a, _Y], corner[a, _V], corner[a, _OURS], 0.0)
        _set(pieces, 0, 1, corner[b, _X], corner[b, _Y], corner[b, _V], corner[b, _OURS], 0.0)
        _set(pieces, 0, 2, middle[b, _X], middle[b, _Y], corner[b, _V], corner[b, _OURS], 1.0)
        _set(pieces, 0, 3, middle[c, _X], middle[c, _Y], corner[a, _V], corner[a, _OURS], 0.0)
        sizes[0] = 4
        return 1
    n = 0
    for a in range(4):
        c = (a + 3) & 3
        v, ours = corner[a, _V], corner[a, _OURS]
        if v > -np.inf:
            _set(pieces, n, 0, corner[a, _X], corner[a, _Y], v, ours, 0.0)
            _set(pieces, n, 1, middle[a, _X], middle[a, _Y], v, ours, 1.0)
            _set(pieces, n, 2, hx, hy, v, ours, 1.0)
            _set(pieces, n, 3, middle[c, _X], middle[c, _Y], v, ours, 0.0)
            sizes[n] = 4
            n += 1
    return n


@njit(cache=True, nogil=True, error_model="numpy")
def add_border_cells(v, enters, xs, ys, width, height, left, top, t, sums, support):  # type: ignore[no-untyped-def]
    """Add the cells that lack corners to a contact's sums and supports.

    Parameters
    ----------
    v, enters, xs, ys, t, sums
        As in `cells.add_cells`.
    width, height, left, top : int
        Size of the padded frame, and where in it the window starts.
    support : ndarray of shape (32, n), float64
        As in `widths.add_supports`.
    """
    end = t.size
    pieces, sizes = np.empty((3, 4, 5)), np.empty(3, np.int64)
    corner, middle = np.empty((4, 4)), np.empty((4, 2))
    whole = np.zeros((end + 1, N_SUMS))
    for r in range(v.shape[0] - 1):
        y0, y1 = ys[r], ys[r + 1]
        # The rim stands half a taxel outside already.
        hy = y0 if top + r == 0 else (y1 if top + r + 2 == height else 0.5 * (y0 + y1))
        for c in range(v.shape[1] - 1):
            first = min(min(enters[r, c], enters[r, c + 1]), min(enters[r + 1, c], enters[r + 1, c + 1]))
            lowest = min(min(v[r, c], v[r, c + 1]), min(v[r + 1, c], v[r + 1, c + 1]))
            if first == end or lowest > -np.inf:
                continue
            x0, x1 = xs[c], xs[c + 1]
            hx = x0 if left + c == 0 else (x1 if left + c + 2 == width else 0.5 * (x0 + x1))
            for j in range(4):
                row, col = r + (j >= 2), c + (j == 1 or j == 2)
                corner[j, _X], corner[j, _Y] = xs[col], ys[row]
                corner[j, _V], corner[j, _OURS] = v[row, col], 1.0 if enters[row, col] < end else 0.0
            middle[0, _X], middle[0, _Y], middle[1, _X], middle[1, _Y] = hx, y0, x1, hy
            middle[2, _X], middle[2, _Y], middle[3, _X], middle[3, _Y] = hx, y1, x0, hy
            for piece in range(_pieces(pieces, sizes, corner, middle, hx, hy)):
                _cut(pieces[piece], sizes[piece], first, t, sums, whole, support)
    for i in range(end):
        for j in range(N_SUMS):
            whole[i + 1, j] += whole[i, j]
            sums[i, j] += whole[i, j]
        if i > 0:
            # Sections nest, and so do their supports.
            for d in range(support.shape[0]):
                support[d, i] = max(support[d, i], support[d, i - 1])


@njit(cache=True, nogil=True, error_model="numpy")
def gap_events(v, width, height, label):  # type: ignore[no-untyped-def]
    """Find where a hole is nothing but a gap of the field: where all taxels around the gap are in.

    Returns
    -------
    ndarray of shape (n, 2), float64
        Contact, and the value below which it surrounds a gap and covers all taxels around it.
    """
    seen = np.zeros(v.size, np.bool_)
    stack = np.empty(v.size, np.int64)
    found = np.empty((v.size, 2), np.float64)
    n = 0
    for source in range(v.size):
        if seen[source] or v[source] > -np.inf:
            continue
        stack[0], depth = source, 1
        seen[source] = True
        contact, lowest, one = -1, np.inf, True
        while depth > 0:
            depth -= 1
            row, col = stack[depth] // width, stack[depth] % width
            for dr in range(-1, 2):
                for dc in range(-1, 2):
                    r, c = row + dr, col + dc
                    if r < 0 or c < 0 or r >= height or c >= width:
                        continue
                    q = r * width + c
                    if v[q] == -np.inf:
                        if not seen[q]:
                            seen[q] = True
                            stack[depth] = q
                            depth += 1
                    elif dr == 0 or dc == 0:
                        if lowest == np.inf:
                            contact = label[q]
                        one = one and label[q] == contact
                        lowest = min(lowest, v[q])
        # The first gap is the outside: it holds the rim.
        if source > 0 and one and contact >= 0:
            found[n, 0], found[n, 1] = contact, lowest
            n += 1
    return found[:n]
