"""Intervals of shares and of means over repetitions."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

__all__ = ["mean_interval", "share_interval"]

_CONFIDENCE = 0.95


def share_interval(right: int, total: int) -> tuple[float, float]:
    """Return Wilson's 95 % interval of a share; all of 0 to 1 where nothing was counted.

    Examples
    --------
    >>> [round(bound, 3) for bound in share_interval(40, 40)]
    [0.912, 1.0]
    """
    if total == 0:
        return 0.0, 1.0
    from scipy.stats import binomtest

    found = binomtest(right, total).proportion_ci(_CONFIDENCE, method="wilson")
    return float(found.low), float(found.high)


def mean_interval(percent: NDArray[np.float64]) -> tuple[float, float, float]:
    """Return the mean of percentages and its 95 % interval (Student), within 0 and 100; NaN bounds for a single one.

    Examples
    --------
    >>> [round(bound, 1) for bound in mean_interval(np.array([97.0, 100.0]))]
    [98.5, 79.4, 100.0]
    """
    mean = float(percent.mean())
    if percent.size < 2:
        return mean, float("nan"), float("nan")
    from scipy.stats import t

    half = float(t.ppf((1 + _CONFIDENCE) / 2, percent.size - 1) * percent.std(ddof=1) / np.sqrt(percent.size))
    return mean, max(0.0, mean - half), min(100.0, mean + half)
