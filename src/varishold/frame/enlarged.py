"""Frames that were enlarged: every taxel stands many times, side by side, as in a picture of few large squares."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from varishold.frame.fault import Frames, pieces_at
from varishold.frame.spread import spread_over

__all__ = ["enlargement"]

# Frames that are looked at, and borders between unlike lines that tell how far they are apart.
_LOOKED_AT, _FEWEST_BORDERS = 32, 6


def enlargement(frames: Frames) -> tuple[int, int]:
    """Return how many rows and columns show each taxel: (1, 1) where each shows one.

    Parameters
    ----------
    frames : ndarray of shape (n_frames, rows, cols), or what gives slices of it

    Examples
    --------
    >>> frames = np.random.default_rng(0).normal(0, 1, (5, 8, 9))
    >>> enlargement(np.kron(frames, np.ones((1, 3, 2)))), enlargement(frames)
    ((3, 2), (1, 1))
    """
    n_frames, rows, cols = frames.shape
    unlike = [np.zeros(rows - 1, np.bool_), np.zeros(cols - 1, np.bool_)]
    for (frame,) in pieces_at(frames, spread_over(n_frames, _LOOKED_AT).tolist()):
        unlike[0] |= _unlike(frame)
        unlike[1] |= _unlike(frame.T)
        if all(_times(each) == 1 for each in unlike):
            break
    return _times(unlike[0]), _times(unlike[1])


def _unlike(lines: NDArray[Any]) -> NDArray[np.bool_]:
    """Return which lines are another than the next; what is no number is like itself."""
    differs = lines[1:] != lines[:-1]
    if lines.dtype.kind == "f":
        differs &= ~(np.isnan(lines[1:]) & np.isnan(lines[:-1]))
    found: NDArray[np.bool_] = differs.any(axis=1)
    return found


def _times(unlike: NDArray[np.bool_]) -> int:
    """Return how many lines always stand together, where enough borders tell it."""
    borders = np.flatnonzero(unlike) + 1
    return math.gcd(len(unlike) + 1, *borders.tolist()) if borders.size >= _FEWEST_BORDERS else 1
