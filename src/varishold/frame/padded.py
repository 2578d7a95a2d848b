"""Lines of a frame that were put around it: no taxels stand there."""

from __future__ import annotations

import numpy as np

from varishold.frame.fault import Floats, Frames, Mask, pieces_at
from varishold.frame.spread import spread_over

__all__ = ["padding", "padding_words"]

# Frames that there must be, and that are looked at.
_FEWEST, _LOOKED_AT = 12, 32
# One line at a border may be broken; where more than that never change side by side, no taxels stand there. Rows and
# columns that must be left.
_ONE_LINE, _FEWEST_LEFT = 1, 5
# So many of the taxels within read more than one value, in each line that is left at the border too: noise is seen.
_NOISY = 0.95
# In the quietest quarter of the frames noise goes to both sides of the value around: its share on one is so near to a
# half. Where no reading comes there, something presses a part of the taxels in so many frames: it changes them so many
# times as much as most.
_QUIET, _MIXED, _OFTEN, _FAR = 4, 0.45, 0.1, 10.0


def padding(frames: Frames, usable: Mask) -> Mask | None:
    """Return where lines around the taxels read one and the same value all the time, amid noise; None for nowhere.

    A sensor whose taxels read noise at rest does so at its border too: frames that were laid into a larger picture do
    not. Where zeros hide the noise, what nothing presses looks the same: noise must go to both sides of the value, as a
    rest does, or be there around something that presses.

    Parameters
    ----------
    frames : ndarray of shape (n_frames, rows, cols), or what gives slices of it
    usable : ndarray of shape (rows, cols), bool
        What is not usable counts as nothing.

    Returns
    -------
    ndarray of shape (rows, cols), bool, or None

    Examples
    --------
    >>> frames = np.random.default_rng(0).normal(0, 1, (40, 8, 8))
    >>> padding(frames, np.ones((8, 8), bool)) is None
    True
    >>> wide = np.pad(frames, ((0, 0), (2, 2), (0, 3)))
    >>> found = padding(wide, np.ones((12, 11), bool))
    >>> np.flatnonzero(found.all(axis=1)).tolist(), np.flatnonzero(found.all(axis=0)).tolist()
    ([0, 1, 10, 11], [8, 9, 10])
    """
    if frames.shape[0] < _FEWEST:
        return None
    numbers = spread_over(frames.shape[0], _LOOKED_AT).tolist()
    low, high = np.full(usable.shape, np.inf), np.full(usable.shape, -np.inf)
    for (frame,) in pieces_at(frames, numbers):
        low, high = np.minimum(low, frame), np.maximum(high, frame)
    changes = usable & (low != high)
    if not changes.any():
        return None
    spans = [np.flatnonzero(changes.any(axis=axis)) for axis in (1, 0)]
    (top, bottom), (left, right) = ((int(span[0]), int(span[-1]) + 1) for span in spans)
    rows, cols = usable.shape
    if max(top, left, rows - bottom, cols - right) <= _ONE_LINE or min(bottom - top, right - left) < _FEWEST_LEFT:
        return None
    around = np.ones(usable.shape, np.bool_)
    around[top:bottom, left:right] = False
    values = low[around & usable]
    if values.size == 0 or (values != values[0]).any():
        return None
    there, noisy = usable[top:bottom, left:right], changes[top:bottom, left:right]
    parts = (np.s_[:], np.s_[0], np.s_[-1], np.s_[:, 0], np.s_[:, -1])
    if any(np.count_nonzero(noisy[part]) < _NOISY * np.count_nonzero(there[part]) for part in parts):
        return None
    inside, value = usable & ~around, float(values[0])
    seen = np.array([frame[inside] for (frame,) in pieces_at(frames, numbers)], dtype=np.float64)
    if (low[inside] > value).all() or (high[inside] < value).all():
        return around if _some_stands_out(seen) else None
    quiet = seen[np.argsort(seen.mean(axis=1))[: len(seen) // _QUIET]]
    return around if _goes_about(quiet, value) else None


def _goes_about(quiet: Floats, value: float) -> bool:
    """Tell whether the noise of frames in which least presses goes to both sides of a value, each for itself."""
    below = quiet <= value
    mixed = np.abs(below.mean(axis=1) - 0.5) <= _MIXED
    goes = below.any(axis=0) & ~below.all(axis=0)
    return bool(mixed.mean() >= 0.5 and goes.mean() >= _NOISY)


def _some_stands_out(seen: Floats) -> bool:
    """Tell whether in some frames some of what changes stands out of what most do, and of what others ever do."""
    off = seen - seen.mean(axis=0)
    off -= np.median(off, axis=1)[:, None]
    least = float(np.quantile(np.ptp(off, axis=0), 0.25))
    np.abs(off, out=off)
    return bool(np.mean(off.max(axis=1) > np.maximum(_FAR * np.median(off, axis=1), least)) >= _OFTEN)


def padding_words(around: Mask) -> str:
    """Return where no taxels stand, in words."""
    lines = [np.flatnonzero(~around.all(axis=axis)) for axis in (1, 0)]
    (top, bottom), (left, right) = ((int(each[0]), int(each[-1])) for each in lines)
    return (
        f"taxels stand in rows {top} to {bottom} and columns {left} to {right} alone: what is around them never changes"
    )
