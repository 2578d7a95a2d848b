"""How long is waited before a lost source is tried again."""

from __future__ import annotations

__all__ = ["THERE_S", "RetryWait"]

# A source that was there for longer has come back; one that was there for less is still being lost. Seconds.
THERE_S = 10.0
# A sensor that is plugged in is found at once; a server that hangs up again and again is not flooded. Seconds.
_SHORTEST_S, _LONGEST_S = 0.25, 2.0


class RetryWait:
    """Waits twice as long each time that the source was there for a short while, until it has been there for long.

    Examples
    --------
    >>> wait = RetryWait()
    >>> [wait.after_loss(there_s) for there_s in (1.0, 1.0, None, 1.0, 60.0)]
    [0.25, 0.5, 0.25, 1.0, 0.25]
    """

    def __init__(self) -> None:
        self._next_s = _SHORTEST_S

    def after_loss(self, there_s: float | None) -> float:
        """Return for how many seconds to wait now.

        Parameters
        ----------
        there_s : float or None
            For how long the source was there, seconds; None where it could not be opened, which is no burden to it.
        """
        if there_s is None:
            return _SHORTEST_S
        wait_s = _SHORTEST_S if there_s > THERE_S else self._next_s
        self._next_s = min(2 * wait_s, _LONGEST_S)
        return wait_s
