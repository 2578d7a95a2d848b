"""A contact's signature: scale-free numbers that say how its sections nest and grow, and how its taxels lie."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from varishold.files.compiling import njit
from varishold.touch.bands import BANDS, PER_BAND, lowest_section, section_bands
from varishold.touch.state import STATE_GROUPS, STATE_NAMES
from varishold.touch.taxel_moments import PER_WEIGHT, WEIGHTS, contact_taxels, weighted_moments, weights_of

__all__ = ["SIGNATURE_GROUPS", "SIGNATURE_NAMES", "signature_into"]

# Frames as good as free of noise, and those too small to tell, count as having this share of it.
_LEAST_NOISE = 1.5e-3
# What stands at the centre is a mean over this share of the lowest section's area and half a taxel.
_CENTRE_SHARE, _CENTRE_TAXELS = 0.02, 0.5
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
    *(f"{name}_{band}" for _, name in PER_BAND for band in range(BANDS)),
    *(f"{weight}_{name}" for weight in WEIGHTS for _, name in PER_WEIGHT),
    *(name for _, name in _SINGLE),
    *STATE_NAMES,
)
#: What each number of a signature tells of, in the same order.
SIGNATURE_GROUPS: tuple[str, ...] = (
    *(group for group, _ in PER_BAND for _ in range(BANDS)),
    *(group for _ in WEIGHTS for group, _ in PER_WEIGHT),
    *(group for group, _ in _SINGLE),
    *STATE_GROUPS,
)

_N_BANDS = len(PER_BAND) * BANDS
_N_WEIGHT = len(PER_WEIGHT)


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
def _at_centre(x, y, height, cx, cy, area):  # type: ignore[no-untyped-def]
    """Return the mean height around (cx, cy), and how far from there the highest taxel lies."""
    reach = 2.0 * (_CENTRE_SHARE * area + _CENTRE_TAXELS)
    near, weight, highest = 0.0, 0.0, 0
    for i in range(x.size):
        g = math.exp(-((x[i] - cx) ** 2 + (y[i] - cy) ** 2) / reach)
        near += g * height[i]
        weight += g
        if height[i] > height[highest]:
            highest = i
    return near / weight if weight > 0.0 else 0.0, math.hypot(x[highest] - cx, y[highest] - cy)


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
