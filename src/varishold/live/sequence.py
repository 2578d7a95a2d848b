"""The numbers that a sensor gives its readings: how many never came."""

from __future__ import annotations

__all__ = ["SequenceCounter"]

# Counters of so many bits begin again at 0.
_WIDTHS = (8, 16, 32, 64)
# More readings than this many times what the time allows cannot have been lost; the sensor began anew.
_PLAUSIBLE_TIMES, _PLAUSIBLE_MORE = 3.0, 16.0


class SequenceCounter:
    """Counts what a sensor's numbers say was lost, came twice or out of order.

    Attributes
    ----------
    lost, twice, late, restarts : int
        Readings that never came, came again, came after a later one (they are taken off those lost), and how often the
        counter began anew.

    Examples
    --------
    >>> counter = SequenceCounter()
    >>> for k, number in enumerate((253, 254, 255, 0, 1, 4, 5)):
    ...     counter.add(number, 0.01)
    >>> counter.lost, counter.restarts
    (2, 0)
    """

    def __init__(self) -> None:
        self.lost = self.twice = self.late = self.restarts = 0
        self._last: int | None = None
        self._largest = 0
        self._around = 0
        self._step: int | None = None
        self._usual_s = 0.0
        self._waited_s = 0.0

    def add(self, number: int, passed_s: float) -> None:
        """Take a reading's number.

        Parameters
        ----------
        number : int
            As the sensor sent it; a sender that counts in twos is understood.
        passed_s : float
            Since the reading before it came.
        """
        self._waited_s += max(passed_s, 0.0)
        last, self._largest = self._last, max(self._largest, number)
        if last is None:
            self._last, self._waited_s = number, 0.0
            return
        ahead = self._ahead(number, last)
        if ahead == 0:
            self.twice += 1
            return
        waited_s, self._waited_s = self._waited_s, 0.0
        if ahead < 0 and -ahead <= _PLAUSIBLE_MORE and self.lost > 0:
            self.late += 1
            self.lost -= 1
            return
        self._last = number
        if ahead < 0 or not self._plausible(ahead, waited_s):
            self.restarts += 1
            self._largest, self._around = number, 0
            return
        if self._step is None:
            self._step, self._usual_s = ahead, waited_s
            return
        self._step = min(self._step, ahead)
        steps = ahead // self._step
        self.lost += steps - 1
        self._usual_s += 0.05 * (waited_s / steps - self._usual_s)

    def _ahead(self, number: int, last: int) -> int:
        """Return how far a number is ahead of the last one, round the end of the counter if that is nearer."""
        ahead = number - last
        if self._around and max(number, last) >= self._around:
            self._around = 0
        if not self._around and ahead < 0:
            around = next(((1 << bits) for bits in _WIDTHS if self._largest < (1 << bits)), 0)
            # A counter that goes round was near its end.
            if -ahead <= around // 2:
                return ahead
            self._around = around
        half = self._around // 2
        return (ahead + half) % self._around - half if self._around else ahead

    def _plausible(self, ahead: int, waited_s: float) -> bool:
        """Tell whether so many readings can have been lost in that time."""
        if self._step is None:
            return True
        most = _PLAUSIBLE_MORE if self._usual_s <= 0.0 else waited_s / self._usual_s * _PLAUSIBLE_TIMES
        return ahead / self._step <= most + _PLAUSIBLE_MORE
