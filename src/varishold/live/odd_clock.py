"""A sensor's clock that does not run in seconds: by its times contacts cannot be followed."""

from __future__ import annotations

from collections import deque
from statistics import median

from varishold.live.sample import Sample

__all__ = ["OddClock"]

# Readings so far apart, so many times in a row, are not of a skin that is touched; nor do times go back, or stay
# where they are while a pad is read again, so often.
_FAR_S, _TIMES = 1.0, 10
# Times go back where they do so as often among so many readings: those of two senders at once go to and fro.
_AMONG = 4 * _TIMES
# Nor where they came so much sooner one after the other; a sensor that is slow is none that is odd.
_SOONER = 0.2
# Nearer than this they may be of a slow sensor whose readings are handed on all at once, as out of a file. They are
# milliseconds where they come as these would, to within such a factor.
_SLOW_S, _MILLISECOND, _AS_FAST = 10.0, 1e-3, 2.0


class OddClock:
    """Looks at the sensor's own times.

    Attributes
    ----------
    words : str
        What is odd about them; empty while nothing is.

    Examples
    --------
    >>> clock = OddClock()
    >>> for k in range(12):
    ...     clock.look(Sample(20.0 * k, 1e9 + 0.02 * k, None, {}))
    >>> clock.words
    'readings are 20 s apart by their own times: are these milliseconds? time_s is in seconds and rises'
    """

    def __init__(self) -> None:
        self.words = ""
        self._last: tuple[float | None, float] = None, 0.0
        self._back: deque[bool] = deque(maxlen=_AMONG)
        self._still = 0
        # By how much sooner each of the newest readings came than its time says.
        self._sooner: deque[float] = deque(maxlen=_TIMES)
        # The pads that came with the newest time: several may be read at one.
        self._pads: set[str] = set()

    def look(self, sample: Sample) -> None:
        """Take the time of the next reading, by the sensor's clock and by this machine's."""
        device_time_s, host_time_s = sample.device_time_s, sample.host_time_s
        (last_s, last_host_s), self._last = self._last, (device_time_s, host_time_s)
        if self.words or last_s is None or device_time_s is None:
            return
        step_s = device_time_s - last_s
        if step_s >= _FAR_S and host_time_s - last_host_s < _SOONER * step_s:
            self._sooner.append((host_time_s - last_host_s) / step_s)
        else:
            self._sooner.clear()
        self._back.append(device_time_s < last_s)
        self._look_at_pads(sample, is_still=step_s == 0.0)
        what = ""
        if len(self._sooner) == _TIMES and (step_s >= _SLOW_S or self._comes_in_milliseconds()):
            what = f"readings are {step_s:.3g} s apart by their own times: are these milliseconds?"
        elif sum(self._back) >= _TIMES:
            what = "the times of readings go back;"
        elif self._still >= _TIMES:
            what = "the times of readings stand still;"
        self.words = what and f"{what} time_s is in seconds and rises"

    def _comes_in_milliseconds(self) -> bool:
        return _MILLISECOND / _AS_FAST <= median(self._sooner) <= _MILLISECOND * _AS_FAST

    def _look_at_pads(self, sample: Sample, *, is_still: bool) -> None:
        again = is_still and not self._pads.isdisjoint(sample.pads)
        if again or not is_still:
            self._pads = set()
        self._still = self._still + again if is_still else 0
        self._pads.update(sample.pads)
