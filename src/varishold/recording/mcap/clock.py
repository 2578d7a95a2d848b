"""Seconds as floats, and the whole nanoseconds that messages carry."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

__all__ = ["STAMPS_NS", "nanoseconds", "seconds"]

_NS = 10**9
#: Nanoseconds that the stamp of a message can hold: 32 bits of seconds, with a sign.
STAMPS_NS = range(-(2**31) * _NS, 2**31 * _NS)


def nanoseconds(time_s: float) -> int:
    """Return the whole nanosecond next to a time.

    Examples
    --------
    >>> nanoseconds(1.76e9), nanoseconds(-0.25)
    (1760000000000000000, -250000000)
    """
    whole = math.floor(time_s)
    return whole * _NS + round((time_s - whole) * _NS)


def seconds(time_ns: NDArray[np.int64]) -> NDArray[np.float64]:
    """Return the float next to each time; where a float is coarser than a nanosecond, the one that it came from."""
    whole, part = np.divmod(time_ns, _NS)
    return np.where(np.abs(time_ns) < 2**53, time_ns / _NS, whole + part / _NS)
