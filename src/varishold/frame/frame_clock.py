"""Time between frames, by a clock that may jump and a stream that may pause."""

from __future__ import annotations

import math

from varishold.errors import InputError

__all__ = ["FrameClock"]

# A pause is longer than so many times the usual distance of frames, and than so many seconds.
_PAUSE_TIMES, _PAUSE_S = 8.0, 2.0
# How soon the usual distance follows, as a share a frame.
_USUAL_SHARE = 0.05


class FrameClock:
    """Counts the seconds in which frames came, without pauses and jumps.

    Attributes
    ----------
    now_s : float
        Seconds counted so far; never runs back.
    paused_s : float or None
        Of the last frame: how long nothing came before it, negative where the clock was set back; None where it came
        as usual.

    Examples
    --------
    >>> clock = FrameClock()
    >>> [clock.add(time_s) for time_s in (7.0, 7.5, 8.0, 60.0, 60.5)], clock.now_s
    ([0.0, 0.5, 0.5, 0.0, 0.5], 1.5)
    """

    def __init__(self) -> None:
        self.now_s = 0.0
        self.paused_s: float | None = None
        self._time_s: float | None = None
        self._usual_s: float | None = None

    def add(self, time_s: float) -> float:
        """Take a frame's time; return the seconds since the one before, 0 where the stream paused or the clock jumped.

        Raises
        ------
        InputError
            If the time is not finite.
        """
        if not math.isfinite(time_s):
            raise InputError(f"time_s must be finite, got {time_s!r}")
        before_s, self._time_s, self.paused_s = self._time_s, time_s, None
        if before_s is None:
            return 0.0
        passed_s = time_s - before_s
        longest_s = math.inf if self._usual_s is None else max(_PAUSE_S, _PAUSE_TIMES * self._usual_s)
        if not 0.0 <= passed_s <= longest_s:
            self.paused_s = passed_s
            return 0.0
        self._usual_s = passed_s if self._usual_s is None else self._usual_s + _USUAL_SHARE * (passed_s - self._usual_s)
        self.now_s += passed_s
        return passed_s
