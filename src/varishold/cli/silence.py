"""A source that is open and brings no readings: told once as long as it lasts, for it may be meant so."""

from __future__ import annotations

import time

from varishold.cli.printing import tell

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

    def look(self, received: int, damaged: int, damage: str = "", *, is_open: bool = True) -> None:
        """Say so if no reading has come for long, or much that is none; to be called now and then.

        Parameters
        ----------
        received, damaged, damage
            As `varishold.live.lull.Lull.look` takes them.
        is_open : bool
            Whether the source is there.
        """
        if not is_open:
            self._lull.restart(time.monotonic())
        elif words := self._lull.look(received, damaged, time.monotonic(), damage):
            tell(f"{self._address}: {words}")
