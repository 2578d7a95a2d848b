"""Frames in which a pad says nothing: all of its taxels show one and the same value, as where a plug came off."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from varishold._counted import counted
from varishold.frame.fault import Floats, Frames, Mask, blocks_of, pieces_at
from varishold.frame.runs import runs_of
from varishold.frame.spread import spread_over

__all__ = ["SHORT", "Silent", "came_up", "silent_frames"]

# Taxels that are compared first; only where they are alike all are.
_PICKED = 8
# Frames that have a picture, without which nothing is known of the pad, and of which some are looked at.
_FEWEST_FRAMES, _MOST_LOOKED = 8, 256
# By noise alone all taxels would be alike in less than this share of the frames.
_BY_CHANCE = 1e-6
# Of frames with a picture the quietest, which stand for one that has none.
_QUIET = 0.25
#: Up to so many such frames on end are as the one before them, or as the first one that shows something.
SHORT = 5
# What is pressed all over and saturated is no fault: it comes up by more than one frame, from nearer than this share.
_NEAR = 0.5


@dataclass(frozen=True, eq=False)
class Silent:
    """Frames that have no picture, and which are taken instead.

    Parameters
    ----------
    frames : Frames
        All of a recording, shape (n_frames, rows, cols).
    usable : ndarray of shape (rows, cols), bool
    instead : ndarray of shape (n_frames,), integer
        The number of the frame that stands for each: its own where it has a picture.
    """

    frames: Frames
    usable: Mask
    instead: NDArray[np.intp]

    def mended(self, first: int, last: int) -> NDArray[Any]:
        """Return frames first to last - 1 with a picture each."""
        made = np.asarray(self.frames[first:last])
        silent = first + np.flatnonzero(self.instead[first:last] != np.arange(first, last))
        if silent.size:
            made = made.copy()
        for number in silent.tolist():
            other = int(self.instead[number])
            made[number - first][self.usable] = np.asarray(self.frames[other : other + 1])[0][self.usable]
        return made

    def words(self) -> tuple[str, ...]:
        """Return which frames have none, in words."""
        silent = self.instead != np.arange(len(self.instead))
        runs = [f"{run[0]}" if len(run) == 1 else f"{run[0]} to {run[-1]}" for run in runs_of(silent)]
        listed = ", ".join(runs[:3]) + (f" and {counted(len(runs) - 3, 'time')} more" if len(runs) > 3 else "")
        what = "frame" if len(runs) == 1 and "to" not in runs[0] else "frames"
        return (f"{what} {listed}: all taxels show one and the same value, the pad said nothing; taken as before it",)


def silent_frames(frames: Frames, usable: Mask) -> Silent | None:
    """Return which frames of a recording have no picture, where others have one; None where all have.

    All taxels show exactly the same there, as they never do by their noise. Short runs are as the frame before them, or
    the first one with a picture, long ones as frames in which nothing presses.

    Parameters
    ----------
    frames : ndarray of shape (n_frames, rows, cols), or what gives slices of it
    usable : ndarray of shape (rows, cols), bool

    Examples
    --------
    >>> frames = 200 + np.random.default_rng(0).normal(0, 1, (60, 8, 8))
    >>> frames[40:] = 0.0
    >>> found = silent_frames(frames, np.ones((8, 8), bool))
    >>> found.words()[0][:36], bool(found.mended(0, 60).min() > 190)
    ('frames 40 to 59: all taxels show one', True)
    """
    n_frames, places = frames.shape[0], np.flatnonzero(usable)
    if places.size < _PICKED:
        return None
    picked = places[np.linspace(0, places.size - 1, _PICKED).astype(np.intp)]
    alike, values = np.zeros(n_frames, np.bool_), np.zeros(n_frames)
    for at, block in blocks_of(frames):
        flat = block.reshape(len(block), -1)
        first = flat[:, picked[:1]]
        maybe = np.flatnonzero((flat[:, picked] == first).all(axis=1))
        found = maybe[(flat[maybe][:, places] == first[maybe]).all(axis=1)]
        alike[at + found], values[at + found] = True, first[found, 0]
    if not alike.any() or np.count_nonzero(~alike) < _FEWEST_FRAMES:
        return None
    good = np.flatnonzero(~alike)
    looked = good[spread_over(good.size, _MOST_LOOKED)]
    shown = [piece[0][usable].astype(np.float64) for piece in pieces_at(frames, looked.tolist())]
    # A sensor without noise shows its rest in most taxels of a frame, and in all of many frames.
    usual, counts = zip(*(_commonest(one) for one in shown), strict=True)
    if np.quantile(counts, 0.9) >= places.size * math.exp(math.log(_BY_CHANCE) / places.size):
        return None
    totals = np.array([float(one.mean()) for one in shown])
    is_quiet = totals <= np.quantile(totals, _QUIET)
    quiet, rest = looked[is_quiet], float(np.median(totals[is_quiet]))
    instead = np.arange(n_frames)
    for run in runs_of(alike):
        before = float(np.mean(frames[run.start - 1 : run.start][:, usable])) if run.start > 0 else rest
        # Where there is no noise the rest is one of the usual values.
        if values[run.start] in usual or came_up(values[run.start] - rest, before - rest):
            continue
        beside = run.start - 1 if run.start > 0 else run.stop
        instead[run] = beside if len(run) <= SHORT else quiet[np.array(run) % len(quiet)]
    return Silent(frames, usable, instead) if (instead != np.arange(n_frames)).any() else None


def came_up(height: float, before: float) -> bool:
    """Tell whether one value everywhere, so high above rest, is what the mean of the frame before came up to."""
    return height > 0.0 and before > _NEAR * height


def _commonest(frame: Floats) -> tuple[float, int]:
    """Return the value that most taxels show, and how many."""
    values, counts = np.unique(frame, return_counts=True)
    return float(values[counts.argmax()]), int(counts.max())
