"""What is being let go: taxels that are slow to fall stand alone for a while after a touch."""

from __future__ import annotations

import math
from collections import deque

import numpy as np
from numpy.typing import NDArray

from varishold.touch.tracking.felt import Felt

__all__ = ["LettingGo"]

# Frames are kept so far apart, for so long.
_APART_S, _KEPT_S = 0.02, 0.2
# What has fallen by so much from their older half to their newer one is falling, and has not come up again from its
# lowest by more than so many sigma of the noise. A touch that begins was not there in the older half.
_FALLING, _SIGMAS = 0.02, 3.0
# Times are compared to within this.
_SAME_S = 1e-6


class LettingGo:
    """The frames of the last moment, by which a contact that falls is told from one that presses."""

    def __init__(self) -> None:
        self._frames: deque[tuple[float, NDArray[np.float64]]] = deque()

    def clear(self) -> None:
        """Forget all frames."""
        self._frames.clear()

    def update(self, time_s: float, frame: NDArray[np.float64]) -> None:
        """Take one more frame, of shape (rows, cols)."""
        if self._frames and 0.0 <= time_s - self._frames[-1][0] < _APART_S - _SAME_S:
            return
        self._frames.append((time_s, np.array(frame)))
        while len(self._frames) > 1 and time_s - self._frames[1][0] >= _KEPT_S - _SAME_S:
            self._frames.popleft()

    def is_falling(self, felt: Felt) -> bool:
        """Tell whether the taxels of a contact stood higher a moment ago."""
        sums = [float(frame.ravel()[felt.taxels].sum()) for _, frame in self._frames]
        half = len(sums) // 2
        if half == 0 or felt.load > min(sums) + _SIGMAS * felt.sigma * math.sqrt(2.0 * len(felt.taxels)):
            return False
        return sum(sums[-half:]) < (1.0 - _FALLING) * sum(sums[:half])
