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
from numpy.typing import NDArray

from varishold.files.compiling import njit
from varishold.levelset.sorting import sort_falling

__all__ = ["SPLIT_RATIO", "merge_tree"]

# Two peaks are two contacts only if the saddle between them lies below this share of the lower peak: the
# ring of a punch, a plane or a ridge with noise on it stays one contact, two fingertips become two.
SPLIT_RATIO = 0.5

_WHOLE, _FINISHED, _SPLIT = 0, 1, 2
_MINIMUM = -1


def _neighbourhoods() -> tuple[NDArray[np.int8], NDArray[np.int64], NDArray[np.int8], NDArray[np.int8]]:
    """Return what each pattern of higher neighbours says, as far as it can without their values.

    A pattern's bits are left, up, right, down, then the diagonals after each of them. Returned are the number
    of pieces above, which saddle cells' means must still be asked (bits 0 to 3: cells whose sides are above and
    whose diagonal is not; 4 to 7: whose diagonal alone is above), the number of cells wholly above, and a higher
    neighbour to climb to (1 to 4 in the same order, the two with a lower index first; 0 for none).
    """
    pieces, around, climb = (np.zeros(256, np.int8) for _ in range(3))
    ask = np.zeros(256, np.int64)
    for pattern in range(256):
        side = [bool(pattern >> j & 1) for j in range(4)]
        diagonal = [bool(pattern >> (4 + j) & 1) for j in range(4)]
        both = [side[j] and side[(j + 1) % 4] for j in range(4)]
        above = [both[j] and diagonal[j] for j in range(4)]
        alone = [diagonal[j] and not side[j] and not side[(j + 1) % 4] for j in range(4)]
        pieces[pattern] = _MINIMUM if all(above) else sum(side) - sum(above)
        ask[pattern] = sum((both[j] and not above[j]) << j | alone[j] << (4 + j) for j in range(4))
        around[pattern] = sum(above)
        climb[pattern] = next((j + 1 for j in range(4) if side[j]), 0)
    return pieces, ask, around, climb


_PIECES, _ASK, _AROUND, _CLIMB = _neighbourhoods()


@njit(cache=True, nogil=True, error_model="numpy")
def _root_of(parent, p):  # type: ignore[no-untyped-def]
    """Return the root of p, halving the path on the way."""
    while parent[p] != p:
        parent[p] = parent[parent[p]]
        p = parent[p]
    return p


@njit(cache=True, nogil=True, error_model="numpy")
def _cell(p, width, j):  # type: ignore[no-untyped-def]
    """Return the two sides, the diagonal and the first corner of the j-th cell around p, clockwise from left."""
    if j == 0:
        return p - 1, p - width, p - width - 1, p - width - 1
    if j == 1:
        return p - width, p + 1, p - width + 1, p - width
    if j == 2:
        return p + 1, p + width, p + width + 1, p
    return p + width, p - 1, p + width - 1, p - 1


@njit(cache=True, nogil=True, error_model="numpy")
def _cell_sum(v, corner, width):  # type: ignore[no-untyped-def]
    """Return four times the mean of a cell, always summed in one order."""
    return (v[corner] + v[corner + 1]) + (v[corner + width] + v[corner + width + 1])


@njit(cache=True, nogil=True, error_model="numpy")
def _higher(v, q, p):  # type: ignore[no-untyped-def]
    return v[q] > v[p] or (v[q] == v[p] and q < p)


@njit(cache=True, nogil=True, error_model="numpy")
def _joins_diagonally(v, p, one, two, corner, width):  # type: ignore[no-untyped-def]
    """Tell whether p hangs together with the higher diagonal of a cell whose other two corners are lower."""
    if _cell_sum(v, corner, width) > 4.0 * v[p]:
        return True
    # Across the corner that a cell lacks runs a triangle's side.
    return (v[one] == -np.inf) != (v[two] == -np.inf)


@njit(cache=True, nogil=True, error_model="numpy")
def _patterns(upper, here, lower, patterns):  # type: ignore[no-untyped-def]
    """Write which neighbours of here[1:-1] are higher; of equal values the one before is."""
    for c in range(1, here.size - 1):
        u = here[c]
        patterns[c - 1] = (
            int(here[c - 1] >= u)
            | int(upper[c] >= u) << 1
            | int(here[c + 1] > u) << 2
            | int(lower[c] > u) << 3
            | int(upper[c - 1] >= u) << 4
            | int(upper[c + 1] >= u) << 5
            | int(lower[c + 1] > u) << 6
            | int(lower[c - 1] > u) << 7
        )


@njit(cache=True, nogil=True, error_model="numpy")
def _classify(v, width, height, floor, parent, event_at, event_kind, joint_at, joint_to, joint_value):  # type: ignore[no-untyped-def]
    """Find the critical taxels above the floor and point every other one at a higher neighbour.

    Returns the numbers of critical taxels (`event_at`; `event_kind` is the number of pieces above, or
    _MINIMUM) and of joints (saddle cells whose diagonal joins at the cell's mean).
    """
    n_events, n_joints = 0, 0
    step = (0, -1, -width, 1, width)
    patterns = np.empty(width, np.int64)
    for r in range(1, height - 1):
        first, stop = r * width + 1, (r + 1) * width - 1
        while first < stop and not v[first] > floor:
            first += 1
        while first < stop and not v[stop - 1] > floor:
            stop -= 1
        if first == stop:
            continue
        # By itself, so that it runs over many taxels an instruction.
        _patterns(v[first - width - 1 : stop - width + 1], v[first - 1 : stop + 1], v[first + width - 1 :], patterns)
        for p in range(first, stop):
            u = v[p]
            if not u > floor:
                continue
            pattern = patterns[p - first]
            pieces = _PIECES[pattern]
            above = p + step[_CLIMB[pattern]]
            ask = _ASK[pattern]
            if ask:
                around = _AROUND[pattern]
                for j in range(4):
                    if not ask >> j & 17:
                        continue
                    one, two, diagonal, corner = _cell(p, width, j)
                    if ask >> j & 1:
                        if v[diagonal] == -np.inf or _cell_sum(v, corner, width) > 4.0 * u:
                            around += 1
                            pieces -= 1
                    elif _joins_diagonally(v, p, one, two, corner, width):
                        pieces += 1
                        if above == p:
                            above = diagonal
                    else:
                        total = _cell_sum(v, corner, width)
                        if total > 4.0 * max(v[one], v[two]) and total > 4.0 * floor:
                            joint_at[n_joints] = p
                            joint_to[n_joints] = diagonal
                            joint_value[n_joints] = 0.25 * total
                            n_joints += 1
                if around == 4:
                    pieces = _MINIMUM
            parent[p] = parent[above] if above < p else above
            if pieces != 1:
                event_at[n_events] = p
                event_kind[n_events] = pieces
                n_events += 1
    return n_events, n_joints


@njit(cache=True, nogil=True, error_model="numpy")
def _join(x, y, saddle, peak, noise, group, owner, state, ends):  # type: ignore[no-untyped-def]
    """Join the parts of two peaks at a saddle and return the peak that stays."""
    if peak[y] > peak[x] or (peak[y] == peak[x] and y < x):
        x, y = y, x
    group[y] = x
    if state[x] == _WHOLE and state[y] == _WHOLE:
        if saddle < SPLIT_RATIO * peak[y] and peak[y] - saddle > noise:
            ends[x] = saddle
            ends[y] = saddle
            state[x], state[y] = _SPLIT, _FINISHED
        else:
            owner[y] = x
    elif state[x] == _WHOLE or state[y] == _WHOLE:
        whole = x if state[x] == _WHOLE else y
        if saddle < SPLIT_RATIO * peak[whole] and peak[whole] - saddle > noise:
            ends[whole] = saddle
        else:
            # A bump on the skirt of contacts that have ended above it belongs to none of them.
            owner[whole] = -1
        state[whole] = _FINISHED
        state[x] = _SPLIT
    return x


@njit(cache=True, nogil=True, error_model="numpy")
def merge_tree(v, width, height, floor, noise, label):  # type: ignore[no-untyped-def]
    """Find the contacts of a padded frame and the topological events within each.

    Parameters
    ----------
    v : ndarray of shape (height * width,), float64
        The padded frame, -inf where there is no taxel (the whole rim among them).
    width, height : int
        Of the padded frame.
    floor : float
        Contacts are parts of {V > floor}.
    noise : float
        A peak that stands no higher than this over its saddle is no contact of its own.
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
    # The taxel that a taxel climbs to; a taxel has at most two diagonals that join at a cell's mean.
    parent = np.empty(v.size, np.int32)
    critical_at = np.empty(n, np.int64)
    kind = np.empty(n, np.int64)
    joint_at = np.empty(2 * n, np.int64)
    joint_to = np.empty(2 * n, np.int64)
    joint_value = np.empty(2 * n, np.float64)
    n_critical, n_joints = _classify(
        v, width, height, floor, parent, critical_at, kind, joint_at, joint_to, joint_value
    )

    n_events = n_critical + n_joints
    at = np.empty(n_events, np.int64)
    value = np.empty(n_events, np.float64)
    parts = np.zeros(n_events, np.int64)
    holes = np.zeros(n_events, np.int64)
    n_peaks, n_saddles = 0, n_joints
    for e in range(n_critical):
        at[e], value[e] = critical_at[e], v[critical_at[e]]
        n_peaks += kind[e] == 0
        n_saddles += kind[e] > 0
    for j in range(n_joints):
        at[n_critical + j], value[n_critical + j] = joint_at[j], joint_value[j]
    number = np.empty(v.size, np.int32)
    peak = np.empty(n_peaks, np.float64)
    summit = np.empty(n_peaks, np.int64)
    # Peaks that hang together; the peak whose contact a peak belongs to, -1 for none.
    group = np.arange(n_peaks)
    owner = np.arange(n_peaks)
    state = np.zeros(n_peaks, np.int64)
    ends_at = np.full(n_peaks, floor)
    order = np.empty(n_saddles, np.int64)
    n_peaks, n_saddles = 0, 0
    for e in range(n_events):
        if e < n_critical and kind[e] == 0:
            parts[e] = 1
            number[at[e]] = n_peaks
            peak[n_peaks], summit[n_peaks] = value[e], at[e]
            n_peaks += 1
        elif e < n_critical and kind[e] == _MINIMUM:
            holes[e] = -1
        else:
            order[n_saddles] = e
            n_saddles += 1
    sort_falling(value, order)

    around = np.empty(8, np.int64)
    for s in range(n_saddles):
        e = order[s]
        p = at[e]
        near = 0
        if e >= n_critical:
            links = 1
            around[0], around[1] = p, joint_to[e - n_critical]
            near = 2
        else:
            links = kind[e] - 1
            for j in range(4):
                one, two, diagonal, corner = _cell(p, width, j)
                if _higher(v, one, p):
                    around[near] = one
                    near += 1
                elif (
                    _higher(v, diagonal, p)
                    and not _higher(v, two, p)
                    and _joins_diagonally(v, p, one, two, corner, width)
                ):
                    around[near] = diagonal
                    near += 1
        top = -1
        for j in range(near):
            other = _root_of(group, number[_root_of(parent, around[j])])
            if top < 0:
                top = other
            elif other != top:
                top = _join(top, other, value[e], peak, noise, group, owner, state, ends_at)
                parts[e] -= 1
        holes[e] = links + parts[e]

    # Contacts are numbered in the order of their peaks' indices.
    contact = np.empty(n_peaks, np.int32)
    n_contacts = 0
    for i in range(n_peaks):
        if owner[i] == i:
            contact[i] = n_contacts
            n_contacts += 1
    peak_at = np.empty(n_contacts, np.int64)
    ends = np.empty(n_contacts, np.float64)
    for i in range(n_peaks):
        j = i
        while j >= 0 and owner[j] != j:
            j = owner[j]
        if j < 0:
            contact[i] = -1
        elif j == i:
            peak_at[contact[i]], ends[contact[i]] = summit[i], ends_at[i]
        else:
            contact[i] = contact[j]
    for r in range(1, height - 1):
        for p in range(r * width + 1, (r + 1) * width - 1):
            if v[p] > floor:
                k = contact[number[_root_of(parent, p)]]
                if k >= 0 and v[p] > ends[k]:
                    label[p] = k
    return peak_at, ends, at, value, parts, holes
