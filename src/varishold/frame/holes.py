"""Readings of 0 where a depth camera saw nothing."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from varishold.frame.spread import spread_over

__all__ = ["hole_share"]

# So many frames are looked at.
_LOOKED_AT = 16
# Holes are few, and what is seen is nowhere as low as this share of what is usually seen.
_MOST, _FAR = 0.3, 0.5


def hole_share(frames: NDArray[Any], usable: NDArray[np.bool_]) -> float:
    """Return which share of readings are holes: exactly 0, far below all others; 0 where there are none.

    Parameters
    ----------
    frames : ndarray of shape (n_frames, rows, cols)
        As they came, of a sensor whose readings fall under pressure. May be mapped; some are read.
    usable : ndarray of shape (rows, cols), bool
    """
    chosen = spread_over(len(frames), _LOOKED_AT)
    seen = np.concatenate([np.asarray(frames[k])[usable] for k in chosen])
    zero = seen == 0
    share = float(zero.mean())
    if not 0 < share <= _MOST:
        return 0.0
    others = seen[~zero]
    return share if float(others.min()) > _FAR * float(np.median(others)) > 0 else 0.0
