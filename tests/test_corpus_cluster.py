"""A corpus on a cluster of dask: the same bytes, and what is wrong with it is told in one line."""

from __future__ import annotations

import os
import sys
import threading
from collections.abc import Callable
from concurrent.futures import BrokenExecutor, CancelledError, Future
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from tests.corpus_recordings import recording

from varishold.corpus import AskTouch, run_corpus, tasks
from varishold.corpus import cluster as room
from varishold.corpus.cluster import cluster
from varishold.corpus.content import program_digest
from varishold.corpus.opened import Reading
from varishold.corpus.tasks import BlockTask, CannotKeep, Job, SurveyTask, do_elsewhere
from varishold.errors import InputError, MissingExtraError
from varishold.recording import write

distributed = pytest.importorskip("distributed", reason="takes the extra cluster")
# What it closes late, and its own use of what is old, is not ours.
pytestmark = [pytest.mark.filterwarnings("ignore::ResourceWarning"), pytest.mark.filterwarnings("ignore::UserWarning")]


@pytest.fixture
def corpus(tmp_path: Path) -> list[str]:
    for seed in range(3):
        write(recording(seed), tmp_path / f"r{seed}.npz")
    return [str(tmp_path / f"r{seed}.npz") for seed in range(3)]


@pytest.fixture
def expected(corpus: list[str], tmp_path: Path) -> bytes:
    run_corpus(corpus, AskTouch(), tmp_path / "expected.parquet")
    return (tmp_path / "expected.parquet").read_bytes()


def test_a_cluster_that_is_there_gives_the_same_bytes(corpus: list[str], expected: bytes, tmp_path: Path) -> None:
    with distributed.LocalCluster(
        n_workers=2, threads_per_worker=2, processes=False, dashboard_address=None, protocol="tcp"
    ) as made:
        found = cluster(made.scheduler_address)
        run_corpus(corpus, AskTouch(), tmp_path / "names.parquet", workers=found, work=do_elsewhere)
        assert (tmp_path / "names.parquet").read_bytes() == expected
        with cluster(made.scheduler_address) as workers:
            assert len(workers) == 4


def die_once(task: Any) -> Any:
    mark = Path(task.job.folder).with_name("died")
    if isinstance(task, BlockTask) and not mark.exists():
        mark.touch()
        os.kill(os.getpid(), 9)
    return tasks.do_elsewhere(task)


def test_a_killed_worker_costs_its_block(corpus: list[str], expected: bytes, tmp_path: Path) -> None:
    found = cluster(room.LOCAL, number=2)
    run_corpus(corpus, AskTouch(), tmp_path / "names.parquet", workers=found, work=die_once)
    assert (tmp_path / "died").exists()
    assert (tmp_path / "names.parquet").read_bytes() == expected


@pytest.mark.parametrize("address", ["tcp://127.0.0.1:1", "nonsense", "tcp://", "carrier-pigeon://roof:1", ""])
def test_where_no_cluster_answers_it_is_told(
    corpus: list[str], tmp_path: Path, address: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(room, "_PATIENCE_S", 1)
    with pytest.raises(InputError, match=r"no cluster answers there: .*; name a scheduler's address") as caught:
        run_corpus(corpus, AskTouch(), tmp_path / "names.parquet", workers=cluster(address), work=do_elsewhere)
    assert str(caught.value).startswith(f"{address}: ")
    assert sorted(os.listdir(tmp_path)) == ["r0.npz", "r1.npz", "r2.npz"]


def test_workers_of_another_version_are_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    with distributed.LocalCluster(n_workers=1, processes=False, dashboard_address=None, protocol="tcp") as made:
        # Something that is another there.
        monkeypatch.setattr(room, "program_digest", threading.get_ident)
        with (
            pytest.raises(InputError, match="has another version of varishold; install the same there"),
            cluster(made.scheduler_address),
        ):
            pytest.fail("it was taken")


def test_a_worker_says_what_it_lacks(tmp_path: Path) -> None:
    job = Job(AskTouch(), Reading(), str(tmp_path / "none"), program_digest())
    with pytest.raises(CannotKeep, match=r"none: a worker on .* does not see this folder; name one that all share"):
        do_elsewhere(SurveyTask(job, "a.npz"))
    with pytest.raises(CannotKeep, match="runs another version of varishold; install the same there"):
        do_elsewhere(SurveyTask(Job(AskTouch(), Reading(), str(tmp_path), "other"), "a.npz"))


def test_without_the_extra_the_command_that_adds_it_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(MissingExtraError, match=r"pip install -e '\.\[cluster\]'"), cluster("local"):
        pytest.fail("it was not missed")


def raises(error: BaseException) -> Callable[[Future[Any]], None]:
    return lambda future: future.set_exception(error)


@pytest.mark.parametrize(
    ("ends", "as_what"),
    [
        (raises(distributed.KilledWorker("task", SimpleNamespace(address="tcp://a:2"), 3)), BrokenExecutor),
        (raises(CancelledError()), CannotKeep),
        (raises(OSError("gone")), CannotKeep),
        (raises(InputError("a.npz: is odd")), InputError),
        (raises(ZeroDivisionError()), ZeroDivisionError),
        (lambda future: (future.cancel(), future.set_running_or_notify_cancel()), CannotKeep),
    ],
)
def test_what_became_of_a_task_is_told_as_by_all_workers(ends: Callable[[Any], None], as_what: type) -> None:
    told, done = Future[int](), Future[int]()
    ends(done)
    room._pass_on(told, "tcp://a:1", done)
    assert type(told.exception()) is as_what


def test_what_a_task_gave_is_passed_on() -> None:
    told, done = Future[int](), Future[int]()
    done.set_result(7)
    room._pass_on(told, "tcp://a:1", done)
    assert told.result() == 7
