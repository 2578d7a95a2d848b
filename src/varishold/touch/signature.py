"""A contact's signature: scale-free numbers that say how its sections nest and grow.

The sections of a profile are gathered in `BANDS` bands of relative depth q = (theta_1 - theta) /
(theta_1 - delta), so that any schedule of thresholds gives the same signature. Every length is measured
against the lowest section, so that neither the pitch nor the unit matters.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from varishold.files.compiling import njit
from varishold.levelset.columns import BOTTOM, HOLES, LEFT, PARTS, RIGHT, TOP, measure_columns

__all__ = ["BANDS", "SIGNATURE_GROUPS", "SIGNATURE_NAMES", "signature_into"]

#: Bands of relative depth, the first nearest the top.
BANDS = 8

_DIRECTIONS = 16
# Frames as good as free of noise, and those too small to tell, count as having this share of it.
_LEAST_NOISE = 1.5e-3
_PER_BAND = (
    ("growth", "root_area"),
    ("growth", "minor"),
    ("growth", "major"),
    ("growth", "perimeter"),
    ("outline", "compactness"),
    ("elongation", "aspect"),
    ("outline", "fullness"),
    ("outline", "box_fill"),
    ("elongation", "second_harmonic"),
    ("outline", "fourth_harmonic"),
    ("outline", "fourth_phase"),
    ("outline", "sixth_harmonic"),
    ("drift", "drift"),
    ("holes and parts", "holes"),
    ("holes and parts", "parts"),
)
_WEIGHTS = ("height", "height_squared", "base")
_PER_WEIGHT = (
    ("volume", "spread"),
    ("volume", "peakedness"),
    ("elongation", "moment_2"),
    ("outline", "moment_3"),
    ("outline", "moment_4"),
    ("outline", "moment_6"),
)
_SINGLE = (
    ("volume", "fill"),
    ("volume", "top_at_centre"),
    ("volume", "peak_offset"),
    ("resolution", "log_size"),
    ("resolution", "log_minor"),
    ("resolution", "noise"),
    ("border", "field_share"),
    ("border", "side_1"),
    ("border", "side_2"),
    ("border", "side_3"),
    ("border", "side_4"),
    ("border", "opposite"),
)

#: Name of every number of a signature, in order.
SIGNATURE_NAMES: tuple[str, ...] = (
    *(f"{name}_{band}" for name in (n for _, n in _PER_BAND) for band in range(BANDS)),
    *(f"{weight}_{name}" for weight in _WEIGHTS for _, name in _PER_WEIGHT),
    *(name for _, name in _SINGLE),
)
#: What each number of a signature tells of, in the same order.
SIGNATURE_GROUPS: tuple[str, ...] = (
    *(group for group, _ in _PER_BAND for _ in range(BANDS)),
    *(group for _ in _WEIGHTS for group, _ in _PER_WEIGHT),
    *(group for group, _ in _SINGLE),
)

_COS = np.cos(np.outer([2.0, 4.0, 6.0], np.arange(_DIRECTIONS)) * np.pi / _DIRECTIONS)
_SIN = np.sin(np.outer([2.0, 4.0, 6.0], np.arange(_DIRECTIONS)) * np.pi / _DIRECTIONS)
_N_BAND = len(_PER_BAND)
_N = len(SIGNATURE_NAMES)


@njit(cache=True, nogil=True)
def _outermost_share(values, label, index):  # type: ignore[no-untyped-def]
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


@njit(cache=True, nogil=True)
def _side_shares(values, label, index):  # type: ignore[no-untyped-def]
    """Return how much of the field's upper, lower, left and right side the contact covers, each from 0 to 1."""
    sides = np.empty(4)
    sides[0] = _outermost_share(values.T, label.T, index)
    sides[1] = _outermost_share(values[::-1].T, label[::-1].T, index)
    sides[2] = _outermost_share(values, label, index)
    sides[3] = _outermost_share(values[:, ::-1], label[:, ::-1], index)
    return sides


@njit(cache=True, nogil=True)
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
    step_y, step_x = pitch[0] / unit, pitch[1] / unit
    n = counts.shape[1]
    threshold, area, perimeter, centroid, covariance, extent = measure_columns(measures)
    out[:] = 0.0
    span = peak - floor
    if span <= 0.0:
        span = 1.0
    last = n - 1
    while last > 0 and not area[last] > 0.0:
        last -= 1
    base_area = max(area[last] / unit**2, 1e-9)
    base_root = math.sqrt(base_area)
    base_perimeter = max(perimeter[last] / unit, 1e-9)
    half = 0.5 * (covariance[last, 0] + covariance[last, 3])
    diff = 0.5 * (covariance[last, 0] - covariance[last, 3])
    root = math.sqrt(diff * diff + covariance[last, 1] ** 2)
    base_major = math.sqrt(max(half + root, 0.0)) / unit + 1e-6
    base_minor = math.sqrt(max(half - root, 0.0)) / unit + 1e-6

    count = np.zeros(BANDS)
    row = np.zeros(_N_BAND)
    band_values = np.zeros((BANDS, _N_BAND))
    for i in range(n):
        a = area[i] / unit**2
        if not a > 1e-9:
            continue
        q = (peak - threshold[i]) / span
        band = int(q * BANDS)
        if band < 0:
            band = 0
        elif band >= BANDS:
            band = BANDS - 1
        p = perimeter[i] / unit
        half = 0.5 * (covariance[i, 0] + covariance[i, 3])
        diff = 0.5 * (covariance[i, 0] - covariance[i, 3])
        root = math.sqrt(diff * diff + covariance[i, 1] ** 2)
        major = math.sqrt(max(half + root, 0.0)) / unit + 1e-6
        minor = math.sqrt(max(half - root, 0.0)) / unit + 1e-6
        c0 = 0.0
        c2 = 0.0
        s2 = 0.0
        c4 = 0.0
        s4 = 0.0
        c6 = 0.0
        s6 = 0.0
        box = 1e300
        for k in range(_DIRECTIONS):
            w = extent[i, k] / unit
            c0 += w
            c2 += w * _COS[0, k]
            s2 += w * _SIN[0, k]
            c4 += w * _COS[1, k]
            s4 += w * _SIN[1, k]
            c6 += w * _COS[2, k]
            s6 += w * _SIN[2, k]
            across = w * extent[i, (k + _DIRECTIONS // 2) % _DIRECTIONS] / unit
            box = min(box, across)
        c0 = max(c0, 1e-9)
        h2 = math.hypot(c2, s2)
        row[0] = math.sqrt(a) / base_root
        row[1] = minor / base_minor
        row[2] = major / base_major
        row[3] = p / base_perimeter
        row[4] = p * p / (4.0 * math.pi * a)
        row[5] = minor / major
        row[6] = 4.0 * math.pi * major * minor / a
        row[7] = a / max(box, 1e-9)
        row[8] = h2 / c0
        row[9] = math.hypot(c4, s4) / c0
        # The fourth harmonic along the elongation's own axis: its sign tells a rectangle from an ellipse.
        if h2 > 1e-12:
            re, im = (c2 * c2 - s2 * s2) / (h2 * h2), 2.0 * c2 * s2 / (h2 * h2)
            row[10] = (c4 * re + s4 * im) / c0
        else:
            row[10] = 0.0
        row[11] = math.hypot(c6, s6) / c0
        row[12] = math.hypot(centroid[i, 0] - centroid[last, 0], centroid[i, 1] - centroid[last, 1]) / unit / base_root
        row[13] = min(counts[HOLES, i], 3)
        row[14] = min(counts[PARTS, i], 4)
        count[band] += 1.0
        for j in range(_N_BAND):
            band_values[band, j] += row[j]
    filled = -1
    for band in range(BANDS):
        if count[band] > 0:
            for j in range(_N_BAND):
                band_values[band, j] /= count[band]
            filled = band
        elif filled >= 0:
            for j in range(_N_BAND):
                band_values[band, j] = band_values[filled, j]
    for band in range(BANDS - 2, -1, -1):
        if count[band] == 0 and (band == 0 or band_values[band, 5] == 0.0):
            for j in range(_N_BAND):
                band_values[band, j] = band_values[band + 1, j]
    k = 0
    for j in range(_N_BAND):
        for band in range(BANDS):
            v = band_values[band, j]
            # A sliver's ratio may be anything; what lies beyond a few units says no more.
            out[k] = v if v < 4.0 else 4.0 + math.log(v / 4.0)
            k += 1

    top, bottom, left, right = place[TOP], place[BOTTOM] + 1, place[LEFT], place[RIGHT] + 1
    total = np.zeros(3)
    mx = np.zeros(3)
    my = np.zeros(3)
    volume = 0.0
    cells = 0
    best = -1e300
    best_r = 0
    best_c = 0
    frame_rows, frame_cols = padded.shape[0] - 2, padded.shape[1] - 2
    for r in range(top, bottom):
        for c in range(left, right):
            if label[r, c] != index:
                continue
            v = (padded[r, c] - floor) / span
            if v < 0.0:
                v = 0.0
            if v > best:
                best = v
                best_r = r
                best_c = c
            cells += 1
            volume += v
            b = min(v * 2.5, 1.0)
            total[0] += v
            mx[0] += v * c
            my[0] += v * r
            total[1] += v * v
            mx[1] += v * v * c
            my[1] += v * v * r
            total[2] += b
            mx[2] += b * c
            my[2] += b * r
    for w in range(3):
        t = max(total[w], 1e-12)
        cx = mx[w] / t
        cy = my[w] / t
        m_r2 = 0.0
        m_r3 = 0.0
        m_r4 = 0.0
        m_r6 = 0.0
        re2 = 0.0
        im2 = 0.0
        re3 = 0.0
        im3 = 0.0
        re4 = 0.0
        im4 = 0.0
        re6 = 0.0
        im6 = 0.0
        for r in range(top, bottom):
            y = (r - cy) * step_y
            for c in range(left, right):
                if label[r, c] != index:
                    continue
                v = (padded[r, c] - floor) / span
                if v < 0.0:
                    v = 0.0
                if w == 1:
                    v = v * v
                elif w == 2:
                    v = min(v * 2.5, 1.0)
                x = (c - cx) * step_x
                r2 = x * x + y * y
                zr = x * x - y * y
                zi = 2.0 * x * y
                m_r2 += v * r2
                m_r3 += v * r2 * math.sqrt(r2)
                m_r4 += v * r2 * r2
                m_r6 += v * r2 * r2 * r2
                re2 += v * zr
                im2 += v * zi
                re3 += v * (zr * x - zi * y)
                im3 += v * (zr * y + zi * x)
                r4 = zr * zr - zi * zi
                i4 = 2.0 * zr * zi
                re4 += v * r4
                im4 += v * i4
                re6 += v * (r4 * zr - i4 * zi)
                im6 += v * (r4 * zi + i4 * zr)
        m_r2 = max(m_r2, 1e-12)
        out[k] = 2.0 * math.pi * m_r2 / t / base_area
        out[k + 1] = m_r4 * t / (m_r2 * m_r2) - 1.0
        out[k + 2] = math.hypot(re2, im2) / m_r2
        out[k + 3] = math.hypot(re3, im3) / max(m_r3, 1e-12)
        out[k + 4] = math.hypot(re4, im4) / max(m_r4, 1e-12)
        out[k + 5] = math.hypot(re6, im6) / max(m_r6, 1e-12)
        k += 6
    t = max(total[0], 1e-12)
    cx = mx[0] / t
    cy = my[0] / t
    near = 0.0
    weight = 0.0
    reach = 0.02 * base_area + 0.5
    for r in range(top, bottom):
        for c in range(left, right):
            if label[r, c] == index:
                d2 = ((r - cy) * step_y) ** 2 + ((c - cx) * step_x) ** 2
                g = math.exp(-d2 / (2.0 * reach))
                near += g * (padded[r, c] - floor) / span
                weight += g
    out[k] = volume / max(base_area, 1.0)
    out[k + 1] = near / weight if weight > 0.0 else 0.0
    out[k + 2] = math.hypot((best_r - cy) * step_y, (best_c - cx) * step_x) / base_root
    out[k + 3] = math.log(base_root)
    out[k + 4] = math.log(base_minor)
    out[k + 5] = math.log(max(sigma / span, _LEAST_NOISE))
    out[k + 6] = cells / (frame_rows * frame_cols)
    sides = _side_shares(padded[1:-1, 1:-1], label[1:-1, 1:-1], index)
    opposite = max(min(sides[0], sides[1]), min(sides[2], sides[3]))
    sides.sort()
    for j in range(4):
        out[k + 7 + j] = sides[3 - j]
    out[k + 11] = opposite
