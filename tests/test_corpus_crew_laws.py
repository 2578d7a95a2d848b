"""Those who work: how they are begun and ended, and what is different in the world while they start."""

from __future__ import annotations

import logging
import os
import signal
import warnings
from concurrent.futures import BrokenExecutor, Future
from contextlib import ExitStack
from types import SimpleNamespace
from typing import Any, ClassVar

import pytest

from varishold.corpus import cluster as room
from varishold.corpus import crew
from varishold.errors import InputError

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
        with crew._single_threaded():
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


# A cluster


def test_loggers_are_silent_meanwhile_and_as_they_were_afterwards() -> None:
    names = {"distributed.nanny": logging.INFO, "tornado": logging.DEBUG, "distributedly": logging.WARNING}
    before = {name: logging.getLogger(name).level for name in names}

    def look() -> None:
        with room._silent():
            for name in ("distributed.nanny", "tornado"):
                assert not logging.getLogger(name).isEnabledFor(logging.CRITICAL)
            assert logging.getLogger("distributedly").isEnabledFor(logging.WARNING)
            # In a test it would be an error.
            warnings.warn("old", stacklevel=1)
            raise ZeroDivisionError

    try:
        for name, level in names.items():
            logging.getLogger(name).setLevel(level)
        with pytest.raises(ZeroDivisionError):
            look()
        assert {name: logging.getLogger(name).level for name in names} == names
    finally:
        for name, level in before.items():
            logging.getLogger(name).setLevel(level)


def test_a_worker_has_a_seat_a_thread_and_all_are_in_order() -> None:
    client = SimpleNamespace(nthreads=lambda: {"tcp://b": 2, "tcp://a": 1, "tcp://c": 0})
    assert room._seats(client) == ["tcp://a", "tcp://b", "tcp://b"]


def test_a_seat_is_a_worker_s_own_until_that_is_lost() -> None:
    pytest.importorskip("distributed", reason="takes the extra cluster")
    asked: list[Any] = []

    class Executor:
        def submit(self, work: Any, task: Any) -> Future[Any]:
            future: Future[Any] = Future()
            future.set_result(work(task))
            return future

    def executor(**how: Any) -> Executor:
        asked.append(how)
        return Executor()

    seat = room._Seat(SimpleNamespace(get_executor=executor), "tcp://s", "tcp://a")
    # The same task may be asked twice: it is done twice.
    assert asked == [{"workers": ["tcp://a"], "allow_other_workers": True, "pure": False}]
    assert seat.submit(str, 4).result() == "4"


@pytest.mark.parametrize(
    ("answers", "told"),
    [
        ({"tcp://a": "same"}, ""),
        ({}, ""),
        ({"tcp://a": "same", "tcp://b": "other"}, "tcp://s: its worker tcp://b has another version of varishold"),
        ({"tcp://a": ImportError("none")}, "tcp://s: its worker tcp://a cannot run varishold: none; install it there"),
    ],
)
def test_workers_are_asked_for_their_program_first(
    answers: dict[str, Any], told: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked: list[Any] = []

    def ask(what: Any, **how: Any) -> dict[str, Any]:
        asked.append((what, how))
        return answers

    def digest() -> str:
        return "same"

    monkeypatch.setattr(room, "program_digest", digest)
    client = SimpleNamespace(run=ask)
    if told:
        with pytest.raises(InputError) as caught:
            room._check_programs("tcp://s", client)
        assert str(caught.value).startswith(told)
    else:
        room._check_programs("tcp://s", client)
    assert asked == [(digest, {"on_error": "return"})]


def test_a_cluster_of_this_machine_is_small_quiet_and_gone_afterwards(monkeypatch: pytest.MonkeyPatch) -> None:
    dask = pytest.importorskip("dask", reason="takes the extra cluster")
    distributed = pytest.importorskip("distributed", reason="takes the extra cluster")
    said: dict[str, Any] = {}

    class Local:
        def __init__(self, **how: Any) -> None:
            assert os.path.isdir(how["local_directory"])
            said.update(how, quiet={name: dask.config.get(name) for name in room._QUIET})

        def __enter__(self) -> str:
            return "made"

        def __exit__(self, *_: object) -> None:
            said["ended"] = os.path.isdir(said["local_directory"])

    monkeypatch.setattr(distributed, "LocalCluster", Local)
    with ExitStack() as stack:
        assert room._local(stack, 3) == "made"
        assert "ended" not in said
    assert said["ended"]
    assert not os.path.exists(said["local_directory"])
    assert (said["n_workers"], said["threads_per_worker"], said["memory_limit"], said["dashboard_address"]) == (
        3, 1, None, None,
    )  # fmt: skip
    assert said["silence_logs"] == logging.CRITICAL
    # Nothing looks at the workers while they work.
    assert [value for name, value in said["quiet"].items() if name.endswith("enabled")] == [False, False]


@pytest.mark.parametrize(("number", "made"), [(None, 5), (3, 3), (1, 1)])
def test_a_cluster_of_this_machine_has_a_worker_a_processor_unless_it_is_told(
    number: int | None, made: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    distributed = pytest.importorskip("distributed", reason="takes the extra cluster")
    asked: list[Any] = []

    class Client:
        def __init__(self, known: Any, **how: Any) -> None:
            asked.append((known, how))

        def __enter__(self) -> Client:
            return self

        def __exit__(self, *_: object) -> None:
            asked.append("closed")

        def wait_for_workers(self, *what: Any, **how: Any) -> None:
            asked.append((what, how))

        def run(self, what: Any, **how: Any) -> dict[str, Any]:
            return {"tcp://a": what()}

        def nthreads(self) -> dict[str, int]:
            return {"tcp://a": 2}

        def get_executor(self, **how: Any) -> None:
            return None

    monkeypatch.setattr(distributed, "Client", Client)
    monkeypatch.setattr(room, "processors", lambda: 5)
    monkeypatch.setattr(room, "_local", lambda stack, count: f"{count} workers")
    patience = room._PATIENCE_S
    for address, known in ((room.LOCAL, f"{made} workers"), ("tcp://b:1", "tcp://b:1")):
        asked.clear()
        with room.cluster(address, number=number) as seats:
            assert len(seats) == 2
            # It is not the one that a user's own calls of dask would go to.
            assert asked == [
                (known, {"timeout": patience, "set_as_default": False}), ((1,), {"timeout": patience}),
            ]  # fmt: skip
        assert asked[-1] == "closed"
    assert 5 <= patience <= 60
