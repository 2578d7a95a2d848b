"""Features of a data set that are pads: a frame a row, or a window of several that were read since the row before."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from varishold.recording.stored import Column, Turned

__all__ = ["Window", "window_of"]

# What the first side of a window is called.
_TIMES = ("time", "times", "window", "step", "steps", "sample", "samples", "history", "frames", "k", "t")
# Components of a taxel, and which of them is along the pad's normal.
_COMPONENTS, _NORMAL = 3, 2


@dataclass(frozen=True)
class Window:
    """A column of which each row holds one frame or several.

    Parameters
    ----------
    column : Column
        Of shape (n_rows, ...), or (n_rows, times, ...) where there are several.
    times : int
        Frames of a row.
    notes : tuple of str
        What was assumed.
    """

    column: Any
    times: int = 1
    notes: tuple[str, ...] = ()

    @property
    def shape(self) -> tuple[int, ...]:
        """What one frame a row would have."""
        tail = self.column.shape[1:]
        return (self.column.shape[0], *(tail[1:] if self.times > 1 else tail))

    @property
    def dtype(self) -> np.dtype[Any]:
        dtype: np.dtype[Any] = self.column.dtype
        return dtype

    def __getitem__(self, wanted: slice, /) -> NDArray[Any]:
        return self.spread(self.times)[wanted]

    def spread(self, times: int) -> _Spread:
        """Return it with so many frames a row; each reading stays until the next."""
        return _Spread(self, times)


@dataclass(frozen=True)
class _Spread:
    window: Window
    times: int

    @property
    def shape(self) -> tuple[int, ...]:
        n_rows, *tail = self.window.shape
        return (n_rows * self.times, *tail)

    @property
    def dtype(self) -> np.dtype[Any]:
        return self.window.dtype

    def check(self) -> None:
        """Check the column that it is made of."""
        column = self.window.column
        while isinstance(column, Turned):
            column = column.source
        column.check()

    def small(self) -> NDArray[Any]:
        """Read all of it."""
        self.check()
        return self[:]

    def __getitem__(self, wanted: slice, /) -> NDArray[Any]:
        first, last, _ = wanted.indices(self.shape[0])
        rows = slice(first // self.times, math.ceil(last / self.times))
        block = np.asarray(self.window.column[rows])
        block = block if self.window.times > 1 else block[:, None]
        # Which of its readings each frame of a row shows.
        shown = np.arange(self.times) * self.window.times // self.times
        frames = block if len(shown) == block.shape[1] else block[:, shown]
        begun = rows.start * self.times
        return frames.reshape(-1, *self.shape[1:])[first - begun : last - begun]


def window_of(name: str, column: Column, names: Sequence[str]) -> Window | None:
    """Return what a feature of two sides or three holds; None where nobody can know.

    Parameters
    ----------
    name : str
    column : Column
        Of shape (n_rows, rows, cols), (n_rows, times, rows, cols) or (n_rows, rows, cols, 3).
    names : sequence of str
        What the sides are called; may be empty.
    """
    tail = column.shape[1:]
    if len(tail) == 2:
        return Window(column)
    if len(tail) != 3:
        return None
    timely = bool(names) and names[0].lower() in _TIMES
    if not timely and tail[2] == _COMPONENTS:
        turned = Turned(column, tail[:2], lambda block: block[..., _NORMAL])
        return Window(turned, notes=(f"{name}: x, y, z of each taxel; z is taken as pressure",))
    if not timely and (names or tail[0] == _COMPONENTS):
        # Components, or a picture's colours: what the first side is nobody has said.
        return None
    if tail[0] == 1:
        return Window(Turned(column, tail[1:], lambda block: block[:, 0]))
    return Window(column, tail[0])
