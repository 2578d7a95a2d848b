"""Who does what next: every block is done once, a recording stays where it is open, and one that fails stops nobody."""

from __future__ import annotations

import random
from collections import Counter
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from varishold.corpus import AskTouch
from varishold.corpus.agenda import Agenda, Entry
from varishold.corpus.opened import Reading
from varishold.corpus.tasks import BlockTask, Job, Surveyed, SurveyTask

Task = SurveyTask | BlockTask


def agenda_of(folder: Path, n: int) -> tuple[Job, Agenda]:
    job = Job(AskTouch(), Reading(), str(folder), "program")
    return job, Agenda(job, [f"r{k}" for k in range(n)])


def surveyed(path: str, n_frames: int, n_blocks: int) -> Surveyed:
    return Surveyed(f"key-{path}", ((path, 1, 2),), n_frames, n_blocks)


@given(st.lists(st.integers(0, 5), min_size=1, max_size=5), st.integers(1, 4), st.integers(0, 10**6))
def test_every_block_is_done_once_and_all_frames_are_counted(
    tmp_path_factory: pytest.TempPathFactory, blocks: list[int], n_workers: int, seed: int
) -> None:
    rng = random.Random(seed)
    job, agenda = agenda_of(tmp_path_factory.mktemp("a"), len(blocks))
    n_blocks = {f"r{k}": n for k, n in enumerate(blocks)}
    open_at: dict[int, str] = {}
    running: dict[int, Task] = {}
    done: Counter[tuple[str, int]] = Counter()
    left = dict(n_blocks)
    seen: list[str] = []
    while True:
        for worker in range(n_workers):
            if worker in running:
                continue
            task = agenda.next_for(worker)
            if task is None:
                continue
            assert task.job is job
            mine = open_at.get(worker, "")
            waiting = {path: left[path] for path in seen if left[path] and path not in begun(running)}
            if isinstance(task, SurveyTask):
                # Who has blocks of an open recording goes on with these.
                assert not waiting.get(mine)
                seen.append(task.path)
            else:
                assert (task.key, task.stamp) == (f"key-{task.path}", ((task.path, 1, 2),))
                if waiting.get(mine):
                    assert task.path == mine
                else:
                    # Nothing is left to be looked through; who waits longest is helped.
                    assert len(seen) == len(blocks)
                    assert waiting[task.path] == max(waiting.values())
                left[task.path] -= 1
            open_at[worker] = task.path
            running[worker] = task
        if not running:
            break
        worker = rng.choice(sorted(running))
        task = running.pop(worker)
        if isinstance(task, SurveyTask):
            agenda.done(task, surveyed(task.path, 7 * n_blocks[task.path], n_blocks[task.path]))
        else:
            done[task.path, task.number] += 1
            agenda.done(task, 7)
    assert seen == list(n_blocks)
    assert done == Counter({(path, k): 1 for path, n in n_blocks.items() for k in range(n)})
    assert agenda.n_done == agenda.n_frames == 7 * sum(blocks)
    assert all(entry.answered for entry in agenda.entries)
    assert [entry.path for entry in agenda.entries] == list(n_blocks)
    assert agenda.next_for(0) is None


def begun(running: dict[int, Task]) -> set[str]:
    """Return the recordings that are being looked through."""
    return {task.path for task in running.values() if isinstance(task, SurveyTask)}


@pytest.mark.parametrize("there", [(), (0,), (1, 3), (0, 1, 2, 3)])
def test_blocks_that_are_there_are_not_begun_and_count_as_done(tmp_path: Path, there: tuple[int, ...]) -> None:
    job, agenda = agenda_of(tmp_path, 1)
    for number in there:
        job.part_path("key-r0", number).touch()
    task = agenda.next_for(0)
    assert isinstance(task, SurveyTask)
    entry = agenda.entries[0]
    assert not entry.answered
    agenda.done(task, surveyed("r0", 42, 4))
    assert (agenda.n_frames, agenda.n_done, entry.n_left) == (42, 42 * len(there) // 4, 4 - len(there))
    assert entry.answered == (len(there) == 4)
    given_out: list[int] = []
    while isinstance(block := agenda.next_for(0), BlockTask):
        assert not entry.answered
        given_out.append(block.number)
        agenda.done(block, 10)
    assert given_out == [k for k in range(4) if k not in there]
    assert entry.answered
    assert agenda.n_done == 42 * len(there) // 4 + 10 * len(given_out)


def test_a_recording_without_blocks_is_answered_at_once(tmp_path: Path) -> None:
    _, agenda = agenda_of(tmp_path, 1)
    agenda.done(SurveyTask(agenda._job, "r0"), surveyed("r0", 9, 0))
    assert agenda.entries[0].answered
    assert (agenda.n_frames, agenda.n_done) == (9, 0)


def test_parts_and_surveys_are_named_by_their_key(tmp_path: Path) -> None:
    job, _ = agenda_of(tmp_path, 1)
    assert job.survey_path("k") == tmp_path / "k.survey.npz"
    assert job.part_path("k", 0) == tmp_path / "k-000000.parquet"
    assert job.part_path("k", 1234567) == tmp_path / "k-1234567.parquet"


@pytest.mark.parametrize(
    ("reason", "told"),
    [("is odd", "r0: is odd"), ("r0: is odd", "r0: is odd"), ("r0 is odd", "r0 is odd"), ("", "r0: ")],
)
def test_a_failure_is_told_once_and_by_name(tmp_path: Path, reason: str, told: str) -> None:
    _, agenda = agenda_of(tmp_path, 2)
    first = agenda.next_for(0)
    assert first is not None
    agenda.done(first, surveyed("r0", 30, 3))
    block = agenda.next_for(0)
    assert block is not None
    assert agenda.failed(block, reason) == told
    assert agenda.failed(block, "again") == ""
    entry = agenda.entries[0]
    assert (entry.failure, list(entry.pending), entry.answered) == (told, [], False)
    # The worker goes on with the other.
    following = agenda.next_for(0)
    assert isinstance(following, SurveyTask)
    assert following.path == "r1"
    assert agenda.next_for(1) is None


def test_an_entry_is_answered_when_all_its_parts_are_there() -> None:
    seen = surveyed("a", 1, 1)
    assert Entry("a", seen, n_left=0).answered
    assert not Entry("a", seen, n_left=1).answered
    assert not Entry("a", None, n_left=0).answered
    assert not Entry("a", seen, n_left=0, failure="odd").answered


def test_a_task_whose_worker_was_lost_comes_first_and_once_more(tmp_path: Path) -> None:
    _, agenda = agenda_of(tmp_path, 3)
    one, two = agenda.next_for(0), agenda.next_for(1)
    assert one is not None
    assert two is not None
    assert agenda.lost(one)
    assert agenda.lost(two)
    # Before anything new, in the order in which they were lost, to whoever asks.
    assert agenda.next_for(1) is one
    assert agenda.next_for(0) is two
    assert not agenda.lost(one)
    assert not agenda.lost(two)
    third = agenda.next_for(0)
    assert third is not None
    assert third.path == "r2"
    assert agenda.lost(third)
