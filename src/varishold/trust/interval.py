"""How far a share may be off, by how often it was counted."""

from __future__ import annotations

import math

__all__ = ["share_interval"]

# Of a standard normal number 95 % lie within this.
_Z = 1.959963984540054


def share_interval(counted: int, total: int) -> tuple[float, float]:
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


def _low(counted: int, total: int) -> float:
    share, spare = counted / total, _Z * _Z / total
    half = math.sqrt(share * (1 - share) * spare + spare * spare / 4)
    return max((share + spare / 2 - half) / (1 + spare), 0.0)
