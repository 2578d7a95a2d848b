"""A sensor's clock that does not run in seconds: told once, for contacts in time are then not followed."""

from __future__ import annotations

from varishold.cli.printing import tell

__all__ = ["OddClock"]

# Readings so far apart, so many times in a row, are not of a skin that is touched; nor do times go back so often.
_FAR_S, _TIMES = 1.0, 10


class OddClock:
    """Looks at the sensor's own times.

    Parameters
    ----------
    address : str
        Of the source.
    """

    def __init__(self, address: str) -> None:
        self._address, self._told = address, False
        self._last_s: float | None = None
        self._far, self._back = 0, 0

    def look(self, device_time_s: float | None) -> None:
        """Say so if the time of this reading and those before it cannot be seconds."""
        last_s, self._last_s = self._last_s, device_time_s
        if self._told or last_s is None or device_time_s is None:
            return
        self._far = self._far + 1 if device_time_s - last_s >= _FAR_S else 0
        self._back = self._back + 1 if device_time_s < last_s else 0
        if self._far >= _TIMES:
            self._tell(f"readings are {device_time_s - last_s:.3g} s apart by their own times: are these milliseconds?")
        elif self._back >= _TIMES:
            self._tell("the times of readings go back;")

    def _tell(self, what: str) -> None:
        self._told = True
        tell(f"{self._address}: {what} time_s is in seconds and rises; touches are not followed otherwise")
