"""One frame that was smoothed, interpolated or stored as a lossy picture: taxels share their noise beside a contact."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from varishold.frame.neighbours import three_by_three

__all__ = ["frame_is_smoothed"]

# A quarter of a frame's taxels and more are at the level from which something stands out, by this share of the highest.
_LEVEL, _STANDS_OUT = 0.25, 0.1
# Differences of four taxels that there must be, and how small most are where there is no noise, in shares of the
# highest.
_FEWEST, _NO_NOISE = 16, 1e-4
# What is farther from zero than so many times the median is a rim.
_FAR = 4.5
# Of noise that taxels have for themselves, differences side by side go against each other by half; where neighbours
# share .3 of it, as `quiet.is_smoothed` asks, as a Gaussian of .46 taxels makes it, by .29. So many standard errors are
# chance: the product of n differences of noise has one of .87 / sqrt(n).
_ITS_OWN, _MORE, _CHANCE = -0.5, 0.21, 2.0


def frame_is_smoothed(frame: NDArray[Any], usable: NDArray[np.bool_]) -> bool:
    """Tell whether a single frame's taxels share their noise, as smoothed and interpolated ones do.

    It is read beside what stands out, from differences of four taxels in a square: of these slopes are none, nor what
    rows or columns share. Taxels that have noise for themselves make neighbouring ones go against each other.

    Parameters
    ----------
    frame : ndarray of shape (rows, cols), integer or float
    usable : ndarray of shape (rows, cols), bool
        What is not usable counts as nothing.

    Returns
    -------
    bool
        False too where too few taxels show noise and nothing else.

    Examples
    --------
    >>> frame, all_of_them = np.random.default_rng(0).normal(0, 1, (17, 17)), np.ones((16, 16), bool)
    >>> frame[5:9, 4:9] += 100.0
    >>> mean = (frame[1:, 1:] + frame[1:, :-1] + frame[:-1, 1:] + frame[:-1, :-1]) / 4
    >>> frame_is_smoothed(frame[1:, 1:], all_of_them), frame_is_smoothed(mean, all_of_them)
    (False, True)
    """
    if min(frame.shape) < 3 or not usable.any():
        return False
    values = np.where(usable, frame, 0.0).astype(np.float64)
    level = float(np.quantile(values[usable], _LEVEL))
    highest = float(values[usable].max()) - level
    near = (values > level + _STANDS_OUT * highest) | ~usable
    beside = ~np.any(three_by_three(near, off_pad=False), axis=0)
    square = beside[1:, 1:] & beside[1:, :-1] & beside[:-1, 1:] & beside[:-1, :-1]
    change = values[1:, 1:] - values[1:, :-1] - values[:-1, 1:] + values[:-1, :-1]
    usual = float(np.median(np.abs(change[square]))) if square.any() else 0.0
    # Where most show nothing, what is left beside a contact is its rim.
    if usual <= _NO_NOISE * highest:
        return False
    np.clip(change, -_FAR * usual, _FAR * usual, out=change)
    return min(_excess(change, square), _excess(change.T, square.T)) > 0.0


def _excess(change: NDArray[np.float64], where: NDArray[np.bool_]) -> float:
    """Return how much more than chance allows differences go with those to their right, instead of against them."""
    both = where[:, 1:] & where[:, :-1]
    one, other = change[:, 1:][both], change[:, :-1][both]
    power = math.sqrt(float(one @ one) * float(other @ other))
    if power == 0.0 or np.count_nonzero(one) < _FEWEST:
        return -1.0
    return float(one @ other) / power - _ITS_OWN - max(_MORE, _CHANCE / math.sqrt(one.size))
