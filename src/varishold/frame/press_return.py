"""How taxels come back after a press: what stays of it, and for how long."""

from __future__ import annotations

from typing import Literal

import numpy as np
from numpy.typing import NDArray

__all__ = ["PressReturn"]

# How soon the rest follows while nothing presses. Seconds.
_REST_S = 3.0
# A press is over when all taxels together show less than this share of its peak, and begins again above the other.
_OVER_SHARE, _AGAIN_SHARE = 0.25, 0.5
# What stays is read so long after that; a taxel has come back below this share of its peak. Seconds.
_READ_AFTER_S, _BACK_SHARE = 0.5, 0.05
# It is waited for no longer; of longer presses drift is not told from what stays. Seconds.
_WAIT_S, _LONGEST_PRESS_S = 30.0, 60.0
# A taxel tells by presses of so many standard deviations of its noise.
_LOUD_SIGMAS = 20.0
# The weight of the newest press.
_NEWEST = 0.3


class PressReturn:
    """Follows presses, the whole pad's as one.

    Parameters
    ----------
    shape : (int, int)

    Attributes
    ----------
    stays_share : ndarray of shape (rows, cols), float64
        What stays of a press after half a second, by its peak, of the last presses; nan where nothing is known.
    return_s : ndarray of shape (rows, cols), float64
        How long it takes until less than 5 % stays; nan where nothing is known.
    resting : bool
        Whether nothing presses and everything has come back.
    """

    def __init__(self, shape: tuple[int, int]) -> None:
        self.stays_share = np.full(shape, np.nan)
        self.return_s = np.full(shape, np.nan)
        self._rest: NDArray[np.float64] | None = None
        self._peak = np.zeros(shape)
        self._total_peak = 0.0
        self._state: Literal["resting", "pressed", "returning"] = "resting"
        self._touched = False
        self._since_s = 0.0
        self._read = False
        self._heard = self._waiting = np.zeros(shape, np.bool_)

    @property
    def resting(self) -> bool:
        """Whether nothing presses and everything has come back."""
        return self._state == "resting" and not self._touched

    def add(
        self, now_s: float, passed_s: float, values: NDArray[np.float64], noise: NDArray[np.float64], *, touched: bool
    ) -> None:
        """Take a frame.

        Parameters
        ----------
        now_s, passed_s : float
            By a clock that never runs back, and since the last frame.
        values, noise : ndarray of shape (rows, cols), float64
        touched : bool
            Whether anything presses.
        """
        if self._rest is None:
            self._rest = values.copy()
        began, self._touched = touched and not self._touched, touched
        if self._state == "resting" and not touched:
            self._rest = self._rest + min(passed_s / _REST_S, 1.0) * (values - self._rest)
            return
        over = values - self._rest
        loud = self._peak > _LOUD_SIGMAS * noise
        total = float(np.maximum(over, 0.0).sum())
        if self._state != "pressed" and touched and (began or total > _AGAIN_SHARE * self._total_peak):
            self._state, self._since_s = "pressed", now_s
            self._peak, self._total_peak = np.zeros_like(over), 0.0
        if self._state == "pressed":
            self._peak = np.maximum(self._peak, over)
            self._total_peak = max(self._total_peak, total)
            if not touched or total < _OVER_SHARE * self._total_peak:
                lasted_s, self._since_s = now_s - self._since_s, now_s
                self._read = lasted_s > _LONGEST_PRESS_S
                self._heard = self._waiting = loud if not self._read else np.zeros_like(loud)
                self._state = "returning"
        elif self._state == "returning":
            self._return(now_s - self._since_s, over)

    def _return(self, after_s: float, over: NDArray[np.float64]) -> None:
        """Read what stays so long after a press."""
        if not self._read and after_s >= _READ_AFTER_S:
            self._read = True
            # What has come back already, too: of that little stays.
            stays = np.divide(over, self._peak, out=np.zeros_like(over), where=self._heard)
            self.stays_share = _newest(self.stays_share, np.maximum(stays, 0.0), self._heard)
        back = self._waiting & (over < _BACK_SHARE * self._peak)
        if after_s >= _WAIT_S:
            back = self._waiting
        if back.any():
            self.return_s = _newest(self.return_s, np.full_like(over, after_s), back)
            self._waiting = self._waiting & ~back
        if self._read and not self._waiting.any():
            self._state = "resting"


def _newest(known: NDArray[np.float64], new: NDArray[np.float64], where: NDArray[np.bool_]) -> NDArray[np.float64]:
    """Return a running mean with what is new at some taxels."""
    mean = np.where(np.isnan(known), new, known + _NEWEST * (new - known))
    return np.where(where, mean, known)
