"""Which taxels are pressed, which are held because of it, and which are free, from frame to frame."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from varishold.frame.patches import PatchGrid

__all__ = ["LONE", "OFF_SIGMAS", "ON_SIGMAS", "PressedTaxels"]

# A press begins above the one and ends below the other.
ON_SIGMAS, OFF_SIGMAS = 8.0, 4.0
# It begins at three neighbours, or at one taxel so many times as high: a lone taxel latches on noise.
LONE = 4.0
# Taxels around a press that may feel it; fewer where hardly one would stay free.
_GUARD = 2
# How long a taxel is held after it was pressed or guarded. Seconds.
_DWELL_S = 1.0
# The share of the taxels that must stay free, and the fewest.
_FREE_SHARE, _FEWEST_FREE = 0.125, 3
# What stays below this share of a press's peak is creep, not a press, once it has lasted so long. Seconds.
_CREEP_SHARE, _CREEP_AFTER_S = 0.15, 0.05
# How long a taxel that was pressed creeps back and tells nothing of what others do. Seconds.
_CREEPS_S = 20.0


class PressedTaxels:
    """Presses by hysteresis, with a guard ring and a dwell.

    Parameters
    ----------
    usable : ndarray of shape (rows, cols), bool

    Attributes
    ----------
    bits : int
        The pressed taxels, as `PatchGrid` has them; 0 while nothing presses.
    free : ndarray of shape (rows, cols), bool
        Neither pressed nor held.
    settled : ndarray of shape (rows, cols), bool
        Free for so long that nothing creeps back.
    telling : ndarray of shape (rows, cols), bool
        The taxels that tell the common drift: those settled, or those free where hardly one is settled.
    """

    def __init__(self, usable: NDArray[np.bool_]) -> None:
        self.grid = PatchGrid((usable.shape[0], usable.shape[1]))
        self._usable = usable
        self._usable_bits = self.grid.bits(usable)
        n_usable = self._usable_bits.bit_count()
        self._need_free = max(_FEWEST_FREE, round(_FREE_SHARE * n_usable))
        self._few = n_usable < 3
        self.clear()

    def clear(self) -> None:
        """Forget every press: all taxels are free."""
        shape = self._usable.shape
        self.bits = 0
        self._free_all()
        self._peak = np.zeros(shape)
        self._low_since_s = np.full(shape, np.inf)
        self._held_until_s = np.full(shape, -np.inf)
        self._settled_from_s = np.full(shape, -np.inf)
        self._all_settled_s = -np.inf

    @property
    def mask(self) -> NDArray[np.bool_]:
        """The pressed taxels, of shape (rows, cols)."""
        return self.grid.mask(self.bits)

    def update(self, now_s: float, zeroed: NDArray[np.float64], noise: NDArray[np.float64]) -> NDArray[np.bool_] | None:
        """Take a frame.

        Parameters
        ----------
        now_s : float
        zeroed, noise : ndarray of shape (rows, cols), float64
            What each taxel shows above its baseline, and the standard deviation of its noise.

        Returns
        -------
        ndarray of shape (rows, cols), bool, or None
            Where a press has just ended of which something stays: the taxels whose creep may be followed.
        """
        on = ON_SIGMAS * noise
        hot = zeroed > on
        any_hot = bool(hot.any())
        released = 0
        if any_hot or self.bits:
            self.bits = self._pressed(zeroed, on, hot)
            if self.bits:
                released = self._ended(now_s, zeroed)
                self.bits &= ~released
                self._hold(now_s)
        if released:
            self._held_until_s[self.grid.mask(released)] = now_s
        if now_s < self._all_settled_s:
            self.free = self._usable & (self._held_until_s <= now_s)
            self.settled = self._usable & (self._settled_from_s <= now_s)
            enough = np.count_nonzero(self.settled) >= self._need_free
            self.telling = self.settled if enough else self.free
            self._all_free = False
        elif not self._all_free:
            self._free_all()
        return self.grid.mask(released) if released else None

    def _free_all(self) -> None:
        self.free = self.settled = self.telling = self._usable
        self._all_free = True

    def _pressed(self, zeroed: NDArray[np.float64], on: NDArray[np.float64], hot: NDArray[np.bool_]) -> int:
        """Return the pressed taxels: those that were and still show something, and new patches as far as they go."""
        grid = self.grid
        hot_bits = grid.bits(hot) & self._usable_bits
        warm_bits = grid.bits(zeroed > on * (OFF_SIGMAS / ON_SIGMAS)) & self._usable_bits
        seeds = self.bits | (hot_bits if self._few else grid.crowded(hot_bits))
        if hot_bits & ~seeds:
            seeds |= grid.bits(zeroed > LONE * on)
        return grid.joined(seeds, warm_bits)

    def _ended(self, now_s: float, zeroed: NDArray[np.float64]) -> int:
        """Return what belongs to presses that have ended but for their creep, and the taxels around them."""
        ended = 0
        peak = np.zeros_like(zeroed)
        low_since_s = np.full(zeroed.shape, np.inf)
        for part in self.grid.parts(self.bits):
            mask = self.grid.mask(part)
            height = float(zeroed[mask].max())
            highest = max(float(self._peak[mask].max()), height)
            peak[mask] = highest
            if height < _CREEP_SHARE * highest:
                since_s = min(float(self._low_since_s[mask].min()), now_s)
                low_since_s[mask] = since_s
                if now_s - since_s >= _CREEP_AFTER_S:
                    ended |= part
        self._peak, self._low_since_s = peak, low_since_s
        return self.grid.grown(ended, _GUARD) & self._usable_bits & ~self.grid.grown(self.bits & ~ended, _GUARD)

    def _hold(self, now_s: float) -> None:
        """Hold what is pressed and as much around it as leaves enough taxels free."""
        for guard in range(_GUARD, -1, -1):
            held = self.grid.grown(self.bits, guard)
            if (self._usable_bits & ~held).bit_count() >= self._need_free:
                break
        mask = self.grid.mask(held)
        self._held_until_s[mask] = now_s + _DWELL_S
        self._settled_from_s[mask] = now_s + _CREEPS_S
        self._all_settled_s = now_s + _CREEPS_S
