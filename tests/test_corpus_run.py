"""A run over a corpus: what fails is told and stops nobody, what was done is not done again, the bytes are the same."""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import BrokenExecutor, Future
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow.parquet as pq
import pytest
from tests.corpus_recordings import recording

from varishold.corpus import AskTouch, run_corpus, survey, tasks
from varishold.corpus.opened import Reading
from varishold.errors import InputError
from varishold.files.crew import Worker
from varishold.recording import write

N_FILES, CUT = 3, 15
BLOCKS = N_FILES * 3


@pytest.fixture
def corpus(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """Three recordings of three blocks."""
    monkeypatch.setattr(survey, "_FRAMES", CUT)
    for seed in range(N_FILES):
        write(recording(seed), tmp_path / f"r{seed}.npz")
    return [str(tmp_path / f"r{seed}.npz") for seed in range(N_FILES)]


@pytest.fixture
def expected(corpus: list[str], tmp_path: Path) -> bytes:
    run_corpus(corpus, AskTouch(), tmp_path / "expected.parquet")
    return (tmp_path / "expected.parquet").read_bytes()


class Work:
    """Work that counts its tasks, and fails at one of them."""

    def __init__(self, fails: int = -1, how: BaseException | None = None) -> None:
        self.blocks = self.surveys = 0
        self._fails, self._how = fails, how or KeyboardInterrupt()

    def __call__(self, task: Any) -> Any:
        if self.blocks + self.surveys == self._fails:
            self._fails = -1
            raise self._how
        found = tasks.do(task)
        self.blocks += isinstance(task, tasks.BlockTask)
        self.surveys += isinstance(task, tasks.SurveyTask)
        return found


def parts(folder: Path) -> list[str]:
    return sorted(path.name for each in folder.glob(".*.parts") for path in each.iterdir())


@pytest.mark.parametrize("stopped_at", [0, 1, 5, 11])
def test_a_run_that_was_stopped_is_taken_up_where_it_ended(
    corpus: list[str], expected: bytes, tmp_path: Path, stopped_at: int
) -> None:
    first, second = Work(stopped_at), Work()
    with pytest.raises(KeyboardInterrupt):
        run_corpus(corpus, AskTouch(), tmp_path / "names.parquet", work=first)
    # Neither the table nor a part of it.
    assert not list(tmp_path.glob("*names*.parquet"))
    assert not list(tmp_path.glob(".varishold-*"))
    assert len([name for name in parts(tmp_path) if name.endswith("parquet")]) == first.blocks
    run_corpus(corpus, AskTouch(), tmp_path / "names.parquet", work=second)
    assert first.blocks + second.blocks == BLOCKS
    assert (tmp_path / "names.parquet").read_bytes() == expected
    assert parts(tmp_path) == []


def test_a_table_that_was_there_stays_until_the_next_is_whole(
    corpus: list[str], expected: bytes, tmp_path: Path
) -> None:
    run_corpus(corpus[:1], AskTouch(), tmp_path / "names.parquet")
    before = (tmp_path / "names.parquet").read_bytes()
    with pytest.raises(KeyboardInterrupt):
        run_corpus(corpus, AskTouch(), tmp_path / "names.parquet", work=Work(9))
    assert (tmp_path / "names.parquet").read_bytes() == before
    run_corpus(corpus, AskTouch(), tmp_path / "names.parquet")
    assert (tmp_path / "names.parquet").read_bytes() == expected


def test_parts_that_are_kept_answer_for_a_larger_corpus(corpus: list[str], expected: bytes, tmp_path: Path) -> None:
    found = run_corpus(corpus[:2], AskTouch(), tmp_path / "names.parquet", keep_parts=True)
    assert found.folder is not None
    assert len(list(found.folder.iterdir())) == 2 + 6
    more = Work()
    run_corpus(corpus, AskTouch(), tmp_path / "names.parquet", keep_parts=True, work=more)
    assert more.blocks == 3
    assert (tmp_path / "names.parquet").read_bytes() == expected


def test_a_recording_by_another_name_is_known_by_its_content(
    corpus: list[str], tmp_path: Path, expected: bytes
) -> None:
    run_corpus(corpus, AskTouch(), tmp_path / "names.parquet", keep_parts=True)
    moved = tmp_path / "moved.npz"
    moved.write_bytes(Path(corpus[1]).read_bytes())
    work = Work()
    run_corpus([corpus[1], str(moved)], AskTouch(), tmp_path / "names.parquet", work=work, keep_parts=True)
    assert work.blocks == 0
    files = pq.read_table(tmp_path / "names.parquet")["file"].to_pylist()
    assert list(dict.fromkeys(files)) == [corpus[1], str(moved)]
    assert files.count(corpus[1]) == files.count(str(moved)) > 0


@pytest.mark.parametrize("change", ["levels", "content", "pitch"])
def test_what_was_asked_otherwise_is_answered_anew(corpus: list[str], tmp_path: Path, change: str) -> None:
    run_corpus(corpus[:1], AskTouch(), tmp_path / "names.parquet", keep_parts=True)
    if change == "content":
        write(recording(5), corpus[0])
    work = Work()
    ask, reading = (
        AskTouch(levels=16 if change == "levels" else 32),
        Reading(pitch_m=0.1 if change == "pitch" else None),
    )
    run_corpus(corpus[:1], ask, tmp_path / "names.parquet", reading=reading, keep_parts=True, work=work)
    assert work.blocks == 3


def test_a_bad_recording_is_told_and_the_others_are_answered(
    corpus: list[str], expected: bytes, tmp_path: Path
) -> None:
    cut = tmp_path / "cut.npz"
    cut.write_bytes(Path(corpus[0]).read_bytes()[:-200])
    told: list[str] = []
    files = [corpus[0], str(cut), str(tmp_path / "none.npz"), *corpus[1:]]
    found = run_corpus(files, AskTouch(), tmp_path / "names.parquet", tell=told.append)
    assert (tmp_path / "names.parquet").read_bytes() == expected
    assert list(found.failures) == [str(cut), str(tmp_path / "none.npz")]
    assert told == list(found.failures.values())
    assert "cut.npz: is damaged or cut off" in told[0]
    assert told[1].endswith("none.npz: there is no such file")
    assert list(found.health) == corpus
    # Mended, it is added to what was found.
    cut.write_bytes(Path(corpus[2]).read_bytes())
    work = Work()
    run_corpus([*corpus, str(cut)], AskTouch(), tmp_path / "names.parquet", work=work)
    assert work.blocks == 0
    assert parts(tmp_path) == []


def test_where_none_can_be_answered_there_is_no_table(corpus: list[str], tmp_path: Path) -> None:
    (tmp_path / "bad.npz").write_bytes(b"PK none")
    with pytest.raises(InputError, match=r"bad\.npz: "):
        run_corpus([str(tmp_path / "bad.npz")], AskTouch(), tmp_path / "names.parquet")
    with pytest.raises(InputError, match="no recording could be answered"):
        run_corpus([str(tmp_path / "bad.npz"), str(tmp_path / "no")], AskTouch(), tmp_path / "names.parquet")
    assert not (tmp_path / "names.parquet").exists()


def test_a_fault_of_ours_with_one_recording_is_told_as_one(corpus: list[str], tmp_path: Path) -> None:
    told: list[str] = []
    found = run_corpus(
        corpus, AskTouch(), tmp_path / "names.parquet", work=Work(0, ZeroDivisionError("by 0")), tell=told.append
    )
    assert told == [f"{corpus[0]}: ZeroDivisionError: by 0; this is a fault of the program: please tell it"]
    assert list(found.health) == corpus[1:]


def test_a_recording_that_changes_meanwhile_is_not_answered_half(corpus: list[str], tmp_path: Path) -> None:
    def work(task: Any) -> Any:
        if isinstance(task, tasks.BlockTask) and task.number == 1 and task.path == corpus[0]:
            write(recording(8), corpus[0])
        return tasks.do(task)

    found = run_corpus(corpus, AskTouch(), tmp_path / "names.parquet", work=work)
    assert list(found.failures.values()) == [f"{corpus[0]}: was changed while it was being read; run again"]


def test_a_damaged_part_is_told_and_made_anew(corpus: list[str], expected: bytes, tmp_path: Path) -> None:
    found = run_corpus(corpus, AskTouch(), tmp_path / "names.parquet", keep_parts=True)
    assert found.folder is not None
    part = max(found.folder.glob("*.parquet"), key=lambda path: path.stat().st_size)
    content = bytearray(part.read_bytes())
    content[len(content) // 3] ^= 0xFF
    part.write_bytes(content)
    (tmp_path / "names.parquet").unlink()
    with pytest.raises(InputError, match=f"{part.name}: is damaged .* run again"):
        run_corpus(corpus, AskTouch(), tmp_path / "names.parquet")
    assert not (tmp_path / "names.parquet").exists()
    work = Work()
    run_corpus(corpus, AskTouch(), tmp_path / "names.parquet", work=work)
    assert work.blocks == 1
    assert (tmp_path / "names.parquet").read_bytes() == expected


def test_a_damaged_survey_is_made_anew(corpus: list[str], expected: bytes, tmp_path: Path) -> None:
    found = run_corpus(corpus, AskTouch(), tmp_path / "names.parquet", keep_parts=True)
    assert found.folder is not None
    for path in found.folder.glob("*.npz"):
        path.write_bytes(path.read_bytes()[:-30])
    run_corpus(corpus, AskTouch(), tmp_path / "names.parquet")
    assert (tmp_path / "names.parquet").read_bytes() == expected


def test_what_is_not_ours_stays_in_the_folder(corpus: list[str], tmp_path: Path) -> None:
    folder = tmp_path / ".names.parquet.parts"
    folder.mkdir()
    (folder / "notes.txt").write_text("mine")
    run_corpus(corpus, AskTouch(), tmp_path / "names.parquet")
    assert parts(tmp_path) == ["notes.txt"]


class Mortal:
    """A worker that dies at its first task, or at every task of a recording."""

    def __init__(self, always: str = "") -> None:
        self._always, self._died = always, False

    def submit(self, work: Callable[[Any], Any], task: Any) -> Future[Any]:
        future: Future[Any] = Future()
        if not self._died or (self._always and task.path == self._always):
            self._died = True
            future.set_exception(BrokenExecutor("gone"))
        else:
            future.set_result(work(task))
        return future


@contextmanager
def crew_of(*workers: Worker) -> Iterator[Sequence[Worker]]:
    yield workers


def test_a_lost_worker_costs_its_task(corpus: list[str], expected: bytes, tmp_path: Path) -> None:
    work = Work()
    run_corpus(corpus, AskTouch(), tmp_path / "names.parquet", workers=crew_of(Mortal(), Mortal()), work=work)
    assert (work.surveys, work.blocks) == (N_FILES, BLOCKS)
    assert (tmp_path / "names.parquet").read_bytes() == expected


def test_what_kills_every_worker_is_given_up(corpus: list[str], tmp_path: Path) -> None:
    found = run_corpus(corpus, AskTouch(), tmp_path / "names.parquet", workers=crew_of(Mortal(corpus[1])))
    assert found.failures == {corpus[1]: f"{corpus[1]}: a worker died twice over it, perhaps for lack of memory; ask for fewer workers"}  # fmt: skip  # noqa: E501
    assert list(found.health) == [corpus[0], corpus[2]]


def die_once(task: Any) -> Any:
    """End this process as `kill -9` would, once, amid a block."""
    mark = Path(task.job.folder).with_name("died")
    if isinstance(task, tasks.BlockTask) and not mark.exists():
        mark.touch()
        os.kill(os.getpid(), 9)
    return tasks.do(task)


def test_processes_give_the_same_bytes_also_where_one_is_killed(
    tmp_path: Path, corpus: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.undo()
    run_corpus(corpus, AskTouch(), tmp_path / "one.parquet")
    run_corpus(corpus, AskTouch(), tmp_path / "two.parquet", workers=2, work=die_once)
    assert (tmp_path / "died").exists()
    assert (tmp_path / "one.parquet").read_bytes() == (tmp_path / "two.parquet").read_bytes()


def test_another_run_over_the_same_table_is_refused(corpus: list[str], tmp_path: Path) -> None:
    def work(task: Any) -> Any:
        with pytest.raises(InputError, match="another process is writing this file"):
            run_corpus(corpus, AskTouch(), tmp_path / "names.parquet")
        return tasks.do(task)

    run_corpus(corpus[:1], AskTouch(), tmp_path / "names.parquet", work=work)


# The command


def test_the_command_writes_a_table_and_says_so(corpus: list[str], run: Callable[..., Any], tmp_path: Path) -> None:
    assert run("touch", "r?.npz", "-o", "names.parquet", "--workers", 1)[0::2] == (0, "")
    assert run("touch", "r?.npz", "--frames", "peak", "-o", "names.parquet", "--workers", 1, "--json") == (
        0,
        '{"output": "names.parquet", "rows": 3, "frames": 120, "recordings": 3, "failures": {}, "parts": null}\n',
        "",
    )
    (tmp_path / "bad.npz").write_bytes(b"PK none")
    status, out, err = run("touch", ".", "-o", "n.parquet", "--workers", 1, "--frames", "peak", "--json")
    told = json.loads(out)
    assert (status, told["recordings"], list(told["failures"])) == (1, 3, ["bad.npz"])
    # The table of before is no recording.
    assert [line.split(": ")[1] for line in err.splitlines()] == ["note", "bad.npz"]


def test_a_table_among_the_recordings_of_a_folder_is_made_anew(corpus: list[str], run: Callable[..., Any]) -> None:
    asked = ("touch", ".", "-o", "names.parquet", "--workers", 1, "--frames", "peak")
    for more in ((), ("--keep-parts",), ("--report", "page.html"), ("--report", "page.html")):
        status, out, _ = run(*asked, *more)
        assert (status, "3 contacts in 120 frames of 3 recordings" in out) == (0, True)
    # What is a recording is read, by whatever name of the folder.
    assert "is read by this very call" in run("touch", ".", "-o", "r0.npz", "--force")[2]


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (("r0.npz", "--workers", 2), "--workers is for tables: name one with -o, or leave it out"),
        (("r0.npz", "--keep-parts"), "--keep-parts is for tables: name one with -o, or leave it out"),
        (("r0.npz", "-o", "a.parquet", "--workers", 2, "--cluster", "a:1"), "--cluster has its own: leave one out"),
        (("-", "-o", "a.parquet"), "-: standard input cannot be shared among workers; save it to a file"),
        (("r0.npz", "-o", "r0.npz"), "r0.npz: is read by this very call; name another file to write to"),
        (("r0.npz", "-o", "note.txt"), "note.txt: is there, and is no table of this program"),
        (("r0.npz", "-o", "no/a.parquet"), "no/a.parquet: cannot write here: there is no folder"),
    ],
)
def test_what_the_command_cannot_do_is_told_in_one_line(
    corpus: list[str], run: Callable[..., Any], tmp_path: Path, words: tuple[object, ...], told: str
) -> None:
    (tmp_path / "note.txt").write_text("mine")
    status, out, err = run("touch", *words)
    assert (status, out, err.count("\n")) == (1, "", 1)
    assert told in err
    assert np.isin(os.listdir(tmp_path), ["note.txt", *map(os.path.basename, corpus)]).all()


def test_a_full_disk_ends_the_run_and_what_is_there_is_kept(
    corpus: list[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def full(*_: Any) -> None:
        raise InputError("part: cannot write here: no space left on device")

    kept = Work(5)
    with pytest.raises(KeyboardInterrupt):
        run_corpus(corpus, AskTouch(), tmp_path / "names.parquet", work=kept)
    with monkeypatch.context() as patch:
        patch.setattr(tasks, "write_part", full)
        with pytest.raises(InputError, match="no space left on device"):
            run_corpus(corpus, AskTouch(), tmp_path / "names.parquet")
    work = Work()
    run_corpus(corpus, AskTouch(), tmp_path / "names.parquet", work=work)
    assert kept.blocks + work.blocks == BLOCKS


def test_a_file_of_several_names_stands_in_a_table_once(corpus: list[str], expected: bytes, tmp_path: Path) -> None:
    (tmp_path / "other").mkdir()
    (tmp_path / "other" / "link.npz").symlink_to(corpus[1])
    os.link(corpus[2], tmp_path / "hard.npz")
    names = [
        *corpus[:2],
        str(tmp_path / "other" / "link.npz"),
        str(tmp_path / "other" / ".." / Path(corpus[0]).name),
        corpus[2],
        str(tmp_path / "hard.npz"),
    ]
    found = run_corpus(names, AskTouch(), tmp_path / "names.parquet")
    assert list(found.health) == corpus
    assert (tmp_path / "names.parquet").read_bytes() == expected
