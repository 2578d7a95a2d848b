"""Rows or columns of which each goes up and down for itself from frame to frame: found and taken off."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from varishold.frame.fault import Floats, Frames, Mask, blocks_of, pieces_at
from varishold.frame.floor import noise_reach
from varishold.frame.noise import MEDIAN_ABS_NORMAL, OF_MEDIAN, sigma_of_half
from varishold.frame.spread import spread_over
from varishold.frame.together import readings_end, taken_off

__all__ = ["LineNoise", "column_noise", "row_noise"]

_FEWEST_FRAMES, _FEWEST_LINES, _FEWEST_TAXELS = 24, 4, 4
# Frames that are looked at first: so many on end in each of so many places; and lines and taxels of each.
_SAMPLED, _PLACES, _MOST_LINES, _MOST_TAXELS = 24, 4, 24, 32
# Frames that tell what taxels read at rest.
_FOR_REST = 96
# What a line does is what half of its taxels do, those that read least: the others may be pressed. Slow is what it does
# in the median of so many frames.
_LEAST, _SLOW = 0.5, 9
# What a taxel reads at rest is above so much of all that it reads.
_RESTING = 0.25
# Taxels of a line rest where they are at most so many times as unlike each other as in the quarter of least.
_CALM = 1.5
# Half of a line's taxels are alike within so many sigma of a taxel, or as far as noise reaches on the pad where that is
# more, and near their rest within so many of a line.
_FLAT_SIGMAS, _NEAR_SIGMAS = 3.5, 4.0
# What is quick of noise that is as quick as frames come has this share of its sigma.
_QUICK_SHARE = 0.82
# Lines do something for themselves where it is so many times what chance makes of it, and this share of their noise.
_ERRORS, _OF_NOISE = 2.0, 0.5
# What presses lifts neighbouring lines together.
_TOGETHER = 0.5


@dataclass(frozen=True, eq=False)
class LineNoise:
    """What each line of taxels does for itself, as its less pressed taxels show it.

    Parameters
    ----------
    frames : Frames
        All of a recording, shape (n_frames, rows, cols).
    usable : ndarray of shape (rows, cols), bool
    rest : ndarray of shape (rows, cols), float64
        What each taxel reads where nothing presses it.
    axis : {1, 2}
        1 for columns, 2 for rows.
    ends_at : float
        The value at which readings end; they stay there.
    spread, noise : float
        Standard deviations of what a line does, and of what a taxel does beside it.
    """

    frames: Frames
    usable: Mask
    rest: Floats
    axis: int
    ends_at: float
    spread: float
    noise: float

    def mended(self, first: int, last: int) -> NDArray[Any]:
        """Return frames first to last - 1 without what each line does quickly, or where nothing presses it."""
        reach, n_frames = _SLOW // 2, self.frames.shape[0]
        begin, stop = max(first - reach, 0), min(last + reach, n_frames)
        read = np.asarray(self.frames[begin:stop])
        of_lines, free, mean = self._off(read)
        off = np.where(free, mean, _quick(of_lines))
        here = slice(first - begin, last - begin)
        read = read[here]
        return taken_off(read, np.where(self.usable, np.expand_dims(off[here], self.axis), 0.0), self.ends_at)

    def known_well(self) -> LineNoise:
        """Return it with the rest of each line and of its taxels by all frames in which nothing presses them."""
        lines, n_lines, taxels, n_taxels = (np.zeros(1) for _ in range(4))
        for _, read in blocks_of(self.frames):
            _, free, mean = self._off(read)
            beside = read - self.rest - np.expand_dims(mean, self.axis)
            near = (np.abs(beside) <= self._flat) & np.expand_dims(free, self.axis)
            lines, n_lines = lines + np.where(free, mean, 0.0).sum(axis=0), n_lines + np.count_nonzero(free, axis=0)
            taxels, n_taxels = (
                taxels + np.where(near, beside, 0.0).sum(axis=0),
                n_taxels + np.count_nonzero(near, axis=0),
            )
        off = np.expand_dims(lines / np.maximum(n_lines, 1), self.axis - 1) + taxels / np.maximum(n_taxels, 1)
        return replace(self, rest=self.rest + np.where(self.usable, off, 0.0))

    def _off(self, read: NDArray[Any]) -> tuple[Floats, NDArray[np.bool_], Floats]:
        """Return what the less pressed half of each line does, where nothing presses it, and what it does there.

        All of shape (n_frames, n_lines).
        """
        away = read - self.rest
        of_lines, apart = _of_lines(away, self.usable, self.axis)
        # Half of a line's taxels that are alike, near their rest, are not pressed: all that they do is the line's.
        free = (apart <= self._flat) & (np.abs(of_lines) <= _NEAR_SIGMAS * self.spread)
        return of_lines, free, self._mean_of_free(away, of_lines)

    @cached_property
    def _flat(self) -> float:
        return max(_FLAT_SIGMAS * self.noise, noise_reach(self.noise, int(np.count_nonzero(self.usable))))

    def _mean_of_free(self, away: Floats, of_lines: Floats) -> Floats:
        """Return the mean of each line's taxels that are near what half of it does, shape (n_frames, n_lines)."""
        near = np.abs(away - np.expand_dims(of_lines, self.axis)) <= self._flat
        near &= self.usable
        many = np.maximum(np.count_nonzero(near, axis=self.axis), 1)
        return np.asarray(np.where(near, away, 0.0).sum(axis=self.axis) / many)

    def words(self) -> tuple[str, ...]:
        """Return what is taken off, in words."""
        lines = "rows" if self.axis == 2 else "columns"
        return (f"{lines} go up and down each for itself by {self.spread:.3g} from frame to frame: taken off",)


def row_noise(frames: Frames, usable: Mask) -> LineNoise | None:
    """Return what each row of taxels does for itself from frame to frame; None where that is little.

    What presses does not flicker, and lifts a row's taxels less where it does not reach.

    Parameters
    ----------
    frames : ndarray of shape (n_frames, rows, cols), or what gives slices of it
    usable : ndarray of shape (rows, cols), bool

    Examples
    --------
    >>> rng = np.random.default_rng(0)
    >>> frames = rng.normal(0, 1, (100, 8, 12)) + rng.normal(0, 5, (100, 8, 1))
    >>> frames[40:60, 2:6, 2:6] += 100.0
    >>> found = row_noise(frames, np.ones((8, 12), bool))
    >>> mended = found.mended(0, 100)
    >>> round(float(frames[:, 0, 0].std())), round(float(mended[:, 0, 0].std()))
    (5, 1)
    >>> column_noise(frames, np.ones((8, 12), bool)) is None
    True
    """
    return _line_noise(frames, usable, 2)


def column_noise(frames: Frames, usable: Mask) -> LineNoise | None:
    """Return what each column of taxels does for itself, as `row_noise`."""
    return _line_noise(frames, usable, 1)


def _line_noise(frames: Frames, usable: Mask, axis: int) -> LineNoise | None:
    n_frames, n_lines, n_taxels = frames.shape[0], usable.shape[2 - axis], usable.shape[axis - 1]
    if n_frames < _FEWEST_FRAMES or n_lines < _FEWEST_LINES or n_taxels < _FEWEST_TAXELS:
        return None
    places = spread_over(max(0, n_frames - _SAMPLED) + 1, _PLACES).tolist()
    sampled = list(pieces_at(frames, places, _SAMPLED))
    # Of a large pad some lines, neighbours of each other, and some taxels of them tell.
    lines, taxels = np.arange(min(n_lines, _MOST_LINES)), spread_over(n_taxels, _MOST_TAXELS)
    some = np.ix_(lines, taxels) if axis == 2 else np.ix_(taxels, lines)
    chosen = spread_over(n_frames, _FOR_REST).tolist()
    rest = _rest(np.array([piece[0][some] for piece in pieces_at(frames, chosen)]), usable[some])
    away = [np.where(usable[some], part[:, some[0], some[1]] - rest, 0.0) for part in sampled]
    found = _found(away, usable[some], axis)
    if found is None:
        return None
    whole = np.concatenate(list(pieces_at(frames, chosen)))
    rest = _evened(whole, _rest(whole, usable), usable, axis)
    return LineNoise(frames, usable, rest, axis, readings_end(whole[:, usable], whole.dtype.kind), *found).known_well()


def _found(sampled: list[Floats], usable: Mask, axis: int) -> tuple[float, float] | None:
    """Return how far a line goes up and down for itself, and a taxel beside it; None where it is little, or of all.

    Takes what taxels are off their rest, in frames on end.
    """
    quick, left = [], []
    # A sensor that is read more often than it measures says the same again.
    measured = [off[np.append(True, np.diff(off, axis=0).any(axis=(1, 2)))] for off in sampled]
    for off in (each for each in measured if len(each) > _SLOW // 2):
        of_lines, _ = _of_lines(off, usable, axis)
        quick.append(_quick(of_lines))
        steps = np.diff(off - np.expand_dims(of_lines, axis), axis=0)
        steps -= np.median(steps, axis=3 - axis, keepdims=True)
        left.append(np.median(np.abs(steps[:, usable])) / math.sqrt(2.0))
    if not left:
        return None
    noise = float(np.median(left)) / MEDIAN_ABS_NORMAL
    spread = sigma_of_half(np.concatenate(quick))
    by_chance = OF_MEDIAN * noise / math.sqrt(_LEAST * usable.shape[axis - 1])
    certain = spread > max(_ERRORS * by_chance, _OF_NOISE * noise) and _alike(np.concatenate(quick)) <= _TOGETHER
    return (spread / _QUICK_SHARE, noise) if certain else None


def _rest(frames: NDArray[Any], usable: Mask) -> Floats:
    """Return what each taxel reads where nothing presses it, as it is for most of the time or for a quarter of it."""
    rank = int(_RESTING * (len(frames) - 1))
    low = np.where(usable, np.partition(frames, rank, axis=0)[rank], 0.0)
    # All of them read more than that at rest, by what noise makes of a quarter.
    return low + float(np.median((frames - low)[:, usable]))


def _evened(frames: NDArray[Any], rest: Floats, usable: Mask, axis: int) -> Floats:
    """Return a rest whose taxels are alike along each line in the frames in which they are most alike.

    A taxel that is pressed for most of the time seems to rest higher than others, by what its line does.
    """
    away = frames - rest
    beside = np.where(usable, away - np.expand_dims(_of_lines(away, usable, axis)[0], axis), 0.0)
    apart = np.abs(beside).mean(axis=axis, keepdims=True)
    calm = apart <= _CALM * np.quantile(apart, _RESTING, axis=0)
    return np.asarray(rest + np.nanmedian(np.where(calm, beside, np.nan), axis=0))


def _alike(quick: Floats) -> float:
    """Return how far neighbouring lines go together, from -1 to 1."""
    one, other = quick[:, 1:].ravel(), quick[:, :-1].ravel()
    both = math.sqrt(float(one @ one) * float(other @ other))
    return float(one @ other) / both if both > 0.0 else 0.0


def _of_lines(off: Floats, usable: Mask, axis: int) -> tuple[Floats, Floats]:
    """Return the median of the less pressed half of each line's taxels, and how far that half reaches.

    Both of shape (n_frames, n_lines); 0 without taxels.
    """
    rising = np.sort(np.where(usable, off, np.inf), axis=axis)
    half = np.maximum(1, np.rint(_LEAST * np.count_nonzero(usable, axis=axis - 1)).astype(np.intp))

    def ranked(k: NDArray[np.intp]) -> Floats:
        found = np.take_along_axis(rising, np.expand_dims(np.broadcast_to(k, (1, half.size)), axis), axis=axis)
        return np.where(np.isfinite(found), found, 0.0).squeeze(axis)

    lower = (ranked((half - 1) // 2) + ranked(half // 2)) / 2
    return lower, ranked(half - 1) - ranked(np.zeros_like(half))


def _quick(of_lines: Floats) -> Floats:
    """Return what lines do beside what they do slowly."""
    padded = np.pad(of_lines, ((_SLOW // 2, _SLOW // 2), (0, 0)), mode="reflect")
    return of_lines - np.median(np.lib.stride_tricks.sliding_window_view(padded, _SLOW, axis=0), axis=2)
