"""A source that was opened and brings no readings, much that is none, or more than is read: told once as it lasts."""

from __future__ import annotations

from varishold._counted import counted
from varishold.live.source import damage_of, damaged_of, overrun_of

__all__ = ["Lull", "overrun_words", "unused_words"]

# Seconds without a reading after which it is told.
_SILENT_S = 3.0
# Messages of no use are counted so long from the first, and told where they are more than this share of all. Seconds.
_COUNTED_S, _SHARE = 2.5, 0.05
# What is lost is counted so long before it is told, and told again after so long without. Seconds.
_GATHERED_S, _OVER_S = 0.5, 3.0


class Lull:
    """Looks at how many readings have come, and how many messages held none.

    Parameters
    ----------
    now_s : float
        By any clock that only goes on.

    Attributes
    ----------
    damage : str
        What was told of messages that held none, as long as such come; else empty.

    Examples
    --------
    >>> lull = Lull(0.0)
    >>> [lull.look(10, None, now_s) for now_s in (1.0, 2.0, 4.5, 9.0)]
    ['', '', 'no reading has come in 3 s; waiting', '']
    """

    def __init__(self, now_s: float) -> None:
        self._received, self.damage = 0, ""
        # When the last reading came, how many messages held none by then, and since when none was waited for.
        self._came_s, self._damaged_then, self._steady_s = now_s, 0, now_s
        self._silence_told = self._damage_told = False
        self._damaged, self._damaged_s = 0, now_s
        # Since when messages are counted, and how many of both kinds had come before.
        self._counted: tuple[float, int, int] | None = None
        # What was lost by the last look, when that grew, and what is to be told of it since when.
        self._overrun, self._overrun_s = 0, -_OVER_S
        self._untold: tuple[float, int] | None = None

    def restart(self, now_s: float) -> None:
        """Wait from now on: the source was not there until now."""
        self._came_s = self._steady_s = now_s

    def look(self, received: int, source: object, now_s: float) -> str:
        """Return what there is to tell; empty where there is nothing, or it was told.

        Parameters
        ----------
        received : int
            How many readings have come so far.
        source : object
            It counts, where it can, how many messages held none and how many were lost, as a `Source` does.
        now_s : float
        """
        damaged, damage = damaged_of(source), damage_of(source)
        words = self._of_damage(received, damaged, now_s, damage)
        if received != self._received:
            self._take(received, damaged, now_s)
        elif not self._silence_told and now_s - self._came_s > _SILENT_S:
            self._silence_told = True
            wrong = damaged - self._damaged_then
            if wrong and not self._damage_told:
                self._damage_told, self.damage = True, unused_words(wrong, damage=damage)
                words = self.damage
            elif not wrong:
                words = f"no reading has come in {_SILENT_S:.0f} s; waiting"
        return words or self._of_overrun(overrun_of(source), now_s)

    def _take(self, received: int, damaged: int, now_s: float) -> None:
        """Take note of readings that have come; after some time of them a silence is told again."""
        if now_s - self._came_s > _SILENT_S:
            self._steady_s = now_s
        elif now_s - self._steady_s > _SILENT_S:
            self._silence_told = False
        self._received, self._came_s, self._damaged_then = received, now_s, damaged

    def _of_damage(self, received: int, damaged: int, now_s: float, damage: str) -> str:
        if damaged > self._damaged:
            self._counted = self._counted or (now_s, self._damaged, self._received)
            self._damaged, self._damaged_s = damaged, now_s
        elif now_s - self._damaged_s > _SILENT_S:
            self._damage_told, self.damage = False, ""
        if self._counted is None or now_s - self._counted[0] < _COUNTED_S:
            return ""
        wrong, right = damaged - self._counted[1], received - self._counted[2]
        self._counted = None
        if self._damage_told or wrong < 2 or wrong <= _SHARE * (wrong + right):
            return ""
        self._damage_told, self.damage = True, unused_words(wrong, of=wrong + right, damage=damage)
        return self.damage

    def _of_overrun(self, overrun: int, now_s: float) -> str:
        if overrun > self._overrun:
            if now_s - self._overrun_s >= _OVER_S:
                self._untold = (now_s, self._overrun)
            self._overrun, self._overrun_s = overrun, now_s
        if self._untold is None or now_s - self._untold[0] < _GATHERED_S:
            return ""
        lost, self._untold = overrun - self._untold[1], None
        return overrun_words(lost)


def overrun_words(overrun: int) -> str:
    """Say how many messages were lost here; empty of none.

    Examples
    --------
    >>> overrun_words(102)
    '102 messages were lost: they came faster than they could be read'
    """
    which = counted(overrun, "message was lost: it", "messages were lost: they")
    return f"{which} came faster than {which.split()[-1]} could be read" if overrun else ""


def unused_words(damaged: int, *, of: int | None = None, damage: str = "") -> str:
    """Say how many messages held no frame, of how many where some did, and what was wrong; empty of none.

    Examples
    --------
    >>> unused_words(1)
    '1 message held no frame that could be used'
    >>> unused_words(3, of=4, damage="a line is too long")
    '3 of 4 messages held no frame that could be used: a line is too long'
    """
    if not damaged:
        return ""
    which = counted(damaged, "message") if of in (None, damaged) else f"{damaged} of {of} messages"
    return f"{which} held no frame that could be used{': ' * bool(damage)}{damage}"
