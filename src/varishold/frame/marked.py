"""Readings that are none: one number far beyond all others stands where a taxel could not be read for a moment."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from varishold._counted import counted
from varishold.frame.fault import Floats, Frames, Mask, blocks_of, pieces_at, starts_over
from varishold.frame.neighbours import largest_around

__all__ = ["Marked", "marked_readings"]

# Frames that there must be, and at how many places so many on end are looked at.
_FEWEST, _SAMPLED, _PLACES = 8, 64, 4
# It stands so many times as far from the rest as everything else, which goes beyond so many sigma of the noise: so
# something presses, and not so hard.
_BEYOND, _SIGMAS = 3.0, 12.0
# It is seen so often at least, in so large a part of a taxel's readings at most, and mostly without itself on the
# taxels around: what presses so hard would be felt there too.
_FEWEST_TIMES, _SELDOM, _ALONE = 2, 0.25, 0.7
# Frames before and after that tell what a taxel reads.
_BESIDE = 2


@dataclass(frozen=True, eq=False)
class Marked:
    """Readings that are none, and are as those beside them in time.

    Parameters
    ----------
    frames : Frames
        All of a recording, shape (n_frames, rows, cols).
    seldom : ndarray of shape (rows, cols), bool
        Taxels that are read most of the time.
    mark : float
        The number that stands for no reading.
    rest : ndarray of shape (rows, cols), float64
        What is taken where none is near in time.
    """

    frames: Frames
    seldom: Mask
    mark: float
    rest: Floats

    def mended(self, first: int, last: int) -> NDArray[Any]:
        """Return frames first to last - 1; what is no reading has the median of those beside it in time."""
        start = max(first - _BESIDE, 0)
        read = np.asarray(self.frames[start : last + _BESIDE])
        made = read[first - start : last - start]
        none = (read == self.mark) & self.seldom
        if not none[first - start : last - start].any():
            return made
        made = made.copy()
        for k, row, col in np.argwhere(none[first - start : last - start]).tolist():
            near = np.s_[max(k + first - start - _BESIDE, 0) : k + first - start + _BESIDE + 1, row, col]
            beside = read[near][~none[near]]
            value = np.median(beside) if beside.size else self.rest[row, col]
            made[k, row, col] = np.rint(value) if made.dtype.kind in "iu" else value
        return made

    def words(self) -> tuple[str, ...]:
        """Return how many readings are none, in words."""
        n = sum(int(np.count_nonzero((block == self.mark) & self.seldom)) for _, block in blocks_of(self.frames))
        them = counted(n, f"reading is exactly {self.mark:g}", f"readings are exactly {self.mark:g}")
        return (f"{them}, alone and far beyond all others: taken for none, and as those beside in time",)


def marked_readings(frames: Frames, usable: Mask) -> Marked | None:
    """Return which readings of a recording are none; None where all are some.

    Parameters
    ----------
    frames : ndarray of shape (n_frames, rows, cols), or what gives slices of it
    usable : ndarray of shape (rows, cols), bool

    Examples
    --------
    >>> frames = np.random.default_rng(0).normal(0, 1, (40, 8, 8))
    >>> frames[10:30, 2:6, 2:6] += 100.0
    >>> frames[[12, 13, 33], [3, 3, 0], [4, 4, 7]] = 65535.0
    >>> found = marked_readings(frames, np.ones((8, 8), bool))
    >>> found.words()[0][:32], bool(found.mended(0, 40).max() < 110)
    ('3 readings are exactly 65535, al', True)
    """
    n_frames = frames.shape[0]
    if n_frames < _FEWEST or not usable.any():
        return None
    seen = np.concatenate(list(pieces_at(frames, starts_over(n_frames, _SAMPLED, _PLACES), _SAMPLED)))
    readings = seen[:, usable]
    for mark in (float(readings.max()), float(readings.min())):
        none = (seen == mark) & usable
        seldom: Mask = usable & (none.mean(axis=0) <= _SELDOM)
        none &= seldom
        if np.count_nonzero(none) < _FEWEST_TIMES:
            continue
        alone = [largest_around(one.astype(np.float64))[one] == 0.0 for one in none if one.any()]
        if np.concatenate(alone).mean() < _ALONE:
            continue
        rest = np.median(seen, axis=0)
        away = np.abs(seen - rest)
        far = float(away[~none & seldom].max(initial=0.0))
        least = _SIGMAS * float(np.median(np.abs(np.diff(readings.astype(np.float64), axis=0))))
        if far > least and float(away[none].min()) >= _BEYOND * far:
            return Marked(frames, seldom, mark, np.where(usable, rest, 0.0))
    return None
