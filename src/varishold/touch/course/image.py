"""What a press looks like, wherever on the pad it lies: the mean held frame, moved so that its middle is the window's.

Shapes of sections sum up a form; on a small pad two things may have much the same sums and yet look different.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

__all__ = ["image_names", "image_shape", "press_images"]

Floats = NDArray[np.float64]

# A window has at most so many cells along a side; on a larger pad a cell is the mean of several taxels.
_MOST_CELLS = 12
# A pad of fewer lines shows no form; its taxels may be listed in any order.
_FEWEST_LINES = 4


def image_shape(shape: tuple[int, int]) -> tuple[int, int]:
    """Return how many rows and columns of cells the window of a pad has; none where it has fewer than four lines.

    Examples
    --------
    >>> image_shape((5, 9)), image_shape((28, 50)), image_shape((1, 12))
    ((5, 9), (6, 10), (0, 0))
    """
    if min(shape) < _FEWEST_LINES:
        return 0, 0
    side = _cell_side(shape)
    return math.ceil(shape[0] / side), math.ceil(shape[1] / side)


def image_names(shape: tuple[int, int]) -> list[str]:
    """Return the name of each cell, row by row."""
    rows, cols = image_shape(shape)
    return [f"image_at_row_{row}_col_{col}" for row in range(rows) for col in range(cols)]


def press_images(held: Sequence[Floats]) -> Floats:
    """Return the cells of each press, shape (n_presses, n_cells): square roots of shares of the highest one.

    Parameters
    ----------
    held : sequence of ndarray of shape (n_frames, rows, cols), float64
        The frames of each press that are pooled, above the floor; a press that touches nothing has cells of 0.
    """
    return np.stack([_image(frames.mean(axis=0)) for frames in held])


def _image(frame: Floats) -> Floats:
    rows, cols = image_shape((frame.shape[0], frame.shape[1]))
    whole, highest = float(frame.sum()), float(frame.max())
    # Loads near the smallest numbers have no middle.
    if rows == 0 or not whole > 0 or not highest > 0:
        return np.zeros(rows * cols)
    side = _cell_side((frame.shape[0], frame.shape[1]))
    shares = frame / highest
    row, col = np.indices(frame.shape)
    moved = shares
    for axis, (at, cells) in enumerate(((row, rows), (col, cols))):
        middle = float((shares * at).sum() / shares.sum())
        moved = _moved(moved, axis, middle - (cells * side - 1) / 2, cells * side)
    means = moved.reshape(rows, side, cols, side).mean(axis=(1, 3))
    return np.asarray(np.sqrt(means / means.max()).ravel())


def _moved(frame: Floats, axis: int, start: float, n: int) -> Floats:
    """Return a frame from a place between taxels on along an axis, so many of them; 0 beyond the pad."""
    at = start + np.arange(n)
    below = np.floor(at).astype(np.intp)
    part = at - below
    length = frame.shape[axis]

    def taken(places: NDArray[np.intp]) -> Floats:
        inside = (places >= 0) & (places < length)
        found = np.take(frame, places.clip(0, length - 1), axis=axis)
        return np.asarray(found * (inside[:, None] if axis == 0 else inside))

    weight = part[:, None] if axis == 0 else part
    return np.asarray((1 - weight) * taken(below) + weight * taken(below + 1))


def _cell_side(shape: tuple[int, int]) -> int:
    """Return how many taxels long a side of a cell is."""
    return math.ceil(max(shape) / _MOST_CELLS)
