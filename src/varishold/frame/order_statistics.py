"""Medians and quantiles of more numbers than anybody wants to sort at once: what they are given comes in pieces."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator

import numpy as np
from numpy.typing import NDArray

__all__ = ["Pieces", "median_of", "nearest_of", "pieces_of", "quantile_of"]

#: Gives the same numbers, finite float64, each time it is called.
Pieces = Callable[[], Iterator[NDArray[np.float64]]]

# So many numbers are looked at together; fewer are sorted as they are.
_TOGETHER = 1 << 20


def pieces_of(values: NDArray[np.float64]) -> Pieces:
    """Return an array in pieces."""
    return lambda: (values[start : start + _TOGETHER] for start in range(0, len(values), _TOGETHER))


def median_of(pieces: Pieces) -> float:
    """Return the median, as `numpy.median` would of all together; NaN of none.

    Examples
    --------
    >>> median_of(pieces_of(np.array([3.0, 1.0, 2.0, 10.0])))
    2.5
    """
    n = sum(len(piece) for piece in pieces())
    return float(np.median(_neighbours(pieces, n, (n - 1) // 2, n // 2))) if n else math.nan


def quantile_of(pieces: Pieces, share: float) -> float:
    """Return a quantile, as `numpy.quantile` would of all together; NaN of none.

    Examples
    --------
    >>> quantile_of(pieces_of(np.arange(11.0)), 0.25)
    2.5
    """
    n = sum(len(piece) for piece in pieces())
    if not n:
        return math.nan
    place = (n - 1) * share
    low = math.floor(place)
    return float(np.quantile(_neighbours(pieces, n, low, min(low + 1, n - 1)), place - low))


def nearest_of(pieces: Pieces, value: float) -> int:
    """Return the place of the first number that is nearest to a value.

    Examples
    --------
    >>> nearest_of(pieces_of(np.array([5.0, 1.0, 3.0])), 2.0)
    1
    """
    place, distance, start = 0, np.inf, 0
    for piece in pieces():
        away = np.abs(piece - value)
        if away.size and away.min() < distance:
            place, distance = start + int(away.argmin()), float(away.min())
        start += len(piece)
    return place


def _neighbours(pieces: Pieces, n: int, low: int, high: int) -> list[float]:
    """Return the numbers of two ranks that follow one another, or are the same."""
    if n <= _TOGETHER:
        ordered = np.sort(np.concatenate(list(pieces())))
        return [float(ordered[low]), float(ordered[high])]
    below = _ranked(pieces, low)
    if high == low or _count(pieces, below) > high:
        return [below, below]
    return [below, min(float(piece[piece > below].min()) for piece in pieces() if (piece > below).any())]


def _ranked(pieces: Pieces, rank: int) -> float:
    """Return the number that so many are not above, by halving what it may be: its bits, in the numbers' order."""
    least = _order_of(min(float(piece.min()) for piece in pieces() if piece.size))
    most = _order_of(max(float(piece.max()) for piece in pieces() if piece.size))
    while least < most:
        middle = (least + most) // 2
        if _count(pieces, _number_of(middle)) > rank:
            most = middle
        else:
            least = middle + 1
    return _number_of(least)


def _count(pieces: Pieces, limit: float) -> int:
    return sum(int(np.count_nonzero(piece <= limit)) for piece in pieces())


def _order_of(number: float) -> int:
    """Return the place of a number among all floats; neighbours' places differ by one."""
    bits = int(np.float64(number + 0.0).view(np.int64))
    return bits if bits >= 0 else -(bits & 0x7FFF_FFFF_FFFF_FFFF)


def _number_of(order: int) -> float:
    number = float(np.int64(abs(order)).view(np.float64))
    return number if order >= 0 else -number
