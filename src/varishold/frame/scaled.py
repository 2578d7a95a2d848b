"""Frames of which each was scaled to its own largest reading: what presses lightly looks like the rest."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

__all__ = ["scaled_words"]

# Frames that there must be.
_FEWEST = 12
# Nearly all have the same largest reading, most in so few taxels, at so many places: neither saturated nor stuck.
_ALIKE, _TAXELS, _PLACES = 0.9, 2, 4
# What is equal but for rounding.
_ROUNDING = 1e-6


def scaled_words(frames: NDArray[Any], usable: NDArray[np.bool_]) -> tuple[str, ...]:
    """Say that each frame seems to be scaled to its own largest reading; nothing where it does not.

    Parameters
    ----------
    frames : ndarray of shape (n_frames, rows, cols)
        Some of a recording.
    usable : ndarray of shape (rows, cols), bool

    Examples
    --------
    >>> frames = np.random.default_rng(0).normal(10, 1, (40, 8, 8))
    >>> scaled_words(frames, np.ones((8, 8), bool))
    ()
    >>> scaled = frames / frames.max(axis=(1, 2), keepdims=True)
    >>> scaled_words(scaled, np.ones((8, 8), bool))[0][:55]
    'each frame seems to be scaled to its own largest readin'
    """
    if len(frames) < _FEWEST:
        return ()
    seen = frames[:, usable].astype(np.float64)
    highest = seen.max(axis=1)
    usual = float(np.median(highest))
    alike = np.abs(highest - usual) <= _ROUNDING * abs(usual)
    few = np.count_nonzero(seen == highest[:, None], axis=1) <= _TAXELS
    places = np.unique(seen.argmax(axis=1)[alike & few])
    if np.ptp(seen) == 0.0 or alike.mean() < _ALIKE or few.mean() <= 0.5 or places.size < _PLACES:
        return ()
    return (
        f"each frame seems to be scaled to its own largest reading, {usual:g}: loads cannot be told, and noise looks "
        "like a press; give the readings as they come",
    )
