"""Room that a C function works in, one piece a thread."""

from __future__ import annotations

import threading

import numpy as np

from varishold.kernel.library import address

__all__ = ["work_space"]

_FIRST_BYTES = 1 << 16
# What a thread keeps when it needs less again.
_MOST_KEPT = 1 << 25
# Bytes of a cache line: where it begins at one, no vector is written across two.
_LINE = 64


class _Room:
    """Bytes, how many they are, and where they stand."""

    __slots__ = ("at", "n_bytes", "numbers")

    def __init__(self, n_bytes: int) -> None:
        self.numbers = np.empty((n_bytes + _LINE + 7) // 8)
        self.n_bytes = n_bytes
        self.at = -(-address(self.numbers) // _LINE) * _LINE


class _Lent(threading.local):
    def __init__(self) -> None:
        self.room = _Room(_FIRST_BYTES)


_lent = _Lent()


def work_space(n_bytes: int) -> int:
    """Return the address of so many bytes at least, at the beginning of a cache line.

    They are the calling thread's own until it asks again: ask just before the call that needs them.
    """
    room = _lent.room
    if n_bytes > room.n_bytes:
        room = _lent.room = _Room(n_bytes)
    elif room.n_bytes > _MOST_KEPT >= n_bytes:
        room = _lent.room = _Room(max(n_bytes, _FIRST_BYTES))
    return room.at
