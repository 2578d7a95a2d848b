"""Work spread over processes that end with the one that started them, however it ends."""

from __future__ import annotations

import os
import signal
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from multiprocessing.connection import Connection
from threading import Thread
from typing import TypeVar

__all__ = ["spread"]

_Item = TypeVar("_Item")
_Result = TypeVar("_Result")


def spread(
    work: Callable[[_Item], _Result], items: Sequence[_Item], *, processes: int, chunk: int = 1
) -> Iterator[_Result]:
    """Yield ``work(item)`` for every item, in order.

    Parameters
    ----------
    work : callable
        Defined at the top of a module, so that other processes can find it.
    items : sequence
    processes : int
        1 works in this process.
    chunk : int
        Items that a process takes at a time.
    """
    if processes <= 1:
        yield from map(work, items)
        return
    # Fresh processes: a copy of one with threads (a progress bar's) can hang.
    context = get_context("spawn")
    listening, held = context.Pipe(duplex=False)
    with ProcessPoolExecutor(processes, mp_context=context, initializer=_end_with, initargs=(listening,)) as pool:
        try:
            # What starts meanwhile never hears Ctrl-C; here it is heard afterwards.
            before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
            try:
                results = pool.map(work, items, chunksize=chunk)
            finally:
                signal.pthread_sigmask(signal.SIG_SETMASK, before)
            yield from results
        except BaseException:
            # Nobody waits for work that is not wanted any more.
            held.close()
            raise
    held.close()
    listening.close()


def _end_with(parent: Connection) -> None:
    """End this process as soon as its parent, or the parent's interest, has gone."""

    def wait() -> None:
        try:
            parent.recv_bytes()
        except (EOFError, OSError):
            os._exit(1)

    Thread(target=wait, daemon=True).start()
