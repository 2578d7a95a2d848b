"""When the readings of a recording or a simulation are due."""

from __future__ import annotations

import time
from collections.abc import Callable

__all__ = ["Pace"]

# Readings that are given at once, at most, so that whoever reads can still be stopped.
_MOST_AT_ONCE = 64


class Pace:
    """Gives readings when they are due; one that is late is given at once, and none is left out.

    Parameters
    ----------
    speed : float
        The readings' seconds in one of ours; 0 for as fast as they are wanted.
    """

    def __init__(self, speed: float) -> None:
        self._speed = speed
        self.restart()

    def restart(self) -> None:
        """Begin now."""
        self._began_s, self._host_began_s = time.monotonic(), time.time()

    def due(self, due_s: Callable[[int], float], first: int, last: int, timeout_s: float) -> int:
        """Return the number behind the last reading that is due; wait for the first one, but no longer than that.

        Parameters
        ----------
        due_s : callable
            When each reading is due by its number, seconds since the beginning; never falls.
        first, last : int
            The reading that comes next, and the number behind the last one there is.
        timeout_s : float
        """
        last = min(last, first + _MOST_AT_ONCE)
        if self._speed == 0 or first >= last:
            return last
        time.sleep(min(max(due_s(first) / self._speed - self._passed_s(), 0.0), timeout_s))
        now_s, number = self._passed_s() * self._speed, first
        while number < last and due_s(number) <= now_s:
            number += 1
        return number

    def host_time_s(self, due_s: float) -> float:
        """Return this machine's time of a reading, seconds since 1970: now, or as if in real time where speed is 0."""
        return time.time() if self._speed > 0 else self._host_began_s + due_s

    def _passed_s(self) -> float:
        return time.monotonic() - self._began_s
