"""Those who do the work: this process, or others of this machine; each takes a task at a time."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from concurrent.futures import BrokenExecutor, Future, ProcessPoolExecutor
from contextlib import contextmanager
from multiprocessing import get_context
from typing import Any, Protocol

from varishold.files.workers import can_share, end_with, interrupted_afterwards

__all__ = ["Worker", "here", "processes", "processors"]


# A library of linear algebra starts a thread a processor in every process, unless it is told otherwise.
_THREADS = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS")


class Worker(Protocol):
    """Somebody who does a task at a time."""

    def submit(self, work: Callable[[Any], Any], task: Any) -> Future[Any]:
        """Begin a task; its future raises BrokenExecutor where whoever did it has died."""


class _Here:
    """This process."""

    def submit(self, work: Callable[[Any], Any], task: Any) -> Future[Any]:
        future: Future[Any] = Future()
        try:
            future.set_result(work(task))
        except Exception as error:
            future.set_exception(error)
        return future


class _Process:
    """A process of its own, and the next one when it has died."""

    def __init__(self) -> None:
        # Fresh processes: a copy of one with threads (a progress bar's, a library's) can hang.
        self._context = get_context("spawn")
        self._begin()

    def _begin(self) -> None:
        self._listening, self._held = self._context.Pipe(duplex=False)
        self._pool = ProcessPoolExecutor(1, self._context, initializer=end_with, initargs=(self._listening,))
        self._broken = False

    def submit(self, work: Callable[[Any], Any], task: Any) -> Future[Any]:
        # What starts meanwhile never hears Ctrl-C.
        with interrupted_afterwards(), _single_threaded():
            try:
                return self._pool.submit(work, task)
            except BrokenExecutor:
                self.close()
                self._begin()
                return self._pool.submit(work, task)

    def close(self) -> None:
        """End the process, whatever it does."""
        self._held.close()
        self._pool.shutdown(wait=True, cancel_futures=True)
        self._listening.close()


@contextmanager
def _single_threaded() -> Iterator[None]:
    """What starts meanwhile uses one thread: there are as many processes as there is room for."""
    unset = [name for name in _THREADS if name not in os.environ]
    os.environ.update(dict.fromkeys(unset, "1"))
    try:
        yield
    finally:
        for name in unset:
            del os.environ[name]


def processors() -> int:
    """Return how many processors this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


@contextmanager
def here() -> Iterator[list[Worker]]:
    """Work in this process."""
    yield [_Here()]


@contextmanager
def processes(number: int) -> Iterator[list[Worker]]:
    """Work in so many processes of this machine, which end with this one, however it ends."""
    if not can_share(get_context("spawn")):
        with here() as workers:
            yield workers
        return
    made: list[_Process] = []
    try:
        for _ in range(number):
            made.append(_Process())
        yield list(made)
    finally:
        for each in made:
            each.close()
