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
from varishold.levelset.columns import (
    BORDERS,
    BOTTOM,
    END,
    HOLES,
    LEFT,
    N_COLUMNS,
    N_MEASURED,
    N_PLACES,
    N_TAXELS,
    PARTS,
    PEAK,
    PEAK_COL,
    PEAK_ROW,
    RIGHT,
    TOP,
    measure_columns,
)
from varishold.levelset.green import N_SUMS, S_AREA, S_LENGTH, S_X, S_XX, S_XY, S_Y, S_YY, add_line
from varishold.levelset.merge_tree import merge_tree
from varishold.levelset.sorting import sort_falling
from varishold.levelset.widths import GROUP, N_DIRECTIONS, add_supports

__all__ = ["add_faces", "finish", "sections"]

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
    places = np.zeros((n_contacts, N_PLACES), np.int64)
    for k in range(n_contacts):
        places[k, PEAK_ROW], places[k, PEAK_COL] = peak_at[k] // width, peak_at[k] % width
        places[k, TOP], places[k, LEFT] = height, width
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
            places[k, TOP] = min(places[k, TOP], r)
            places[k, BOTTOM] = r
            places[k, LEFT] = min(places[k, LEFT], p - r * width)
            places[k, RIGHT] = max(places[k, RIGHT], q - 1 - r * width)
            places[k, N_TAXELS] += q - p
            places[k, BORDERS] |= int(v[p - 1] == -np.inf) | int(v[q] == -np.inf) << 1 | int(up) << 2 | int(down) << 3
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
def finish(measures, end, sums, counts, support, x, y):  # type: ignore[no-untyped-def]
    """Write a contact's measures, but for the thresholds, from its sums and supports around (x, y)."""
    _, area, perimeter, centroid, covariance, extent = measure_columns(measures)
    for i in range(area.size):
        if i < end and counts[PARTS, i] > 0 and sums[i, S_AREA] > 0.0:
            over = 1.0 / sums[i, S_AREA]
            mx, my = sums[i, S_X] * over, sums[i, S_Y] * over
            area[i], perimeter[i] = sums[i, S_AREA], sums[i, S_LENGTH]
            centroid[i, 0], centroid[i, 1] = x + mx, y + my
            covariance[i, 0] = sums[i, S_XX] * over - mx * mx
            covariance[i, 1] = covariance[i, 2] = sums[i, S_XY] * over - mx * my
            covariance[i, 3] = sums[i, S_YY] * over - my * my
            for j in range(N_DIRECTIONS):
                extent[i, j] = support[j, i] + support[j + N_DIRECTIONS, i]
        else:
            # Nothing where the section is empty, unknown below the contact's end.
            area[i] = perimeter[i] = 0.0 if i < end else np.nan
            centroid[i], covariance[i], extent[i] = np.nan, np.nan, area[i]


@njit(cache=True, nogil=True, error_model="numpy")
def _begin(v, width, height, floor, noise, thresholds, n_even):  # type: ignore[no-untyped-def]
    """Find the contacts and set up their thresholds, parts and holes."""
    label = np.empty(v.size, np.int32)
    peak_at, ends, event_at, event_value, event_parts, event_holes = merge_tree(v, width, height, floor, noise, label)
    n_contacts = peak_at.size
    n = n_even if n_even > 0 else thresholds.size
    places = _places(v, width, height, label, peak_at)
    values = np.empty((n_contacts, 2), np.float64)
    measures = np.empty((n_contacts, N_COLUMNS * n), np.float64)
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
        values[k, PEAK], values[k, END] = v[peak_at[k]], ends[k]
        end = n
        measures[k, :n] = levels[min(k, own - 1), :n]
        if n_even == 0:
            while end > 0 and thresholds[end - 1] < ends[k]:
                end -= 1
        places[k, N_MEASURED] = end
    for e in range(event_at.size):
        k = label[event_at[e]]
        if k >= 0 and event_value[e] > ends[k] and places[k, N_MEASURED] > 0:
            j = min(k, own - 1)
            i = _first_below(levels[j], begin[j], scale[j], most[j], event_value[e])
            if i < places[k, N_MEASURED]:
                counts[k, PARTS, i] += event_parts[e]
                counts[k, HOLES, i] += event_holes[e]
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
        counts[PARTS, i] += counts[PARTS, i - 1]
        counts[HOLES, i] += counts[HOLES, i - 1]


@njit(cache=True, nogil=True, error_model="numpy")
def _by_falling_area(places, measures):  # type: ignore[no-untyped-def]
    """Return the contacts' order by falling area of their lowest section, then by falling number of taxels."""
    n_contacts = places.shape[0]
    area = np.zeros(n_contacts)
    for k in range(n_contacts):
        if places[k, N_MEASURED] > 0:
            area[k] = measure_columns(measures[k])[1][places[k, N_MEASURED] - 1]
    order = np.arange(n_contacts)
    # Stable, so that the last sort goes first.
    sort_falling(places[:, N_TAXELS], order)
    sort_falling(area, order)
    return order


@njit(cache=True, nogil=True, error_model="numpy")
def sections(v, width, height, floor, noise, thresholds, n_even, xs, ys, gaps):  # type: ignore[no-untyped-def]
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
    noise : float
        A peak that stands no higher than this over its saddle is no contact of its own.
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
    values : ndarray of shape (n_contacts, 2), float64
        As `varishold.levelset.columns` names them.
    order : ndarray of shape (n_contacts,), int64
        The contacts by falling area of their lowest section, then by falling number of taxels.
    measures : ndarray of shape (n_contacts, 25 * n), float64
        As `varishold.levelset.columns` names them; all but the thresholds are NaN below the contact's end.
    counts : ndarray of shape (n_contacts, 2, n), int64
        Parts and holes.
    """
    label, places, values, measures, counts, levels, begin, scale, most = _begin(
        v, width, height, floor, noise, thresholds, n_even
    )
    covered = np.empty((0, 2))
    if gaps:
        covered = gap_events(v, width, height, label)
    else:
        _fill_rim(v, width, height, label)
    wx, wy = np.empty(width), np.empty(height)
    for k in range(places.shape[0]):
        end = places[k, N_MEASURED]
        sums = np.zeros((max(end, 1), N_SUMS), np.float64)
        support = np.full((2 * N_DIRECTIONS, end + GROUP), -np.inf)
        x, y = xs[places[k, PEAK_COL]], ys[places[k, PEAK_ROW]]
        if end > 0:
            top, bottom = places[k, TOP] - 1, places[k, BOTTOM] + 1
            left, right = places[k, LEFT] - 1, places[k, RIGHT] + 1
            t = measures[k, :end]
            own = min(k, levels.shape[0] - 1)
            for g in range(covered.shape[0]):
                if covered[g, 0] == k and covered[g, 1] > t[end - 1]:
                    i = _first_below(levels[own], begin[own], scale[own], most[own], covered[g, 1])
                    counts[k, HOLES, i] -= 1
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
                    if places[k, BORDERS] >> bit & 1:
                        add_faces(window, enters, wx, wy, t, sums, bit * (window.shape[1] - 1))
            add_supports(window, enters, wx, wy, t, support)
        finish(measures[k], end, sums, counts[k], support, x, y)
    return label, places, values, _by_falling_area(places, measures), measures, counts
