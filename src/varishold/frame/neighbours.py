"""What stands out of the taxels around it: single taxels, and whole lines of them."""

from __future__ import annotations

from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from varishold.frame.runs import runs_of

__all__ = ["largest_around", "median_around", "three_by_three", "whole_lines"]

# A line of taxels stands out where so many of it do, and of the lines beside it only so many.
_OF_LINE, _BESIDE_LINE, _SHORTEST_LINE = 0.8, 0.2, 5

Floats = NDArray[np.float64]
Mask = NDArray[np.bool_]
T = TypeVar("T", bound=np.generic)


def three_by_three(values: NDArray[T], off_pad: float) -> list[NDArray[T]]:
    """Return the values of the eight taxels around each, and its own as the fifth of nine; each of shape (rows, cols).

    `off_pad` is the value of what is off the pad.
    """
    rows, cols = values.shape
    padded = np.pad(values, 1, constant_values=off_pad)
    return [padded[down : down + rows, right : right + cols] for down in range(3) for right in range(3)]


def largest_around(beyond: Floats) -> Floats:
    """Return the largest of the values of the eight taxels around each, 0 at least; shape (rows, cols)."""
    largest = np.zeros_like(beyond)
    for values in _eight(beyond, 0.0):
        np.maximum(largest, values, out=largest)
    return largest


def median_around(values: Floats, usable: Mask) -> Floats:
    """Return the median of the values of the usable of the eight taxels around each; 0 where there is none."""
    rising = np.sort(_eight(np.where(usable, values, np.nan), np.nan), axis=0)
    many = np.count_nonzero(np.isfinite(rising), axis=0)
    middle = [np.take_along_axis(rising, np.maximum(k, 0)[None], axis=0)[0] for k in ((many - 1) // 2, many // 2)]
    return np.where(many > 0, (middle[0] + middle[1]) / 2, 0.0)


def _eight(values: Floats, off_pad: float) -> list[Floats]:
    found = three_by_three(values, off_pad)
    return found[:4] + found[5:]


def whole_lines(out: Mask, usable: Mask, *, side_by_side: int = 1) -> Mask:
    """Return rows and columns of which nearly all stands out, next to nothing of those beside them; (rows, cols).

    So many of them may stand side by side, where there are lines on both sides of them.
    """
    return usable & (_whole_rows(out, usable, side_by_side) | _whole_rows(out.T, usable.T, side_by_side).T)


def _whole_rows(out: Mask, usable: Mask, side_by_side: int) -> Mask:
    n = usable.sum(axis=1)
    shares = (out & usable).sum(axis=1) / np.maximum(n, 1)
    lines = (shares >= _OF_LINE) & (n >= _SHORTEST_LINE)
    for run in runs_of(lines):
        beside = [*shares[max(run.start - 1, 0) : run.start], *shares[run.stop : run.stop + 1]]
        between = len(run) == 1 or len(beside) == 2
        lines[run] = len(run) <= side_by_side and between and all(share <= _BESIDE_LINE for share in beside)
    return np.repeat(lines[:, None], usable.shape[1], axis=1)
