"""What faults of a recording's frames have in common: how they are read, mended and told."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Any, Protocol

import numpy as np
from numpy.typing import DTypeLike, NDArray

from varishold.files import let_go

__all__ = ["Fault", "Floats", "Frames", "Mask", "blocks_of", "in_type", "pieces_at", "starts_over"]

Floats = NDArray[np.float64]
Mask = NDArray[np.bool_]

# Bytes of readings, as floats, that are looked at together.
_TOGETHER = 1 << 24


class Frames(Protocol):
    """Frames of which a slice is read; an array is some."""

    @property
    def shape(self) -> tuple[int, ...]: ...
    def __getitem__(self, wanted: slice, /) -> Any: ...


class Fault(Protocol):
    """A fault that was found in a recording's frames."""

    def mended(self, first: int, last: int) -> NDArray[Any]:
        """Return frames first to last - 1 without it, in their own type; shape (last - first, rows, cols).

        Frames in which there is nothing to mend are not copied.
        """

    def words(self) -> tuple[str, ...]:
        """Return what is mended in the whole recording, in words; nothing where nothing is."""


def blocks_of(frames: Frames) -> Iterator[tuple[int, NDArray[Any]]]:
    """Yield the number of the first frame and some frames, in bounded memory: mapped ones are let go again."""
    n_frames, rows, cols = frames.shape
    many = max(1, _TOGETHER // (8 * rows * cols))
    # What others looked at here and there is still near.
    let_go(frames)
    for first in range(0, n_frames, many):
        block = np.asarray(frames[first : first + many])
        yield first, block
        let_go(block)


def pieces_at(frames: Frames, starts: Iterable[int], length: int = 1) -> Iterator[NDArray[Any]]:
    """Yield copies of so many frames from each of some numbers on, fewer at the end: mapped ones are let go again.

    Examples
    --------
    >>> frames = np.arange(5.0).reshape(5, 1, 1)
    >>> [piece.ravel().tolist() for piece in pieces_at(frames, [0, 3, 4], 2)]
    [[0.0, 1.0], [3.0, 4.0], [4.0]]
    """
    for start in starts:
        read = np.asarray(frames[start : start + length])
        piece = read.copy()
        let_go(read)
        yield piece


def starts_over(n_frames: int, length: int, most: int) -> list[int]:
    """Return where at most so many pieces of frames begin, evenly over a recording, no more than it has.

    Examples
    --------
    >>> starts_over(100, 10, 4), starts_over(15, 10, 4), starts_over(5, 10, 4)
    ([0, 30, 60, 90], [0, 5], [0])
    """
    starts: list[int] = (
        np.linspace(0, max(0, n_frames - length), min(most, -(-n_frames // length))).astype(int).tolist()
    )
    return starts


def in_type(values: Floats, dtype: DTypeLike) -> NDArray[Any]:
    """Return readings in a type: whole numbers are rounded, and end where the type does."""
    kind = np.dtype(dtype)
    if kind.kind in "iu":
        bounds = np.iinfo(kind)
        values = np.clip(np.rint(values), bounds.min, bounds.max)
    return values.astype(kind)
