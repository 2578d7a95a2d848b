"""Room that a C function works in, one piece a thread."""

from __future__ import annotations

import threading

import numpy as np

from varishold.kernel.library import address

__all__ = ["work_space"]

_FIRST_BYTES = 1 << 16
# What a thread keeps when it needs less again.
_MOST_KEPT = 1 << 25


class _Room(threading.local):
    def __init__(self) -> None:
        self.make(_FIRST_BYTES)

    def make(self, n_bytes: int) -> None:
        self.room = np.empty((n_bytes + 7) // 8)
        self.n_bytes = n_bytes
        self.at = address(self.room)


_lent = _Room()


def work_space(n_bytes: int) -> int:
    """Return the address of so many bytes at least, aligned as a double is.

    They are the calling thread's own until it asks again: ask just before the call that needs them.
    """
    if n_bytes > _lent.n_bytes:
        _lent.make(n_bytes)
    elif _lent.n_bytes > _MOST_KEPT >= n_bytes:
        _lent.make(max(n_bytes, _FIRST_BYTES))
    return _lent.at
