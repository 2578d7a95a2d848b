"""The state of the sensor under a contact: what its taxels tell of themselves rather than of the form.

Saturated and equal readings, roughness inside the contact and outside it, ghosts along rows and columns, how the
contact stands beside the frame's highest one, the sides at which the pad ends it, how steep its border is at three
heights, how a face leans. Names rest on the signature; these numbers say how far it can be trusted. None has a unit.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from varishold.files.compiling import njit
from varishold.levelset.columns import BOTTOM, LEFT, RIGHT, TOP

__all__ = ["STATE_GROUPS", "STATE_NAMES", "state_into"]

_STATE = (
    ("saturation", "top_share"),
    ("saturation", "near_top_share"),
    ("saturation", "exact_top_share"),
    ("saturation", "spike"),
    ("resolution", "equal_share"),
    ("resolution", "lowest_share"),
    ("roughness", "roughness"),
    ("roughness", "roughness_tail"),
    ("roughness", "mixed_roughness"),
    ("roughness", "free_roughness"),
    ("roughness", "free_level"),
    ("roughness", "ghost"),
    ("roughness", "others"),
    ("prominence", "prominence"),
    ("border", "cut_low"),
    ("border", "cut_half"),
    ("border", "cut_high"),
    ("sharpness", "edge_low"),
    ("sharpness", "edge_half"),
    ("sharpness", "edge_high"),
    ("tilt", "lean"),
    ("tilt", "unevenness"),
    ("tilt", "crown"),
)

#: Name of every number of the state, in order.
STATE_NAMES: tuple[str, ...] = tuple(name for _, name in _STATE)
#: What each number tells of, in the same order.
STATE_GROUPS: tuple[str, ...] = tuple(group for group, _ in _STATE)

# Shares of the way from the floor to the peak at which borders are looked at.
_LOW, _HALF, _HIGH = 0.2, 0.5, 0.8
# Readings this near the peak may be saturated.
_TOP, _NEAR_TOP = 0.98, 0.93
_FEWEST = 4.0


@njit(nogil=True)
def _at(padded, r, c):  # type: ignore[no-untyped-def]
    """Return the taxel at a place, -inf where there is none: the rim of a field without gaps holds its border's."""
    if r < 1 or c < 1 or r > padded.shape[0] - 2 or c > padded.shape[1] - 2:
        return -np.inf
    return padded[r, c]


@njit(nogil=True)
def _add_edge(v, w, levels, total, count):  # type: ignore[no-untyped-def]
    """Add the step between two taxels to each level that lies between them."""
    step, most, least = abs(v - w), max(v, w), min(v, w)
    for k in range(len(levels)):
        if most > levels[k] and least <= levels[k]:
            total[k] += step
            count[k] += 1.0


@njit(nogil=True)
def state_into(
    out: NDArray[np.float64],
    padded: NDArray[np.float64],
    label: NDArray[np.int32],
    index: int,
    place: NDArray[np.int64],
    peak: float,
    floor: float,
) -> None:
    """Fill `out` (length of `STATE_NAMES`) with the state of the sensor under a contact.

    `padded`, `label`, `index` and `place` are the contact's and its frame's, as in
    `varishold.levelset.Frame`; `peak` and `floor` are where its profile begins and ends.
    """
    out[:] = 0.0
    span = peak - floor
    if span <= 0.0:
        span = 1.0
    rows, cols = padded.shape[0] - 2, padded.shape[1] - 2
    top, bottom, left, right = place[TOP], place[BOTTOM] + 1, place[LEFT], place[RIGHT] + 1
    low, half, high = floor + _LOW * span, floor + _HALF * span, floor + _HIGH * span
    near, topmost = floor + _NEAR_TOP * span, floor + _TOP * span
    in_row, in_col = np.zeros(rows + 2, np.bool_), np.zeros(cols + 2, np.bool_)

    n, n_near, n_top, n_exact = 0.0, 0.0, 0.0, 0.0
    pairs, equal = 0.0, 0.0
    cut_low, cut_half, cut_high = 0.0, 0.0, 0.0
    edge_sum, edge_count = np.zeros(3), np.zeros(3)
    rough, rough_2, n_rough, mixed, n_mixed = 0.0, 0.0, 0.0, 0.0, 0.0
    second = -np.inf
    c_n, sx, sy, sv, sxx, sxy, syy, sxv, syv, svv = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    rim_sum, rim_count, core_sum, core_count = 0.0, 0.0, 0.0, 0.0
    middle_y, middle_x = 0.5 * (top + bottom - 1), 0.5 * (left + right - 1)
    levels = (low, half, high)
    for r in range(top, bottom):
        for c in range(left, right):
            if label[r, c] != index:
                continue
            v = padded[r, c]
            n += 1.0
            in_row[r], in_col[c] = True, True
            n_near += v >= near
            n_top += v >= topmost
            n_exact += v == peak
            if v > second and v < peak:
                second = v
            up, down = _at(padded, r - 1, c), _at(padded, r + 1, c)
            before, after = _at(padded, r, c - 1), _at(padded, r, c + 1)
            at_border = (up == -np.inf) or (down == -np.inf) or (before == -np.inf) or (after == -np.inf)
            if at_border:
                cut_low += v > low
                cut_half += v > half
                cut_high += v > high
            # Differences to the next taxel down and right, inside the field.
            for k in range(2):
                w = down if k == 0 else after
                if w == -np.inf:
                    continue
                if label[r + 1 - k, c + k] == index:
                    pairs += 1.0
                    equal += v == w and v < peak
                _add_edge(v, w, levels, edge_sum, edge_count)
            # A neighbour above or before that is outside the contact is met from this side only.
            if up != -np.inf and label[r - 1, c] != index:
                _add_edge(v, up, levels, edge_sum, edge_count)
            if before != -np.inf and label[r, c - 1] != index:
                _add_edge(v, before, levels, edge_sum, edge_count)
            if v <= low or at_border:
                continue
            if up > low and down > low and before > low and after > low:
                residual = abs(v - 0.25 * (up + down + before + after))
                rough += residual
                rough_2 += residual * residual
                n_rough += 1.0
                for dy in (-1, 1):
                    for dx in (-1, 1):
                        across = _at(padded, r + dy, c + dx)
                        if across != -np.inf:
                            mixed += abs(v - (up if dy < 0 else down) - (before if dx < 0 else after) + across)
                            n_mixed += 1.0
            if v > half:
                x, y = c - middle_x, r - middle_y
                if up > half and down > half and before > half and after > half:
                    core_sum += v
                    core_count += 1.0
                    c_n += 1.0
                    sx += x
                    sy += y
                    sv += v
                    sxx += x * x
                    sxy += x * y
                    syy += y * y
                    sxv += x * v
                    syv += y * v
                    svv += v * v
                else:
                    rim_sum += v
                    rim_count += 1.0

    # Taxels outside the contact: their level, their roughness, and whether those in its rows and columns are higher.
    free, free_sum, free_abs, cross, n_cross, n_lowest, others, field = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    lowest, highest, free_pairs = np.inf, -np.inf, 0.0
    for r in range(1, rows + 1):
        for c in range(1, cols + 1):
            if padded[r, c] != -np.inf:
                lowest, highest = min(lowest, padded[r, c]), max(highest, padded[r, c])
    for r in range(1, rows + 1):
        for c in range(1, cols + 1):
            v = padded[r, c]
            if v == -np.inf:
                continue
            field += 1.0
            n_lowest += v == lowest
            if label[r, c] == index:
                continue
            others += v > floor
            v = min(v, floor)
            free += 1.0
            free_sum += v
            for k in range(2):
                other = _at(padded, r + 1 - k, c + k)
                if other != -np.inf and label[r + 1 - k, c + k] != index:
                    free_abs += abs(v - min(other, floor))
                    free_pairs += 1.0
            if in_row[r] != in_col[c]:
                cross += v
                n_cross += 1.0
    beside = free - n_cross
    root = math.sqrt(max(n, 1.0))
    breadth = 2.0 * root / math.sqrt(math.pi)

    out[0] = n_top / max(n, 1.0)
    out[1] = n_near / max(n, 1.0)
    out[2] = math.log(max(n_exact, 1.0))
    out[3] = (peak - second) / span if second > -np.inf else 0.0
    out[4] = equal / max(pairs, 1.0)
    out[5] = n_lowest / max(field, 1.0)
    scale = rough / max(n_rough, 1.0) / span
    out[6] = math.log(scale + 1e-3)
    out[7] = math.sqrt(rough_2 / max(n_rough, 1.0)) / span / (scale + 1e-3)
    out[8] = math.log(0.5 * mixed / max(n_mixed, 1.0) / span + 1e-3)
    out[9] = math.log(free_abs / max(free_pairs, 1.0) / span + 1e-3)
    level = free_sum / max(free, 1.0)
    out[10] = min(max(level / span, -1.0), 1.0)
    away = (free_sum - cross) / max(beside, 1.0)
    out[11] = (cross / n_cross - away) / span if n_cross >= _FEWEST and beside >= _FEWEST else 0.0
    out[12] = math.log1p(others / max(n, 1.0))
    out[13] = peak / highest if highest > 0.0 else 1.0
    out[14] = cut_low / root
    out[15] = cut_half / root
    out[16] = cut_high / root
    for k in range(3):
        out[17 + k] = edge_sum[k] / max(edge_count[k], 1.0) / span
    if c_n >= _FEWEST:
        vxx, vyy, vxy = sxx - sx * sx / c_n, syy - sy * sy / c_n, sxy - sx * sy / c_n
        vxv, vyv, vvv = sxv - sx * sv / c_n, syv - sy * sv / c_n, svv - sv * sv / c_n
        determinant = vxx * vyy - vxy * vxy
        if determinant > 1e-9:
            gx, gy = (vxv * vyy - vyv * vxy) / determinant, (vyv * vxx - vxv * vxy) / determinant
            out[20] = math.hypot(gx, gy) * breadth / span
            out[21] = math.sqrt(max(vvv - gx * vxv - gy * vyv, 0.0) / c_n) / span
    if core_count > 0.0 and rim_count > 0.0:
        out[22] = (core_sum / core_count - rim_sum / rim_count) / span
