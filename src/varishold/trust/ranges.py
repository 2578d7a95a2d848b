"""Ranges of what was learned, and how far beyond them a number lies."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

__all__ = ["Ranges", "held_out_beyond", "learn_ranges"]

Floats = NDArray[np.float64]

# In parts of the range.
_MOST_BEYOND = 1e90


@dataclass(frozen=True, eq=False)
class Ranges:
    """The least and the largest that was seen of each number, shape (n_numbers,); inf and -inf of one never seen."""

    low: Floats
    high: Floats

    def beyond(self, values: ArrayLike) -> Floats:
        """Return how far beyond its range each number lies, in parts of the range.

        Parameters
        ----------
        values : array_like of shape (n, n_numbers)
            NaN where unknown.

        Returns
        -------
        ndarray of shape (n, n_numbers), float64
            0 within, and where nothing is known of the value or of the number. What never varied is one range beyond
            wherever it differs.

        Examples
        --------
        >>> learn_ranges([[0.0, 5.0], [2.0, 5.0]]).beyond([[1.0, 5.0], [3.0, 5.1]]).tolist()
        [[0.0, 0.0], [0.5, 1.0]]
        """
        return _beyond(np.asarray(values, dtype=np.float64), self.low, self.high)


def learn_ranges(values: ArrayLike) -> Ranges:
    """Return the range of each number in `values` of shape (n, n_numbers), NaN where unknown."""
    low, high = _ends(np.asarray(values, dtype=np.float64))
    return Ranges(low.min(axis=0, initial=np.inf), high.max(axis=0, initial=-np.inf))


def held_out_beyond(values: ArrayLike, groups: ArrayLike | None = None) -> Floats:
    """Return how far each number lies beyond the range of the other groups' rows: what known things reach.

    Parameters
    ----------
    values : array_like of shape (n, n_numbers)
        NaN where unknown.
    groups : array_like of shape (n,), optional
        What is held out together; default: every row alone.

    Returns
    -------
    ndarray of shape (n, n_numbers), float64
        As `Ranges.beyond`.

    Examples
    --------
    >>> held_out_beyond([[0.0], [1.0], [4.0]]).tolist()
    [[0.3333333333333333], [0.0], [3.0]]
    """
    given = np.asarray(values, dtype=np.float64)
    of = np.arange(len(given)) if groups is None else np.unique(np.asarray(groups), return_inverse=True)[1]
    low, high = _ends(given)
    return _beyond(given, _least_of_others(low, of), -_least_of_others(-high, of))


def _ends(values: Floats) -> tuple[Floats, Floats]:
    known = np.isfinite(values)
    return np.where(known, values, np.inf), np.where(known, values, -np.inf)


def _least_of_others(values: Floats, groups: NDArray[np.integer]) -> Floats:
    """Return for every row the least of each number in the other groups, shape (n, n_numbers)."""
    least = np.full((int(groups.max(initial=-1)) + 2, values.shape[1]), np.inf)
    np.minimum.at(least, groups, values)
    first, columns = least.argmin(axis=0), np.arange(values.shape[1])
    lowest = least[first, columns]
    least[first, columns] = np.inf
    return np.asarray(np.where(groups[:, None] == first, least.min(axis=0), lowest))


def _beyond(values: Floats, low: Floats, high: Floats) -> Floats:
    told = np.isfinite(values) & (low <= high)
    with np.errstate(over="ignore", invalid="ignore"):
        off = np.where(told, np.maximum(np.maximum(low - values, values - high), 0.0), 0.0)
        span = np.where(told & (high > low), high - low, 1.0)
        # Numbers so far apart that sums over many of them would be infinite are as far beyond as can be told.
        parts = np.minimum(np.nan_to_num(off / span), _MOST_BEYOND)
    return np.asarray(np.where(told & (high == low), off > 0, parts), dtype=np.float64)
