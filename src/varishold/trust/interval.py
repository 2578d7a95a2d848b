"""How far a share, or the difference of two, may be off, by how often each was counted."""

from __future__ import annotations

import math

__all__ = ["NORMAL", "difference_interval", "share_interval"]

#: Of a standard normal number 95 % lie within this.
NORMAL = 1.959963984540054
# An end is halved until it is known to single precision and better.
_HALVINGS = 50


def share_interval(counted: float, total: float) -> tuple[float, float]:
    """Return Wilson's 95 % interval of a share; all of 0 to 1 where nothing was counted.

    References
    ----------
    E. Wilson, "Probable inference, the law of succession, and statistical inference", 1927.

    Examples
    --------
    >>> [round(end, 3) for end in share_interval(40, 40)]
    [0.912, 1.0]
    """
    if total == 0:
        return 0.0, 1.0
    return _low(counted, total), 1.0 - _low(total - counted, total)


def difference_interval(first: int, second: int, total: int) -> tuple[float, float]:
    """Return Tango's 95 % interval of the difference of two shares of the same things; all of -1 to 1 of no things.

    Differences that lie in it are those that McNemar's test, without a correction, would not reject. Where the things
    hold nothing on which the two differ, it is as wide as Wilson's of a share of which nothing was counted.

    Parameters
    ----------
    first, second : int
        Of how many things only the one, and only the other, is true.
    total : int
        How many things there are.

    References
    ----------
    T. Tango, "Equivalence test and confidence interval for the difference in proportions for the paired-sample
    design", Statistics in Medicine 17 (1998) 891-908.

    Examples
    --------
    >>> [round(end, 3) for end in difference_interval(0, 0, 40)]
    [-0.088, 0.088]
    >>> [round(end, 3) for end in difference_interval(9, 2, 44)]
    [0.013, 0.312]
    """
    if total == 0:
        return -1.0, 1.0
    return -_largest_difference(second, first, total), _largest_difference(first, second, total)


def _largest_difference(first: int, second: int, total: int) -> float:
    """Return the largest difference that does not contradict what was counted."""
    low, high = (first - second) / total, 1.0
    for _ in range(_HALVINGS):
        middle = (low + high) / 2
        # The likeliest share of those of which only the other is true, were this the difference.
        b = (2 * total - first + second) * middle - first - second
        likeliest = (math.sqrt(max(b * b + 8 * total * second * middle * (1 - middle), 0.0)) - b) / (4 * total)
        variance = total * max(2 * likeliest + middle * (1 - middle), 0.0)
        if total * middle - (first - second) > NORMAL * math.sqrt(variance):
            high = middle
        else:
            low = middle
    return (low + high) / 2


def _low(counted: float, total: float) -> float:
    share, spare = counted / total, NORMAL * NORMAL / total
    half = math.sqrt(share * (1 - share) * spare + spare * spare / 4)
    return max((share + spare / 2 - half) / (1 + spare), 0.0)
