"""Taxels that stick from some frame of a recording on, while everything else is pressed and let go."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from varishold.frame.fault import Floats, Frames, Mask, blocks_of, in_type, pieces_at
from varishold.frame.health import taxels_in_words
from varishold.frame.neighbours import largest_around, whole_lines
from varishold.frame.noise import MEDIAN_ABS_NORMAL
from varishold.frame.spread import spread_over

__all__ = ["ALONE", "MOST", "SIGMAS", "Sticking", "most_sticking", "sticking_taxels"]

# The first and the last frames, which say what a taxel reads before and after.
_ENDS = 8
#: What sticks stands off what it read at the start by so many sigma and this share of what others read, and so many
#: times as far as any taxel around it.
SIGMAS, _SHARE, ALONE = 12.0, 0.05, 4.0
# One that reads less than at the start may have been pressed there: it sticks where it alone has no noise. So many of
# the others may have none.
_STILL = 0.1
#: More taxels than these, or than this share of the pad, are no faults.
MOST, _MOST_SHARE = 2, 0.03
# Others are pressed where so many of them stand above this share of what they read at most.
_FEWEST_PRESSED, _PRESSED_SHARE = 3, 0.1
# Frames that count as a rest, and as a press, and places from which frames are taken to see how much is read.
_FEWEST_FRAMES, _PLACES = 3, 512


@dataclass(frozen=True, eq=False)
class Sticking:
    """Taxels that stick, and from which frame on each does.

    Parameters
    ----------
    frames : Frames
        All of a recording, shape (n_frames, rows, cols).
    usable : ndarray of shape (rows, cols), bool
    begin : ndarray of shape (rows, cols), float64
        What taxels read at the start.
    since : ndarray of shape (rows, cols), integer
        The first frame in which a taxel sticks; the number of frames where it never does.
    """

    frames: Frames
    usable: Mask
    begin: Floats
    since: NDArray[np.intp]

    def mended(self, first: int, last: int) -> NDArray[Any]:
        """Return frames first to last - 1, what sticks filled from the taxels beside it."""
        made = np.asarray(self.frames[first:last])
        sticking = np.argwhere(self.since < last)
        if len(sticking):
            made = made.copy()
        for row, col in sticking:
            start = max(int(self.since[row, col]), first)
            beside = np.zeros_like(self.usable)
            beside[max(row - 1, 0) : row + 2, max(col - 1, 0) : col + 2] = True
            beside &= self.usable & (self.since == self.frames.shape[0])
            filled = np.full(last - start, self.begin[row, col])
            if beside.any():
                filled += (made[start - first :, beside] - self.begin[beside]).mean(axis=1)
            made[start - first :, row, col] = in_type(filled, made.dtype)
        return made

    def words(self) -> tuple[str, ...]:
        """What sticks, in words: a sentence for all that do so from the same frame on."""
        frames = np.unique(self.since[self.since < self.frames.shape[0]])
        return tuple(
            f"{taxels_in_words(self.since == frame)} sticks from frame {frame} on: filled from those beside"
            for frame in frames
        )


def sticking_taxels(frames: Frames, usable: Mask) -> Sticking | None:
    """Return which taxels and lines of a recording stick from some frame on; None where none does.

    Such a taxel stands alone, then something else is pressed and let go, and it stands there still. It sticks high, or
    lower than it read at the start and without its noise.

    Parameters
    ----------
    frames : ndarray of shape (n_frames, rows, cols), or what gives slices of it
        Larger readings mean more pressure.
    usable : ndarray of shape (rows, cols), bool

    Examples
    --------
    >>> frames = np.random.default_rng(0).normal(0, 1, (60, 8, 8))
    >>> frames[40:50, 2:6, 2:6] += 100.0
    >>> frames[25:, 1, 6] += 80.0
    >>> sticking_taxels(frames, np.ones((8, 8), bool)).words()
    ('taxel (1, 6) sticks from frame 25 on: filled from those beside',)
    """
    n_frames = frames.shape[0]
    if n_frames < 3 * _ENDS:
        return None
    first, last = (
        np.where(usable, part, 0).astype(np.float64) for part in (frames[:_ENDS], frames[n_frames - _ENDS :])
    )
    begin, end = np.median(first, axis=0), np.median(last, axis=0)
    rise = end - begin
    sigma = float(np.median(np.abs(np.concatenate([first - begin, last - end]))[:, usable])) / MEDIAN_ABS_NORMAL
    off = np.abs(rise) > max(SIGMAS * sigma, _SHARE * float(np.abs(rise).max()))
    lines = whole_lines(off, usable)
    alone = off & (np.abs(rise) > ALONE * largest_around(np.where(lines, 0.0, np.abs(rise)))) & ~lines
    if np.count_nonzero(alone) > most_sticking(usable):
        return None
    alone |= lines & off
    others = usable & ~alone
    # On a pad of one line there is nothing beside it.
    if not others.any():
        return None
    still = np.ptp(last, axis=0) == 0.0
    alone &= (rise > 0.0) | (still & (np.count_nonzero(still & others) <= _STILL * np.count_nonzero(others)))
    if not alone.any():
        return None
    places = spread_over(n_frames - 1, _PLACES)
    pairs = (pair[:, others] - begin[others] for pair in pieces_at(frames, places.tolist(), 2))
    span = max(float(pair.min(axis=0).max()) for pair in pairs)
    alone &= np.abs(rise) > _SHARE * span
    if not alone.any() or not span > SIGMAS * sigma:
        return None
    pressed, off_rest = _course(frames, begin, others, max(SIGMAS * sigma, _PRESSED_SHARE * span), alone, rise)
    since = np.full(usable.shape, n_frames, dtype=np.intp)
    for (row, col), off_then in zip(np.argwhere(alone), off_rest.T, strict=True):
        found = _since(off_then, pressed)
        since[row, col] = n_frames if found is None else found
    return Sticking(frames, usable, begin, since) if (since < n_frames).any() else None


def most_sticking(usable: Mask) -> int:
    """Return how many single taxels of a pad may stick at once, and be no form."""
    return max(MOST, int(_MOST_SHARE * np.count_nonzero(usable)))


def _since(off: Mask, pressed: Mask) -> int | None:
    """Return from which frame on a taxel sticks that is off its rest in the last one; None where it need not."""
    at_rest = np.flatnonzero(~off)
    since = int(at_rest[-1]) + 1 if at_rest.size else 0
    rests = since + np.flatnonzero(~pressed[since:])
    if rests.size < _FEWEST_FRAMES or pressed[-_ENDS:].any():
        return None
    later = np.count_nonzero(pressed[rests[_FEWEST_FRAMES - 1] :])
    return since if later >= _FEWEST_FRAMES else None


def _course(frames: Frames, begin: Floats, others: Mask, least: float, alone: Mask, rise: Floats) -> tuple[Mask, Mask]:
    """Return in which frames others are pressed, and in which each taxel of `alone` is off its rest: (n_frames, n)."""
    pressed, off = [], []
    for _, block in blocks_of(frames):
        pressed.append((block[:, others] - begin[others] > least).sum(axis=1) >= _FEWEST_PRESSED)
        off.append((block[:, alone] - begin[alone]) / rise[alone] > 0.5)
    return np.concatenate(pressed), np.concatenate(off)
