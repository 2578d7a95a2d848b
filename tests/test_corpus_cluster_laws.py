"""A cluster: how it is begun and ended, what its workers are asked first, and what is silent meanwhile."""

from __future__ import annotations

import logging
import os
import warnings
from concurrent.futures import Future
from contextlib import ExitStack
from types import SimpleNamespace
from typing import Any

import pytest

from varishold.corpus import cluster as room
from varishold.errors import InputError


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


def test_a_client_that_fails_is_closed_at_once() -> None:
    told: list[Any] = []

    class Client:
        def __init__(self, known: str, **how: Any) -> None:
            told.append((known, how))
            if known != "there":
                raise OSError("nobody answers")

        def close(self) -> None:
            told.append("closed")

    assert isinstance(room._begun(Client, "there"), Client)
    how = {"timeout": room._PATIENCE_S, "set_as_default": False}
    assert told == [("there", how)]
    with pytest.raises(OSError, match="nobody answers"):
        room._begun(Client, "gone")
    assert told == [("there", how), ("gone", how), "closed"]


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
