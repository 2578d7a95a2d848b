"""Whether times can be seconds."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

__all__ = ["no_seconds"]

# The calendar in other units, by where it begins: 1.7e12, 1.7e15 and 1.7e18 are of our days. 1e11 s is the year 5138.
_CALENDARS = ((1e17, "nanoseconds"), (1e14, "microseconds"), (1e11, "milliseconds"))
# Frames that are farther apart, or nearer, are no recording of touch, seconds: 20 ms are 2.3e-7 days.
_FARTHEST_S, _NEAREST_S = 1000.0, 1e-5


def no_seconds(time_s: NDArray[np.float64]) -> list[str]:
    """Say where times are hardly seconds: far behind our days, hours apart, or some microseconds.

    Parameters
    ----------
    time_s : ndarray of shape (n_frames,), float64

    Examples
    --------
    >>> no_seconds(np.array([1.7e18, 1.7e18 + 1e7]))
    ['time begins at 1.7e+18 s: is it in nanoseconds?']
    >>> no_seconds(np.array([0.0, 1e4])), no_seconds(np.array([1.7e9, 1.7e9 + 60]))
    (['frames are 1e+04 s apart: is the time in seconds?'], [])
    >>> no_seconds(np.arange(3) * 0.02 / 86400)
    ['frames are 2.315e-07 s apart: is the time in seconds?']
    """
    begin = float(time_s[0]) if time_s.size else 0.0
    for calendar, unit in _CALENDARS:
        if begin >= calendar:
            return [f"time begins at {begin:.4g} s: is it in {unit}?"]
    apart = float(np.median(np.diff(time_s))) if time_s.size > 1 else 0.0
    return (
        [f"frames are {apart:.4g} s apart: is the time in seconds?"]
        if apart > _FARTHEST_S or 0.0 < apart < _NEAREST_S
        else []
    )
