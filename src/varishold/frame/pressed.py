"""Which taxels are pressed, which are held because of it, and which are free, from frame to frame."""

from __future__ import annotations

from dataclasses import dataclass

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
# What lasts is looked at so often. Seconds.
_LOOK_S = 0.02
# The share of the taxels that must stay free, and the fewest.
_FREE_SHARE, _FEWEST_FREE = 0.125, 2
# What stays below this share of a press's peak is creep, not a press, once it has lasted so long. Seconds. Where the
# drift was not known meanwhile, drift may stay besides, up to that share in all.
_CREEP_SHARE, _CREEP_AFTER_S, _MOST_STAYS = 0.15, 0.05, 0.4
# How long a taxel that was pressed, or guarded, creeps back and tells nothing of what others do. Seconds.
_CREEPS_S, _GUARD_CREEPS_S = 20.0, 3.0


@dataclass(slots=True)
class _Press:
    """One patch that is pressed: its taxels, its highest reading, and since when little is left of it."""

    bits: int
    peak: float
    low_since_s: float


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
        Free for so long that nothing creeps back: they tell what all share. Nobody, where they are too few.
    any_settled : bool
    """

    def __init__(self, usable: NDArray[np.bool_]) -> None:
        self.grid = PatchGrid((usable.shape[0], usable.shape[1]))
        self._usable = usable
        self._usable_bits = self.grid.bits(usable)
        n_usable = self._usable_bits.bit_count()
        self._fewest = min(_FEWEST_FREE, n_usable)
        self._need_free = max(self._fewest, round(_FREE_SHARE * n_usable))
        self._few = n_usable < 3
        self.clear()

    def clear(self) -> None:
        """Forget every press: all taxels are free."""
        shape = self._usable.shape
        self.bits = 0
        self._free_all()
        self._before = np.zeros(shape)
        self._presses: list[_Press] = []
        self._looked_s = -np.inf
        self._around = 0
        self._held_until_s = np.full(shape, -np.inf)
        self._settled_from_s = np.full(shape, -np.inf)
        self._all_settled_s = -np.inf

    @property
    def mask(self) -> NDArray[np.bool_]:
        """The pressed taxels, of shape (rows, cols)."""
        return self.grid.mask(self.bits)

    def update(
        self, now_s: float, zeroed: NDArray[np.float64], noise: NDArray[np.float64], unknown: float = 0.0
    ) -> NDArray[np.float64] | None:
        """Take a frame.

        Parameters
        ----------
        now_s : float
        zeroed, noise : ndarray of shape (rows, cols), float64
            What each taxel shows above its baseline, and the standard deviation of its noise.
        unknown : float
            How far the taxels may have drifted since anybody told, in their unit.

        Returns
        -------
        ndarray of shape (rows, cols), float64, or None
            What stays of presses that have just ended, and around them: creep, which may be followed; 0 elsewhere.
        """
        # What one frame alone shows is an impulse.
        steady, self._before = np.minimum(zeroed, self._before), zeroed
        on = ON_SIGMAS * noise
        hot = zeroed > on
        before = self.bits
        if before or hot.any():
            self.bits = self._pressed(zeroed, steady, on, hot)
        if not self.bits & ~self._around and now_s < self._looked_s + _LOOK_S:
            return None
        self._looked_s = now_s
        ended = self._ended(now_s, steady, unknown) if self.bits else 0
        self.bits &= ~ended
        if self.bits:
            self._hold(now_s)
        else:
            self._around = 0
            self._presses.clear()
        stays = None
        if ended:
            released = self.grid.mask(ended)
            self._held_until_s[released] = now_s
            stays = np.where(released, steady, 0.0)
        self._sort_free(now_s)
        return stays

    def _sort_free(self, now_s: float) -> None:
        """Say again who is free, and who is settled."""
        if now_s < self._all_settled_s:
            self.free = self._usable & (self._held_until_s <= now_s)
            self.settled = self._usable & (self._settled_from_s <= now_s)
            self.any_settled = int(np.count_nonzero(self.settled)) >= self._fewest
            if not self.any_settled:
                self.settled = np.zeros_like(self.settled)
            self._all_free = False
        elif not self._all_free:
            self._free_all()

    def _free_all(self) -> None:
        self.free = self.settled = self._usable
        self._all_free = self.any_settled = True

    def _pressed(
        self,
        zeroed: NDArray[np.float64],
        steady: NDArray[np.float64],
        on: NDArray[np.float64],
        hot: NDArray[np.bool_],
    ) -> int:
        """Return the pressed taxels: those that were and still show something, and new patches as far as they go."""
        grid = self.grid
        hot_bits = grid.bits(hot) & self._usable_bits
        warm_bits = grid.bits(zeroed > on * (OFF_SIGMAS / ON_SIGMAS)) & self._usable_bits
        seeds = self.bits | (hot_bits if self._few else grid.crowded(hot_bits))
        if hot_bits & ~seeds:
            seeds |= grid.bits(steady > LONE * on)
        return grid.joined(seeds, warm_bits)

    def _ended(self, now_s: float, steady: NDArray[np.float64], unknown: float) -> int:
        """Return what belongs to presses that have ended but for their creep, and the taxels around them."""
        ended, presses = 0, []
        for part in self.grid.parts(self.bits):
            height = float(steady[self.grid.mask(part)].max())
            press = _Press(part, height, np.inf)
            for earlier in self._presses:
                if earlier.bits & part:
                    press.peak = max(press.peak, earlier.peak)
                    press.low_since_s = min(press.low_since_s, earlier.low_since_s)
            if height >= min(_CREEP_SHARE * press.peak + unknown, _MOST_STAYS * press.peak):
                press.low_since_s = np.inf
            else:
                press.low_since_s = min(press.low_since_s, now_s)
                if now_s - press.low_since_s >= _CREEP_AFTER_S:
                    ended |= part
                    continue
            presses.append(press)
        self._presses = presses
        return self.grid.grown(ended, _GUARD) & self._usable_bits & ~self.grid.grown(self.bits & ~ended, _GUARD)

    def _hold(self, now_s: float) -> None:
        """Hold what is pressed and as much around it as leaves enough taxels free."""
        for guard in range(_GUARD, -1, -1):
            held = self.grid.grown(self.bits, guard)
            if (self._usable_bits & ~held).bit_count() >= self._need_free:
                break
        self._around = held
        around = self.grid.mask(held)
        self._held_until_s[around] = now_s + _DWELL_S
        self._settled_from_s[around] = np.maximum(self._settled_from_s[around], now_s + _GUARD_CREEPS_S)
        self._settled_from_s[self.mask] = now_s + _CREEPS_S
        self._all_settled_s = now_s + _CREEPS_S
