"""The signature of a contact in plain Python and numpy, slowly: what the kernel's is compared with."""

from __future__ import annotations

import math
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from varishold.levelset.columns import BOTTOM, BOUNDS, HOLES, LEFT, N_COLUMNS, N_TAXELS, PARTS, RIGHT, TOP
from varishold.levelset.contact import Contact
from varishold.levelset.second_moments import principal_moments
from varishold.levelset.widths import DIRECTIONS, N_DIRECTIONS
from varishold.touch.bands import BANDS, PER_BAND
from varishold.touch.decision import Parameters
from varishold.touch.signature import PER_WEIGHT, SIGNATURE_NAMES, WEIGHTS
from varishold.touch.state import STATE_NAMES

# A taxel so many times its height above the floor counts whole in the base.
_BASE_GAIN = 2.5
_SECOND, _FOURTH, _SIXTH = 0, 1, 2
_COS = np.cos(np.outer([2.0, 4.0, 6.0], DIRECTIONS))
_SIN = np.sin(np.outer([2.0, 4.0, 6.0], DIRECTIONS))
_N = len(PER_BAND)
# Added to axes, so that a section of no breadth has ratios too.
_LEAST_AXIS = 1e-6
_LEAST_AREA = 1e-9
# What lies closer together than this share of the peak is equal.
_SAME = 1e-5
_MOST_HOLES, _MOST_PARTS = 3.0, 4.0
# A sliver's ratio may be anything; what lies beyond a few units says no more.
_MOST = 4.0
# Frames as good as free of noise, and those too small to tell, count as having this share of it.
_LEAST_NOISE = 1.5e-3
# What stands at the centre is a mean over this share of the lowest section's area and half a taxel.
_CENTRE_SHARE, _CENTRE_TAXELS = 0.02, 0.5
_N_BANDS = len(PER_BAND) * BANDS
_N_WEIGHT = len(PER_WEIGHT)
# Shares of the way from the floor to the peak at which borders are looked at.
_LOW, _HALF, _HIGH = 0.200004, 0.500004, 0.800004
# Readings this near the peak may be saturated.
_TOP, _NEAR_TOP = 0.979996, 0.929996
_FEWEST = 4.0
_BESIDE = 0.250004


def measure_columns(measures: NDArray[np.float64]) -> list[NDArray[np.float64]]:
    """Return a contact's measures one by one: shape (n,), or (n, columns) where a measure has several."""
    n = measures.size // N_COLUMNS
    parts = [measures[first * n : stop * n] for first, stop in pairwise(BOUNDS)]
    return [part if part.size == n else part.reshape(n, -1) for part in parts]


def contact_taxels(padded, label, index, place, floor, span):
    """Return the columns, rows and heights of a contact's taxels, the heights from 0 at the floor to 1.

    `padded`, `label` and `place` are its frame's, as in `varishold.levelset.contact.Frame`.
    """
    cols, rows, height = np.empty(place[N_TAXELS]), np.empty(place[N_TAXELS]), np.empty(place[N_TAXELS])
    n = 0
    for r in range(place[TOP], place[BOTTOM] + 1):
        for c in range(place[LEFT], place[RIGHT] + 1):
            if label[r, c] == index:
                cols[n], rows[n] = c, r
                height[n] = max((padded[r, c] - floor) / span, 0.0)
                n += 1
    return cols, rows, height


def weights_of(height):
    """Return the taxels' weights, one row for each of `WEIGHTS`."""
    weights = np.empty((len(WEIGHTS), height.size))
    for i in range(height.size):
        weights[0, i] = height[i]
        weights[1, i] = height[i] * height[i]
        weights[2, i] = min(_BASE_GAIN * height[i], 1.0)
    return weights


def weighted_moments(x, y, weight, area):
    """Return the numbers of one weight, in the order of `PER_WEIGHT`, then the centre (x, y).

    Parameters
    ----------
    x, y : ndarray of shape (n,), float64
        Where the taxels are, in units of which one taxel has the area 1.
    weight : ndarray of shape (n,), float64
    area : float
        Of the lowest section, in taxels.
    """
    total, mx, my = 0.0, 0.0, 0.0
    for i in range(x.size):
        total += weight[i]
        mx += weight[i] * x[i]
        my += weight[i] * y[i]
    total = max(total, 1e-12)
    cx, cy = mx / total, my / total
    r2, r3, r4, r6 = 0.0, 0.0, 0.0, 0.0
    # Sums of z^n with z = x + i y: how much the taxels look the same after an n-th of a turn.
    re2, im2, re3, im3, re4, im4, re6, im6 = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for i in range(x.size):
        w, u, v = weight[i], x[i] - cx, y[i] - cy
        square = u * u + v * v
        zr, zi = u * u - v * v, 2.0 * u * v
        fourth_r, fourth_i = zr * zr - zi * zi, 2.0 * zr * zi
        r2 += w * square
        r3 += w * square * math.sqrt(square)
        r4 += w * square * square
        r6 += w * square * square * square
        re2 += w * zr
        im2 += w * zi
        re3 += w * (zr * u - zi * v)
        im3 += w * (zr * v + zi * u)
        re4 += w * fourth_r
        im4 += w * fourth_i
        re6 += w * (fourth_r * zr - fourth_i * zi)
        im6 += w * (fourth_r * zi + fourth_i * zr)
    r2 = max(r2, 1e-12)
    numbers = (
        2.0 * math.pi * r2 / total / area,
        r4 * total / (r2 * r2) - 1.0,
        math.hypot(re2, im2) / r2,
        math.hypot(re3, im3) / max(r3, 1e-12),
        math.hypot(re4, im4) / max(r4, 1e-12),
        math.hypot(re6, im6) / max(r6, 1e-12),
    )
    return numbers, cx, cy


class Base(NamedTuple):
    """The lowest section, against which all others are measured.

    Lengths are in `unit`, the root of a taxel's area; the centre (x, y) is in the profile's unit.
    """

    unit: float
    area: float
    root_area: float
    perimeter: float
    major: float
    minor: float
    x: float
    y: float


def _axes(covariance, i, unit):
    major, minor = principal_moments(covariance[i, 0], covariance[i, 1], covariance[i, 3])
    return math.sqrt(major) / unit + _LEAST_AXIS, math.sqrt(minor) / unit + _LEAST_AXIS


def lowest_section(measures, unit):
    """Return the `Base` of a contact's measures."""
    _, area, perimeter, centroid, covariance, _ = measure_columns(measures)
    last = area.size - 1
    while last > 0 and not area[last] > 0.0:
        last -= 1
    base_area = max(area[last] / unit**2, _LEAST_AREA)
    major, minor = _axes(covariance, last, unit)
    return Base(
        unit,
        base_area,
        math.sqrt(base_area),
        max(perimeter[last] / unit, _LEAST_AREA),
        major,
        minor,
        centroid[last, 0],
        centroid[last, 1],
    )


def _widths(extent, i, unit):
    """Return what the widths say: second, fourth (and along the elongation) and sixth harmonic, least box.

    Harmonics are shares of the mean width; the box is the least product of two widths at right angles.
    """
    mean, c2, s2, c4, s4, c6, s6 = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    box = 1e300
    for k in range(N_DIRECTIONS):
        w = extent[i, k] / unit
        mean += w
        c2 += w * _COS[_SECOND, k]
        s2 += w * _SIN[_SECOND, k]
        c4 += w * _COS[_FOURTH, k]
        s4 += w * _SIN[_FOURTH, k]
        c6 += w * _COS[_SIXTH, k]
        s6 += w * _SIN[_SIXTH, k]
        box = min(box, w * extent[i, (k + N_DIRECTIONS // 2) % N_DIRECTIONS] / unit)
    mean = max(mean, 1e-9)
    second = math.hypot(c2, s2)
    # The fourth harmonic along the elongation's own axis: its sign tells a rectangle from an ellipse.
    square = second * second + (_SAME * mean) ** 2
    re, im = (c2 * c2 - s2 * s2) / square, 2.0 * c2 * s2 / square
    phase = (c4 * re + s4 * im) / mean
    return second / mean, math.hypot(c4, s4) / mean, phase, math.hypot(c6, s6) / mean, max(box, 1e-9)


def _section(i, area, columns, counts, base):
    """Return the numbers of section i, in the order of `PER_BAND`; `area` is in the base's unit."""
    _, _, perimeters, centroid, covariance, extent = columns
    perimeter = perimeters[i] / base.unit
    major, minor = _axes(covariance, i, base.unit)
    second, fourth, phase, sixth, box = _widths(extent, i, base.unit)
    return (
        math.sqrt(area) / base.root_area,
        minor / base.minor,
        major / base.major,
        perimeter / base.perimeter,
        perimeter * perimeter / (4.0 * math.pi * area),
        minor / major,
        4.0 * math.pi * major * minor / area,
        area / box,
        second,
        fourth,
        phase,
        sixth,
        math.hypot(centroid[i, 0] - base.x, centroid[i, 1] - base.y) / base.unit / base.root_area,
        min(float(counts[HOLES, i]), _MOST_HOLES),
        min(float(counts[PARTS, i]), _MOST_PARTS),
    )


def _fill_empty(bands, count):
    """Give a band without a section what the one above it has; those above all sections, what the first has."""
    filled = -1
    for band in range(BANDS):
        if count[band] > 0:
            if filled < 0:
                bands[:, :band] = bands[:, band : band + 1]
            filled = band
        elif filled >= 0:
            bands[:, band] = bands[:, filled]


def section_bands(out, measures, counts, base, peak, span):
    """Fill `out` with the mean numbers of the sections in each band.

    Parameters
    ----------
    out : ndarray of shape (len(PER_BAND), BANDS), float64
        Overwritten; 0 where there is no section at all.
    measures, counts : ndarray
        As in `varishold.levelset.Profile`.
    base : Base
    peak, span : float
        The contact's highest value, and how far it stands above its floor.
    """
    columns = measure_columns(measures)
    threshold, area = columns[0], columns[1]
    count = np.zeros(BANDS)
    out[:] = 0.0
    for i in range(area.size):
        a = area[i] / base.unit**2
        if not a > _LEAST_AREA:
            continue
        band = min(max(int((peak - threshold[i]) / span * (BANDS * (1.0 + _SAME))), 0), BANDS - 1)
        numbers = _section(i, a, columns, counts, base)
        count[band] += 1.0
        for j in range(_N):
            out[j, band] += numbers[j]
    for band in range(BANDS):
        if count[band] > 0:
            for j in range(_N):
                v = out[j, band] / count[band]
                out[j, band] = v if v < _MOST else _MOST + math.log(v / _MOST)
    _fill_empty(out, count)


def _outermost_share(values, label, index):
    """Return the share of rows whose first taxel is the contact's; where the field has gaps, they are passed over."""
    taken, there = 0, 0
    for r in range(values.shape[0]):
        c = 0
        while c < values.shape[1] and values[r, c] == -np.inf:
            c += 1
        if c < values.shape[1]:
            there += 1
            taken += label[r, c] == index
    return taken / max(there, 1)


def _side_shares(values, label, index):
    """Return how much of the field's upper, lower, left and right side the contact covers, each from 0 to 1."""
    sides = np.empty(4)
    sides[0] = _outermost_share(values.T, label.T, index)
    sides[1] = _outermost_share(values[::-1].T, label[::-1].T, index)
    sides[2] = _outermost_share(values, label, index)
    sides[3] = _outermost_share(values[:, ::-1], label[:, ::-1], index)
    return sides


def _at_centre(x, y, height, cx, cy, area):
    """Return the mean height around (cx, cy), and how far from there the highest taxel lies."""
    reach = 2.0 * (_CENTRE_SHARE * area + _CENTRE_TAXELS)
    near, weight, highest = 0.0, 0.0, 0
    for i in range(x.size):
        g = math.exp(-((x[i] - cx) ** 2 + (y[i] - cy) ** 2) / reach)
        near += g * height[i]
        weight += g
        if height[i] > height[highest] + _SAME:
            highest = i
    return near / weight if weight > 0.0 else 0.0, math.hypot(x[highest] - cx, y[highest] - cy)


def signature_into(
    out: NDArray[np.float64],
    measures: NDArray[np.float64],
    counts: NDArray[np.int64],
    padded: NDArray[np.float64],
    label: NDArray[np.int32],
    index: int,
    place: NDArray[np.int64],
    pitch: tuple[float, float],
    peak: float,
    floor: float,
    sigma: float,
) -> None:
    """Fill `out` (length of `SIGNATURE_NAMES`) with a contact's signature.

    `measures` and `counts` are the contact's profile, in the units of `pitch` (row spacing, column spacing),
    which is (1, 1) where it is unknown; `padded`, `label`, `index` and `place` are its frame's, as in
    `varishold.levelset.contact.Frame`.
    """
    unit = math.sqrt(pitch[0] * pitch[1])
    span = peak - floor if peak > floor else 1.0
    base = lowest_section(measures, unit)
    section_bands(out[:_N_BANDS].reshape((len(PER_BAND), BANDS)), measures, counts, base, peak, span)

    x, y, height = contact_taxels(padded, label, index, place, floor, span)
    x *= pitch[1] / unit
    y *= pitch[0] / unit
    weights = weights_of(height)
    k = _N_BANDS
    centre_x, centre_y = 0.0, 0.0
    for w in range(len(WEIGHTS)):
        numbers, cx, cy = weighted_moments(x, y, weights[w], base.area)
        if w == 0:
            centre_x, centre_y = cx, cy
        for j in range(_N_WEIGHT):
            out[k + j] = numbers[j]
        k += _N_WEIGHT

    rows, cols = padded.shape[0] - 2, padded.shape[1] - 2
    top, offset = _at_centre(x, y, height, centre_x, centre_y, base.area)
    sides = _side_shares(padded[1:-1, 1:-1], label[1:-1, 1:-1], index)
    opposite = max(min(sides[0], sides[1]), min(sides[2], sides[3]))
    sides.sort()
    singles = (
        height.sum() / max(base.area, 1.0),
        top,
        offset / base.root_area,
        math.log(base.root_area),
        math.log(base.minor),
        math.log(max(sigma / span, _LEAST_NOISE)),
        height.size / (rows * cols),
        sides[3],
        sides[2],
        sides[1],
        sides[0],
        opposite,
    )
    for j in range(len(singles)):
        out[k + j] = singles[j]


def _at(padded, r, c):
    """Return the taxel at a place, -inf where there is none: the rim of a field without gaps holds its border's."""
    if r < 1 or c < 1 or r > padded.shape[0] - 2 or c > padded.shape[1] - 2:
        return -np.inf
    return padded[r, c]


def _add_edge(v, w, levels, total, count):
    """Add the step between two taxels to each level that lies between them."""
    step, most, least = abs(v - w), max(v, w), min(v, w)
    for k in range(len(levels)):
        if most > levels[k] and least <= levels[k]:
            total[k] += step
            count[k] += 1.0


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
    near, topmost, same = floor + _NEAR_TOP * span, floor + _TOP * span, _SAME * peak
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
            n_exact += v >= peak - same
            if v > second and v < peak - same:
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
                    equal += abs(v - w) <= same and v < peak - same
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
    beside = int(_BESIDE * math.sqrt(max(n, 1.0)))
    for r in range(1, rows + 1):
        for c in range(1, cols + 1):
            if padded[r, c] == -np.inf:
                continue
            lowest = min(lowest, padded[r, c])
            if top - beside <= r < bottom + beside and left - beside <= c < right + beside:
                highest = max(highest, padded[r, c])
                others += label[r, c] != index and padded[r, c] > floor * (1.0 + _SAME)
    for r in range(1, rows + 1):
        for c in range(1, cols + 1):
            v = padded[r, c]
            if v == -np.inf:
                continue
            field += 1.0
            n_lowest += v <= lowest + same
            if label[r, c] == index:
                continue
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


def reference_signature(contact: Contact) -> NDArray[np.float64]:
    """Return what `contact_signature` should."""
    out = np.empty(len(SIGNATURE_NAMES))
    frame, k, profile = contact.frame, contact.index, contact.profile
    form, state = out[: -len(STATE_NAMES)], out[-len(STATE_NAMES) :]
    place, peak, floor = frame.places[k], contact.peak, contact.floor
    with np.errstate(all="ignore"):
        signature_into(
            form,
            profile.measures,
            profile.counts,
            frame.padded,
            frame.label,
            k,
            place,
            contact.spacing,
            peak,
            floor,
            contact.sigma,
        )
        state_into(state, frame.padded, frame.label, k, place, peak, floor)
    return out


def reference_logits(whitened: NDArray[np.float64], parameters: Parameters) -> NDArray[np.float64]:
    """Return what `kind_logits` should, but for rounding: in double precision."""
    h = hidden = whitened
    for layer, (weight, bias) in enumerate(zip(parameters.weights, parameters.biases, strict=True)):
        hidden = h if layer == 0 else np.maximum(h, 0.0)
        h = hidden @ weight.astype(np.float64) + bias
    if parameters.means.size:
        y = hidden @ parameters.whiten.astype(np.float64)
        beyond = np.sqrt(((y - parameters.means) ** 2).sum(axis=1)).min() - parameters.farthest
        h[-1] += 0.3 * max(beyond, 0.0)
    return np.asarray(h)
