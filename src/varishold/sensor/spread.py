"""How a taxel's stress reaches its neighbours, and how that is undone without raising the noise."""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from varishold.errors import InputError

__all__ = ["LARGEST_WITH_GAPS", "Spread", "spread_of"]

Floats = NDArray[np.float64]

#: A pad with gaps has no patterns in closed form; theirs are found numerically on pads of up to so many taxels.
LARGEST_WITH_GAPS = 1024
# A pattern of which less than this share is left is not restored in full: its noise would be raised more than
# 1 / share times.
_LEAST_SHARE = 0.25


class Spread:
    """Crosstalk and blur on a pad: a symmetric mixing of neighbours that leaves an even pressure even.

    With L the Laplacian of the grid of taxels (each taxel's four neighbours, those that exist), it is

        K = (I - crosstalk L) exp(-blur^2 L / 2),

    each taxel giving the share `crosstalk` to each neighbour, and a Gaussian blur of `blur` taxels. Both are diagonal
    in the patterns of L, which on a full rectangle are cosines. The inverse divides each pattern by its share
    k, where k is at least 1/4, and multiplies by 16 k below: exact where it can be, and never louder than 4.

    Parameters
    ----------
    shape : (int, int)
        Rows and columns.
    field : ndarray of shape (rows, cols), bool, optional
        False where there is no taxel.
    crosstalk, blur : float
        As above.
    """

    def __init__(self, shape: tuple[int, int], field: NDArray[np.bool_] | None, crosstalk: float, blur: float) -> None:
        self._shape = shape
        self._field = None if field is None or field.all() else field
        if self._field is None:
            self._down, down = _cosines(shape[0])
            self._across, across = _cosines(shape[1])
            eigenvalues = down[:, None] + across
        else:
            if self._field.sum() > LARGEST_WITH_GAPS:
                raise InputError(
                    f"crosstalk and blur on a pad with gaps are undone for up to {LARGEST_WITH_GAPS} taxels, got "
                    f"{self._field.sum()}; leave crosstalk and blur_taxels out"
                )
            eigenvalues, self._patterns = np.linalg.eigh(_laplacian(self._field))
        share = (1.0 - crosstalk * eigenvalues) * np.exp(-0.5 * blur**2 * eigenvalues)
        self._share = share
        kept = np.where(np.abs(share) >= _LEAST_SHARE, share, 1.0)
        self._inverse = np.where(np.abs(share) >= _LEAST_SHARE, 1.0 / kept, share / _LEAST_SHARE**2)
        #: By how much undoing raises white noise, root mean square.
        self.loudness = float(np.sqrt(np.mean(self._inverse**2)))

    @property
    def factors(self) -> tuple[Floats, Floats, Floats]:
        """What undoes it on a full rectangle: patterns down (rows, rows) and across (cols, cols), and their factors."""
        return self._down, self._across, self._inverse

    def mix(self, frames: Floats) -> Floats:
        """Return K applied to frames of shape (..., rows, cols)."""
        return self._filtered(frames, self._share)

    def undo(self, frames: Floats) -> Floats:
        """Return the inverse of `mix` applied to frames of shape (..., rows, cols)."""
        return self._filtered(frames, self._inverse)

    def _filtered(self, frames: Floats, shares: Floats) -> Floats:
        if self._field is None:
            down, across = self._down, self._across
            return down.T @ ((down @ frames @ across.T) * shares) @ across
        out = frames.copy()
        out[..., self._field] = ((frames[..., self._field] @ self._patterns) * shares) @ self._patterns.T
        return out


@lru_cache(maxsize=32)
def _cached(shape: tuple[int, int], field: bytes | None, crosstalk: float, blur: float) -> Spread:
    mask = None if field is None else np.frombuffer(field, np.bool_).reshape(shape)
    return Spread(shape, mask, crosstalk, blur)


def spread_of(shape: tuple[int, int], field: NDArray[np.bool_] | None, crosstalk: float, blur: float) -> Spread:
    """Return the spread on a pad, made once for each."""
    return _cached(shape, None if field is None else field.tobytes(), crosstalk, blur)


def _cosines(n: int) -> tuple[Floats, Floats]:
    """Return the patterns of a line of n taxels, one a row, orthonormal, and their eigenvalues."""
    k, i = np.arange(n)[:, None], np.arange(n)
    patterns = np.cos(math.pi * k * (2 * i + 1) / (2 * n)) * math.sqrt(2.0 / n)
    patterns[0] /= math.sqrt(2.0)
    return patterns, 2.0 - 2.0 * np.cos(math.pi * np.arange(n) / n)


def _laplacian(field: NDArray[np.bool_]) -> Floats:
    number = np.full(field.shape, -1)
    number[field] = np.arange(np.count_nonzero(field))
    out = np.zeros((np.count_nonzero(field),) * 2)
    for one, other in ((number[1:], number[:-1]), (number[:, 1:], number[:, :-1])):
        both = (one >= 0) & (other >= 0)
        i, j = one[both], other[both]
        np.add.at(out, (i, i), 1.0)
        np.add.at(out, (j, j), 1.0)
        out[i, j] = out[j, i] = -1.0
    return out
