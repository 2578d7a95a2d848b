"""Readings of a stream that come without their sign: told where the stream begins, mended from then on."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from varishold.frame.fault import Mask
from varishold.frame.wrapped import signed_of, wrapped_readings

__all__ = ["RunningSign"]

# The first readings, which show it, and after how many of them it is asked for.
_FIRST, _ASKED_EVERY = 64, 16


class RunningSign:
    """Gives readings below zero their sign where they come without one, as numbers of some bits.

    Parameters
    ----------
    usable : ndarray of shape (rows, cols), bool

    Attributes
    ----------
    bits : int or None
        Of the numbers that come round; None where none do.
    """

    def __init__(self, usable: Mask) -> None:
        self._usable = usable
        self._first: list[NDArray[Any]] = []
        self._asks = True
        self.bits: int | None = None

    def update(self, reading: NDArray[Any]) -> NDArray[Any]:
        """Return the next reading, shape (rows, cols), with its signs."""
        if self._asks:
            self._first.append(np.array(reading))
            if len(self._first) % _ASKED_EVERY == 0:
                found = wrapped_readings(np.array(self._first), self._usable)
                self.bits = None if found is None else found.bits
                self._asks = self.bits is None and len(self._first) < _FIRST
                self._first = self._first if self._asks else []
        return reading if self.bits is None else signed_of(reading, self.bits)

    def words(self) -> tuple[str, ...]:
        """Return what is done, in words; nothing where nothing is."""
        if self.bits is None:
            return ()
        return (f"readings below zero come without their sign, as {self.bits}-bit numbers: taken as below zero",)
