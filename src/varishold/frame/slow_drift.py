"""A rest that drifts all through a recording."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

__all__ = ["slow_drift"]

# Parts of a recording, frames that are looked at in each, and how many there must be.
_PARTS, _LOOKED_AT, _FEWEST = 4, 32, 8
# From part to part the rest moves by this share of its whole way at least, or it is no drift but a press.
_STEADY = 0.12
# Drift is worth a word from this share of all that is read on.
_WORTH = 0.1


def slow_drift(frames: NDArray[Any], usable: NDArray[np.bool_]) -> tuple[float, float] | None:
    """Return how far the rest of most taxels moves, evenly, from the first to the last part of a recording.

    Parameters
    ----------
    frames : ndarray of shape (n_frames, rows, cols)
        May be mapped; some are read.
    usable : ndarray of shape (rows, cols), bool

    Returns
    -------
    drift, share : float
        In the unit of the frames, and of all that is read; None where there is none that is worth a word.
    """
    n = len(frames)
    if n < _PARTS * _FEWEST:
        return None
    bounds = np.linspace(0, n, _PARTS + 1).astype(int)
    looked = [np.unique(np.linspace(a, b - 1, _LOOKED_AT).astype(int)) for a, b in pairwise(bounds.tolist())]
    seen = [np.array([frames[k][usable] for k in some], dtype=np.float64) for some in looked]
    # The median taxel feels no press that covers less than half of the pad, and the lowest frame of a part no other.
    rest = np.array([np.median(part, axis=1).min() for part in seen])
    drift = float(rest[-1] - rest[0])
    span = max(float(part.max()) for part in seen) - min(float(part.min()) for part in seen)
    if not np.isfinite(drift) or not span > 0 or abs(drift) < _WORTH * span:
        return None
    steps = np.diff(rest) / drift
    return (drift, abs(drift) / span) if (steps >= _STEADY).all() else None
