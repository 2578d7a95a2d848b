"""How noisy the frames are, by what the contacts' frames say and by how free taxels change from frame to frame."""

from __future__ import annotations

import math
from collections import deque
from statistics import median

import numpy as np
from numpy.typing import NDArray

from varishold.touch.tracking.felt import Felt

__all__ = ["Noise"]

# The noise is the median of so many estimates: an impulse, or a touch not yet found, is in few of them.
_KEPT = 31
# Frames are compared so far apart, if so many taxels are free.
_INTERVAL_S, _FEWEST = 0.02, 6


class Noise:
    """Follows the standard deviation of the frames' noise.

    A single frame of few taxels does not tell its noise from its contacts, and one of few counts hardly shows any; two
    frames do.
    """

    def __init__(self) -> None:
        self._told: deque[float] = deque(maxlen=_KEPT)
        self._measured: deque[float] = deque(maxlen=_KEPT)
        self._before: NDArray[np.float64] | None = None
        self._before_s = self._next_s = -math.inf

    def sigma(self, time_s: float, frame: NDArray[np.float64], felt: list[Felt]) -> float:
        """Return the noise by all frames so far, in their unit.

        Parameters
        ----------
        time_s : float
        frame : ndarray of shape (rows, cols), float64
        felt : list of Felt
            Its contacts.
        """
        if felt:
            self._told.append(felt[0].sigma)
        if time_s < self._before_s:
            self._next_s = -math.inf
        if self._before is not None:
            self._measure(frame, felt)
            self._next_s = time_s + _INTERVAL_S
            self._before = None
        elif time_s >= self._next_s:
            self._before, self._before_felt = np.array(frame), felt
        self._before_s = time_s
        return max((median(each) for each in (self._told, self._measured) if each), default=0.0)

    def _measure(self, frame: NDArray[np.float64], felt: list[Felt]) -> None:
        assert self._before is not None
        change = (frame - self._before).ravel()
        free = np.isfinite(change)
        for one in (*felt, *self._before_felt):
            free[one.taxels] = False
        left = change[free]
        if len(left) >= _FEWEST:
            self._measured.append(math.sqrt(float(left @ left) / (2 * len(left))))
