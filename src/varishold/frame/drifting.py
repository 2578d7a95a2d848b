"""A rest that all taxels of a pad leave together while a recording goes on: drift, or a jump, found and taken off."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from varishold.frame.fault import Floats, Frames, Mask, blocks_of, pieces_at
from varishold.frame.noise import MEDIAN_ABS_NORMAL, OF_MEDIAN
from varishold.frame.spread import spread_over
from varishold.frame.together import LARGEST_SHARE, readings_end, shares_of, without_it

__all__ = ["Drifting", "drifting_rest"]

_FEWEST_FRAMES, _FEWEST_TAXELS = 24, 16
# Frames and taxels that are looked at.
_LOOKED_AT, _MOST_TAXELS = 512, 256
# Something presses where so many of them are so many sigma off what all do; so many frames without it show the rest.
_PRESSED, _SIGMAS, _FEWEST_QUIET = 3, 8.0, 16
# Frames in which all are off by this share of the farthest tell how each goes with the others.
_FAR = 0.25
# More frames than that, lower than what should be the rest by this share of the highest press, tell that it is none.
_FEWEST_BELOW, _FAR_BELOW = 4, 0.25
# What all do leaves at most this part of how far taxels are off then.
_LEFT = 0.8
# A taxel whose median stands so many times as far above this share of what it reads as that of others is pressed in
# most frames.
_LOWER, _TOO_HIGH = 0.25, 4.0
# The quieter frames tell the noise.
_QUIETER = 0.25
# The rest leaves itself by so many standard errors, and this share of the highest press, which is so many times that.
_ERRORS, _LEAST, _ABOVE = 8.0, 0.02, 1.0
# Frames at either end that tell where it begins and ends.
_ENDS = 8
# What presses all over rises out of the drift by this share of the highest press, within so many times the usual press,
# of which this part goes before and after it.
_ALL_OVER, _TIMES, _AROUND = 0.1, 2.0, 0.25
# Where both are the same, what is pressed all over comes and goes: a rest that drifts is not at one level for so long.
_AT_REST = 0.4
# In a press of so many frames the rest jumps, where it goes so many times as far as usual, and a jump leaves so small a
# part of what going evenly does.
_FEWEST_IN_PRESS, _SUDDEN, _JUMPS = 3, 3.0, 0.7
# What all do is the median of so many frames in which nothing presses.
_SMOOTHED = 5


@dataclass(frozen=True, eq=False)
class Drifting:
    """How far all taxels are off the rest that they begin at.

    Parameters
    ----------
    frames : Frames
        All of a recording, shape (n_frames, rows, cols).
    level : ndarray of shape (n_frames,), float64
        How far the mean taxel is off.
    share : ndarray of shape (rows, cols), float64
        How far each taxel goes where all go by 1; 0 where there is none.
    ends_at : float
        The value at which readings end; they stay there.
    """

    frames: Frames
    level: Floats
    share: Floats
    ends_at: float

    def mended(self, first: int, last: int) -> NDArray[Any]:
        """Return frames first to last - 1 on the rest that they begin at."""
        return without_it(np.asarray(self.frames[first:last]), self.level[first:last], self.share, self.ends_at)

    def words(self) -> tuple[str, ...]:
        """Return how far the rest goes, in words."""
        lowest, highest = float(self.level.min()), float(self.level.max())
        return (f"the rest of all taxels goes {lowest:+.3g} to {highest:+.3g} off where it begins: taken off",)


@dataclass(frozen=True, eq=False)
class _Picked:
    """Some taxels, which stand for all.

    Parameters
    ----------
    places : ndarray of shape (n,), integer
        In frames that are laid flat.
    rest : ndarray of shape (n,), float64
    share : ndarray of shape (n,), float64
        How far each goes where all go by 1.
    sigma : float
        How far those that nothing presses scatter around what all do.
    highest : float
        How far one that is pressed stands above what all do.
    """

    places: NDArray[np.intp]
    rest: Floats
    share: Floats
    sigma: float
    highest: float

    def seen(self, read: NDArray[Any]) -> tuple[Floats, Mask]:
        """Return how far all are off, and whether something presses, from frames of shape (n_frames, n)."""
        off = read - self.rest
        together = np.median(off, axis=1)
        off -= together[:, None] * self.share
        np.abs(off, out=off)
        return together, np.count_nonzero(off > _SIGMAS * self.sigma, axis=1) >= _PRESSED

    @property
    def least(self) -> float:
        """The least that is no chance, and worth to be taken off."""
        return max(_ERRORS * OF_MEDIAN * self.sigma / math.sqrt(self.places.size), _LEAST * self.highest)

    def explains(self, read: Floats, together: Floats) -> bool:
        """Tell whether taxels go together where all are far off, not each its own way."""
        goes = np.abs(together - np.median(together))
        far = goes >= _FAR * goes.max()
        off = read[far] - np.median(read, axis=0)
        left = off - (together[far] - np.median(together))[:, None] * self.share
        return bool(np.median(np.abs(left)) <= _LEFT * np.median(np.abs(off)))

    def quiet(self, together: Floats, pressed: Mask) -> Mask:
        """Return in which frames nothing presses, neither some taxels nor all of them alike."""
        edges = np.flatnonzero(np.diff(np.r_[False, pressed, False]))
        lasts = np.sort(edges[1::2] - edges[::2])
        # The press that half of all pressed frames are no longer than: what wavers makes many short ones.
        usual = int(lasts[np.searchsorted(np.cumsum(lasts), lasts.sum() / 2)]) if edges.size else 1
        width = int(_TIMES * usual) // 2 * 2 + 1
        # What comes and goes within the width is not in the highest of what is lowest in each.
        beneath = -_lowest(-_lowest(together, width), width)
        over = ~pressed & (together - beneath > max(self.least, _ALL_OVER * self.highest))
        around = 2 * (1 + int(_AROUND * usual)) + 1
        quiet: Mask = ~pressed & (_lowest(np.where(over, -1.0, 0.0), around) == 0.0)
        return quiet


def drifting_rest(frames: Frames, usable: Mask) -> Drifting | None:
    """Return how far the rest of all taxels together goes in a recording; None where it stays, or that is not certain.

    It is read from frames in which nothing presses, and goes on evenly through presses. What presses a pad all over
    comes and goes, and is none.

    Parameters
    ----------
    frames : ndarray of shape (n_frames, rows, cols), or what gives slices of it
    usable : ndarray of shape (rows, cols), bool

    Examples
    --------
    >>> frames = np.random.default_rng(0).normal(0, 1, (200, 8, 8)) + np.linspace(0, 40, 200)[:, None, None]
    >>> frames[40:60, 2:6, 2:6] += 100.0
    >>> found = drifting_rest(frames, np.ones((8, 8), bool))
    >>> mended = found.mended(0, 200)
    >>> round(float(mended[190:].mean())), round(float(mended[50, 4, 4]), -1)
    (1, 100.0)
    """
    n_frames, places = frames.shape[0], np.flatnonzero(usable)
    if n_frames < _FEWEST_FRAMES or places.size < _FEWEST_TAXELS:
        return None
    some = places[spread_over(places.size, _MOST_TAXELS)]
    looked = _looked(frames, spread_over(n_frames, _LOOKED_AT), some)
    picked = _picked(some, looked)
    if picked is None:
        return None
    return _followed(frames, usable, picked, readings_end(looked, np.asarray(frames[:1]).dtype.kind))


def _looked(frames: Frames, numbers: NDArray[np.intp], places: NDArray[np.intp]) -> Floats:
    """Return what some taxels read in some frames, shape (n_frames, n_taxels)."""
    read = np.empty((numbers.size, places.size))
    for k, one in enumerate(pieces_at(frames, numbers.tolist())):
        read[k] = one.reshape(-1)[places]
    return read


def _picked(places: NDArray[np.intp], looked: Floats) -> _Picked | None:
    """Return the taxels that tell how the rest drifts; None where it does not."""
    picked = _of_shares(places, looked, np.ones(places.size))
    together, pressed = picked.seen(looked)
    if pressed.all() or np.ptp(together[~pressed]) < picked.least:
        return None
    # As all do, or each by its own share: by which of them less seems to be pressed.
    other = _of_shares(places, looked, _rough_shares(looked))
    if np.count_nonzero(other.seen(looked)[1]) < np.count_nonzero(pressed):
        picked = other
    together, pressed = picked.seen(looked)
    is_quiet, highest, least = picked.quiet(together, pressed), picked.highest, picked.least
    quiet = together[is_quiet]
    if quiet.size < _FEWEST_QUIET:
        return None
    low, high = np.quantile(quiet, [0.02, 0.98])
    if high - low < least or highest < _ABOVE * (high - low) or not picked.explains(looked[is_quiet], quiet):
        return None
    goes = abs(float(np.median(quiet[-_ENDS:]) - np.median(quiet[:_ENDS]))) >= least
    return picked if goes or _most_at_one_level(quiet, least) < _AT_REST else None


def _of_shares(places: NDArray[np.intp], looked: Floats, share: Floats) -> _Picked:
    """Return some taxels with their rest, where each goes by its share of what all do."""
    together = np.median(looked - np.median(looked, axis=0), axis=1)
    rest = _unpressed(looked - together[:, None] * share)
    off = looked - rest
    away = off - np.median(off, axis=1)[:, None] * share
    # Presses that cover most of a small pad leave a quarter of the frames at rest.
    sigma = float(np.quantile(np.median(np.abs(away), axis=1), _QUIETER)) / MEDIAN_ABS_NORMAL
    return _Picked(places, rest, share, sigma, float(away.max()))


def _unpressed(read: Floats) -> Floats:
    """Return what each taxel reads in the median of all frames, or what the lower ones tell of one pressed in most."""
    middle, low = np.median(read, axis=0), np.quantile(read, _LOWER, axis=0)
    above = middle - low
    usual = float(np.median(above))
    return np.where(above > _TOO_HIGH * usual, low + usual, middle)


def _rough_shares(looked: Floats) -> Floats:
    """Return how far each taxel goes where all go by 1, as most frames tell it in which they are far off."""
    off = looked - np.median(looked, axis=0)
    together = np.median(off, axis=1)
    together -= np.median(together)
    farthest = float(np.abs(together).max())
    if not farthest > 0.0:
        return np.ones(looked.shape[1])
    far = np.abs(together) >= _FAR * farthest
    return np.clip(np.median(off[far] / together[far, None], axis=0), 0.0, LARGEST_SHARE)


def _most_at_one_level(values: Floats, width: float) -> float:
    """Return the largest share of values that lie within so much of each other."""
    rising = np.sort(values)
    return float((np.searchsorted(rising, rising + width, side="right") - np.arange(rising.size)).max() / rising.size)


def _followed(frames: Frames, usable: Mask, picked: _Picked, ends_at: float) -> Drifting | None:
    together, pressed = [], []
    for _, block in blocks_of(frames):
        off, touched = picked.seen(block.reshape(len(block), -1)[:, picked.places])
        together.append(off)
        pressed.append(touched)
    course = np.concatenate(together)
    quiet = np.flatnonzero(picked.quiet(course, np.concatenate(pressed)))
    if quiet.size < _FEWEST_QUIET:
        return None
    level = np.interp(np.arange(frames.shape[0]), quiet, _smoothed(course[quiet]))
    _put_jumps(level, course, quiet, picked.least)
    # Presses lift what all do: where it lies far lower than the rest, that is no rest, but a press all over.
    if np.count_nonzero(course < level - _FAR_BELOW * picked.highest) > _FEWEST_BELOW:
        return None
    level -= np.median(level[quiet[:_ENDS]])
    if not np.ptp(level) >= max(picked.least, np.finfo(np.float64).tiny):
        return None
    return Drifting(frames, level, _shares(frames, usable, quiet, level, picked.sigma), ends_at)


def _put_jumps(level: Floats, course: Floats, quiet: NDArray[np.intp], least: float) -> None:
    """Let the rest jump within a press where what all do then, the pressed ones among them, is nearer to a jump."""
    apart = quiet[_ENDS:] - quiet[:-_ENDS]
    usual = float(np.median(np.abs(level[quiet[_ENDS:]] - level[quiet[:-_ENDS]]) / apart))
    for before, after in zip(quiet[:-1].tolist(), quiet[1:].tolist(), strict=True):
        low, high = float(level[before]), float(level[after])
        if after - before < _FEWEST_IN_PRESS or abs(high - low) < max(least, _SUDDEN * usual * (after - before)):
            continue
        seen = course[before + 1 : after]
        # How far off the course is as long as the rest stays at one, and from there on at the other.
        first = np.r_[0.0, np.cumsum(np.abs(seen - low))]
        then = np.r_[np.cumsum(np.abs(seen - high)[::-1])[::-1], 0.0]
        jump = int(np.argmin(first + then))
        if (first + then)[jump] < _JUMPS * np.abs(seen - level[before + 1 : after]).sum():
            level[before + 1 : before + 1 + jump], level[before + 1 + jump : after] = low, high


def _lowest(values: Floats, width: int) -> Floats:
    """Return the lowest of each value and those beside it, of so many, an odd number."""
    n, half = values.size, width // 2
    found, reach = np.pad(values, half, constant_values=np.inf), 1
    while reach < width:
        step = min(reach, width - reach)
        found = np.minimum(found[:-step], found[step:])
        reach += step
    return found[:n]


def _smoothed(values: Floats) -> Floats:
    """Return the median of each value and those beside it."""
    padded = np.pad(values, _SMOOTHED // 2, mode="edge")
    return np.asarray(np.median(np.lib.stride_tricks.sliding_window_view(padded, _SMOOTHED), axis=1))


def _shares(frames: Frames, usable: Mask, quiet: NDArray[np.intp], level: Floats, sigma: float) -> Floats:
    """Return how far each taxel goes where all go by 1, from some of the quiet frames."""
    chosen = quiet[spread_over(quiet.size, _LOOKED_AT)]
    read = _looked(frames, chosen, np.flatnonzero(usable))
    share = np.zeros(usable.shape)
    # What never changes is broken.
    share[usable] = np.where(np.ptp(read, axis=0) > 0.0, shares_of(read, level[chosen], sigma), 0.0)
    return share
