"""Pads that come no more while others of the same source do."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

__all__ = ["PAD_SILENT", "PadSilence"]

# A pad is silent where it has not come for so long, for so many times as long as it took before, and in so many
# readings of others: one leap of the clock silences none. Seconds.
_SILENT_S, _TIMES, _READINGS = 3.0, 5.0, 10
#: What is told of it.
PAD_SILENT = "no reading of it comes any more, while others do"


@dataclass(slots=True)
class _Came:
    """When a pad came last and how long it took, and how many readings have come without it."""

    last_s: float
    took_s: float = 0.0
    without: int = 0
    is_silent: bool = False


class PadSilence:
    """Looks which pads come with each reading.

    Examples
    --------
    >>> silence = PadSilence()
    >>> silence.look(0.0, ["left", "right"])
    (set(), set())
    >>> [silence.look(k / 10, ["right"]) for k in range(1, 40)][30]
    ({'left'}, set())
    >>> silence.look(4.0, ["left"])
    (set(), {'left'})
    """

    def __init__(self) -> None:
        self._came: dict[str, _Came] = {}

    def look(self, time_s: float, came: Iterable[str]) -> tuple[set[str], set[str]]:
        """Return the pads that have fallen silent by now, and those that are back.

        Parameters
        ----------
        time_s : float
            Of the reading; never less than that of the one before.
        came : iterable of str
            The pads in it.
        """
        here = set(came)
        back = {name for name in here if (pad := self._came.get(name)) is not None and pad.is_silent}
        for name in here:
            before = self._came.get(name)
            self._came[name] = _Came(time_s, 0.0 if before is None else time_s - before.last_s)
        fallen = set()
        for name in self._came.keys() - here:
            pad = self._came[name]
            pad.without += 1
            late = time_s - pad.last_s > max(_SILENT_S, _TIMES * pad.took_s)
            if late and pad.without >= _READINGS and not pad.is_silent:
                pad.is_silent = True
                fallen.add(name)
        return fallen, back
