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
# It is known after so many frames.
_KNOWN = 5
# Later, two frames are compared so often, if so many taxels are free: of no contact that stands so many sigma high.
_INTERVAL_S, _FEWEST, _HIGH = 0.02, 6, 8.0


class Noise:
    """Follows the standard deviation of the frames' noise.

    A single frame of few taxels does not tell its noise from its contacts, and one of few counts hardly shows any; two
    frames do.
    """

    def __init__(self) -> None:
        self._told: deque[float] = deque(maxlen=_KEPT)
        self._measured: deque[float] = deque(maxlen=_KEPT)
        self._before: tuple[NDArray[np.float64], list[Felt]] | None = None
        self._next_s = -math.inf
        self._frames = 0
        #: Standard deviation of the noise, in the unit of the frames; 0 where none was seen.
        self.sigma = 0.0

    @property
    def is_known(self) -> bool:
        """Whether there were enough frames."""
        return self._frames >= _KNOWN

    def update(self, time_s: float, frame: NDArray[np.float64], felt: list[Felt]) -> None:
        """Take one more frame, of shape (rows, cols), and its contacts."""
        self._frames += 1
        if felt:
            self._told.append(felt[0].contact.sigma)
        if self._before is not None:
            self._measure(frame, felt, *self._before)
            self._next_s = time_s + _INTERVAL_S
        # Where the clock has jumped back, nothing is waited for.
        due = not time_s < self._next_s <= time_s + _INTERVAL_S
        self._before = (np.array(frame), felt) if due or not self.is_known else None
        self.sigma = max((median(each) for each in (self._told, self._measured) if each), default=0.0)

    def _measure(
        self, frame: NDArray[np.float64], felt: list[Felt], before: NDArray[np.float64], felt_before: list[Felt]
    ) -> None:
        there = np.isfinite(frame) & np.isfinite(before)
        change = np.subtract(frame, before, out=np.zeros(frame.shape), where=there).ravel()
        free = there.ravel()
        for one in (*felt, *felt_before):
            if one.peak > _HIGH * self.sigma:
                free[one.taxels] = False
        left = change[free]
        if len(left) >= _FEWEST:
            self._measured.append(math.sqrt(float(left @ left) / (2 * len(left))))
