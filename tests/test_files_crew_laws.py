"""Those who work: how they are begun and ended, and what is different in the world while they start."""

from __future__ import annotations

import os
import signal
from concurrent.futures import BrokenExecutor, Future
from typing import Any, ClassVar

import pytest

from varishold.errors import InputError
from varishold.files import crew

THREADS = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS")


def test_this_process_works_at_once_and_keeps_what_is_raised() -> None:
    with crew.here() as workers:
        (one,) = workers
        done = one.submit(lambda task: task + 1, 3)
        assert done.done()
        assert done.result() == 4
        assert isinstance(one.submit(lambda task: 1 / task, 0).exception(), ZeroDivisionError)

        def interrupted(_: Any) -> None:
            raise KeyboardInterrupt

        with pytest.raises(KeyboardInterrupt):
            one.submit(interrupted, 0)


@pytest.mark.parametrize("given", [{}, {"OMP_NUM_THREADS": "7"}, dict.fromkeys(THREADS, "3")])
def test_what_starts_meanwhile_has_one_thread_unless_somebody_said_otherwise(
    given: dict[str, str], monkeypatch: pytest.MonkeyPatch
) -> None:
    for name in THREADS:
        monkeypatch.delenv(name, raising=False)
    for name, value in given.items():
        monkeypatch.setenv(name, value)
    seen = {}

    def look() -> None:
        with crew._environment(dict.fromkeys(crew._THREADS, "1")):
            seen.update({name: os.environ[name] for name in THREADS})
            raise ValueError("own")

    with pytest.raises(ValueError, match="own"):
        look()
    assert seen == {**dict.fromkeys(THREADS, "1"), **given}
    assert {name: os.environ[name] for name in THREADS if name in os.environ} == given


def test_there_are_as_many_processors_as_this_process_may_use(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(os, "sched_getaffinity", lambda pid: {0, 3, 5} if pid == 0 else {1}, raising=False)
    assert crew.processors() == 3
    monkeypatch.delattr(os, "sched_getaffinity")
    for told, expected in ((6, 6), (None, 1)):
        monkeypatch.setattr(os, "cpu_count", lambda told=told: told)
        assert crew.processors() == expected


class Pool:
    """Stands for a pool of one process: dies where it is told to."""

    made: ClassVar[list[Pool]] = []

    def __init__(self, number: int, context: Any, *, initializer: Any, initargs: Any) -> None:
        assert number == 1
        assert context.get_start_method() == "spawn"
        assert initializer is crew.end_with
        (self.listening,) = initargs
        self.dead = False
        self.ended: dict[str, Any] = {}
        Pool.made.append(self)

    def submit(self, work: Any, task: Any) -> Future[Any]:
        if self.dead:
            raise BrokenExecutor("dead")
        assert all(os.environ.get(name) for name in THREADS)
        if hasattr(signal, "pthread_sigmask"):
            assert signal.SIGINT in signal.pthread_sigmask(signal.SIG_BLOCK, [])
        future: Future[Any] = Future()
        future.set_result(work(task))
        return future

    def shutdown(self, **how: Any) -> None:
        self.ended = how


@pytest.fixture
def pools(monkeypatch: pytest.MonkeyPatch) -> list[Pool]:
    Pool.made = []
    monkeypatch.setattr(crew, "ProcessPoolExecutor", Pool)
    return Pool.made


def test_processes_are_made_replaced_and_ended(pools: list[Pool]) -> None:
    with crew.processes(3) as workers:
        assert len(workers) == len(pools) == 3
        assert workers[1].submit(str, 5).result() == "5"
        pools[1].dead = True
        # The next one takes the task, and the dead one is cleared away.
        assert workers[1].submit(str, 6).result() == "6"
        assert len(pools) == 4
        assert pools[1].ended == {"wait": True, "cancel_futures": True}
        assert pools[1].listening.closed
        assert not any(pools[k].ended or pools[k].listening.closed for k in (0, 2, 3))
        # What holds a process alive is held until the end.
        assert not any(pools[k].listening.poll() for k in (0, 2, 3))
    for pool in pools:
        assert pool.ended == {"wait": True, "cancel_futures": True}
        assert pool.listening.closed


def test_processes_end_also_where_somebody_stumbles(pools: list[Pool]) -> None:
    with pytest.raises(ValueError, match="own"), crew.processes(2):
        raise ValueError("own")
    assert [bool(pool.ended) for pool in pools] == [True, True]


def test_where_processes_cannot_share_this_one_works(pools: list[Pool], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(crew, "can_share", lambda context: False)
    with crew.processes(4) as workers:
        assert [type(worker) for worker in workers] == [crew._Here]
    assert pools == []


class Mortal:
    """Works, but dies over some items: so many times over each."""

    def __init__(self, dies: dict[int, int]) -> None:
        self.dies, self.asked = dies, list[int]()

    def submit(self, work: Any, task: Any) -> Future[Any]:
        self.asked.append(task)
        future: Future[Any] = Future()
        if self.dies.get(task, 0):
            self.dies[task] -= 1
            future.set_exception(BrokenExecutor("dead"))
        else:
            try:
                future.set_result(work(task))
            except ArithmeticError as error:
                future.set_exception(error)
        return future


@pytest.mark.parametrize("count", [0, 1, 2, 5])
def test_shared_work_comes_back_in_order_whoever_did_it(count: int) -> None:
    crews = [Mortal({}) for _ in range(count)]
    got = crew.shared(lambda n: 12 // n, [3, 4, 1, 0, 2], crews)
    assert [next(got), next(got), next(got)] == [4, 3, 12]
    with pytest.raises(ZeroDivisionError):
        next(got)
    assert all(one.asked for one in crews)


def test_work_goes_on_only_as_it_is_asked_for() -> None:
    one = Mortal({})
    got = crew.shared(str, [5, 6, 7], [one])
    assert one.asked == []
    assert next(got) == "5"
    assert one.asked == [5]
    assert [*got] == ["6", "7"]


def test_who_dies_once_costs_an_item_and_who_dies_twice_ends_it() -> None:
    one = Mortal({6: 1, 8: 1})
    assert [*crew.shared(str, [5, 6, 7, 8], [one])] == ["5", "6", "7", "8"]
    assert one.asked == [5, 6, 6, 7, 8, 8]
    got = crew.shared(str, [5, 6, 7], [Mortal({6: 2})])
    assert next(got) == "5"
    with pytest.raises(InputError, match=r"^a worker died twice over the same work, perhaps for lack of memory; ask"):
        next(got)


def test_so_many_or_whoever_comes(pools: list[Pool]) -> None:
    for few in (0, 1):
        with crew.crew_of(few) as workers:
            assert [type(worker) for worker in workers] == [crew._Here]
    with crew.crew_of(2) as workers:
        assert len(workers) == len(pools) == 2
    mine = crew.here()
    assert crew.crew_of(mine) is mine
