"""A baseline that follows: free taxels each by itself, pressed ones by what the free ones share."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from varishold.frame.common_drift import CommonDrift
from varishold.frame.pressed import ON_SIGMAS, PressedTaxels
from varishold.frame.running_noise import RunningNoise

__all__ = ["FollowingBaseline"]

# How soon it follows what the free taxels share, what a free taxel does on its own, and what creeps back or has
# sunk below zero. Seconds.
_COMMON_S, _OWN_S, _CREEP_S = 0.2, 2.0, 0.15
# How long creep is followed so after a press has ended. Seconds.
_CREEPS_BACK_S = 1.0
# While nobody tells the common drift, it may go on so many times as fast as it did.
_UNKNOWN_PACES = 2.0
# The share of the taxels that lie closest together after a pause: they are free.
_CLOSEST_SHARE = 0.25
# A taxel that is off by more than so many standard deviations of its noise tells no more of what all do.
_CLOSE_SIGMAS = 2.5
# A taxel of a smaller share tells nothing of the common drift.
_LEAST_SHARE = 0.2


class FollowingBaseline:
    """What is taken off a frame, step by step.

    Parameters
    ----------
    usable : ndarray of shape (rows, cols), bool

    Attributes
    ----------
    values : ndarray of shape (rows, cols), float64
        Replaced, never written into.
    presses : PressedTaxels
    drift : CommonDrift
    noise : RunningNoise
    """

    def __init__(self, usable: NDArray[np.bool_]) -> None:
        self._usable = usable
        self.values = np.zeros(usable.shape)
        self.presses = PressedTaxels(usable)
        self.drift = CommonDrift(usable)
        self.noise = RunningNoise(usable)
        self._creeping_until_s = np.full(usable.shape, -np.inf)
        self._any_creeping_until_s = -np.inf
        self._untold_s = 0.0
        self._own = np.zeros(usable.shape)
        self._weigh()

    def set(self, values: NDArray[np.float64], where: NDArray[np.bool_] | None = None) -> None:
        """Begin anew at these values, everywhere or at some taxels."""
        self.values = values.copy() if where is None else np.where(where, values, self.values)
        self.drift.start_block(self.values)

    def set_noise(self, sigma: NDArray[np.float64]) -> None:
        """Begin with a noise that was measured otherwise."""
        self.noise.set(sigma)
        self._weigh()

    def follow(self, now_s: float, passed_s: float, frame: NDArray[np.float64], zeroed: NDArray[np.float64]) -> None:
        """Judge a frame and take a step.

        Parameters
        ----------
        now_s, passed_s : float
            By a clock that never runs back, and since the last step.
        frame, zeroed : ndarray of shape (rows, cols), float64
            As it came, finite and kept for a while, and without the baseline, 0 where not usable.
        """
        if self.noise.add(passed_s, frame, zeroed, self.presses.free):
            self._weigh()
        crept = self.presses.update(
            now_s, zeroed, self.noise.floored, _UNKNOWN_PACES * self.drift.pace * self._untold_s
        )
        self._untold_s = 0.0 if self.presses.any_settled else self._untold_s + passed_s
        if crept is not None:
            self.values = self.values + crept
            zeroed = zeroed - crept
            self._creeping_until_s[crept != 0.0] = self._any_creeping_until_s = now_s + _CREEPS_BACK_S
        off = self._common_offset(zeroed)
        common = off * -math.expm1(-passed_s / _COMMON_S)
        self.drift.level += common
        shared = self.drift.share * common
        # What all are off together is left to the common drift, or pressed taxels would miss a part of it.
        own = (zeroed - self.drift.share * off) * self.presses.free
        self.values = self.values + shared + self._own_step(now_s, passed_s, own)
        self.drift.learn(passed_s, self.values, self.presses.settled)

    def resume(self, frame: NDArray[np.float64]) -> None:
        """Follow what the taxels have in common after a pause: those that lie closest together are free."""
        heard = self._usable & (self.drift.share > _LEAST_SHARE)
        ranked = np.sort((frame - self.values)[heard] / self.drift.share[heard])
        n_closest = max(3, round(_CLOSEST_SHARE * ranked.size))
        if ranked.size >= n_closest:
            closest = int(np.argmin(ranked[n_closest - 1 :] - ranked[: ranked.size - n_closest + 1]))
            common = float(np.mean(ranked[closest : closest + n_closest]))
            self.drift.level += common
            self.values = self.values + self.drift.share * common
        self.noise.forget_frame()
        self.drift.start_block(self.values)

    def _common_offset(self, zeroed: NDArray[np.float64]) -> float:
        """Return how far the mean taxel is off; one that begins to be pressed hardly counts."""
        known = np.minimum(zeroed, self._close)
        np.maximum(known, -self._close, out=known)
        return self.drift.offset(known, self._weight * self.presses.settled)

    def _own_step(self, now_s: float, passed_s: float, own: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return how far each baseline moves towards what its taxel is off: faster where it creeps back or has sunk."""
        before, self._own = self._own, own
        # An impulse moves it no farther than what is just no press.
        step = np.minimum(own, self._on)
        np.maximum(step, -self._on, out=step)
        step *= -math.expm1(-passed_s / _OWN_S)
        fast = own < -self._on
        if now_s < self._any_creeping_until_s:
            fast |= now_s < self._creeping_until_s
        elif not fast.any():
            return step
        # What lasts for two frames is no impulse.
        fast &= before * own > 0.0
        return np.where(fast, -math.expm1(-passed_s / _CREEP_S) * own, step)

    def _weigh(self) -> None:
        """Take the noise as it is now: how much each taxel tells of the others, and how far off it may be at most."""
        noise = self.noise.floored
        self._on = ON_SIGMAS * noise
        self._close = _CLOSE_SIGMAS * noise
        weight = np.zeros(noise.shape)
        np.divide(self.noise.median or self.noise.least or 1.0, noise, out=weight, where=self._usable & (noise > 0.0))
        self._weight = weight * weight
