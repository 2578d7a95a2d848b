"""Time that only goes on, whatever the sensor's clock does."""

from __future__ import annotations

import math

from varishold.live.odd_clock import OddClock
from varishold.live.sample import Sample

__all__ = ["SteadyTime"]

# A device clock that leaps further ahead than this began anew, or sends nonsense. Seconds.
_LONGEST_S = 86400.0


class SteadyTime:
    """The time of each sample, by the sensor's clock where it has one that runs in seconds, else by this machine's.

    A sensor that was lost and came back counts from zero again: time then goes on from where it was, by as much as
    this machine's clock says has passed.

    Examples
    --------
    >>> clock = SteadyTime()
    >>> [clock.time_s(Sample(device, host, None, {})) for device, host in ((7.0, 100.0), (7.5, 100.5), (0.0, 102.0))]
    [7.0, 7.5, 9.0]
    """

    def __init__(self) -> None:
        self._offset_s = 0.0
        self._odd = OddClock()
        self._last: tuple[float, float] | None = None

    @property
    def now_s(self) -> float:
        """The time of the newest sample; 0 before the first."""
        return 0.0 if self._last is None else self._last[0]

    def time_s(self, sample: Sample) -> float:
        """Return a sample's time, at least that of the sample before it."""
        was_odd = bool(self._odd.words)
        self._odd.look(sample)
        is_odd, device = bool(self._odd.words), sample.device_time_s
        own = sample.host_time_s if is_odd or device is None or not math.isfinite(device) else device
        if self._last is None:
            time_s = own
        else:
            last_s, last_host_s = self._last
            time_s = own + self._offset_s
            if is_odd != was_odd or not last_s <= time_s <= last_s + _LONGEST_S:
                passed_s = sample.host_time_s - last_host_s
                time_s = last_s + (passed_s if 0 <= passed_s <= _LONGEST_S else 0.0)
                self._offset_s = time_s - own
        self._last = time_s, sample.host_time_s
        return time_s
