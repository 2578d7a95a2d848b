"""Masks as whole numbers, a bit a taxel: grown, joined and taken apart in a few instructions a step.

A row takes one bit more than it has columns; that bit is never set, so that a shift by one never reaches the next row.
Neighbours are the eight around a taxel.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

__all__ = ["PatchGrid", "in_patches"]


class PatchGrid:
    """The taxels of a pad as the bits of a number.

    Parameters
    ----------
    shape : (int, int)
        Rows and columns.

    Examples
    --------
    >>> import numpy as np
    >>> grid = PatchGrid((3, 4))
    >>> mask = np.array([[1, 1, 0, 0], [0, 1, 0, 0], [0, 0, 0, 1]], bool)
    >>> grid.mask(grid.joined(grid.crowded(grid.bits(mask)), grid.bits(mask))).astype(int)
    array([[1, 1, 0, 0],
           [0, 1, 0, 0],
           [0, 0, 0, 0]])
    """

    def __init__(self, shape: tuple[int, int]) -> None:
        rows, cols = shape
        self._stride = cols + 1
        self._n_bits = rows * self._stride
        self._n_bytes = (self._n_bits + 7) // 8
        self._shape = (rows, self._stride)
        self._room = np.zeros(self._shape, np.bool_)
        self._inside = self._room[:, :cols]
        self._inside[:] = True
        self.all = int.from_bytes(np.packbits(self._room, bitorder="little").tobytes(), "little")

    def bits(self, mask: NDArray[np.bool_]) -> int:
        """Return a mask of shape (rows, cols) as a number."""
        self._inside[:] = mask
        return int.from_bytes(np.packbits(self._room, bitorder="little").tobytes(), "little")

    def mask(self, bits: int) -> NDArray[np.bool_]:
        """Return a number as a mask of shape (rows, cols), a new one."""
        raw = np.frombuffer(bits.to_bytes(self._n_bytes, "little"), np.uint8)
        flat = np.unpackbits(raw, count=self._n_bits, bitorder="little").view(np.bool_)
        return flat.reshape(self._shape)[:, :-1]

    def grown(self, bits: int, by: int = 1) -> int:
        """Return a set and all taxels at most so many rows and columns from it."""
        for _ in range(by):
            bits |= bits << 1 | bits >> 1
            bits = (bits | bits << self._stride | bits >> self._stride) & self.all
        return bits

    def crowded(self, bits: int) -> int:
        """Return the taxels of a set that have two neighbours or more in it.

        Every connected patch of three taxels or more has such a taxel, no smaller one has.
        """
        once = twice = 0
        for shift in (1, self._stride - 1, self._stride, self._stride + 1):
            for moved in (bits << shift, bits >> shift):
                twice |= once & moved
                once |= moved
        return bits & twice

    def joined(self, seeds: int, through: int) -> int:
        """Return what is connected with a seed inside `through`."""
        found = seeds & through
        while True:
            wider = self.grown(found) & through
            if wider == found:
                return found
            found = wider

    def parts(self, bits: int) -> Iterator[int]:
        """Go through the connected patches of a set."""
        while bits:
            part = self.joined(bits & -bits, bits)
            yield part
            bits &= ~part


def in_patches(mask: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Return the part of a mask, (rows, cols), that lies in patches of three neighbours or more."""
    grid = PatchGrid((mask.shape[0], mask.shape[1]))
    bits = grid.bits(mask)
    return grid.mask(grid.joined(grid.crowded(bits), bits))
