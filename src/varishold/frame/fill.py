"""Filling broken taxels from their neighbours."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

from varishold.errors import InputError
from varishold.files.compiling import njit
from varishold.frame.checks import as_floats, as_usable

__all__ = ["fill_invalid", "fill_taxels"]

# Relative to the range of the frame's values; far below any sensor's resolution.
_TOLERANCE = 1e-10
_MOST_SWEEPS = 10_000


@njit(cache=True)
def fill_taxels(frame, usable, field):  # type: ignore[no-untyped-def]
    """Fill a frame in place where `field` and not `usable`; the compiled core of `fill_invalid`.

    Parameters
    ----------
    frame : ndarray of shape (rows, cols), float64
        Overwritten where filled.
    usable : ndarray of shape (rows, cols), bool
        Where the frame's values are to be believed; it is not read outside the field.
    field : ndarray of shape (rows, cols), bool
        Where there are taxels.

    Returns
    -------
    int
        Number of taxels filled.
    """
    rows, cols = frame.shape
    broken_row = np.empty(rows * cols, np.int64)
    broken_col = np.empty(rows * cols, np.int64)
    n = 0
    low, high = np.inf, -np.inf
    for r in range(rows):
        for c in range(cols):
            if field[r, c]:
                if usable[r, c]:
                    low, high = min(low, frame[r, c]), max(high, frame[r, c])
                else:
                    broken_row[n], broken_col[n] = r, c
                    n += 1
    if n == 0 or low > high:
        return n
    for k in range(n):
        frame[broken_row[k], broken_col[k]] = low
    # Successive over-relaxation, best for a square hole of n taxels, good for every other.
    relaxation = 2.0 / (1.0 + math.sin(math.pi / (math.sqrt(n) + 2.0)))
    for _ in range(_MOST_SWEEPS):
        change = 0.0
        for k in range(n):
            r, c = broken_row[k], broken_col[k]
            total, count = 0.0, 0
            if r > 0 and field[r - 1, c]:
                total += frame[r - 1, c]
                count += 1
            if r + 1 < rows and field[r + 1, c]:
                total += frame[r + 1, c]
                count += 1
            if c > 0 and field[r, c - 1]:
                total += frame[r, c - 1]
                count += 1
            if c + 1 < cols and field[r, c + 1]:
                total += frame[r, c + 1]
                count += 1
            if count > 0:
                step = relaxation * (total / count - frame[r, c])
                frame[r, c] += step
                change = max(change, abs(step))
        if change <= _TOLERANCE * (high - low):
            break
    # Over-relaxation may overshoot the harmonic function by its tolerance.
    for k in range(n):
        r, c = broken_row[k], broken_col[k]
        frame[r, c] = min(max(frame[r, c], low), high)
    return n


def fill_invalid(frame: ArrayLike, valid: ArrayLike, field: ArrayLike | None = None) -> NDArray[np.float64]:
    """Fill broken taxels so that each is the mean of its neighbours (a discrete harmonic function).

    Filled values never leave the range of the others. A part of the field that has no working taxel at all is
    filled with the lowest value of the rest: no contact is seen where nothing was felt.

    Parameters
    ----------
    frame : array_like of shape (rows, cols), float or integer
        The frame; broken taxels may hold anything, also NaN.
    valid : array_like of shape (rows, cols), bool
        False where a taxel is broken.
    field : array_like of shape (rows, cols), bool, optional
        False where there is no taxel: never filled and never a neighbour. Default: taxels everywhere.

    Returns
    -------
    ndarray of shape (rows, cols), float64
        A new frame; outside the field as it was.

    Raises
    ------
    InputError
        If shapes differ or no taxel is left to fill from.

    Examples
    --------
    >>> import numpy as np
    >>> frame = np.array([[1.0, 2.0, 1.0], [2.0, np.nan, 4.0], [1.0, 4.0, 1.0]])
    >>> round(float(fill_invalid(frame, np.isfinite(frame))[1, 1]), 6)
    3.0
    """
    filled = as_floats(frame, 2, "a frame", masked=True).copy()
    inside = as_usable(filled, filled.shape, field)
    usable = as_usable(frame, filled.shape, None, valid)
    if not np.any(usable & inside):
        raise InputError(f"all {np.count_nonzero(inside)} taxels are broken: nothing to fill from")
    fill_taxels(filled, usable, inside)
    return filled
