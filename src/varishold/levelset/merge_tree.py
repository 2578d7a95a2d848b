"""Which taxels hang together at which threshold: the merge tree of superlevel sets, and contacts cut from it.

As the threshold falls, the section {V > theta} changes its topology only at critical points: a maximum
opens a part, a saddle joins two parts or closes a ring around a hole, a minimum fills a hole. A taxel is
critical or not by its eight neighbours alone (how many pieces of its neighbourhood stand above it), so only
those few are sorted and joined, in falling order, by union-find.

Two taxels hang together along a row or a column, and along a diagonal where marching squares joins the two
corners of a saddle cell: where the mean of the cell's four values is above the threshold. Equal values are
ordered by their index, so a plateau is a maximum once.

Arrays here are flat views of a frame padded by one taxel on every side; -inf is where there is no taxel.
"""

from __future__ import annotations

import numpy as np
from numba import njit

__all__ = ["SPLIT_RATIO", "cell_sum", "merge_tree", "root_of"]

# Two peaks are two contacts only if the saddle between them lies below this share of the lower peak: the
# ring of a punch, a plane or a ridge with noise on it stays one contact, two fingertips become two.
SPLIT_RATIO = 0.5

_WHOLE, _FINISHED, _DROPPED, _SPLIT = 0, 1, 2, 3


@njit(cache=True, nogil=True, inline="always")
def cell_sum(v, p, width):  # type: ignore[no-untyped-def]
    """Return four times the mean of the cell whose first corner is p; always summed in one order."""
    return (v[p] + v[p + 1]) + (v[p + width] + v[p + width + 1])


@njit(cache=True, nogil=True)
def root_of(parent, p):  # type: ignore[no-untyped-def]
    """Return the root of p, halving the path on the way."""
    while parent[p] != p:
        parent[p] = parent[parent[p]]
        p = parent[p]
    return p


@njit(cache=True, nogil=True)
def _sort_falling(value, order, n):  # type: ignore[no-untyped-def]
    """Sort order[:n] so that value[order] falls; stable (bottom-up merge sort over short sorted runs)."""
    run = 16
    for start in range(0, n, run):
        stop = min(start + run, n)
        for i in range(start + 1, stop):
            item = order[i]
            key = value[item]
            j = i
            while j > start and value[order[j - 1]] < key:
                order[j] = order[j - 1]
                j -= 1
            order[j] = item
    if n <= run:
        return
    other = np.empty(n, np.int64)
    while run < n:
        for start in range(0, n, 2 * run):
            middle, stop = min(start + run, n), min(start + 2 * run, n)
            i, j = start, middle
            for k in range(start, stop):
                if i < middle and (j >= stop or value[order[i]] >= value[order[j]]):
                    other[k] = order[i]
                    i += 1
                else:
                    other[k] = order[j]
                    j += 1
        order[:n] = other[:n]
        run *= 2


@njit(cache=True, nogil=True)
def _classify(v, width, height, floor, parent, event_at, event_kind, joint_a, joint_c, joint_value):  # type: ignore[no-untyped-def]
    """Find the critical taxels above the floor and point every other one at a higher neighbour.

    Returns the number of critical taxels (`event_at`; `event_kind` = pieces of the upper neighbourhood, -1
    for a minimum) and of joints (saddle cells whose diagonal joins at the cell's mean).
    """
    missing = -np.inf
    n_events, n_joints = 0, 0
    for r in range(1, height - 1):
        for p in range(r * width + 1, (r + 1) * width - 1):
            u = v[p]
            if not u > floor:
                continue
            vl, vu, vr, vd = v[p - 1], v[p - width], v[p + 1], v[p + width]
            left, up, right, down = vl >= u, vu >= u, vr > u, vd > u
            pieces = 0
            above = p
            if down:
                pieces += 1
                above = p + width
            if right:
                pieces += 1
                above = p + 1
            if up:
                pieces += 1
                above = parent[p - width]
            if left:
                pieces += 1
                above = parent[p - 1]
            around = 0
            for side in range(4):
                if side == 0:
                    one, two, v1, v2, opposite = left, up, vl, vu, p - width - 1
                    corner, higher = opposite, v[opposite] >= u
                elif side == 1:
                    one, two, v1, v2, opposite = up, right, vu, vr, p - width + 1
                    corner, higher = p - width, v[opposite] >= u
                elif side == 2:
                    one, two, v1, v2, opposite = right, down, vr, vd, p + width + 1
                    corner, higher = p, v[opposite] > u
                else:
                    one, two, v1, v2, opposite = down, left, vd, vl, p + width - 1
                    corner, higher = p - 1, v[opposite] > u
                if one and two:
                    if higher or v[opposite] == missing or cell_sum(v, corner, width) > 4.0 * u:
                        around += 1
                elif higher and not one and not two:
                    total = cell_sum(v, corner, width)
                    if total > 4.0 * u or (v1 == missing) != (v2 == missing):
                        pieces += 1
                        if above == p:
                            above = opposite
                    elif total > 4.0 * max(v1, v2) and total > 4.0 * floor:
                        joint_a[n_joints] = p
                        joint_c[n_joints] = opposite
                        joint_value[n_joints] = 0.25 * total
                        n_joints += 1
            parent[p] = above
            pieces -= around
            if pieces != 1:
                event_at[n_events] = p
                event_kind[n_events] = -1 if around == 4 else pieces
                n_events += 1
    return n_events, n_joints


@njit(cache=True, nogil=True)
def _join(x, y, saddle, v, parent, owner, state, ends):  # type: ignore[no-untyped-def]
    """Join the parts of two peaks at a saddle and return the peak that stays."""
    if v[y] > v[x] or (v[y] == v[x] and y < x):
        x, y = y, x
    parent[y] = x
    if state[x] == _WHOLE and state[y] == _WHOLE:
        if saddle < SPLIT_RATIO * v[y]:
            ends[x] = saddle
            ends[y] = saddle
            state[x], state[y] = _SPLIT, _FINISHED
        else:
            owner[y] = x
    elif state[x] == _WHOLE or state[y] == _WHOLE:
        whole = x if state[x] == _WHOLE else y
        if saddle < SPLIT_RATIO * v[whole]:
            ends[whole] = saddle
        else:
            owner[whole] = -1
        state[whole] = _FINISHED
        state[x] = _SPLIT
    return x


@njit(cache=True, nogil=True)
def merge_tree(v, width, height, floor, label):  # type: ignore[no-untyped-def]
    """Find the contacts of a padded frame and the topological events within each.

    Parameters
    ----------
    v : ndarray of shape (height * width,), float64
        The padded frame, -inf where there is no taxel (the whole rim among them).
    width, height : int
        Of the padded frame.
    floor : float
        Contacts are parts of {V > floor}.
    label : ndarray of shape (height * width,), int32
        Overwritten with each taxel's contact, -1 for none.

    Returns
    -------
    peak_at : ndarray of shape (n_contacts,), int64
        Index of each contact's highest taxel.
    ends : ndarray of shape (n_contacts,), float64
        Where each contact ends: the floor, or its saddle if it was split.
    event_at, event_value, event_parts, event_holes : ndarray of shape (n_events,)
        At thresholds below `event_value` the contact around the taxel `event_at` has so many parts and
        holes more.
    """
    n = 0
    for p in range(v.size):
        label[p] = -1
        n += v[p] > floor
    # A taxel has at most two diagonals that join at a cell's mean.
    parent = np.empty(v.size, np.int64)
    event_at = np.empty(n, np.int64)
    event_kind = np.empty(n, np.int64)
    joint_a = np.empty(2 * n, np.int64)
    joint_c = np.empty(2 * n, np.int64)
    joint_value = np.empty(2 * n, np.float64)
    n_events, n_joints = _classify(v, width, height, floor, parent, event_at, event_kind, joint_a, joint_c, joint_value)

    ascent = parent.copy()

    total = n_events + n_joints
    at = np.empty(total, np.int64)
    value = np.empty(total, np.float64)
    parts = np.zeros(total, np.int64)
    holes = np.zeros(total, np.int64)
    order = np.empty(total, np.int64)
    owner = np.empty(v.size, np.int64)
    state = np.empty(v.size, np.int8)
    ends_at = np.empty(v.size, np.float64)
    n_saddles = 0
    for e in range(n_events):
        p = event_at[e]
        at[e], value[e] = p, v[p]
        if event_kind[e] == 0:
            parts[e] = 1
            owner[p], state[p], ends_at[p] = p, _WHOLE, floor
        elif event_kind[e] < 0:
            holes[e] = -1
        else:
            order[n_saddles] = e
            n_saddles += 1
    for j in range(n_joints):
        e = n_events + j
        at[e], value[e] = joint_a[j], joint_value[j]
        order[n_saddles] = e
        n_saddles += 1
    _sort_falling(value, order, n_saddles)

    missing = -np.inf
    for s in range(n_saddles):
        e = order[s]
        p, u = at[e], value[e]
        top = root_of(parent, p)
        joined = 0
        if e >= n_events:
            links = 1
            other = root_of(parent, joint_c[e - n_events])
            if other != top:
                _join(top, other, u, v, parent, owner, state, ends_at)
                joined = 1
        else:
            links = event_kind[e] - 1
            for side in range(8):
                if side == 0:
                    q, higher = p - width, v[p - width] >= u
                elif side == 1:
                    q, higher = p - 1, v[p - 1] >= u
                elif side == 2:
                    q, higher = p + 1, v[p + 1] > u
                elif side == 3:
                    q, higher = p + width, v[p + width] > u
                elif side == 4:
                    q, higher = p - width - 1, v[p - width - 1] >= u
                    one, two, corner = p - 1, p - width, q
                elif side == 5:
                    q, higher = p - width + 1, v[p - width + 1] >= u
                    one, two, corner = p - width, p + 1, p - width
                elif side == 6:
                    q, higher = p + width - 1, v[p + width - 1] > u
                    one, two, corner = p - 1, p + width, p - 1
                else:
                    q, higher = p + width + 1, v[p + width + 1] > u
                    one, two, corner = p + 1, p + width, p
                if not higher:
                    continue
                if side >= 4:
                    v1, v2 = v[one], v[two]
                    if v1 > u or v2 > u or (v1 == u and one < p) or (v2 == u and two < p):
                        continue
                    if not (cell_sum(v, corner, width) > 4.0 * u or (v1 == missing) != (v2 == missing)):
                        continue
                other = root_of(parent, q)
                if other != top:
                    top = _join(top, other, u, v, parent, owner, state, ends_at)
                    joined += 1
        parts[e] = -joined
        holes[e] = links - joined

    # Peaks that a contact is named after, in the order of their index.
    n_contacts = 0
    split = False
    for e in range(n_events):
        p = at[e]
        if event_kind[e] == 0:
            split = split or state[p] != _WHOLE or owner[p] < 0
            if owner[p] == p:
                label[p] = n_contacts
                n_contacts += 1
    peak_at = np.empty(n_contacts, np.int64)
    ends = np.empty(n_contacts, np.float64)
    for e in range(n_events):
        p = at[e]
        if event_kind[e] == 0 and owner[p] == p:
            peak_at[label[p]] = p
            ends[label[p]] = ends_at[p]
    for p in range(width, v.size - width):
        if not v[p] > floor:
            continue
        if split:
            peak = root_of(ascent, p)
            while owner[peak] >= 0 and owner[peak] != peak:
                peak = owner[peak]
            k = label[peak] if owner[peak] >= 0 else -1
            if k >= 0 and not v[p] > ends[k]:
                k = -1
        else:
            k = label[root_of(parent, p)]
        label[p] = k
    return peak_at, ends, at, value, parts, holes
