"""Whether the readings of a stream fall where something presses: it is then taken to press where nothing does."""

from __future__ import annotations

import heapq
import itertools

import numpy as np
from numpy.typing import NDArray

from varishold.frame.polarity import Fall, find_fall

__all__ = ["RunningFall"]

# First frames, and frames that stand farthest off their rest, that are kept: fewer where they hold more readings.
_FIRST, _FARTHEST, _READINGS = 8, 24, 1 << 18
# A frame stands off by so many sigma at least. Frames that are kept are so far apart, and looked at so often: seconds.
_STANDS_SIGMAS, _APART_S, _LOOK_S = 8.0, 0.1, 1.0

Floats = NDArray[np.float64]


class RunningFall:
    """Watches a pad's frames; what it keeps does not grow.

    Parameters
    ----------
    usable : ndarray of shape (rows, cols), bool

    Attributes
    ----------
    found : Fall or None
        How readings fall where something presses, as far as is seen; its frame is none of the stream's.

    Examples
    --------
    >>> y, x = np.mgrid[-6:7, -6:7]
    >>> press = np.maximum(4.0 - np.hypot(x, y), 0.0)
    >>> watched = RunningFall(np.ones(x.shape, bool))
    >>> for k in range(300):
    ...     watched.update(k / 50, -20.0 * (k % 100 > 60) * press, np.full(x.shape, 250.0), 1.0)
    >>> watched.found.rest, round(watched.found.pressed)
    (250.0, 197)
    """

    def __init__(self, usable: NDArray[np.bool_]) -> None:
        self._usable = usable
        self._most = min(_FARTHEST, max(_FIRST, _READINGS // usable.size))
        self._first: list[Floats] = []
        self._farthest: list[tuple[float, int, Floats]] = []
        self._number = itertools.count()
        self._next_s = self._look_s = -np.inf
        self._is_new = False
        self._last: Fall | None = None
        self.found: Fall | None = None

    def update(self, time_s: float, zeroed: Floats, rest: Floats, sigma: float) -> None:
        """Take a frame.

        Parameters
        ----------
        time_s : float
        zeroed, rest : ndarray of shape (rows, cols), float64
            Zero at rest, numbers throughout; and what was taken off.
        sigma : float
            Standard deviation of the noise.
        """
        if not self._next_s - _APART_S <= time_s < self._next_s:
            self._keep(time_s, zeroed, rest, sigma)
        if self._is_new and not self._look_s - _LOOK_S <= time_s < self._look_s:
            kept = [*self._first, *(one for _, _, one in self._farthest)]
            fall = find_fall(np.array(kept), self._usable)
            # One look may be at what has just broken.
            self.found, self._last = (None if self._last is None else fall), fall
            self._is_new, self._look_s = False, time_s + _LOOK_S

    def _keep(self, time_s: float, zeroed: Floats, rest: Floats, sigma: float) -> None:
        if len(self._first) < _FIRST:
            self._first.append(zeroed + rest)
            self._next_s = time_s + _APART_S
            return
        off = float(np.abs(zeroed).max())
        if off < _STANDS_SIGMAS * sigma or (len(self._farthest) == self._most and off <= self._farthest[0][0]):
            return
        one = off, next(self._number), zeroed + rest
        if len(self._farthest) < self._most:
            heapq.heappush(self._farthest, one)
        else:
            heapq.heapreplace(self._farthest, one)
        self._next_s, self._is_new = time_s + _APART_S, True
