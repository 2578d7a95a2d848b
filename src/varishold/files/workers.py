"""What processes that work for another one need: a place for locks, deaf ears for Ctrl-C, and an end with that one."""

from __future__ import annotations

import os
import signal
from collections.abc import Iterator
from contextlib import contextmanager
from multiprocessing.connection import Connection
from multiprocessing.context import SpawnContext
from threading import Thread, current_thread, main_thread

__all__ = ["can_share", "end_with", "interrupted_afterwards"]

# Windows has none: there Ctrl-C comes to every process of the console.
_HAS_MASKS = hasattr(signal, "pthread_sigmask")


def can_share(context: SpawnContext) -> bool:
    """Tell whether there is a place for the locks that processes share; where nothing can be written there is none."""
    try:
        context.Lock()
    except OSError:
        return False
    return True


@contextmanager
def interrupted_afterwards() -> Iterator[None]:
    """What starts meanwhile never hears Ctrl-C; here it is heard afterwards, whichever thread it came to."""
    heard: list[int] = []
    mine = current_thread() is main_thread()
    handler = signal.signal(signal.SIGINT, lambda number, _: heard.append(number)) if mine else None
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT}) if _HAS_MASKS else set()
    try:
        yield
    finally:
        if _HAS_MASKS:
            signal.pthread_sigmask(signal.SIG_SETMASK, before)
        if mine:
            signal.signal(signal.SIGINT, handler)
    if heard:
        signal.raise_signal(signal.SIGINT)


def end_with(parent: Connection) -> None:
    """End this process as soon as its parent, or the parent's interest, has gone."""

    def wait() -> None:
        try:
            parent.recv_bytes()
        except (EOFError, OSError):
            os._exit(1)

    Thread(target=wait, daemon=True).start()
