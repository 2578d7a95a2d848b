"""What stands out of the taxels around it: single taxels, and whole lines of them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

__all__ = ["largest_around", "whole_lines"]

# A line of taxels stands out where so many of it do, and of the lines beside it only so many.
_OF_LINE, _BESIDE_LINE, _SHORTEST_LINE = 0.8, 0.2, 5

Floats = NDArray[np.float64]
Mask = NDArray[np.bool_]


def largest_around(beyond: Floats) -> Floats:
    """Return the largest of the values of the eight taxels around each, 0 at least; shape (rows, cols)."""
    padded = np.pad(beyond, 1)
    rows, cols = beyond.shape
    largest = np.zeros_like(beyond)
    for down in range(3):
        for right in range(3):
            if (down, right) != (1, 1):
                np.maximum(largest, padded[down : down + rows, right : right + cols], out=largest)
    return largest


def whole_lines(out: Mask, usable: Mask) -> Mask:
    """Return rows and columns of which nearly all stands out, next to nothing of those beside them; (rows, cols)."""
    return usable & (_whole_rows(out, usable) | _whole_rows(out.T, usable.T).T)


def _whole_rows(out: Mask, usable: Mask) -> Mask:
    n = usable.sum(axis=1)
    shares = np.pad((out & usable).sum(axis=1) / np.maximum(n, 1), 1)
    lines = (shares[1:-1] >= _OF_LINE) & (n >= _SHORTEST_LINE)
    lines &= (shares[:-2] <= _BESIDE_LINE) & (shares[2:] <= _BESIDE_LINE)
    return np.repeat(lines[:, None], usable.shape[1], axis=1)
