"""A frame made fit and measured, all in one compiled call: each call costs more than a small contact."""

from __future__ import annotations

import math

import numpy as np

from varishold.files.compiling import njit
from varishold.frame.fill import fill_taxels
from varishold.frame.floor import default_floor, noise_reach, timed_floor
from varishold.frame.level import level_into
from varishold.frame.noise import noise_sigma
from varishold.frame.repair import repair_into
from varishold.levelset.columns import END, N_TAXELS, PEAK
from varishold.levelset.kernel import sections
from varishold.levelset.padding import FINE, pad_frame, positions

__all__ = ["UNORDERED", "measure_frame"]

#: What may be wrong beside the faults of a frame's padding: thresholds neither fall nor rise, or are not finite.
UNORDERED = 3
# A contact of fewer taxels, or of a smaller share of the largest one's, that rises no higher above its floor than noise
# does is a speck on a skirt.
_SPECK_TAXELS, _SPECK_SHARE = 12, 0.05


@njit(cache=True, nogil=True, error_model="numpy")
def _fall(levels):  # type: ignore[no-untyped-def]
    """Return thresholds that rise or fall already as falling ones, and whether they were such, and finite."""
    n = levels.size
    falls, rises = True, True
    for i in range(n - 1):
        falls &= levels[i] >= levels[i + 1]
        rises &= levels[i] <= levels[i + 1]
    ordered = n == 0 or ((falls or rises) and math.isfinite(levels[0]) and math.isfinite(levels[n - 1]))
    return levels if falls else levels[::-1].copy(), ordered


@njit(cache=True, nogil=True, error_model="numpy")
def _without_noise(order, places, values, noise):  # type: ignore[no-untyped-def]
    """Return the contacts that are more than noise: higher than it reaches, and no specks that it makes on a skirt."""
    few = _SPECK_TAXELS
    for k in order:
        few = max(few, int(_SPECK_SHARE * places[k, N_TAXELS]))
    kept, n = np.empty_like(order), 0
    for k in order:
        speck = places[k, N_TAXELS] < few and values[k, PEAK] - values[k, END] <= noise
        if values[k, PEAK] > noise and not speck:
            kept[n] = k
            n += 1
    return kept[:n]


@njit(cache=True, nogil=True, error_model="numpy")
def measure_frame(frame, n_even, levels, row_pitch, col_pitch, valid, field, floor, timed_sigma):  # type: ignore[no-untyped-def]
    """Do all of `find_contacts`: one call, as each costs more than a small contact."""
    padded, inside, usable, n_inside, n_usable, peak, fault = pad_frame(frame, field, valid)
    thresholds, ordered = _fall(levels)
    if fault == FINE and not ordered:
        fault = UNORDERED
    sigma, noise = np.nan, 0.0
    if fault != FINE:
        floor = np.inf
    elif n_usable < n_inside:
        fill_taxels(padded[1:-1, 1:-1], usable, inside)
    dead, rest = np.zeros(frame.shape, np.bool_), np.zeros(3)
    if floor < 0.0:
        scratch = np.empty(frame.size)
        sigma = noise_sigma(frame, usable, scratch)
        # Thresholds in the frame's own unit speak of the frame as it is.
        if n_even > 0:
            inner = padded[1:-1, 1:-1]
            repaired = repair_into(inner, usable, inside, sigma, dead)
            levelled = level_into(inner, usable & ~dead, sigma, rest)
            if repaired or levelled:
                sigma = noise_sigma(inner, usable & ~dead, scratch)
                peak = 0.0
                for value in inner.ravel():
                    peak = max(peak, value)
        noise = noise_reach(max(sigma, timed_sigma), n_usable)
        floor = default_floor(sigma, peak) if timed_sigma < 0.0 else timed_floor(timed_sigma, peak)
    height, width = padded.shape
    xs, ys = positions(width - 2, col_pitch), positions(height - 2, row_pitch)
    label, places, values, order, measures, counts = sections(
        padded.ravel(), width, height, floor, noise, thresholds, n_even, xs, ys, n_inside < frame.size
    )
    if noise > 0.0:
        order = _without_noise(order, places, values, noise)
    return fault, padded, label.reshape(height, width), places, values, order, measures, counts, sigma, dead, rest
