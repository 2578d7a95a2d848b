"""Work spread over processes that end with the one that started them, however it ends."""

from __future__ import annotations

import os
import signal
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from contextlib import contextmanager
from multiprocessing import get_context
from multiprocessing.connection import Connection
from multiprocessing.context import SpawnContext
from threading import Thread, current_thread, main_thread
from typing import TypeVar

__all__ = ["can_share", "end_with", "interrupted_afterwards", "spread"]

# Windows has none: there Ctrl-C comes to every process of the console.
_HAS_MASKS = hasattr(signal, "pthread_sigmask")
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
        1 works in this process, as any number does where processes cannot share a lock.
    chunk : int
        Items that a process takes at a time.
    """
    # Fresh processes: a copy of one with threads (a progress bar's) can hang.
    context = get_context("spawn")
    with interrupted_afterwards():
        alone = processes <= 1 or not can_share(context)
    if alone:
        yield from map(work, items)
        return
    listening, held = context.Pipe(duplex=False)
    pool = ProcessPoolExecutor(processes, mp_context=context, initializer=end_with, initargs=(listening,))
    with listening, held, pool:
        try:
            with interrupted_afterwards():
                parts = [pool.submit(_all_of, work, items[at : at + chunk]) for at in range(0, len(items), chunk)]
            # Not `pool.map`, which cancels what is left when it is interrupted, and its thread then stumbles over it.
            parts.reverse()
            while parts:
                yield from parts.pop().result()
        except BaseException:
            # Nobody waits for work that is not wanted any more.
            held.close()
            raise


def can_share(context: SpawnContext) -> bool:
    """Tell whether there is a place for the locks that processes share; where nothing can be written there is none."""
    try:
        context.Lock()
    except OSError:
        return False
    return True


def _all_of(work: Callable[[_Item], _Result], items: Sequence[_Item]) -> list[_Result]:
    return [work(item) for item in items]


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
