"""Frames that are spoilt: broken off before their last taxel, or full of noise that no frame beside them has."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from varishold._counted import counted
from varishold.frame.fault import Floats, Frames, Mask, blocks_of, in_type, pieces_at
from varishold.frame.runs import runs_of
from varishold.frame.spread import spread_over

__all__ = [
    "FEWEST_COLS",
    "FEWEST_TAXELS",
    "LONGEST",
    "ROUGH",
    "Spoilt",
    "broken_off",
    "is_white",
    "least_fall",
    "median_bend",
    "spoilt_frames",
    "three_on_end",
]

#: Taxels and columns that there must be; and frames.
FEWEST_TAXELS, FEWEST_COLS, _FEWEST_FRAMES = 36, 4, 8
# Of a large frame so many rows tell whether it is rough, and so many frames how far readings reach.
_MOST_ROWS, _FOR_RANGE = 16, 64
#: A step from one frame to the next is rough where it is so many times what steps usually are, so many frames around;
#: and where second differences along rows are such a share of what most of the step stays within: of noise they are .5
#: to 1, of what presses, even on taxels whose gains differ by a third, .3 at most.
ROUGH, _AROUND, _MOST_OF_STEP, _WHITE = 6.0, 15, 0.9, 0.42
#: More frames on end are no burst; the frame after it is as far from that before it as this share of its steps at most.
LONGEST, _BACK = 3, 0.5
# Of so many frames the usual steps are found together.
_WINDOWS = 1 << 16
# A frame is broken off where its last taxels, half a row and more, show one value, and so many of them show more in the
# frames before and after it, by this share of all readings and so many usual steps: half of them, or some of a press of
# which the taxels before them show that it stays. Of those this share as many have fallen at most.
_FAR, _STEPS, _HALF, _OTHERS, _FEWEST_FAR = 0.05, 5.0, 0.5, 0.2, 3


@dataclass(frozen=True, eq=False)
class Spoilt:
    """Frames that are spoilt, and from which taxel on.

    Parameters
    ----------
    frames : Frames
        All of a recording, shape (n_frames, rows, cols).
    usable : ndarray of shape (rows, cols), bool
    begins : mapping of int to int
        For each spoilt frame the first taxel, in the order of rows, that is replaced; 0 where all are.
    """

    frames: Frames
    usable: Mask
    begins: dict[int, int]

    def mended(self, first: int, last: int) -> NDArray[Any]:
        """Return frames first to last - 1; what is spoilt is the mean of the nearest frames before and after it."""
        made = np.asarray(self.frames[first:last])
        here = [k for k in self.begins if first <= k < last]
        if here:
            made = made.copy()
        for k in here:
            replaced = self.usable.copy()
            replaced.flat[: self.begins[k]] = False
            beside = [other for other in (self._nearest(k, -1), self._nearest(k, 1)) if other is not None]
            around = [np.asarray(self.frames[j : j + 1])[0][replaced].astype(np.float64) for j in beside]
            made[k - first][replaced] = in_type(np.mean(around, axis=0), made.dtype)
        return made

    def _nearest(self, k: int, way: int) -> int | None:
        while k in self.begins:
            k += way
        return k if 0 <= k < self.frames.shape[0] else None

    def words(self) -> tuple[str, ...]:
        """Return how many are spoilt, in words."""
        broken = sum(begin > 0 for begin in self.begins.values())
        told = []
        for many, what in ((broken, "broken off before the last taxel"), (len(self.begins) - broken, "full of noise")):
            if many:
                told.append(f"{counted(many, 'frame')} {what}: taken as between the frames beside")
        return tuple(told)


def spoilt_frames(frames: Frames, usable: Mask) -> Spoilt | None:
    """Return which frames of a recording are spoilt, alone in time; None where none is.

    Parameters
    ----------
    frames : ndarray of shape (n_frames, rows, cols), or what gives slices of it
    usable : ndarray of shape (rows, cols), bool

    Examples
    --------
    >>> rng = np.random.default_rng(0)
    >>> frames = 50 + rng.normal(0, 1, (40, 8, 8))
    >>> frames[0] = 500 * rng.random((8, 8))
    >>> frames[20, 5:] = 0.0
    >>> spoilt_frames(frames, np.ones((8, 8), bool)).begins
    {20: 40, 0: 0}
    """
    n_frames, _, cols = frames.shape
    places = np.flatnonzero(usable)
    if n_frames < _FEWEST_FRAMES or places.size < FEWEST_TAXELS or cols < FEWEST_COLS:
        return None
    places_in_time = spread_over(n_frames - 1, _FOR_RANGE).tolist()
    some = np.array([pair[:, usable] for pair in pieces_at(frames, places_in_time, 2)])
    least = 1.0 if (some == np.rint(some)).all() else 0.0
    usual = float(np.median(np.abs(np.diff(some.astype(np.float64), axis=1))))
    far = least_fall(float(np.ptp(some)), usual, least)
    begins: dict[int, int] = {}
    steps = np.zeros(n_frames + 1)
    before: NDArray[Any] = np.asarray(frames[:1])
    for at, block in blocks_of(frames):
        # Each block, with the two frames before it: the last of a block waits for what follows.
        seen = np.concatenate([before, block]) if at else block
        start = at - len(before) if at else 0
        begins |= {start + k: begin for k, begin in broken_off(seen, places, far, cols).items()}
        steps[start + 1 : start + len(seen)] = _roughness(seen, usable)
        before = np.array(seen[-2:])
    for run in _bursts(steps, least):
        # What a burst leaves is what was before it, and steps to it and from it are as rough as noise.
        around = np.asarray(frames[max(run.start - 1, 0) : run.stop + 1])
        ends = around[[0, -1]] if run.start > 0 and run.stop < n_frames else around[:1]
        comes_back = (_roughness(ends, usable) <= _BACK * min(steps[run.start], steps[run.stop])).all()
        if comes_back and all(is_white(two, usable) for two in pairwise(around)):
            begins |= dict.fromkeys(run, 0)
    return Spoilt(frames, usable, begins) if begins else None


def least_fall(span: float, usual: float, least: float) -> float:
    """Return by how much readings fall at least that are missing, where they span so much and steps are so large."""
    return max(_FAR * span, _STEPS * max(usual, least))


def broken_off(frames: NDArray[Any], places: NDArray[np.intp], far: float, cols: int) -> dict[int, int]:
    """Return the first taxel that is missing of each frame that is broken off; not of the first and the last one."""
    flat = frames.reshape(len(frames), -1)
    least = max(cols // 2, FEWEST_COLS)
    maybe = np.flatnonzero((flat[:, places[-least:]] == flat[:, places[-1:]]).all(axis=1))
    maybe = maybe[(maybe > 0) & (maybe < len(frames) - 1)]
    if maybe.size == 0:
        return {}
    some = flat[maybe][:, places].astype(np.float64)
    other = some != some[:, -1:]
    # A frame of which all taxels are alike has no picture at all.
    missing = np.where(other.any(axis=1), np.argmax(other[:, ::-1], axis=1), 0)
    tail = np.arange(places.size) >= places.size - missing[:, None]
    lower = np.minimum(flat[maybe - 1][:, places], flat[maybe + 1][:, places])
    fallen, stands = lower - some > far, np.abs(some - some[:, -1:]) > far
    gone, others = np.count_nonzero(fallen & tail, axis=1), np.count_nonzero(fallen & ~tail, axis=1)
    stays = np.count_nonzero(stands & ~fallen & ~tail, axis=1) >= _FEWEST_FAR
    broken = (gone >= _FEWEST_FAR) & ((gone >= _HALF * missing) | stays)
    # Where something is let go, others fall too.
    broken &= others * missing <= _OTHERS * gone * (places.size - missing)
    return {int(maybe[k]): int(places[places.size - missing[k]]) for k in np.flatnonzero(broken)}


def _roughness(frames: NDArray[Any], usable: Mask) -> Floats:
    """Return how rough the step to each frame but the first is: the median of its second differences along rows."""
    rows = spread_over(usable.shape[0], _MOST_ROWS)
    return median_bend(np.diff(frames[:, rows].astype(np.float64), axis=0), three_on_end(usable[rows]))


def three_on_end(usable: Mask) -> Mask:
    """Return where three taxels of a row are usable on end; two columns fewer."""
    return usable[:, 2:] & usable[:, 1:-1] & usable[:, :-2]


def median_bend(steps: Floats, three: Mask) -> Floats:
    """Return the median of the second differences along rows, where there are three taxels on end.

    Takes arrays of shape (..., rows, cols) and (rows, cols - 2); returns one of shape (...).
    """
    if not three.any():
        return np.zeros(steps.shape[:-2])
    bends = np.abs(steps[..., 2:] - 2.0 * steps[..., 1:-1] + steps[..., :-2])[..., three]
    middle = bends.shape[-1] // 2
    return np.asarray(np.partition(bends, middle)[..., middle])


def is_white(two: tuple[NDArray[Any], NDArray[Any]], usable: Mask) -> bool:
    """Tell whether the step from one frame to another is as rough as noise."""
    step = np.abs(two[1].astype(np.float64) - two[0])[usable]
    return bool(_roughness(np.stack(two), usable)[0] > _WHITE * float(np.quantile(step, _MOST_OF_STEP)))


def _bursts(steps: Floats, least: float) -> Iterator[range]:
    """Yield runs of frames to and from which steps are rough; what has no step on a side is asked of the other."""
    n_frames = len(steps) - 1
    padded = np.pad(steps[1:n_frames], (_AROUND // 2, _AROUND // 2), mode="reflect")
    windows = np.lib.stride_tricks.sliding_window_view(padded, _AROUND)
    usual = np.concatenate([np.median(windows[k : k + _WINDOWS], axis=1) for k in range(0, len(windows), _WINDOWS)])
    rough = np.ones(n_frames + 1, np.bool_)
    rough[1:n_frames] = steps[1:n_frames] > ROUGH * np.maximum(usual, least)
    spoilt = rough[:-1] & rough[1:]
    yield from (run for run in runs_of(spoilt) if len(run) <= LONGEST)
