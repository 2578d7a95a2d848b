"""A source that is open and says nothing: told once, for it may be meant so."""

from __future__ import annotations

import sys
import time
from typing import TYPE_CHECKING

from varishold.cli.printing import printable

if TYPE_CHECKING:
    from varishold.live import Stream

__all__ = ["Silence"]

# Seconds after which it is told.
_SILENT_S = 3.0


class Silence:
    """Looks whether anything comes.

    Parameters
    ----------
    stream : Stream
    """

    def __init__(self, stream: Stream) -> None:
        self._stream, self._told = stream, False
        self._since_s = time.monotonic()

    def look(self) -> None:
        """Say so if nothing has come for long; to be called now and then."""
        if self._told or self._stream.state != "open":
            self._since_s = time.monotonic()
        elif self._stream.received:
            self._told = True
        elif time.monotonic() - self._since_s > _SILENT_S:
            self._told = True
            words = f"{self._stream.address}: nothing has come in {_SILENT_S:.0f} s; waiting"
            print(f"varishold: {printable(words)}", file=sys.stderr, flush=True)
