"""The frames of presses that are pooled: those that hold most of the load, of all pads together."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from varishold.errors import InputError
from varishold.frame import recording_noise
from varishold.frame.floor import FLOOR_SIGMAS
from varishold.frame.spread import spread_over
from varishold.touch.course.one_sensor import pads_in_words
from varishold.touch.course.presses import Press

__all__ = ["HeldFrames", "held_frames", "held_of", "one_size", "press_floor", "some_presses"]

Floats = NDArray[np.float64]

# Frames that hold this share of the largest load are pooled, at most so many of them.
_HELD, _MOST_HELD = 0.8, 6
# What is typical of presses is told well enough by so many.
_MOST_LOOKED_AT = 100


def some_presses(presses: Sequence[Press]) -> list[Press]:
    """Return presses that stand for all: evenly drawn from the first to the last."""
    return [presses[k] for k in spread_over(len(presses), _MOST_LOOKED_AT)]


def press_floor(presses: Sequence[Press]) -> float:
    """Return the standard plane of presses: four sigma of their noise, in the unit of the frames."""
    pads = [(frames, press.fields[name]) for press in some_presses(presses) for name, frames in press.pads.items()]
    noise = [recording_noise(frames, field) for frames, field in pads]
    return FLOOR_SIGMAS * float(np.median(noise))


def held_frames(load: Floats) -> NDArray[np.intp]:
    """Return which frames of a press are pooled: at most six that hold most of the load, shape (n_frames,)."""
    holding = np.flatnonzero(load >= _HELD * load.max())
    spread = np.unique(np.linspace(0, len(holding) - 1, _MOST_HELD).round().astype(int))
    return np.asarray(holding[spread], dtype=np.intp)


def held_of(press: Press, floor: float) -> NDArray[np.intp]:
    """Return which frames of a press are pooled, by the load of all its pads above the floor."""
    load = sum(np.maximum(frames - floor, 0.0).sum(axis=(1, 2)) for frames in press.pads.values())
    return held_frames(np.asarray(load))


def one_size(pads: Mapping[str, tuple[int, int]]) -> tuple[int, int]:
    """Return the rows and columns that all pads have.

    Raises
    ------
    InputError
        If they are of several sizes.
    """
    size, *others = set(pads.values())
    if others:
        raise InputError(
            f"pads must be of one size, got {pads_in_words(pads)}; measure each by itself, or learn with "
            "TactileClassifier"
        )
    return size


@dataclass(frozen=True, eq=False)
class HeldFrames:
    """The held frames of presses on pads of one size.

    Parameters
    ----------
    frames : ndarray of shape (n_frames, n_pads, rows, cols), float64
        Of press after press.
    starts : ndarray of shape (n_presses,), int
        Where each press's frames begin.
    """

    frames: Floats
    starts: NDArray[np.intp]

    @classmethod
    def of(cls, presses: Sequence[Press], pads: Mapping[str, tuple[int, int]], floor: float) -> HeldFrames:
        """Return the held frames of presses that all have the same pads.

        Parameters
        ----------
        presses : sequence of Press
            At least one.
        pads : mapping of str to (int, int)
            Rows and columns of each pad, by name, in the order of the result; all of `one_size`.
        floor : float
            What counts as load begins above it.

        Raises
        ------
        InputError
            If a press has other pads.
        """
        kept = []
        for press in presses:
            if press.shapes != pads:
                raise InputError(
                    f"{press.place}: has the pads {pads_in_words(press.shapes)}, wanted are {pads_in_words(pads)}"
                )
            held = held_of(press, floor)
            kept.append(np.stack([press.pads[name][held] for name in pads], axis=1))
        return cls(np.concatenate(kept), np.cumsum([0, *(len(frames) for frames in kept[:-1])]))

    def mean(self, numbers: Floats) -> Floats:
        """Return each press's mean of what was measured of its frames, shape (n_presses, n_numbers)."""
        counts = np.diff(self.starts, append=len(self.frames))
        return np.asarray(np.add.reduceat(numbers, self.starts, axis=0) / counts[:, None])
