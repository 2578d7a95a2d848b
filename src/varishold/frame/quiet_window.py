"""A short run of frames from which a zero is taken, and whether something moved in it."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from varishold.frame.noise import MEDIAN_ABS_NORMAL
from varishold.frame.patches import in_patches
from varishold.frame.quiet import off_plane

__all__ = ["QuietWindow", "standing_patch"]

_FEWEST_FRAMES = 8
# From the mean of absolute differences of two to a standard deviation.
_SIGMA_OF_MEAN = math.sqrt(math.pi) / 2.0
# A taxel whose values within the window are farther apart than so many standard deviations has moved; of a thousand
# noisy values the farthest two are seven apart.
_MOVED_SIGMAS = 10.0
# So long a window tells a rise from noise. Seconds.
_ENOUGH_S = 0.1
# No taxel counts as noisier than this many times the skin's median.
_NOISIEST = 3.0
# A single value so many standard deviations from all others of its taxel is a glitch, and left out.
_GLITCH_SIGMAS = 30.0
# A patch that stands so many times as far off the others' plane as they scatter is pressed.
_STANDS_OFF = 8.0


class QuietWindow:
    """Frames, summed up as they come.

    Parameters
    ----------
    usable : ndarray of shape (rows, cols), bool
    lasts_s : float
        How long it takes, and eight frames at least.

    Attributes
    ----------
    n_frames : int
    """

    def __init__(self, usable: NDArray[np.bool_], lasts_s: float) -> None:
        self._usable = usable
        self._lasts_s = lasts_s
        self._passed_s = 0.0
        self.n_frames = 0
        self._sum = np.zeros(usable.shape)
        self._changes = np.zeros(usable.shape)
        self._alone, self._squares = np.zeros((2, *usable.shape))
        self._low = np.full(usable.shape, np.inf)
        self._high = np.full(usable.shape, -np.inf)
        # The readings at the lowest and the highest, and the two largest changes.
        self._at_low, self._at_high, self._largest, self._second = np.zeros((4, *usable.shape))
        self._glitch, self._without_farthest = np.zeros(usable.shape, np.bool_), np.zeros(usable.shape)
        self._before: NDArray[np.float64] | None = None

    def add(self, passed_s: float, values: NDArray[np.float64]) -> bool:
        """Take a frame, which is kept until the next; tell whether the window is full."""
        if self._before is not None:
            self._passed_s += passed_s
            change = np.abs(values - self._before)
            self._changes += change
            self._second = np.maximum(self._second, np.minimum(self._largest, change))
            self._largest = np.maximum(self._largest, change)
        self._sum += values
        # What all do together is no press that moves.
        alone = values - np.median(values[self._usable]) if self._usable.any() else values
        off = alone - self._alone
        self._alone = self._alone + off / (self.n_frames + 1)
        self._squares = self._squares + off * (alone - self._alone)
        self._at_low = np.where(alone < self._low, values, self._at_low)
        self._at_high = np.where(alone > self._high, values, self._at_high)
        self._low = np.minimum(self._low, alone)
        self._high = np.maximum(self._high, alone)
        self._before = values
        self.n_frames += 1
        self._look_for_glitches()
        return self._passed_s >= self._lasts_s and self.n_frames >= _FEWEST_FRAMES

    @property
    def mean(self) -> NDArray[np.float64]:
        """Mean of the frames so far, glitches left out."""
        mean = self._sum / max(self.n_frames, 1)
        if not self._glitch.any():
            return mean
        is_high = self._high - self._alone > self._alone - self._low
        at = np.where(is_high, self._at_high, self._at_low)
        return np.where(self._glitch, mean + (mean - at) / (self.n_frames - 1), mean)

    @property
    def sigma(self) -> NDArray[np.float64]:
        """Standard deviation of each taxel's noise, also where a filter hides it from one frame to the next."""
        about_mean: NDArray[np.float64] = np.sqrt(self._squares / max(self.n_frames - 1, 1))
        return np.maximum(self._sigma_of_changes, np.where(self._glitch, self._without_farthest, about_mean))

    @property
    def _sigma_of_changes(self) -> NDArray[np.float64]:
        """The same from successive frames: what moves for some time hardly adds to it."""
        changes = self._changes * (_SIGMA_OF_MEAN / max(self.n_frames - 1, 1))
        if not self._glitch.any():
            return changes
        # A glitch makes two changes, or one where it came last.
        rest = (self._changes - self._largest - self._second) * (_SIGMA_OF_MEAN / (self.n_frames - 3))
        return np.where(self._glitch, np.maximum(rest, 0.0), changes)

    def _look_for_glitches(self) -> None:
        """Note where one value is a glitch, and each taxel's standard deviation without its farthest value."""
        n = self.n_frames
        if n < _FEWEST_FRAMES or not self._usable.any():
            return
        far = np.maximum(self._high - self._alone, self._alone - self._low) * (n / (n - 1))
        # Of n values the farthest is left out: their squares fall by that much.
        squares = self._squares - far**2 * ((n - 1) / n)
        self._without_farthest = np.sqrt(np.maximum(squares, 0.0) / (n - 2))
        usual = float(np.median(self._without_farthest[self._usable]))
        self._glitch = self._usable & (far > _GLITCH_SIGMAS * np.maximum(self._without_farthest, usual))

    def moved(self, least_noise: float) -> NDArray[np.bool_]:
        """Return where a patch of three neighbours or more moved while the frames came, (rows, cols)."""
        if not self._usable.any():
            return self._usable.copy()
        sigma = self._sigma_of_changes
        median = max(float(np.median(sigma[self._usable])), least_noise)
        # A taxel that is moved to and fro seems noisy.
        noise = np.clip(sigma, median, _NOISIEST * median)
        return in_patches((self._high - self._low > _MOVED_SIGMAS * noise) & self._usable)

    def rises(self, values: NDArray[np.float64], least_noise: float) -> NDArray[np.bool_]:
        """Return where a patch of three neighbours or more rises in a new frame above a window long enough to say so.

        Nowhere, where another falls at once: what rises has pressed already and moves.
        """
        nowhere = np.zeros_like(self._usable)
        if self._passed_s < _ENOUGH_S or self.n_frames < _FEWEST_FRAMES or not self._usable.any():
            return nowhere
        off = values - self.mean
        off -= np.median(off[self._usable])
        noise = max(float(np.median(self._sigma_of_changes[self._usable])), least_noise)
        rises, falls = (in_patches((sign * off > _MOVED_SIGMAS * noise) & self._usable) for sign in (1, -1))
        return nowhere if falls.any() else rises


def standing_patch(mean: NDArray[np.float64], usable: NDArray[np.bool_], noise: float) -> NDArray[np.bool_]:
    """Return where a patch of three neighbours or more stands above the plane that the taxels lie in, (rows, cols)."""
    if np.count_nonzero(usable) < 4:
        return np.zeros(usable.shape, np.bool_)
    off = off_plane(mean, usable)
    off -= np.median(off[usable])
    scatter = float(np.median(np.abs(off[usable]))) / MEDIAN_ABS_NORMAL
    return in_patches((off > _STANDS_OFF * max(scatter, noise)) & usable)
