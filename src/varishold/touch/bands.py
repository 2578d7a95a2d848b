"""What a contact's sections say, gathered in bands of relative depth.

Relative depth is q = (theta_1 - theta) / (theta_1 - delta), so that any schedule of thresholds gives the same
numbers. Every length is measured against the lowest section, so that neither the pitch nor the unit matters.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from varishold.files.compiling import njit
from varishold.levelset.columns import HOLES, PARTS, measure_columns
from varishold.levelset.second_moments import principal_moments
from varishold.levelset.widths import DIRECTIONS, N_DIRECTIONS

__all__ = ["BANDS", "PER_BAND", "Base", "lowest_section", "section_bands"]

#: Bands of relative depth, the first nearest the top.
BANDS = 8

#: Group and name of every number of a section, in the order in which `_section` returns them.
PER_BAND = (
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

_SECOND, _FOURTH, _SIXTH = 0, 1, 2
_COS = np.cos(np.outer([2.0, 4.0, 6.0], DIRECTIONS))
_SIN = np.sin(np.outer([2.0, 4.0, 6.0], DIRECTIONS))
_N = len(PER_BAND)
# Added to axes, so that a section of no breadth has ratios too.
_LEAST_AXIS = 1e-6
_LEAST_AREA = 1e-9
_MOST_HOLES, _MOST_PARTS = 3.0, 4.0
# A sliver's ratio may be anything; what lies beyond a few units says no more.
_MOST = 4.0

_principal_moments = njit(cache=True, nogil=True)(principal_moments)


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


@njit(cache=True, nogil=True)
def _axes(covariance, i, unit):  # type: ignore[no-untyped-def]
    major, minor = _principal_moments(covariance[i, 0], covariance[i, 1], covariance[i, 3])
    return math.sqrt(major) / unit + _LEAST_AXIS, math.sqrt(minor) / unit + _LEAST_AXIS


@njit(cache=True, nogil=True)
def lowest_section(measures, unit):  # type: ignore[no-untyped-def]
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


@njit(cache=True, nogil=True)
def _widths(extent, i, unit):  # type: ignore[no-untyped-def]
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
    phase = 0.0
    # The fourth harmonic along the elongation's own axis: its sign tells a rectangle from an ellipse.
    if second > 1e-12:
        re, im = (c2 * c2 - s2 * s2) / (second * second), 2.0 * c2 * s2 / (second * second)
        phase = (c4 * re + s4 * im) / mean
    return second / mean, math.hypot(c4, s4) / mean, phase, math.hypot(c6, s6) / mean, max(box, 1e-9)


@njit(cache=True, nogil=True)
def _section(i, area, columns, counts, base):  # type: ignore[no-untyped-def]
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


@njit(cache=True, nogil=True)
def _fill_empty(bands, count):  # type: ignore[no-untyped-def]
    """Give a band without a section what the one above it has; those above all sections, what the first has."""
    filled = -1
    for band in range(BANDS):
        if count[band] > 0:
            if filled < 0:
                bands[:, :band] = bands[:, band : band + 1]
            filled = band
        elif filled >= 0:
            bands[:, band] = bands[:, filled]


@njit(cache=True, nogil=True)
def section_bands(out, measures, counts, base, peak, span):  # type: ignore[no-untyped-def]
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
        band = min(max(int((peak - threshold[i]) / span * BANDS), 0), BANDS - 1)
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
