"""The noise of each taxel while frames come in: a running median, so that presses and impulses hardly count."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from varishold.frame.noise import MEDIAN_ABS_NORMAL

__all__ = ["RunningNoise"]

# Frames so far apart are compared: frames that come twice and filters in the sensor do not hide the noise.
_APART_S = 0.1
# How soon it follows. Seconds.
_MEMORY_S = 20.0
# The first comparisons are averaged; a running median would be long on its way.
_AVERAGED = 16
_SIGMA_OF_MEAN = math.sqrt(math.pi) / 2.0
# From the median of absolute differences of two to a standard deviation.
_SIGMA_OF_MEDIAN = 1.0 / (MEDIAN_ABS_NORMAL * math.sqrt(2.0))


class RunningNoise:
    """Standard deviation of each taxel's noise, from what changes within a tenth of a second.

    Parameters
    ----------
    usable : ndarray of shape (rows, cols), bool
    least : float
        No noise is taken to be less, in the unit of the frames.

    Attributes
    ----------
    sigma : ndarray of shape (rows, cols), float64
        As it was measured; replaced, never written into.
    floored : ndarray of shape (rows, cols), float64
        Nowhere less than the skin's median, nor than `least`.
    """

    def __init__(self, usable: NDArray[np.bool_], least: float = 0.0) -> None:
        self._usable = usable
        self.least = least
        self._before: NDArray[np.float64] | None = None
        self._waited_s = 0.0
        self._n_averaged = 0
        self._take(np.zeros(usable.shape))

    @property
    def known(self) -> bool:
        """Whether it has been measured."""
        return self._n_averaged >= _AVERAGED

    def set(self, sigma: NDArray[np.float64]) -> None:
        """Begin with a noise that was measured otherwise."""
        self._n_averaged = _AVERAGED
        self._take(sigma)

    def _take(self, sigma: NDArray[np.float64]) -> None:
        self.sigma = sigma
        self.median = float(np.median(sigma[self._usable])) if self._usable.any() else 0.0
        self.floored = np.maximum(sigma, max(self.median, self.least))

    def add(self, passed_s: float, values: NDArray[np.float64]) -> bool:
        """Take a frame; tell whether the noise was measured anew.

        Parameters
        ----------
        passed_s : float
            Since the last frame.
        values : ndarray of shape (rows, cols), float64
            Finite; kept until the next frame that is compared.
        """
        self._waited_s += passed_s
        if self._before is not None and self._waited_s < _APART_S:
            return False
        if self._before is not None:
            self._compare(np.abs(values - self._before))
        self._before, self._waited_s = values, 0.0
        return True

    def _compare(self, change: NDArray[np.float64]) -> None:
        if self._n_averaged < _AVERAGED:
            self._n_averaged += 1
            self._take(self.sigma + (_SIGMA_OF_MEAN * change - self.sigma) / self._n_averaged)
        else:
            step = min(self._waited_s / _MEMORY_S, 0.5)
            # A running median: a step up where the change is larger than expected, one down where it is smaller.
            pace = step * np.maximum(self.sigma, max(self.median, self.least))
            up = np.sign(change - self.sigma / _SIGMA_OF_MEDIAN)
            self._take(np.maximum(self.sigma + pace * up, 0.0))

    def forget_frame(self) -> None:
        """Compare the next frame with none before it: time was lost in between."""
        self._before = None
