"""Baselines as others have them, to be compared with: taken once, high pass, and adapted where nothing is felt."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

__all__ = ["PLAIN_ZEROS", "GatedZero", "HighPassZero", "StaticZero"]

_START_S = 1.0


class StaticZero:
    """The mean of the first second."""

    def __init__(self, sigma: NDArray[np.float64]) -> None:
        self.sigma = sigma
        self.baseline = np.zeros_like(sigma)
        self._n = 0
        self._last_s: float | None = None

    def update(self, time_s: float, frame: NDArray[np.uint16]) -> NDArray[np.float64]:
        """Take a frame and return it zeroed."""
        values = frame.astype(np.float64)
        passed_s = 0.0 if self._last_s is None else time_s - self._last_s
        self._last_s = time_s
        if time_s < _START_S:
            self._n += 1
            self.baseline = self.baseline + (values - self.baseline) / self._n
        zeroed: NDArray[np.float64] = values - self.baseline
        if time_s >= _START_S:
            self.adapt(passed_s, zeroed)
        return zeroed

    def adapt(self, passed_s: float, zeroed: NDArray[np.float64]) -> None:
        """Leave it as it is."""


class HighPassZero(StaticZero):
    """Every taxel's baseline runs after it: in 10 s, where something is felt in 30 s."""

    def adapt(self, passed_s: float, zeroed: NDArray[np.float64]) -> None:
        """Run after it."""
        felt = zeroed > 8.0 * self.sigma
        pace = np.where(felt, -math.expm1(-passed_s / 30.0), -math.expm1(-passed_s / 10.0))
        self.baseline = self.baseline + pace * zeroed


class GatedZero(StaticZero):
    """A taxel adapts in 2 s where nothing is felt, by the same hysteresis of 8 and 4 sigma."""

    def __init__(self, sigma: NDArray[np.float64]) -> None:
        super().__init__(sigma)
        self._felt = np.zeros(sigma.shape, np.bool_)

    def adapt(self, passed_s: float, zeroed: NDArray[np.float64]) -> None:
        """Adapt where free."""
        self._felt = zeroed > np.where(self._felt, 4.0, 8.0) * self.sigma
        self.baseline = self.baseline + ~self._felt * -math.expm1(-passed_s / 2.0) * zeroed


PLAIN_ZEROS = {"static": StaticZero, "high pass": HighPassZero, "gated": GatedZero}
