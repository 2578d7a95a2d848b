"""A source that was opened and brings no readings, or much that is none: told once as long as it lasts."""

from __future__ import annotations

__all__ = ["Lull", "unused_words"]

# Seconds without a reading after which it is told.
_SILENT_S = 3.0
# Messages of no use are counted so long from the first, and told where they are more than this share of all. Seconds.
_COUNTED_S, _SHARE = 2.5, 0.05


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
    >>> [lull.look(10, 0, now_s) for now_s in (1.0, 2.0, 4.5, 9.0)]
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

    def restart(self, now_s: float) -> None:
        """Wait from now on: the source was not there until now."""
        self._came_s = self._steady_s = now_s

    def look(self, received: int, damaged: int, now_s: float, damage: str = "") -> str:
        """Return what there is to tell; empty where there is nothing, or it was told.

        Parameters
        ----------
        received, damaged : int
            How many readings have come so far, and how many messages held none.
        now_s : float
        damage : str
            What was wrong with the newest of those, in words.
        """
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
        return words

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
    which = f"{damaged} message{'s' * (damaged > 1)}" if of in (None, damaged) else f"{damaged} of {of} messages"
    return f"{which} held no frame that could be used{': ' * bool(damage)}{damage}"
