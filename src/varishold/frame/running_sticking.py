"""Taxels that begin to stick while a stream runs: found by what others do meanwhile."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from varishold.frame.neighbours import largest_around
from varishold.frame.sticking import ALONE, MOST, SIGMAS, most_sticking

__all__ = ["RunningSticking"]

# What sticks stands alone for so long, then others are pressed for so long, then it stands alone again. Seconds.
_ALONE_S, _PRESSED_S = 0.3, 0.05
# It is back where it reads less than this share of what it did.
_BACK = 0.5
# A gap in the stream counts no longer than this. Seconds.
_LONGEST_S = 0.1

Floats = NDArray[np.float64]
Mask = NDArray[np.bool_]


class RunningSticking:
    """Watches a pad's zeroed frames; what it keeps does not grow.

    Parameters
    ----------
    usable : ndarray of shape (rows, cols), bool

    Attributes
    ----------
    stuck : ndarray of shape (rows, cols), bool, or None
        The taxels that stick now; None where none does.

    Examples
    --------
    >>> frames = np.random.default_rng(0).normal(0, 1, (300, 8, 8))
    >>> frames[140:200, 2:6, 2:6] += 100.0
    >>> frames[50:280, 1, 6] += 80.0
    >>> watched = RunningSticking(np.ones((8, 8), bool))
    >>> for k, frame in enumerate(frames):
    ...     watched.update(k / 100, frame, 1.0)
    ...     if k in (199, 240):
    ...         print(k, None if watched.stuck is None else np.argwhere(watched.stuck).tolist())
    199 None
    240 [[1, 6]]
    >>> print(watched.stuck)
    None
    """

    def __init__(self, usable: Mask) -> None:
        self._usable = usable
        self._most = most_sticking(usable)
        self.stuck: Mask | None = None
        self._before_s: float | None = None
        # Of what may stick: how high it stood, and how long it was alone, others were pressed, and it was alone again.
        self._level, self._alone_s, self._pressed_s, self._again_s = np.zeros((4, *usable.shape))
        self._any = False

    def update(self, time_s: float, zeroed: Floats, sigma: float) -> None:
        """Take a frame.

        Parameters
        ----------
        time_s : float
        zeroed : ndarray of shape (rows, cols), float64
            Upright and zero at rest.
        sigma : float
            Standard deviation of the noise.
        """
        passed_s = 0.0 if self._before_s is None else min(max(time_s - self._before_s, 0.0), _LONGEST_S)
        self._before_s = time_s
        high = zeroed > SIGMAS * sigma
        if not self._any and not high.any():
            return
        high &= self._usable
        watched = self._level > 0.0
        self._forget(watched & (zeroed < _BACK * self._level))
        watched = self._level > 0.0
        if np.count_nonzero(high) <= self._most:
            alone = high & (zeroed > ALONE * largest_around(np.abs(zeroed)))
            new = alone & ~watched
            self._level[new] = zeroed[new]
            pressed = self._pressed_s >= _PRESSED_S
            self._again_s[alone & watched & pressed] += passed_s
            self._alone_s[alone & watched & ~pressed] += passed_s
        elif np.count_nonzero(high & ~watched) > MOST:
            self._forget(watched & (self._alone_s < _ALONE_S))
            self._pressed_s[self._level > 0.0] += passed_s
        self._any = bool((self._level > 0.0).any())
        stuck = self._again_s >= _ALONE_S
        self.stuck = stuck if stuck.any() else None

    def _forget(self, where: Mask) -> None:
        for of in (self._level, self._alone_s, self._pressed_s, self._again_s):
            of[where] = 0.0
