"""Whether the readings of a stream fall where something presses: it is then taken to press where nothing does."""

from __future__ import annotations

import heapq
import itertools
from operator import itemgetter

import numpy as np
from numpy.typing import NDArray

from varishold.frame.polarity import Fall, find_fall

__all__ = ["RunningFall"]

# First frames, and frames that stand farthest off their rest, that are kept: fewer where they hold more readings.
_FIRST, _FARTHEST, _READINGS = 8, 24, 1 << 18
# A frame stands off by so many sigma at least, at so many taxels. Frames that are kept are so far apart, and looked at
# so often; a look that agrees with one so long before is believed: seconds.
_STANDS_SIGMAS, _STANDING, _APART_S, _LOOK_S, _AGREES_S = 8.0, 3, 0.1, 0.2, 0.5
# The rest from which frames stand off is forgotten so slowly: more slowly than presses last. Seconds.
_REST_S = 30.0

Floats = NDArray[np.float64]


class RunningFall:
    """Watches a pad's frames; what it keeps does not grow.

    Parameters
    ----------
    usable : ndarray of shape (rows, cols), bool

    Attributes
    ----------
    suspected : bool
        Whether they seem to fall by the newest look, which may be at what has just broken.
    found : Fall or None
        How readings fall where something presses, once several looks agree and until presses are seen to rise; its
        frame is none of the stream's.

    Examples
    --------
    >>> y, x = np.mgrid[-6:7, -6:7]
    >>> press = np.maximum(4.0 - np.hypot(x, y), 0.0)
    >>> watched = RunningFall(np.ones(x.shape, bool))
    >>> for k in range(300):
    ...     watched.update(k / 50, 250.0 - 20.0 * (k % 100 > 60) * press, 1.0)
    >>> watched.suspected, watched.found.rest, round(watched.found.pressed)
    (True, 250.0, 197)
    """

    def __init__(self, usable: NDArray[np.bool_]) -> None:
        self._usable = usable
        self._most = min(_FARTHEST, max(_FIRST, _READINGS // usable.size))
        self._first: list[Floats] = []
        self._farthest: list[tuple[float, int, Floats]] = []
        self._number = itertools.count()
        self._next_s = self._look_s = -np.inf
        self._is_new = False
        self._rest: Floats
        self._since_s: float | None = None
        self.found: Fall | None = None

    def update(self, time_s: float, values: Floats, sigma: float) -> None:
        """Take a frame.

        Parameters
        ----------
        time_s : float
        values : ndarray of shape (rows, cols), float64
            Numbers throughout, whatever is read at rest.
        sigma : float
            Standard deviation of the noise; 0 where it is not known yet.
        """
        if not self._next_s - _APART_S <= time_s < self._next_s:
            self._keep(time_s, values, sigma)
        if self._is_new and not self._look_s - _LOOK_S <= time_s < self._look_s:
            self._look(time_s)
            self._is_new, self._look_s = False, time_s + _LOOK_S

    @property
    def suspected(self) -> bool:
        return self._since_s is not None

    def _look(self, time_s: float) -> None:
        farthest = [one for _, _, one in sorted(self._farthest, key=itemgetter(1))]
        kept = np.array([*self._first, *farthest])
        fall = find_fall(kept, self._usable)
        if fall is None:
            self._since_s = None
            # A press that is too light to tell is no reason to forget what was told; one that rises elsewhere is.
            if self.found is not None and find_fall(-kept, self._usable & ~self.found.taxels) is not None:
                self.found = None
        elif self._since_s is None or time_s < self._since_s:
            self._since_s = time_s
        elif self.found is None and time_s - self._since_s >= _AGREES_S:
            self.found = fall

    def _keep(self, time_s: float, values: Floats, sigma: float) -> None:
        self._next_s = time_s + _APART_S
        if len(self._first) < _FIRST:
            self._first.append(values)
            self._rest = np.mean(self._first, axis=0)
            self._is_new = True
            return
        off = np.abs((change := (values - self._rest)[self._usable]) - np.median(change))
        self._rest += min(_APART_S / _REST_S, 1.0) * (values - self._rest)
        stands_off = float(np.partition(off, -_STANDING)[-_STANDING])
        if stands_off < _STANDS_SIGMAS * sigma:
            return
        one = stands_off, next(self._number), values
        if len(self._farthest) < self._most:
            heapq.heappush(self._farthest, one)
        elif stands_off > self._farthest[0][0]:
            heapq.heapreplace(self._farthest, one)
        else:
            return
        self._is_new = True
