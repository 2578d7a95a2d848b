"""Readings of a stream in which a pad says nothing: all taxels show one value, which their noise never lets them."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from varishold.frame.readings import LARGEST
from varishold.frame.silent import SHORT, came_up

__all__ = ["RunningSilence"]

# Readings with a picture after which it is known that a pad has noise, and taxels without which nothing is known.
_KNOWN, _FEWEST_TAXELS = 30, 8


class RunningSilence:
    """Watches a pad's readings; what it keeps does not grow.

    Parameters
    ----------
    usable : ndarray of shape (rows, cols), bool
    rises : bool
        Whether larger readings mean more pressure.

    Attributes
    ----------
    lasts : bool
        Whether the pad has said nothing for more than a few readings.

    Examples
    --------
    >>> silence = RunningSilence(np.ones((4, 4), bool))
    >>> rng = np.random.default_rng(0)
    >>> for k in range(100):
    ...     read = silence.update(rng.normal(200, 1, (4, 4)) if k < 60 else np.zeros((4, 4)))
    ...     if k in (62, 80):
    ...         print(k, silence.lasts, bool(read.mean() > 190))
    62 False True
    80 True True
    """

    def __init__(self, usable: NDArray[np.bool_], *, rises: bool = True) -> None:
        self._places = np.flatnonzero(usable)
        self._sign = 1.0 if rises else -1.0
        self._n_pictures = self._n_silent = 0
        self._has_noise = self._places.size >= _FEWEST_TAXELS
        self._rest = 0.0
        self._last: NDArray[Any] | None = None
        self.lasts = False

    def update(self, values: NDArray[Any]) -> NDArray[Any]:
        """Return what stands for the next reading, shape (rows, cols): itself, or the last one that said something."""
        if not self._says_nothing(values):
            self._last, self._n_silent, self.lasts = values, 0, False
            return values
        self._n_silent += 1
        self.lasts = self._n_silent > SHORT
        return values if self._last is None else self._last

    def _says_nothing(self, values: NDArray[Any]) -> bool:
        if not self._has_noise:
            return False
        flat = values.ravel()
        value = flat[self._places[0]]
        alike = bool(value == flat[self._places[-1]]) and bool((flat[self._places] == value).all())
        if self._n_pictures < _KNOWN:
            # A pad that rests without noise shows one value from the start.
            self._has_noise = not alike
            self._rest += self._mean(flat) / _KNOWN
            self._n_pictures += 1
            return False
        if not alike or self._n_silent:
            return alike
        last = self._rest if self._last is None else self._mean(self._last.ravel())
        return not came_up(self._sign * (float(value) - self._rest), self._sign * (last - self._rest))

    def _mean(self, flat: NDArray[Any]) -> float:
        """Return the mean reading, without what is no number; 0 where all are none."""
        with np.errstate(invalid="ignore"):
            read = flat[self._places].astype(np.float64)
        read = read[np.abs(read) < LARGEST]
        return float(read.mean()) if read.size else 0.0
