"""Whether what moves slides: by the form of the section, or by the shear that is measured."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

from varishold.errors import InputError
from varishold.touch.names import KINDS
from varishold.touch.surface import Surface
from varishold.touch.tracking.felt import Felt

__all__ = ["Shear", "as_shear", "is_sliding"]

Point = tuple[float, float]
# A flat face and what has square sections cannot roll without showing others. Cones and ridges could not either, but
# few taxels tell them from balls and lying cylinders too seldom.
_SLIDES = np.array([kind.form == "pillar" or kind.section == "square" for kind in KINDS])
# How sure it must be that it is one of them.
_SURE = 0.9
# Shear pulls along if it comes to this share of the largest shear of the touch, to this share of its load, and to so
# many sigma of its noise.
_OF_LARGEST, _OF_LOAD, _SIGMAS = 0.5, 0.05, 4.0


def is_sliding(answer: Surface | None) -> bool:
    """Tell whether a contact that moves must slide, because its form cannot roll.

    A ball and a lying cylinder look alike whether they roll or slide.
    """
    return answer is not None and float(answer.kind_probability[_SLIDES].sum()) >= _SURE


class Shear:
    """The shear under one touch: its sum now, and the largest so far."""

    def __init__(self) -> None:
        self._now = np.zeros(2)
        self._largest = self._noise = 0.0

    def update(self, felt: Felt, shear: NDArray[np.float64], sigma: float) -> None:
        """Take a new frame's shear, of shape (n_taxels, 2), and its noise."""
        under = shear[felt.taxels]
        self._now = under.sum(axis=0)
        self._noise = sigma * math.sqrt(len(under))
        self._largest = max(self._largest, float(np.hypot(*self._now)))

    def pulls(self, way: Point, load: float) -> bool:
        """Tell whether it pulls along a way."""
        along = float(self._now @ way) / max(math.hypot(*way), 1e-300)
        return along > max(_OF_LARGEST * self._largest, _OF_LOAD * load, _SIGMAS * self._noise)


def as_shear(shear: ArrayLike, shape: tuple[int, int]) -> NDArray[np.float64]:
    """Return a frame's shear as float64, of shape (rows * cols, 2).

    Raises
    ------
    InputError
        If it has another shape than (rows, cols, 2), or is not finite.
    """
    try:
        values = np.asarray(shear, dtype=np.float64)
    except (TypeError, ValueError, OverflowError):
        values = np.empty(0)
    if values.shape != (*shape, 2):
        raise InputError(f"shear must be numbers of shape (rows, cols, 2), here {(*shape, 2)}; got {values.shape}")
    if not np.isfinite(values).all():
        row, col = np.argwhere(~np.isfinite(values).all(axis=2))[0].tolist()
        raise InputError(f"shear must be finite, got {values[row, col].tolist()} at (row, col) = ({row}, {col})")
    return values.reshape(-1, 2)
