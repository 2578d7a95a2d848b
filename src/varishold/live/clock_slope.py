"""How a sensor's clock runs against this machine's."""

from __future__ import annotations

import math

__all__ = ["ClockSlope"]

# What was seen longer ago is forgotten. Seconds.
_MEMORY_S = 120.0
# Nothing is said before so long. Seconds.
_KNOWN_S = 10.0
# Clocks that part by more between two readings were set, or began anew. Seconds.
_SET_S = 5.0


class ClockSlope:
    """The slope of the sensor's clock over this machine's, by least squares over the last minutes.

    Attributes
    ----------
    n_set : int
        How often one of the clocks was set, or began anew.

    Examples
    --------
    >>> slope = ClockSlope()
    >>> for k in range(2000):
    ...     slope.add(0.01 * k * (1 + 50e-6), 1e9 + 0.01 * k)
    >>> round(slope.ppm)
    50
    """

    def __init__(self) -> None:
        self.n_set = 0
        self._begin()

    def _begin(self) -> None:
        self._first: tuple[float, float] | None = None
        self._last = (0.0, 0.0)
        self._weight = self._host = self._ahead = self._host_host = self._host_ahead = 0.0

    @property
    def ppm(self) -> float | None:
        """By how many millionths the sensor's clock is fast; None before it is known."""
        if self._first is None or self._last[0] < _KNOWN_S:
            return None
        return 1e6 * self._host_ahead / self._host_host

    def add(self, device_s: float, host_s: float) -> None:
        """Take both times of a reading, seconds; what is not finite is passed over."""
        if not (math.isfinite(device_s) and math.isfinite(host_s)):
            return
        if self._first is None:
            self._first = device_s, host_s
        host, ahead = host_s - self._first[1], (device_s - self._first[0]) - (host_s - self._first[1])
        last_host, last_ahead = self._last
        was_set = host < last_host or abs(ahead - last_ahead) > _SET_S
        # Of what came before a long silence nothing is left to be compared with.
        if was_set or host - last_host > _MEMORY_S:
            self.n_set += was_set
            self._begin()
            self._first = device_s, host_s
            host = ahead = last_host = 0.0
        self._last = host, ahead
        # Means, and sums of products about them, of all before; old ones fade.
        faded = math.exp(-(host - last_host) / _MEMORY_S)
        before = self._weight * faded
        self._weight = before + 1.0
        off_host, off_ahead = host - self._host, ahead - self._ahead
        self._host += off_host / self._weight
        self._ahead += off_ahead / self._weight
        share = before / self._weight
        self._host_host = self._host_host * faded + share * off_host * off_host
        self._host_ahead = self._host_ahead * faded + share * off_host * off_ahead
