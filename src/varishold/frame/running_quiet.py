"""What a stream shows while nothing presses: far too noisy taxels, and whether taxels share their noise."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from varishold.frame.noisy import noisy_taxels
from varishold.frame.quiet import is_smoothed

__all__ = ["RunningQuiet"]

# Successive quiet frames that are looked at: as many as hold so many readings, but some; and how often. Seconds.
_MOST_FRAMES, _READINGS, _FEWEST_FRAMES = 32, 1 << 20, 9
_AGAIN_S = 60.0


class RunningQuiet:
    """Watches a pad's frames while nothing presses; what it keeps does not grow.

    Parameters
    ----------
    usable : ndarray of shape (rows, cols), bool

    Attributes
    ----------
    shares : bool
        Whether neighbouring taxels share their noise, as where readings are smoothed or interpolated.
    noisy : ndarray of shape (rows, cols), bool, or None
        Which taxels are far noisier than those beside them; None where none is.

    Examples
    --------
    >>> rng = np.random.default_rng(0)
    >>> for smoothed in (False, True):
    ...     watched = RunningQuiet(np.ones((8, 8), bool))
    ...     for k in range(40):
    ...         noise = rng.normal(0, 1, (9, 9))
    ...         mean = (noise[1:, 1:] + noise[:-1, 1:] + noise[1:, :-1] + noise[:-1, :-1]) / 4
    ...         watched.update(k / 50, mean if smoothed else noise[1:, 1:], is_pressed=False)
    ...     print(watched.shares)
    False
    True
    """

    def __init__(self, usable: NDArray[np.bool_]) -> None:
        self._usable = usable
        self._most = min(_MOST_FRAMES, max(_FEWEST_FRAMES, _READINGS // usable.size))
        self._frames: list[NDArray[np.float64]] = []
        self._next_s = -np.inf
        self.shares = False
        self.noisy: NDArray[np.bool_] | None = None

    def update(self, time_s: float, zeroed: NDArray[np.float64], *, is_pressed: bool) -> None:
        """Take a frame.

        Parameters
        ----------
        time_s : float
        zeroed : ndarray of shape (rows, cols), float64
        is_pressed : bool
            Whether anything presses.
        """
        if is_pressed or not self._usable.any():
            self._frames.clear()
        elif not self._next_s - _AGAIN_S <= time_s < self._next_s:
            self._frames.append(zeroed)
            if len(self._frames) == self._most:
                frames = np.array(self._frames)
                self.shares = is_smoothed(frames, self._usable)
                self.noisy = noisy_taxels(frames, self._usable)
                self._frames.clear()
                self._next_s = time_s + _AGAIN_S
