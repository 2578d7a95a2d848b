"""A source that is lost again and again: told once as long as it goes on like that."""

from __future__ import annotations

import re

from varishold.live.retry_wait import THERE_S
from varishold.live.stream import Change

__all__ = ["Losses"]

# So many ways to be lost are told, before all others are taken for the same.
_MOST_WAYS = 8
_NUMBERS = re.compile(r"\d+(\.\d+)?")


class Losses:
    """Looks at a source's changes, and tells which loss there is to tell of.

    Examples
    --------
    >>> from varishold.live.stream import Change
    >>> losses = Losses()
    >>> [losses.is_news(Change(at_s, state, "gone")) for at_s, state in ((1, "lost"), (2, "open"), (3, "lost"))]
    [True, False, False]
    """

    def __init__(self) -> None:
        self._told: set[str] = set()
        self._opened_s: float | None = None

    def is_news(self, change: Change) -> bool:
        """Tell whether a change is a loss that was not told yet, but for its numbers.

        Parameters
        ----------
        change : Change
            Each is to be shown, in their order.
        """
        if change.state != "lost":
            if change.state == "open" and self._opened_s is None:
                self._opened_s = change.host_time_s
            return False
        if self._opened_s is not None and change.host_time_s - self._opened_s > THERE_S:
            self._told.clear()
        self._opened_s = None
        way = _NUMBERS.sub("", change.words)
        if way in self._told or len(self._told) == _MOST_WAYS:
            return False
        self._told.add(way)
        return True
