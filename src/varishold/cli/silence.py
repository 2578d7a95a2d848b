"""A source that is open and brings no readings: told once as long as it lasts, for it may be meant so."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING

from varishold.cli.printing import tell

if TYPE_CHECKING:
    from varishold.live import Recorder, Stream

__all__ = ["Silence"]


class Silence:
    """Looks whether readings come.

    Parameters
    ----------
    address : str
        Of the source, for messages.
    """

    def __init__(self, address: str) -> None:
        from varishold.live.lull import Lull

        self._address = address
        self._lull = Lull(time.monotonic())

    def look(self, received: int, source: Stream | Recorder, *, is_open: bool = True) -> None:
        """Say so if no reading has come for long, much that is none, or more than is read; to be called now and then.

        Parameters
        ----------
        received : int
            How many readings have come so far.
        source : Stream or Recorder
            Counts what could not be used, and what was lost here.
        is_open : bool
            Whether the source is there.
        """
        if not is_open:
            self._lull.restart(time.monotonic())
            return
        if words := self._lull.look(received, source, time.monotonic()):
            tell(f"{self._address}: {words}")
