"""Taxels that are far noisier than those beside them, as with a bad joint: not to be believed."""

from __future__ import annotations

import numpy as np

from varishold.frame.fault import Floats, Frames, Mask, pieces_at
from varishold.frame.health import taxels_in_words
from varishold.frame.neighbours import median_around
from varishold.frame.noise import ROUNDING
from varishold.frame.spread import spread_over

__all__ = ["noisy_taxels", "noisy_words"]

_FEWEST_FRAMES, _FEWEST_TAXELS = 24, 16
# Places at which three frames on end are looked at; of a large pad as few as hold so many readings, but some.
_PLACES, _READINGS, _FEWEST_PLACES = 48, 1 << 20, 12
# A taxel is too noisy that scatters so many times as much as those beside it, and as all do, and by this share of what
# is read at most; of noise, second differences are 1.7 times the first, of what moves they are less than this.
_TIMES, _OF_SPAN, _WHITE = 5.0, 0.03, 1.3
# What presses goes with one beside it so far. More taxels are no faults.
_ALIKE, _MOST_SHARE = 0.5, 0.1


def noisy_taxels(frames: Frames, usable: Mask) -> Mask | None:
    """Return which taxels are far noisier than those beside them; None where none is, or too many are.

    Parameters
    ----------
    frames : ndarray of shape (n_frames, rows, cols), or what gives slices of it
    usable : ndarray of shape (rows, cols), bool

    Examples
    --------
    >>> frames = np.random.default_rng(0).normal(0, 1, (60, 8, 8))
    >>> frames[20:40, 2:6, 2:6] += 100.0
    >>> noisy_taxels(frames, np.ones((8, 8), bool)) is None
    True
    >>> frames[:, 1, 6] *= 20.0
    >>> np.argwhere(noisy_taxels(frames, np.ones((8, 8), bool))).tolist()
    [[1, 6]]
    """
    n_frames = frames.shape[0]
    if n_frames < _FEWEST_FRAMES or np.count_nonzero(usable) < _FEWEST_TAXELS:
        return None
    many = min(_PLACES, max(_FEWEST_PLACES, _READINGS // usable.size))
    places = spread_over(n_frames - 2, many).tolist()
    some = np.array(list(pieces_at(frames, places, 3)), dtype=np.float64)
    some[:, :, ~usable] = 0.0
    steps = np.diff(some, axis=1).reshape(-1, *usable.shape)
    scatter = np.median(np.abs(steps), axis=0)
    turns = np.median(np.abs(np.diff(some, n=2, axis=1))[:, 0], axis=0)
    whole = bool((some == np.rint(some)).all())
    usual = np.maximum(median_around(scatter, usable), float(np.median(scatter[usable])))
    least = max(_OF_SPAN * float(np.ptp(some[:, :, usable])), ROUNDING if whole else 0.0)
    noisy = usable & (scatter > _TIMES * usual) & (scatter > least) & (turns > _WHITE * scatter)
    for row, col in np.argwhere(noisy).tolist():
        noisy[row, col] = not _goes_with_others(steps, row, col)
    return noisy if 0 < np.count_nonzero(noisy) <= _MOST_SHARE * np.count_nonzero(usable) else None


def _goes_with_others(steps: Floats, row: int, col: int) -> bool:
    """Tell whether a taxel does what one beside it does: both are pressed."""
    around = steps[:, max(row - 1, 0) : row + 2, max(col - 1, 0) : col + 2].reshape(len(steps), -1)
    own = steps[:, row, col]
    alike = own @ around / np.maximum(np.sqrt((own @ own) * (around * around).sum(axis=0)), np.finfo(float).tiny)
    return bool(np.sort(alike)[-2] > _ALIKE)


def noisy_words(noisy: Mask) -> str:
    """Say which taxels are too noisy."""
    return f"{taxels_in_words(noisy)} is far noisier than those beside it: filled from its neighbours"
