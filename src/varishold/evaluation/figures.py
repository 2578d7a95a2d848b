"""A figure with its interval: over groups where there are enough of them, over presses where there are not."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from varishold.trust import share_interval

__all__ = ["FEWEST_GROUPS", "Figure", "difference_figure", "mean_figure", "share_figure"]

Floats = NDArray[np.float64]

#: Fewer groups than these give no interval.
FEWEST_GROUPS = 3
CONFIDENCE = 0.95


@dataclass(frozen=True)
class Figure:
    """A number, and where it may lie.

    Parameters
    ----------
    value : float
    low, high : float or None
        Ends of the 95 % interval; None where there is none.
    over : {"groups", "presses"} or None
        What the interval was taken over. Presses of one session are alike, so that over presses it is too narrow.
    n : int
        How many presses were counted.
    n_groups : int
        How many groups they are of; 0 where no groups are known.
    """

    value: float
    low: float | None
    high: float | None
    over: Literal["groups", "presses"] | None
    n: int
    n_groups: int

    def to_dict(self) -> dict[str, Any]:
        """Return what JSON holds."""
        ends = [None if end is None else round(end, 6) for end in (self.low, self.high)]
        value = round(self.value, 6)
        return {
            "value": value,
            "low": ends[0],
            "high": ends[1],
            "interval_over": self.over,
            "n_presses": self.n,
            "n_groups": self.n_groups,
        }


def share_figure(counted: ArrayLike, groups: NDArray[Any] | None = None) -> Figure:
    """Return the share of presses of which something is true.

    Over three groups or more the interval is Student's, of the ratio of sums over groups; it is never narrower than
    Wilson's over presses, which stands alone where there are fewer groups.

    Parameters
    ----------
    counted : array_like of shape (n,), bool
        At least one.
    groups : ndarray of shape (n,), optional

    References
    ----------
    W. Cochran, "Sampling Techniques", 1977, chapter 9: ratio estimates from clusters of unequal sizes.
    """
    values = np.asarray(counted, dtype=np.float64)
    low, high = share_interval(int(values.sum()), values.size)
    over, n_groups, half = _over_groups(values, groups)
    mean = float(values.mean())
    if over == "groups":
        low, high = min(low, max(mean - half, 0.0)), max(high, min(mean + half, 1.0))
    return Figure(mean, low, high, over, values.size, n_groups)


def mean_figure(values: ArrayLike, groups: NDArray[Any] | None = None) -> Figure:
    """Return the mean of a number a press; the interval is Student's, over groups or over presses."""
    numbers = np.asarray(values, dtype=np.float64)
    mean = float(numbers.mean())
    over, n_groups, half = _over_groups(numbers, groups)
    if numbers.size < 2:
        return Figure(mean, None, None, None, numbers.size, n_groups)
    if over == "presses":
        half = _student(numbers.size) * float(numbers.std(ddof=1)) / math.sqrt(numbers.size)
    return Figure(mean, mean - half, mean + half, over, numbers.size, n_groups)


def difference_figure(mine: ArrayLike, other: ArrayLike, groups: NDArray[Any] | None = None) -> Figure:
    """Return how much larger the share of one answerer is than another's on the same presses."""
    return mean_figure(np.asarray(mine, dtype=np.float64) - np.asarray(other, dtype=np.float64), groups)


def _over_groups(values: Floats, groups: NDArray[Any] | None) -> tuple[Literal["groups", "presses"], int, float]:
    """Return what the interval is over, the number of groups, and half the interval over groups."""
    if groups is None:
        return "presses", 0, 0.0
    codes = np.unique(groups, return_inverse=True)[1]
    sizes = np.bincount(codes).astype(np.float64)
    n = len(sizes)
    if n < FEWEST_GROUPS:
        return "presses", n, 0.0
    left = np.bincount(codes, weights=values) - values.mean() * sizes
    variance = n / (n - 1) * float((left * left).sum()) / float(sizes.sum()) ** 2
    return "groups", n, _student(n) * math.sqrt(variance)


def _student(n: int) -> float:
    from scipy.special import stdtrit

    return float(stdtrit(n - 1, (1 + CONFIDENCE) / 2))
