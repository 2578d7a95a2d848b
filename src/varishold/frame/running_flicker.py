"""Taxels and lines that flicker in a stream, as at a loose wire: they jump again and again, those beside them not."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from varishold.frame.fill import filled_above_rest
from varishold.frame.health import taxels_in_words
from varishold.frame.neighbours import largest_around, whole_lines
from varishold.frame.sticking import ALONE, SIGMAS, most_sticking

__all__ = ["RunningFlicker"]

# Jumps of the last seconds count, older ones less. What jumps so often alone, or in such a share of the readings where
# these are few, flickers; it does so no more where both are much less, some seconds after the last of them.
_LAST_S = 2.0
_MANY, _SHARE, _MOST_COUNTED = 24.0, 0.4, 48.0
_FEW, _SMALL_SHARE = 6.0, 0.1
# A jump is so much of what the taxel reads beyond its rest: a load that trembles on one taxel is none.
_OF_READ = 0.5
# No more than this share of a pad flickers.
_MOST_SHARE = 0.25
# Of fewer readings, or of less than so many seconds, nothing is said, nor of pads of fewer taxels.
_FEWEST_READINGS, _LEAST_S, _FEWEST_TAXELS = 16.0, 1.0, 9
# A gap in the stream counts no longer than this. Seconds.
_LONGEST_S = 0.5

Floats = NDArray[np.float64]
Mask = NDArray[np.bool_]


class RunningFlicker:
    """Watches a pad's readings; what it keeps does not grow.

    A press that begins or ends is a jump too: a taxel, or a whole row or column, has to jump a dozen times a second, or
    in four of ten readings.

    Parameters
    ----------
    usable : ndarray of shape (rows, cols), bool

    Attributes
    ----------
    flickering : ndarray of shape (rows, cols), bool, or None
        The taxels that flicker now; None where none does.

    Examples
    --------
    >>> rng = np.random.default_rng(0)
    >>> watched = RunningFlicker(np.ones((8, 8), bool))
    >>> for k in range(300):
    ...     frame = rng.normal(0, 1, (8, 8))
    ...     frame[1, 6] += 80.0 * (k // 4 % 2)
    ...     mended = watched.update(k / 100, frame, np.zeros((8, 8)), 1.0)
    >>> print(np.argwhere(watched.flickering).tolist(), bool(abs(mended[1, 6]) < 3))
    [[1, 6]] True
    """

    def __init__(self, usable: Mask) -> None:
        self._usable = usable
        self._looks = np.count_nonzero(usable) >= _FEWEST_TAXELS
        self._most = most_sticking(usable)
        self.flickering: Mask | None = None
        self._last: tuple[float, NDArray[Any]] | None = None
        # How many readings came lately, and how often each taxel jumped alone.
        self._readings, self._jumps = 0.0, np.zeros(usable.shape)
        self._watched_s = 0.0
        self._any = False

    def update(self, time_s: float, values: NDArray[Any], rest: Floats, sigma: float) -> NDArray[Any]:
        """Return what stands for the next reading: what flickers rests as it did, and rises as those beside it do.

        Parameters
        ----------
        time_s : float
        values : ndarray of shape (rows, cols), float or integer
        rest : ndarray of shape (rows, cols), float64
            What each taxel reads at rest.
        sigma : float
            Standard deviation of the noise of the usual taxel.

        Returns
        -------
        ndarray of shape (rows, cols)
            The values themselves where none flickers.
        """
        if self._looks and self._last is not None:
            passed_s = min(max(time_s - self._last[0], 0.0), _LONGEST_S)
            # What is no number is none of this, and others tell of it.
            with np.errstate(invalid="ignore", over="ignore"):
                self._count(passed_s, values, self._last[1], rest, sigma)
        self._last = time_s, values
        return values if self.flickering is None else filled_above_rest(values, self.flickering, rest, self._usable)

    def words(self) -> tuple[str, ...]:
        """Return what flickers, in words; nothing where nothing does."""
        if self.flickering is None:
            return ()
        return (f"{taxels_in_words(self.flickering)} flickers: filled from those beside",)

    def _count(self, passed_s: float, values: NDArray[Any], before: NDArray[Any], rest: Floats, sigma: float) -> None:
        self._watched_s += passed_s
        fade = math.exp(-passed_s / _LAST_S)
        self._readings = self._readings * fade + 1.0
        if self._any:
            self._jumps *= fade
        steps = np.abs(np.subtract(values, before, dtype=np.float64))
        far = (steps > SIGMAS * sigma) & self._usable
        if far.any():
            far &= steps > _OF_READ * np.maximum(np.abs(values - rest), np.abs(before - rest))
            alone = self._alone(far, steps)
            if alone.any():
                self._jumps = np.minimum(self._jumps + alone, _MOST_COUNTED)
                self._any = True
        if self._any:
            self._judge()

    def _alone(self, far: Mask, steps: Floats) -> Mask:
        """Return which taxels jump while those beside them do not, and whole lines of such."""
        lines = whole_lines(far, self._usable) & far
        single = far & ~lines
        if np.count_nonzero(single) > self._most:
            # What moves is a press; what flickers goes on beside it.
            single = np.zeros_like(far) if self.flickering is None else single & self.flickering
        if single.any():
            single &= steps > ALONE * largest_around(np.where(np.isnan(steps), 0.0, steps))
        return lines | single

    def _judge(self) -> None:
        begins = min(_MANY, _SHARE * self._readings)
        goes_on = min(_FEW, _SMALL_SHARE * self._readings)
        so_far = np.zeros_like(self._usable) if self.flickering is None else self.flickering
        known = self._readings >= _FEWEST_READINGS and self._watched_s >= _LEAST_S
        now = (self._jumps >= np.where(so_far, goes_on, begins)) & known
        single = np.count_nonzero(now & ~whole_lines(now, self._usable))
        some = single <= self._most and 0 < np.count_nonzero(now) <= _MOST_SHARE * np.count_nonzero(self._usable)
        self.flickering = now if some else None
        if float(self._jumps.max()) < goes_on / _FEW:
            self._jumps[:] = 0.0
            self._any = False
