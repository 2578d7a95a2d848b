"""A pad that only goes up and down as a whole and never rests: a press all over, or a rest that drifts."""

from __future__ import annotations

import math

import numpy as np

from varishold.frame.fault import Frames, Mask, pieces_at
from varishold.frame.noise import MEDIAN_ABS_NORMAL, OF_MEDIAN
from varishold.frame.spread import spread_over
from varishold.frame.together import LARGEST_SHARE

__all__ = ["SWAYS", "sways"]

#: What is to be known of such a pad.
SWAYS = "all taxels go up and down together and never rest: a press all over, or a rest that drifts"

_FEWEST_FRAMES, _FEWEST_TAXELS = 24, 16
# Frames and taxels that are looked at.
_LOOKED_AT, _MOST_TAXELS = 512, 256
# So many taxels that stand out of what all do as far as that goes, in more than one frame, show the rest beside them.
_STANDS_OUT, _MANY = 1.0, 3
# A pad rests where it stays for this share of the frames at one level below the middle of its way, to within so many
# standard errors and this share of the way, as a press begins. A wave that turns is there for less than a tenth.
_RESTS, _ERRORS, _LEVEL, _MIDDLE = 0.15, 4.0, 0.02, 0.5


def sways(frames: Frames, usable: Mask) -> bool:
    """Tell whether all that a pad shows is its taxels going up and down together, without any rest between.

    Parameters
    ----------
    frames : ndarray of shape (n_frames, rows, cols), or what gives slices of it
    usable : ndarray of shape (rows, cols), bool

    Examples
    --------
    >>> frames = np.random.default_rng(0).normal(0, 1, (200, 8, 8))
    >>> way = np.linspace(0, 100, 200)[:, None, None]
    >>> works = np.ones((8, 8), bool)
    >>> sways(frames, works), sways(frames + way, works), sways(frames + np.maximum(way - 20, 0), works)
    (False, True, False)
    """
    n_frames, places = frames.shape[0], np.flatnonzero(usable)
    if n_frames < _FEWEST_FRAMES or places.size < _FEWEST_TAXELS:
        return False
    some = places[spread_over(places.size, _MOST_TAXELS)]
    numbers = spread_over(n_frames, _LOOKED_AT)
    off = np.empty((numbers.size, some.size))
    for k, one in enumerate(pieces_at(frames, numbers.tolist())):
        off[k] = one.reshape(-1)[some]
    off -= np.median(off, axis=0)
    together = np.median(off, axis=1)
    way = float(np.ptp(together))
    if not way > 0.0:
        return False
    # From here on in parts of the way: squares of the smallest numbers are nothing.
    off, together = off / way, together / way
    goes = together - together.mean()
    share = np.clip(goes @ off / (goes @ goes), 0.0, LARGEST_SHARE)
    off -= together[:, None] * share
    noise = OF_MEDIAN * float(np.median(np.abs(off))) / (MEDIAN_ABS_NORMAL * math.sqrt(some.size))
    highest = np.partition(off, -_MANY, axis=1)[:, -_MANY]
    if 2.0 * _ERRORS * noise >= 1.0 or np.partition(highest, -2)[-2] >= _STANDS_OUT:
        return False
    low = np.sort(together[together <= together.min() + _MIDDLE])
    level = _LEVEL + _ERRORS * noise
    at_one_level = np.searchsorted(low, low + level, side="right") - np.arange(low.size)
    return bool(at_one_level.max() < _RESTS * numbers.size)
