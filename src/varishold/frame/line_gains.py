"""Rows and columns that read alike too much or too little: told by presses at many places, and evened out."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from varishold.frame.fault import Floats, Mask
from varishold.frame.press_places import press_places

__all__ = ["line_gains"]

# Presses that tell it, and of each half of them those that press a line; lines, and taxels of one that is pressed.
_FEWEST_PRESSES, _FEWEST_HERE, _FEWEST_LINES, _FEWEST_TAXELS = 4, 1, 8, 3
# Forms bend slowly over the pad, as polynomials of this degree do.
_FORM = 3
# What two halves of the presses have in common is so much of what either finds, and gains spread by so much.
_AGREEMENT, _LEAST = 0.75, 0.045
# A second difference of gains that are their own has so many times the variance of one.
_OF_DIFFERENCE = 1.5
# How well a difference is known at most.
_LEAST_NOISE = 0.003


def line_gains(loads: Sequence[Floats], usable: Mask, sigma: float) -> Floats | None:
    """Return how much more or less each taxel reads by its row and its column; None where that is not certain.

    The logarithm of a reading is that of the pressure, and of the gains of its row and its column. What presses is
    smooth nearly everywhere, and lies elsewhere each time: second differences of the logarithms across a line, the
    median of its taxels and of all presses, are what its gain is beside those of the next ones.

    Parameters
    ----------
    loads : sequence of ndarray of shape (rows, cols), float64
        The strongest frame of each press, zero at rest.
    usable : ndarray of shape (rows, cols), bool
    sigma : float
        Standard deviation of the noise.

    Returns
    -------
    ndarray of shape (rows, cols), float64, or None
        About 1.

    Examples
    --------
    >>> rng = np.random.default_rng(0)
    >>> y, x = np.mgrid[:16, :16]
    >>> reads = np.exp(rng.normal(0, 0.1, (16, 1)))
    >>> at = rng.uniform(4, 12, (20, 2))
    >>> balls = [np.maximum(25 - (y - row) ** 2 - (x - col) ** 2, 0.0) ** 0.5 for row, col in at]
    >>> found = line_gains([reads * ball for ball in balls], np.ones((16, 16), bool), 0.01)
    >>> bool(np.std(np.log(reads / found)) < 0.8 * np.std(np.log(reads)))
    True
    >>> line_gains(balls, np.ones((16, 16), bool), 0.01) is None
    True
    """
    if len(loads) < _FEWEST_PRESSES:
        return None
    told = press_places(loads, usable, sigma)
    if told is None:
        return None
    presses, inside = told
    logs = np.log(np.where(inside, presses, 1.0))
    of_rows = _of_lines(logs, inside)
    of_columns = _of_lines(logs.transpose(0, 2, 1), inside.transpose(0, 2, 1))
    if of_rows is None and of_columns is None:
        return None
    rows, cols = usable.shape
    together = (np.zeros(rows) if of_rows is None else of_rows)[:, None]
    gains: Floats = np.exp(together + (np.zeros(cols) if of_columns is None else of_columns))
    return gains


def _of_lines(logs: Floats, inside: Mask) -> Floats | None:
    """Return the logarithms of rows' gains, shape (rows,); None where they are not certain."""
    n_lines = logs.shape[1]
    if n_lines < _FEWEST_LINES:
        return None
    bends = logs[:, 1:-1] - (logs[:, :-2] + logs[:, 2:]) / 2
    seen = inside[:, 1:-1] & inside[:, :-2] & inside[:, 2:]
    told = np.count_nonzero(seen, axis=2) >= _FEWEST_TAXELS
    of_presses = _medians(bends, seen, told)
    halves = [_of_all(of_presses[k::2], told[k::2], _FEWEST_HERE) for k in (0, 1)]
    whole = _of_all(of_presses, told, _FEWEST_HERE)
    common = np.isfinite(halves[0]) & np.isfinite(halves[1])
    if np.count_nonzero(common) < _FEWEST_LINES - 2:
        return None
    one, other = (_without_form(half[common], np.flatnonzero(common)) for half in halves)
    alike, each = float(np.mean(one * other)), float(np.mean(one**2 + other**2) / 2)
    variance = alike / _OF_DIFFERENCE
    if alike < _AGREEMENT * each or variance < _LEAST**2:
        return None
    known = np.flatnonzero(np.isfinite(whole))
    difference = np.zeros((known.size, n_lines))
    for k, line in enumerate(known):
        difference[k, line : line + 3] = -0.5, 1.0, -0.5
    difference = _without_form(difference, known)
    # Half of how far two halves differ is what noise leaves of the whole; of few presses more.
    n_presses = np.count_nonzero(told, axis=0)
    noise = max(float(np.mean((one - other) ** 2)) / 4, _LEAST_NOISE**2)
    weight = n_presses[known] / (noise * np.median(n_presses[common]))
    left = difference.T @ (weight[:, None] * difference) + np.eye(n_lines) / variance
    found: Floats = np.linalg.solve(left, difference.T @ (weight * _without_form(whole[known], known)))
    return found - float(np.median(found))


def _of_all(of_presses: Floats, told: Mask, fewest: int) -> Floats:
    """Return the median of all presses of each line; NaN where too few press it."""
    return _medians(of_presses.T, told.T, np.count_nonzero(told, axis=0) >= fewest)


def _without_form(values: Floats, places: NDArray[np.intp]) -> Floats:
    """Return what is left of values of some lines, along the first axis, when what bends slowly is taken off."""
    basis, _ = np.linalg.qr(np.vander(places - places.mean(), _FORM + 1))
    left: Floats = values - basis @ (basis.T @ values)
    return left


def _medians(values: Floats, seen: Mask, told: Mask) -> Floats:
    """Return the median of those values of the last axis that are seen; NaN where that tells nothing."""
    last = np.where(seen, values, np.inf)
    last.sort(axis=-1)
    n = np.maximum(np.count_nonzero(seen, axis=-1), 1)
    low = np.take_along_axis(last, ((n - 1) // 2)[..., None], axis=-1)[..., 0]
    high = np.take_along_axis(last, (n // 2)[..., None], axis=-1)[..., 0]
    return np.where(told, (low + high) / 2, np.nan)
