"""The noise of each taxel while frames come in: a running median, so that impulses hardly count."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from varishold.frame.noise import MEDIAN_ABS_NORMAL

__all__ = ["RunningNoise"]

# Frames so far apart are looked at: frames that come twice and filters in the sensor do not hide the noise.
_APART_S = 0.1
# How soon it follows, seconds; and the largest share of itself by which one look changes it, or few would tell it.
_MEMORY_S, _MOST_AT_ONCE = 20.0, 0.05
# The first looks are averaged; a running median would be long on its way.
_AVERAGED = 16
_SIGMA_OF_MEAN = math.sqrt(math.pi / 2.0)
# The skin's noise is another where this share of the taxels is so many standard deviations below zero, which no press
# does, or the median of the free ones is so small; and that in so many looks. Then it is measured anew.
_BELOW_SHARE, _BELOW_SIGMAS, _SMALL, _STRANGE_LOOKS = 0.1, 3.0, 0.4, 5
# A taxel that is so far below zero in this share of the last dozen looks has become loud, and is no press though it
# stands out: its noise is learned at once.
_LOUD_SHARE, _LOUD_PACE = 0.15, 1 / 12


class RunningNoise:
    """Standard deviation of each taxel's noise.

    Parameters
    ----------
    usable : ndarray of shape (rows, cols), bool
    least : float
        No noise is taken to be less, in the unit of the frames.

    Attributes
    ----------
    sigma : ndarray of shape (rows, cols), float64
        As it was measured; replaced, never written into.
    median : float
        The skin's.
    floored : ndarray of shape (rows, cols), float64
        Nowhere less than the skin's median, nor than `least`.
    """

    def __init__(self, usable: NDArray[np.bool_], least: float = 0.0) -> None:
        self._usable = usable
        self._n_usable = int(np.count_nonzero(usable))
        self.least = least
        self._before: NDArray[np.float64] | None = None
        self._waited_s = 0.0
        self._n_averaged = self._n_strange = 0
        self._below = np.zeros(usable.shape)
        self._take(np.zeros(usable.shape))

    @property
    def known(self) -> bool:
        """Whether it has been measured."""
        return self._n_averaged >= _AVERAGED

    def set(self, sigma: NDArray[np.float64]) -> None:
        """Begin with a noise that was measured otherwise."""
        self._n_averaged = _AVERAGED
        self._take(sigma)

    def forget_frame(self) -> None:
        """Compare the next frame with none before it: time was lost in between."""
        self._before = None

    def add(
        self,
        passed_s: float,
        values: NDArray[np.float64],
        zeroed: NDArray[np.float64] | None = None,
        free: NDArray[np.bool_] | None = None,
    ) -> bool:
        """Take a frame; tell whether the noise was measured anew.

        Parameters
        ----------
        passed_s : float
            Since the last frame.
        values : ndarray of shape (rows, cols), float64
            Finite; kept until the next frame that is looked at.
        zeroed : ndarray of shape (rows, cols), float64, optional
            What they show above a zero that follows: more of the noise is told by it than by what changes from look to
            look.
        free : ndarray of shape (rows, cols), bool, optional
            Where nothing presses: others are not learned from. Given with `zeroed`.
        """
        self._waited_s += passed_s
        if self._before is not None and self._waited_s < _APART_S:
            return False
        if self._before is not None:
            change = np.abs(values - self._before) / math.sqrt(2.0)
            if not self.known:
                self._n_averaged += 1
                self._take(self.sigma + (_SIGMA_OF_MEAN * change - self.sigma) / self._n_averaged)
            elif zeroed is None or free is None:
                self._run(change, self._usable)
            elif self._is_another(zeroed, free):
                self._n_averaged = 0
            else:
                self._run(np.abs(zeroed), free)
                self._below += _LOUD_PACE * ((zeroed < -_BELOW_SIGMAS * self.floored) - self._below)
                if (loud := self._below > _LOUD_SHARE).any():
                    self._run(change, loud, pace=_MOST_AT_ONCE)
        self._before, self._waited_s = values, 0.0
        return True

    def _run(self, size: NDArray[np.float64], where: NDArray[np.bool_], pace: float | None = None) -> None:
        """Take a step up where a value is larger than its median was, one down where it is smaller."""
        pace = min(self._waited_s / _MEMORY_S, _MOST_AT_ONCE) if pace is None else pace
        step = (
            pace
            * np.maximum(self.sigma, max(self.median, self.least))
            * np.sign(size - MEDIAN_ABS_NORMAL * self.sigma)
            * where
        )
        self._take(np.maximum(self.sigma + step, 0.0))

    def _is_another(self, zeroed: NDArray[np.float64], free: NDArray[np.bool_]) -> bool:
        """Tell whether the skin's noise has changed for some time by more than a running median follows."""
        below = np.count_nonzero(zeroed < -_BELOW_SIGMAS * self.floored) > _BELOW_SHARE * self._n_usable
        small = False
        if not below and self.median > self.least and 2 * np.count_nonzero(free) > self._n_usable:
            small = float(np.median(np.abs(zeroed[free]))) < _SMALL * MEDIAN_ABS_NORMAL * self.median
        self._n_strange = self._n_strange + 1 if below or small else 0
        if self._n_strange < _STRANGE_LOOKS:
            return False
        self._n_strange = 0
        return True

    def _take(self, sigma: NDArray[np.float64]) -> None:
        self.sigma = sigma
        self.median = float(np.median(sigma[self._usable])) if self._n_usable else 0.0
        self.floored = np.maximum(sigma, max(self.median, self.least))
