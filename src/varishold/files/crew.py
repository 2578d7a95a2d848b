"""Those who do the work: this process, or others of this machine, that end with the one that started them."""

from __future__ import annotations

import os
from collections import deque
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import FIRST_COMPLETED, BrokenExecutor, Future, ProcessPoolExecutor, wait
from contextlib import AbstractContextManager, contextmanager
from functools import partial
from multiprocessing import get_context
from typing import Any, Protocol, TypeVar

from varishold.errors import InputError
from varishold.files.workers import can_share, end_with, interrupted_afterwards

__all__ = ["Worker", "crew_of", "here", "processes", "processors", "shared", "spread"]

# A library of linear algebra starts a thread a processor in every process, unless it is told otherwise.
# There are as many processes as there is room for: each uses one.
_THREADS = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS")
# Who removes the locks of a process that was ended where it stood warns of each.
_QUIET = {"PYTHONWARNINGS": "ignore:resource_tracker"}
_Item = TypeVar("_Item")
_Result = TypeVar("_Result")


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

    def submit(self, work: Callable[[Any], Any], task: Any) -> Future[Any]:
        # What starts meanwhile never hears Ctrl-C.
        with interrupted_afterwards(), _environment(dict.fromkeys(_THREADS, "1")):
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
def _environment(told: Mapping[str, str]) -> Iterator[None]:
    """What starts meanwhile is told so, but where the user has said otherwise."""
    unset = [name for name in told if name not in os.environ]
    os.environ.update({name: told[name] for name in unset})
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
    with interrupted_afterwards(), _environment(_QUIET):
        shares = can_share(get_context("spawn"))
    if not shares:
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


def crew_of(workers: int | AbstractContextManager[Sequence[Worker]]) -> AbstractContextManager[Sequence[Worker]]:
    """Return what gives so many processes, this one for 1, or what gives workers itself."""
    if isinstance(workers, AbstractContextManager):
        return workers
    return here() if workers <= 1 else processes(int(workers))


def shared(work: Callable[[_Item], _Result], items: Sequence[_Item], crew: Sequence[Worker]) -> Iterator[_Result]:
    """Yield ``work(item)`` for every item, in order; whoever is free takes the next.

    Parameters
    ----------
    work : callable
        Defined at the top of a module, so that other processes can find it.
    items : sequence
    crew : sequence of Worker
        Nobody for this process.

    Raises
    ------
    InputError
        If workers died twice over the same item.
    """
    if not crew:
        yield from map(work, items)
        return
    free, left = [*crew], deque(range(len(items)))
    busy: dict[Future[Any], tuple[int, Worker]] = {}
    done: dict[int, Future[Any]] = {}
    died = set[int]()
    for wanted in range(len(items)):
        while wanted not in done:
            while free and left:
                at, worker = left.popleft(), free.pop()
                busy[worker.submit(work, items[at])] = at, worker
            for future in wait(busy, return_when=FIRST_COMPLETED).done:
                at, worker = busy.pop(future)
                free.append(worker)
                if not isinstance(future.exception(), BrokenExecutor):
                    done[at] = future
                    continue
                if at in died:
                    raise InputError(
                        "a worker died twice over the same work, perhaps for lack of memory; ask for fewer workers"
                    )
                died.add(at)
                left.appendleft(at)
        yield done.pop(wanted).result()


def spread(
    work: Callable[[_Item], _Result], items: Sequence[_Item], *, processes: int, chunk: int = 1
) -> Iterator[_Result]:
    """Yield ``work(item)`` for every item, in order, by processes that are begun for it.

    Parameters
    ----------
    work, items
        As `shared` takes them.
    processes : int
        1 works in this process, as any number does where processes cannot share a lock.
    chunk : int
        Items that a process takes at a time.
    """
    if processes <= 1:
        yield from map(work, items)
        return
    with crew_of(processes) as crew:
        for found in shared(
            partial(_all_of, work), [items[at : at + chunk] for at in range(0, len(items), chunk)], crew
        ):
            yield from found


def _all_of(work: Callable[[_Item], _Result], items: Sequence[_Item]) -> list[_Result]:
    return [work(item) for item in items]
