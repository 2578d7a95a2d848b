"""A device's counters: they start again at zero, and go on all the same."""

from __future__ import annotations

import math

import numpy as np

from varishold.live.framing.model import Number

__all__ = ["Counting"]


class Counting:
    """Reads a number that comes with every frame; a whole one goes on where it wraps.

    Each step is taken the shorter way around, so that a damaged value does no lasting harm.

    Parameters
    ----------
    number : Number or None
        None where frames carry none.
    """

    def __init__(self, number: Number | None) -> None:
        self._number = number
        self._last: int | None = None

    def of_bytes(self, packet: bytes) -> float | None:
        """Return the number of a packet, times its unit."""
        number = self._number
        if number is None:
            return None
        value = np.frombuffer(packet, number.dtype, 1, number.at)[0]
        if number.dtype.kind == "f":
            return self._scaled(float(value))
        return self._on(int(value)) * number.unit_s

    def whole_of_bytes(self, packet: bytes) -> int | None:
        """Return the whole number of a packet."""
        if self._number is None:
            return None
        return self._on(int(np.frombuffer(packet, self._number.dtype, 1, self._number.at)[0]))

    def of_column(self, columns: list[float]) -> float | None:
        """Return the number in a text's column, times its unit."""
        if self._number is None or self._number.at >= len(columns):
            return None
        return self._scaled(columns[self._number.at])

    def whole_of_column(self, columns: list[float]) -> int | None:
        """Return the whole number in a text's column."""
        value = self.of_column(columns)
        return int(value) if value is not None and abs(value) < 2**53 else None

    def _scaled(self, value: float) -> float | None:
        return value * self._number.unit_s if self._number is not None and math.isfinite(value) else None

    def _on(self, value: int) -> int:
        if self._number is None or self._last is None:
            self._last = value
            return value
        span = 1 << (8 * self._number.dtype.itemsize)
        step = (value - self._last + span // 2) % span - span // 2
        self._last += step
        return self._last
