"""A figure with its interval: over groups where there are enough of them, over presses where there are not."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from varishold.trust import difference_interval, share_interval
from varishold.trust.interval import NORMAL

__all__ = ["FEWEST_GROUPS", "Figure", "difference_figure", "mean_figure", "overstated_figure", "share_figure"]

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

    The interval is Wilson's. Over three groups or more it is that of so many presses as tell as much: the fewer, the
    more groups differ and the fewer there are. Student's would be too narrow near 0 and 1, where groups that do badly
    are rare and seldom among those that were seen.

    Parameters
    ----------
    counted : array_like of shape (n,), bool
        At least one.
    groups : ndarray of shape (n,), optional

    References
    ----------
    E. Korn and B. Graubard, "Confidence intervals for proportions with small expected number of positive counts
    estimated from survey data", Survey Methodology 24 (1998) 193-201.
    W. Cochran, "Sampling Techniques", 1977, chapter 9: ratio estimates from clusters of unequal sizes.

    Examples
    --------
    >>> groups = np.repeat(["mon", "tue", "wed", "thu"], 20)
    >>> for found in (share_figure(np.ones(80)), share_figure(np.ones(80), groups)):
    ...     print(round(found.low, 2), round(found.high, 2), found.over)
    0.95 1.0 presses
    0.89 1.0 groups
    """
    values = np.asarray(counted, dtype=np.float64)
    over, n_groups, variance = _over_groups(values, groups)
    mean, telling = float(values.mean()), float(values.size)
    if over == "groups":
        by_chance = mean * (1 - mean) / values.size
        telling *= min(1.0, by_chance / variance if variance else 1.0) * (NORMAL / _student(n_groups)) ** 2
    low, high = share_interval(mean * telling, telling)
    return Figure(mean, low, high, over, values.size, n_groups)


def mean_figure(values: ArrayLike, groups: NDArray[Any] | None = None) -> Figure:
    """Return the mean of a number a press; the interval is Student's, over groups or over presses."""
    numbers = np.asarray(values, dtype=np.float64)
    mean = float(numbers.mean())
    over, n_groups, variance = _over_groups(numbers, groups)
    if numbers.size < 2:
        return Figure(mean, None, None, None, numbers.size, n_groups)
    half = _student(n_groups if over == "groups" else numbers.size) * math.sqrt(variance)
    return Figure(mean, mean - half, mean + half, over, numbers.size, n_groups)


def difference_figure(mine: ArrayLike, other: ArrayLike, groups: NDArray[Any] | None = None) -> Figure:
    """Return how much larger the share of one answerer is than another's on the same presses.

    The interval is Student's, over groups or over presses; it is never narrower than Tango's over presses, which stands
    where few presses, or none, were answered differently.

    Parameters
    ----------
    mine, other : array_like of shape (n,), bool
        Which presses each answered rightly; at least one.
    groups : ndarray of shape (n,), optional
    """
    right, others = (np.asarray(of, dtype=np.bool_) for of in (mine, other))
    plain = mean_figure(right.astype(np.float64) - others, groups)
    ends = difference_interval(int((right & ~others).sum()), int((others & ~right).sum()), right.size)
    return _as_wide(plain, *ends)


def overstated_figure(top: ArrayLike, right: ArrayLike, groups: NDArray[Any] | None = None) -> Figure:
    """Return by how much the stated probability exceeds the share right.

    The interval is Student's; it is never narrower than that of the share right. Where all answers were right, nothing
    scatters but what was stated, and that tells nothing of errors that are still to come.

    Parameters
    ----------
    top : array_like of shape (n,)
        The probability of each answer.
    right : array_like of shape (n,), bool
    groups : ndarray of shape (n,), optional
    """
    stated, hits = np.asarray(top, dtype=np.float64), np.asarray(right, dtype=np.float64)
    share = share_figure(hits, groups)
    assert share.low is not None
    assert share.high is not None
    mean = float(stated.mean())
    return _as_wide(mean_figure(stated - hits, groups), mean - share.high, mean - share.low)


def _as_wide(figure: Figure, low: float, high: float) -> Figure:
    """Return a figure whose interval reaches at least so far."""
    if figure.low is None or figure.high is None:
        return replace(figure, low=low, high=high, over="presses")
    return replace(figure, low=min(figure.low, low), high=max(figure.high, high))


def _over_groups(values: Floats, groups: NDArray[Any] | None) -> tuple[Literal["groups", "presses"], int, float]:
    """Return what the interval is over, the number of groups, and the variance of the mean over that."""
    n = 0 if groups is None else len(np.unique(groups))
    if groups is None or n < FEWEST_GROUPS:
        return "presses", n, float(values.var(ddof=1)) / values.size if values.size > 1 else 0.0
    codes = np.unique(groups, return_inverse=True)[1]
    sizes = np.bincount(codes).astype(np.float64)
    left = np.bincount(codes, weights=values) - values.mean() * sizes
    return "groups", n, n / (n - 1) * float((left * left).sum()) / float(sizes.sum()) ** 2


def _student(n: int) -> float:
    from scipy.special import stdtrit

    return float(stdtrit(n - 1, (1 + CONFIDENCE) / 2))
