"""The one pass: every contact's sections at all thresholds at once.

Green's theorem turns areas and moments into sums over outline segments. A cell between four taxel centres is
crossed only at the thresholds between its lowest and its highest corner, so the work is one visit to each
cell plus one short sum for each crossed segment; a cell that is covered wholly costs nothing at any
threshold, because the shared borders of neighbouring cells cancel.
"""

from __future__ import annotations

import numpy as np

from varishold.files.compiling import njit
from varishold.levelset.border import add_border_cells, gap_events
from varishold.levelset.cells import add_cells
from varishold.levelset.green import N_SUMS, add_line
from varishold.levelset.merge_tree import merge_tree
from varishold.levelset.widths import GROUP, N_DIRECTIONS, add_supports

__all__ = ["WIDTHS", "add_faces", "finish", "sections"]

# So many numbers a threshold stand before the widths in `measures`.
WIDTHS = 9
# Where a bin holds more thresholds than this, they are searched one by one.
_FEW = 4


@njit(cache=True, nogil=True, error_model="numpy")
def _bin(top, value, scale, last):  # type: ignore[no-untyped-def]
    b = (top - value) * scale
    # Not a number (nothing times infinity) is the first bin.
    b = b if b > 0.0 else 0.0
    return int(b if b < last else last)


@njit(cache=True, nogil=True, error_model="numpy")
def _lay_out(t, begin):  # type: ignore[no-untyped-def]
    """Sort falling thresholds (the last is -inf, and none) into even bins.

    `begin[b]` is overwritten with how many stand in the bins before b; as a bin's number only grows as the value
    falls, only those in the value's own bin must be compared with it. Returns bins per unit and the most in a bin.
    """
    n, last = t.size - 1, begin.size - 2
    span = t[0] - t[n - 1]
    scale = last / span if span > 0 else 0.0
    begin[:] = 0
    most = 0
    for i in range(n):
        begin[_bin(t[0], t[i], scale, last) + 1] += 1
    for b in range(1, begin.size):
        most = max(most, begin[b])
        begin[b] += begin[b - 1]
    return scale, most


@njit(cache=True, nogil=True, error_model="numpy")
def _first_below(t, begin, scale, most, value):  # type: ignore[no-untyped-def]
    """Return the index of the first of the thresholds, laid out in bins, below the value: where it comes in."""
    i = begin[_bin(t[0], value, scale, begin.size - 2)]
    if most > _FEW:
        while t[i] >= value:
            i += 1
        return i
    for _ in range(most):
        i += t[i] >= value
    return i


@njit(cache=True, nogil=True, error_model="numpy")
def _places(v, width, height, label, peak_at):  # type: ignore[no-untyped-def]
    """Return each contact's peak, bounding box, number of taxels and touched borders."""
    n_contacts = peak_at.size
    places = np.zeros((n_contacts, 9), np.int64)
    for k in range(n_contacts):
        places[k, 0], places[k, 1] = peak_at[k] // width, peak_at[k] % width
        places[k, 2], places[k, 4] = height, width
    for r in range(1, height - 1):
        p, stop = r * width + 1, (r + 1) * width - 1
        while p < stop:
            k = label[p]
            if k < 0:
                p += 1
                continue
            q = p
            up, down = False, False
            while q < stop and label[q] == k:
                up |= v[q - width] == -np.inf
                down |= v[q + width] == -np.inf
                q += 1
            places[k, 2] = min(places[k, 2], r)
            places[k, 3] = r
            places[k, 4] = min(places[k, 4], p - r * width)
            places[k, 5] = max(places[k, 5], q - 1 - r * width)
            places[k, 6] += q - p
            places[k, 7] |= int(v[p - 1] == -np.inf) | int(v[q] == -np.inf) << 1 | int(up) << 2 | int(down) << 3
            p = q
    return places


@njit(cache=True, nogil=True, error_model="numpy")
def _fill_rim(v, width, height, label):  # type: ignore[no-untyped-def]
    """Give the rim its neighbours' values and contacts: V is constant over the outer half taxels."""
    for r in range(1, height - 1):
        p, q = r * width, (r + 1) * width - 1
        v[p], label[p] = v[p + 1], label[p + 1]
        v[q], label[q] = v[q - 1], label[q - 1]
    last = (height - 1) * width
    for c in range(width):
        v[c], label[c] = v[width + c], label[width + c]
        v[last + c], label[last + c] = v[last - width + c], label[last - width + c]


@njit(cache=True, nogil=True, error_model="numpy")
def add_faces(v, enters, xs, ys, t, sums, c):  # type: ignore[no-untyped-def]
    """Close the sections along the window's column c, the left or right border of the pad."""
    height = v.shape[0]
    end = t.size
    whole = np.zeros((end + 1, N_SUMS))
    x = xs[c]
    for r in range(height - 1):
        # Upward on the left, downward on the right: the section is on the left hand.
        a, b = (r + 1, r) if c == 0 else (r, r + 1)
        ea, eb, va, vb = enters[a, c], enters[b, c], v[a, c], v[b, c]
        add_line(whole, max(ea, eb), x, ys[a], x, ys[b])
        for i in range(min(ea, eb), max(ea, eb)):
            cut = ys[a] + (ys[b] - ys[a]) * ((va - t[i]) / (va - vb))
            if ea < eb:
                add_line(sums, i, x, ys[a], x, cut)
            else:
                add_line(sums, i, x, cut, x, ys[b])
    for i in range(end):
        for j in range(N_SUMS):
            whole[i + 1, j] += whole[i, j]
            sums[i, j] += whole[i, j]


@njit(cache=True, nogil=True, error_model="numpy")
def finish(out, n, end, sums, counts, support, x, y):  # type: ignore[no-untyped-def]
    """Write a contact's measures, but for the thresholds, from its sums and supports."""
    for i in range(n):
        area, centroid, covariance = n + i, 3 * n + 2 * i, 5 * n + 4 * i
        width = WIDTHS * n + N_DIRECTIONS * i
        if i >= end:
            out[area] = out[2 * n + i] = np.nan
        else:
            out[area] = out[2 * n + i] = 0.0
        if i < end and counts[0, i] > 0 and sums[i, 0] > 0.0:
            over = 1.0 / sums[i, 0]
            mx, my = sums[i, 1] * over, sums[i, 2] * over
            out[area], out[2 * n + i] = sums[i, 0], sums[i, 6]
            out[centroid], out[centroid + 1] = x + mx, y + my
            out[covariance] = sums[i, 3] * over - mx * mx
            out[covariance + 1] = out[covariance + 2] = sums[i, 4] * over - mx * my
            out[covariance + 3] = sums[i, 5] * over - my * my
            for j in range(N_DIRECTIONS):
                out[width + j] = support[j, i] + support[j + N_DIRECTIONS, i]
        else:
            out[centroid] = out[centroid + 1] = np.nan
            for j in range(4):
                out[covariance + j] = np.nan
            for j in range(N_DIRECTIONS):
                out[width + j] = out[area]


@njit(cache=True, nogil=True, error_model="numpy")
def _begin(v, width, height, floor, thresholds, n_even):  # type: ignore[no-untyped-def]
    """Find the contacts and set up their thresholds, parts and holes."""
    label = np.empty(v.size, np.int32)
    peak_at, ends, event_at, event_value, event_parts, event_holes = merge_tree(v, width, height, floor, label)
    n_contacts = peak_at.size
    n = n_even if n_even > 0 else thresholds.size
    places = _places(v, width, height, label, peak_at)
    values = np.empty((n_contacts, 2), np.float64)
    measures = np.empty((n_contacts, (WIDTHS + N_DIRECTIONS) * n), np.float64)
    counts = np.zeros((n_contacts, 2, n), np.int64)
    # Contacts share their thresholds, or each has its own.
    own = n_contacts if n_even > 0 else 1
    levels = np.empty((own, n + 1), np.float64)
    begin = np.empty((own, 2 * n + 2), np.int32)
    scale, most = np.empty(own, np.float64), np.empty(own, np.int64)
    levels[:, n] = -np.inf
    for k in range(own):
        if n_even > 0:
            step = (v[peak_at[k]] - ends[k]) / n
            for i in range(n):
                levels[k, i] = v[peak_at[k]] - (i + 0.5) * step
        else:
            levels[k, :n] = thresholds
        scale[k], most[k] = _lay_out(levels[k], begin[k])
    for k in range(n_contacts):
        values[k, 0], values[k, 1] = v[peak_at[k]], ends[k]
        end = n
        measures[k, :n] = levels[min(k, own - 1), :n]
        if n_even == 0:
            while end > 0 and thresholds[end - 1] < ends[k]:
                end -= 1
        places[k, 8] = end
    for e in range(event_at.size):
        k = label[event_at[e]]
        if k >= 0 and event_value[e] > ends[k] and places[k, 8] > 0:
            j = min(k, own - 1)
            i = _first_below(levels[j], begin[j], scale[j], most[j], event_value[e])
            if i < places[k, 8]:
                counts[k, 0, i] += event_parts[e]
                counts[k, 1, i] += event_holes[e]
    return label, places, values, measures, counts, levels, begin, scale, most


@njit(cache=True, nogil=True, error_model="numpy")
def _window(v, label, width, k, top, bottom, left, right, levels, begin, scale, most, end):  # type: ignore[no-untyped-def]
    """Return a contact's window of values and of the thresholds at which its taxels come in."""
    values = np.empty((bottom - top + 1, right - left + 1), np.float64)
    enters = np.empty((bottom - top + 1, right - left + 1), np.int32)
    for r in range(values.shape[0]):
        at = (top + r) * width + left
        for c in range(values.shape[1]):
            value = v[at + c]
            values[r, c] = value
            i = end
            if label[at + c] == k:
                i = min(i, _first_below(levels, begin, scale, most, value))
            enters[r, c] = i
    return values, enters


@njit(cache=True, nogil=True, error_model="numpy")
def _running_counts(counts, end):  # type: ignore[no-untyped-def]
    for i in range(1, end):
        counts[0, i] += counts[0, i - 1]
        counts[1, i] += counts[1, i - 1]


@njit(cache=True, nogil=True, error_model="numpy")
def _by_falling_area(places, measures, n):  # type: ignore[no-untyped-def]
    n_contacts = places.shape[0]
    area = np.zeros(n_contacts)
    order = np.empty(n_contacts, np.int64)
    for k in range(n_contacts):
        if places[k, 8] > 0:
            area[k] = measures[k, n + places[k, 8] - 1]
        i = k
        while i > 0:
            j = order[i - 1]
            if area[j] > area[k] or (area[j] == area[k] and places[j, 6] >= places[k, 6]):
                break
            order[i] = j
            i -= 1
        order[i] = k
    return order


@njit(cache=True, nogil=True, error_model="numpy")
def sections(v, width, height, floor, thresholds, n_even, xs, ys, gaps):  # type: ignore[no-untyped-def]
    """Find the contacts of a padded frame and measure all their sections.

    Without gaps the rim takes its neighbours' values: its cells, half a taxel wide, are cells like the
    others. With gaps nothing is overwritten.

    Parameters
    ----------
    v : ndarray of shape (height * width,), float64
        The padded frame, -inf on the rim and where there is no taxel.
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
    gaps : bool
        Whether some taxels within the rim do not exist.

    Returns
    -------
    label : ndarray of shape (height * width,), int32
        Each taxel's contact or -1.
    places : ndarray of shape (n_contacts, 9), int64
        Peak's row and column, first and last row, first and last column, number of taxels, touched borders
        (bits: left, right, top, bottom), number of thresholds not below the contact's end.
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
    label, places, values, measures, counts, levels, begin, scale, most = _begin(
        v, width, height, floor, thresholds, n_even
    )
    n = counts.shape[2]
    covered = np.empty((0, 2))
    if gaps:
        covered = gap_events(v, width, height, label)
    else:
        _fill_rim(v, width, height, label)
    wx, wy = np.empty(width), np.empty(height)
    for k in range(places.shape[0]):
        end = places[k, 8]
        sums = np.zeros((max(end, 1), N_SUMS), np.float64)
        support = np.full((2 * N_DIRECTIONS, end + GROUP), -np.inf)
        x, y = xs[places[k, 1]], ys[places[k, 0]]
        if end > 0:
            top, bottom, left, right = places[k, 2] - 1, places[k, 3] + 1, places[k, 4] - 1, places[k, 5] + 1
            t = measures[k, :end]
            own = min(k, levels.shape[0] - 1)
            for g in range(covered.shape[0]):
                if covered[g, 0] == k and covered[g, 1] > t[end - 1]:
                    i = _first_below(levels[own], begin[own], scale[own], most[own], covered[g, 1])
                    counts[k, 1, i] -= 1
            _running_counts(counts[k], end)
            window, enters = _window(
                v, label, width, k, top, bottom, left, right, levels[own], begin[own], scale[own], most[own], end
            )
            for c in range(window.shape[1]):
                wx[c] = xs[left + c] - x
            for r in range(window.shape[0]):
                wy[r] = ys[top + r] - y
            add_cells(window, enters, wx, wy, t, sums)
            if gaps:
                add_border_cells(window, enters, wx, wy, width, height, left, top, t, sums, support)
            else:
                for bit in range(2):
                    if places[k, 7] >> bit & 1:
                        add_faces(window, enters, wx, wy, t, sums, bit * (window.shape[1] - 1))
            add_supports(window, enters, wx, wy, t, support)
        finish(measures[k], n, end, sums, counts[k], support, x, y)
    return label, places, values, _by_falling_area(places, measures, n), measures, counts
