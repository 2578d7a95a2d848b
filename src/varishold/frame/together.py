"""What all taxels of a pad do together: how far each goes with the others, and readings without it."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from varishold.frame.fault import Floats, in_type
from varishold.frame.health import FULL_SCALES

__all__ = ["LARGEST_SHARE", "readings_end", "shares_of", "taken_off", "without_it"]

#: No taxel goes so many times as far as all do, nor the other way.
LARGEST_SHARE = 2.0
# Before anything is known of a taxel's share it is 1, to within so much.
_SHARE_SPREAD = 0.3
# A value that so many readings have exactly, none higher, is where readings end.
_FEWEST_AT_END = 3
# Multiples of it, less their whole part, are spread evenly from 0 to 1, however many they are.
_GOLDEN = (math.sqrt(5.0) - 1.0) / 2.0


def shares_of(readings: Floats, together: Floats, noise: float) -> Floats:
    """Return how far each taxel goes where all go by 1; 1 where all stay.

    A share is known from the frames as well as they tell it, and before them to so much.

    Parameters
    ----------
    readings : ndarray of shape (n_frames, n_taxels), float64
        In which nothing presses.
    together : ndarray of shape (n_frames,), float64
        How far all are off in each frame.
    noise : float
        Standard deviation of one taxel's noise.
    """
    goes = together - together.mean()
    told = float(goes @ goes)
    if not told > 0.0:
        return np.ones(readings.shape[1])
    found = np.clip(goes @ readings / told, 0.0, LARGEST_SHARE)
    return np.asarray(1.0 + (found - 1.0) * told / (told + (noise / _SHARE_SPREAD) ** 2))


def without_it(read: NDArray[Any], together: Floats, share: Floats, ends_at: float) -> NDArray[Any]:
    """Return frames without what all taxels do together, in their own type.

    Parameters
    ----------
    read : ndarray of shape (n_frames, rows, cols)
    together : ndarray of shape (n_frames,), float64
    share : ndarray of shape (rows, cols), float64
        How far each taxel goes where all go by 1; one of share 0 stays as it is.
    ends_at : float
        The value at which readings end; they stay there.
    """
    return taken_off(read, together[:, None, None] * share, ends_at)


def taken_off(read: NDArray[Any], off: Floats, ends_at: float) -> NDArray[Any]:
    """Return frames less how far each reading is off, in their own type; what is off by 0 stays as it is.

    Parameters
    ----------
    read, off : ndarray of shape (n_frames, rows, cols)
    ends_at : float
        The value at which readings end; they stay there.
    """
    left = read - off
    if read.dtype.kind in "iu":
        # What all do together has one fraction: rounded alike in all taxels it would stay in their mean.
        left = np.floor(left + _uneven(read.shape[1:]))
    return np.where((off == 0.0) | (read >= ends_at), read, in_type(left, read.dtype))


def _uneven(shape: tuple[int, ...]) -> Floats:
    """Return a number from 0 to 1 a taxel, of which neighbours' are far apart and the mean is a half."""
    return np.asarray(np.arange(1, math.prod(shape) + 1) * _GOLDEN % 1.0).reshape(shape)


def readings_end(readings: Floats, kind: str) -> float:
    """Return the value at which readings of a kind of number end; infinite where they seem not to."""
    highest = float(readings.max())
    if kind in "iu":
        return highest if int(highest) in FULL_SCALES else math.inf
    return highest if np.count_nonzero(readings == highest) >= _FEWEST_AT_END else math.inf
