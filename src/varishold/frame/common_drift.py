"""The drift that all taxels share, each by its own measure, learned from those that nothing presses."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from varishold.frame.noise import MEDIAN_ABS_NORMAL

__all__ = ["CommonDrift"]

# How long the taxels' drift is summed up before their shares are learned from it: long against the noise, short
# against a press. Seconds.
_BLOCK_S = 5.0
# How soon what a share was learned from is forgotten, while there is something new to learn. Seconds.
_MEMORY_S = 150.0
# How far shares scatter before anything is known of them.
_SHARE_SPREAD = 0.3
# A taxel whose drift is this many standard deviations off its share counts no more than that: it creeps.
_OFF_SHARE = 3.0
# No taxel drifts more than this many times as far as the mean.
_LARGEST_SHARE = 4.0


class CommonDrift:
    """Each taxel's share of the common drift, by recursive least squares.

    Parameters
    ----------
    usable : ndarray of shape (rows, cols), bool

    Attributes
    ----------
    share : ndarray of shape (rows, cols), float64
        How far a taxel drifts where the mean taxel drifts by 1; replaced, never written into.
    level : float
        How far the mean taxel has drifted since the start, in the unit of the frames.
    pace : float
        How far it has drifted in a second lately, up or down.
    """

    def __init__(self, usable: NDArray[np.bool_]) -> None:
        self._usable = usable
        self.share = usable.astype(np.float64)
        self.level = 0.0
        self.pace = 0.0
        self._variance = np.full(usable.shape, _SHARE_SPREAD**2)
        self._block_s = 0.0
        self._whole = usable.copy()
        self._level_before = 0.0
        self._before: NDArray[np.float64] | None = None

    def offset(self, zeroed: NDArray[np.float64], weights: NDArray[np.float64]) -> float:
        """Return by how much the mean taxel is off, by weighted least squares over the taxels' shares.

        Parameters
        ----------
        zeroed, weights : ndarray of shape (rows, cols), float64
            What each taxel is off, and how much it counts; 0 where it is not free.
        """
        weighted = weights * self.share
        whole = float(np.vdot(weighted, self.share))
        return float(np.vdot(weighted, zeroed)) / whole if whole > 0.0 else 0.0

    def learn(self, passed_s: float, baseline: NDArray[np.float64], free: NDArray[np.bool_]) -> None:
        """Take note of the baseline after a step, and learn the shares where a block is full.

        Parameters
        ----------
        passed_s : float
            Since the last step.
        baseline : ndarray of shape (rows, cols), float64
        free : ndarray of shape (rows, cols), bool
            Where a taxel's baseline is its own, and nothing creeps back.
        """
        if self._before is None:
            self.start_block(baseline)
        self._whole &= free
        self._block_s += passed_s
        if self._block_s >= _BLOCK_S:
            self._learn_block(baseline)
            self.start_block(baseline)

    def start_block(self, baseline: NDArray[np.float64]) -> None:
        """Begin a block anew: what the baseline did before is no drift."""
        self._block_s = 0.0
        self._whole = self._usable.copy()
        self._level_before = self.level
        self._before = baseline.copy()

    def _learn_block(self, baseline: NDArray[np.float64]) -> None:
        learning = self._whole
        drift = self.level - self._level_before
        if self._before is None or np.count_nonzero(learning) < 3 or drift == 0.0:
            return
        faded = math.exp(-self._block_s / _MEMORY_S)
        self.pace += (1.0 - faded) * (abs(drift) / self._block_s - self.pace)
        off = baseline - self._before - self.share * drift
        # What free taxels walk on their own, and the noise of their baselines.
        spread = float(np.median(np.abs(off[learning]))) / MEDIAN_ABS_NORMAL
        reach = _OFF_SHARE * spread
        variance = _SHARE_SPREAD**2 + faded * (self._variance - _SHARE_SPREAD**2)
        heard = variance * drift**2
        gain = heard / (heard + spread**2) if spread > 0.0 else np.ones_like(heard)
        step = gain * np.clip(off, -reach, reach) / drift
        share = np.where(learning, np.clip(self.share + step, -_LARGEST_SHARE, _LARGEST_SHARE), self.share)
        self._variance = np.where(learning, variance * (1.0 - gain), self._variance)
        # Who learns is measured by what those who learn have in common: their mean stays, or it would run away from
        # those who do not learn now.
        before, after = float(self.share[learning].sum()), float(share[learning].sum())
        if before > 0.0 and after > 0.0:
            share = np.where(learning, share * (before / after), share)
        self.share = share
