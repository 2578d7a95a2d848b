"""Taxels that seem to come in another order than they stand: what presses them would be smoother in the right one."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from varishold.frame.fault import Floats

__all__ = ["wiring_words"]

# Frames that are asked, and how many there are at least.
_ASKED, _FEWEST = 8, 3
_FEWEST_LINES = 8
# In the right order taxels differ from those beside them by less than this share of what they do as they come; presses
# that come in their order never do in another one.
_SMOOTHER = 0.75


def wiring_words(frames: NDArray[Any], usable: NDArray[np.bool_]) -> tuple[str, ...]:
    """Say in which order taxels seem to come, where they come in another than they stand; nothing where they do not.

    Looked for are every other line read backwards, lines of which every other one comes first, the lines of two halves
    by turns, and another shape.

    Parameters
    ----------
    frames : ndarray of shape (n_frames, rows, cols)
        Some of a recording.
    usable : ndarray of shape (rows, cols), bool

    Examples
    --------
    >>> y, x = np.mgrid[:12, :10]
    >>> frames = np.array([np.maximum(4 - np.hypot(y - k, x - 3), 0) for k in range(3, 10)])
    >>> wiring_words(frames, np.ones((12, 10), bool))
    ()
    >>> frames[:, 1::2] = frames[:, 1::2, ::-1]
    >>> wiring_words(frames, np.ones((12, 10), bool))
    ('every other row seems to come backwards: turned, what presses would be smoother; give the taxels as they stand',)
    """
    rows, cols = usable.shape
    if min(rows, cols) < _FEWEST_LINES:
        return ()
    pressed = _pressed(frames, usable)
    as_it_comes = _roughness(pressed)
    if len(pressed) < _FEWEST or not as_it_comes > 0.0:
        return ()
    orders = [
        (f"{words}: turned, what presses would be smoother; give the taxels as they stand", put)
        for words, put in _ORDERS
    ]
    if rows != cols and usable.all():
        orders.append((f"a shape of {cols} x {rows} would be smoother than {rows} x {cols}", _reshaped))
    roughness, words = min((_roughness(put(pressed)), words) for words, put in orders)
    return (words,) if roughness < _SMOOTHER * as_it_comes else ()


def _pressed(frames: NDArray[Any], usable: NDArray[np.bool_]) -> Floats:
    """Return frames in which much presses, without what the least pressed one shows; shape (n, rows, cols)."""
    # Sums of float16 and float32 overflow.
    seen = np.where(usable, frames, 0.0).astype(np.float64, copy=False)
    if not np.isfinite(seen).all():
        return seen[:0]
    seen -= seen[np.argmin(np.abs(seen).sum(axis=(1, 2)))]
    load = np.abs(seen).sum(axis=(1, 2))
    return seen[np.argsort(-load, kind="stable")[: min(_ASKED, int(np.count_nonzero(load)))]]


def _roughness(frames: Floats) -> float:
    """Return how far neighbours differ, by whole lines, so that a bar is as rough on a pad of any shape."""
    rows, cols = frames.shape[1:]
    return float(np.abs(np.diff(frames, axis=1)).sum() / cols + np.abs(np.diff(frames, axis=2)).sum() / rows)


def _turned(frames: Floats) -> Floats:
    made = frames.copy()
    made[:, 1::2] = made[:, 1::2, ::-1]
    return made


def _apart(frames: Floats) -> Floats:
    """Return rows in their places of which every other one came first."""
    made = np.empty_like(frames)
    half = (frames.shape[1] + 1) // 2
    made[:, ::2], made[:, 1::2] = frames[:, :half], frames[:, half:]
    return made


def _halves(frames: Floats) -> Floats:
    """Return rows in their places of which those of two halves came by turns."""
    return np.concatenate([frames[:, ::2], frames[:, 1::2]], axis=1)


def _reshaped(frames: Floats) -> Floats:
    n, rows, cols = frames.shape
    return frames.reshape(n, cols, rows)


def _of_columns(put: Callable[[Floats], Floats]) -> Callable[[Floats], Floats]:
    return lambda frames: put(frames.swapaxes(1, 2)).swapaxes(1, 2)


_ORDERS: tuple[tuple[str, Callable[[Floats], Floats]], ...] = (
    ("every other row seems to come backwards", _turned),
    ("every other column seems to come backwards", _of_columns(_turned)),
    ("rows seem to come every other one first (0, 2, 4, ..., 1, 3, 5, ...)", _apart),
    ("columns seem to come every other one first (0, 2, 4, ..., 1, 3, 5, ...)", _of_columns(_apart)),
    ("rows of two halves seem to come by turns", _halves),
    ("columns of two halves seem to come by turns", _of_columns(_halves)),
)
