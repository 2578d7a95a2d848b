"""What pressed before there was a zero lets go: its taxels sink to their true rest."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from varishold.frame.patches import PatchGrid, in_patches

__all__ = ["LettingGo"]

# It is looked so often, at the frames since the look before the last one. Seconds.
_LOOK_S = 0.025
# A taxel has sunk whose average is below zero by so many standard deviations of its noise, and of an average's, and
# each frame by so many: a single spoilt one sinks nothing.
_SUNK_SIGMAS, _SUNK_ERRORS, _EACH_SIGMAS = 2.0, 5.0, 1.0
# Taxels that are not known to have been pressed are watched so long, and any goes on to sink for so long. Seconds.
_WATCHED_S, _SINKS_S = 3.0, 1.0
# What was pressed reaches so many taxels around where it was seen.
_AROUND = 2

Floats = NDArray[np.float64]
Mask = NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class _Seen:
    """The sum of some frames, the highest reading of each taxel in them, and how many they are."""

    sum: Floats
    highest: Floats
    n: int

    @classmethod
    def nothing(cls, shape: tuple[int, ...]) -> _Seen:
        return cls(np.zeros(shape), np.full(shape, -np.inf), 0)

    def with_frame(self, values: Floats) -> _Seen:
        return _Seen(self.sum + values, np.maximum(self.highest, values), self.n + 1)


class LettingGo:
    """Watches for patches that sink below a zero that was taken while something may have pressed.

    Parameters
    ----------
    usable : ndarray of shape (rows, cols), bool
    doubtful : ndarray of shape (rows, cols), bool
        Where something pressed, or may have: watched until it lets go, however long that takes. Others are watched
        for three seconds.
    """

    def __init__(self, usable: Mask, doubtful: Mask) -> None:
        grid = PatchGrid((usable.shape[0], usable.shape[1]))
        around = grid.mask(grid.grown(grid.bits(doubtful), _AROUND))
        self._usable = usable
        self._watched_until_s = np.where(around, np.inf, _WATCHED_S)
        self._now_s = 0.0
        self._since_s = 0.0
        # Of the frames since the last look, and of those between the last two.
        self._seen = self._before = _Seen.nothing(usable.shape)

    @property
    def is_over(self) -> bool:
        """Whether no taxel is watched any more."""
        return not bool((self._watched_until_s >= self._now_s).any())

    def add(self, passed_s: float, values: Floats, baseline: Floats, noise: Floats) -> tuple[Mask, Floats] | None:
        """Take a frame; return where taxels have sunk, and what they show now, or None where none has.

        Parameters
        ----------
        passed_s : float
            Since the frame before.
        values, baseline, noise : ndarray of shape (rows, cols), float64
            The frame, what is taken for its zero, and the standard deviation of its noise.
        """
        self._seen = self._seen.with_frame(values)
        self._since_s += passed_s
        if self._since_s < _LOOK_S:
            return None
        self._now_s += self._since_s
        n = self._before.n + self._seen.n
        level = (self._before.sum + self._seen.sum) / n
        highest = np.maximum(self._before.highest, self._seen.highest)
        self._before, self._seen, self._since_s = self._seen, _Seen.nothing(level.shape), 0.0
        if n < 2:
            return None
        least = noise * max(_SUNK_SIGMAS, _SUNK_ERRORS / math.sqrt(n))
        sunk = (level - baseline < -least) & (highest - baseline < -_EACH_SIGMAS * noise)
        sunk &= self._usable & (self._watched_until_s >= self._now_s)
        if not sunk.any() or not (sunk := in_patches(sunk)).any():
            return None
        self._watched_until_s[sunk] = self._now_s + _SINKS_S
        return sunk, level
