"""A frame with a rim: one taxel more on every side, which stands on the pad's border."""

from __future__ import annotations

import math

import numpy as np

from varishold.files.compiling import njit

__all__ = ["ALL_BROKEN", "FINE", "INFINITE", "pad_frame", "positions"]

#: What may be wrong with a frame.
FINE, INFINITE, ALL_BROKEN = 0, 1, 2


@njit(cache=True, nogil=True, error_model="numpy")
def positions(count, pitch):  # type: ignore[no-untyped-def]
    """Return the positions of a padded frame's columns or rows: the outermost on the pad's border.

    Parameters
    ----------
    count : int
        Taxels in a row or column.
    pitch : float
        Their spacing.

    Returns
    -------
    ndarray of shape (count + 2,), float64
        From the pad's centre.
    """
    at = np.empty(count + 2)
    for i in range(count + 2):
        at[i] = (i - 0.5 * (count + 1)) * pitch
    at[0], at[count + 1] = -0.5 * count * pitch, 0.5 * count * pitch
    return at


@njit(cache=True, nogil=True, error_model="numpy")
def pad_frame(frame, field, valid):  # type: ignore[no-untyped-def]
    """Surround a frame by a rim of -inf, the value where there is no taxel.

    Parameters
    ----------
    frame : ndarray of shape (rows, cols), float64
        NaN where there is no taxel, anything where one is broken.
    field, valid : ndarray of shape (rows, cols), bool
        Where there are taxels, and where they work; an empty one is none.

    Returns
    -------
    padded : ndarray of shape (rows + 2, cols + 2), float64
    inside, usable : ndarray of shape (rows, cols), bool
        Where there is a taxel, and where it works.
    n_inside, n_usable : int
    peak : float
        The highest value, at least 0.
    fault : int
        `FINE`, `INFINITE` or `ALL_BROKEN`.
    """
    rows, cols = frame.shape
    padded = np.empty((rows + 2, cols + 2))
    padded[0], padded[rows + 1] = -np.inf, -np.inf
    padded[:, 0], padded[:, cols + 1] = -np.inf, -np.inf
    inside, usable = np.empty((rows, cols), np.bool_), np.empty((rows, cols), np.bool_)
    fault, n_inside, n_usable, peak = FINE, 0, 0, 0.0
    for r in range(rows):
        for c in range(cols):
            value = frame[r, c]
            there = field.size == 0 or field[r, c]
            works = valid.size == 0 or valid[r, c]
            there = there and not (works and math.isnan(value))
            works = works and there
            inside[r, c], usable[r, c] = there, works
            n_inside += there
            n_usable += works
            if works:
                peak = max(peak, value)
                if math.isinf(value):
                    fault = INFINITE
            padded[r + 1, c + 1] = value if there else -np.inf
    if fault == FINE and n_inside > 0 and n_usable == 0:
        fault = ALL_BROKEN
    return padded, inside, usable, n_inside, n_usable, peak, fault
