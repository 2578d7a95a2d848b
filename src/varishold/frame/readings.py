"""Frames as they come from a sensor, one after another: checked, and finite."""

from __future__ import annotations

import contextlib
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from varishold.errors import InputError
from varishold.frame.checks import MOST_READ, as_floats
from varishold.frame.noise import ROUNDING

__all__ = ["LARGEST", "Readings", "as_shape"]

#: Beyond it a reading is no number that a sensor sends. What a zero leaves of lesser ones, and what is louder once
#: crosstalk is undone, stays within what a frame may hold.
LARGEST = MOST_READ / 1e40
# Noise is no less than this share of the first readings, where nothing else is known of it.
_LEAST_OF_READING = 1e-6


def as_shape(shape: tuple[int, int]) -> tuple[int, int]:
    """Return the rows and columns of a pad.

    Raises
    ------
    InputError
        If they are not two whole numbers from 1.
    """
    sizes: tuple[Any, ...] = ()
    with contextlib.suppress(TypeError):
        sizes = tuple(shape)
    if len(sizes) != 2 or not all(isinstance(n, int | np.integer) and n > 0 for n in sizes):
        raise InputError(f"shape must be (rows, cols), two whole numbers from 1, got {shape!r}")
    return int(sizes[0]), int(sizes[1])


class Readings:
    """Takes frames; a reading that is no finite number counts as the taxel's last one.

    Parameters
    ----------
    usable : ndarray of shape (rows, cols), bool
        The taxels that are counted.

    Attributes
    ----------
    n_frames, n_not_finite : int
        How many frames came, and readings that were no finite numbers.
    wrong : ndarray of shape (rows, cols), bool, or None
        Where the last frame held such readings.
    least_noise : float
        Less noise than this cannot be told from none, in the unit of the frames: rounding's where they are whole
        numbers, otherwise a millionth of the first reading.
    """

    def __init__(self, usable: NDArray[np.bool_]) -> None:
        self._usable = usable
        self._last: NDArray[np.float64] | None = None
        self.n_frames = self.n_not_finite = 0
        self.wrong: NDArray[np.bool_] | None = None
        self.least_noise = 0.0

    @property
    def newest(self) -> NDArray[np.float64]:
        """The newest frame that was taken."""
        if self._last is None:
            raise InputError("no frame was taken yet")
        return self._last

    def take(self, frame: ArrayLike) -> NDArray[np.float64]:
        """Return a frame as finite floats, in an array of its own that nobody writes into.

        Raises
        ------
        InputError
            If it has another shape or is none.
        """
        if type(frame) is not np.ndarray or frame.ndim != 2 or frame.dtype.kind not in "iuf":
            frame = as_floats(frame, 2, "a frame", masked=True)
        if frame.shape != self._usable.shape:
            raise InputError(f"a frame must have the shape of the pad, {self._usable.shape}, got {frame.shape}")
        self.wrong = None
        # One sum tells that all are finite, or that one is not or is huge.
        with np.errstate(invalid="ignore", over="ignore"):
            values = np.array(frame, np.float64, order="C")
            total = float(values.sum())
        if not abs(total) < LARGEST:
            self.wrong = ~(np.abs(values) < LARGEST)
            self.n_not_finite += int(np.count_nonzero(self.wrong & self._usable))
            values[self.wrong] = 0.0 if self._last is None else self._last[self.wrong]
        if self._last is None:
            whole = frame.dtype.kind in "iu"
            self.least_noise = ROUNDING if whole else _LEAST_OF_READING * float(np.abs(values).max())
        self._last = values
        self.n_frames += 1
        return values
