"""A run says what it did: frames, ticks, failures in their words; and clears away what it left, and nothing else."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import pytest
from tests.corpus_recordings import recording

from varishold.corpus import AskTouch, run_corpus, survey
from varishold.corpus import run as running
from varishold.corpus.tasks import do
from varishold.errors import InputError, VarisholdError
from varishold.recording import write


def test_a_run_says_what_it_did(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(survey, "_FRAMES", 16)
    for seed in (1, 2):
        write(recording(seed, 40), tmp_path / f"{seed}.npz")
    files = [str(tmp_path / f"{seed}.npz") for seed in (1, 2, 1)]
    ticks: list[tuple[int, int]] = []
    found = run_corpus(
        files, AskTouch(), tmp_path / "t.parquet", tick=lambda completed, total: ticks.append((completed, total))
    )
    # A recording that is named twice is answered once.
    assert (found.n_frames, list(found.health), found.failures, found.folder) == (80, files[:2], {}, None)
    assert ticks == [(0, 40), (16, 40), (32, 40), (40, 40), (40, 80), (56, 80), (72, 80), (80, 80)]
    assert sorted(os.listdir(tmp_path)) == ["1.npz", "2.npz", "t.parquet"]


@pytest.mark.parametrize(
    ("error", "told"),
    [
        (InputError("odd", parameter="shape"), "explained odd"),
        (VarisholdError("odd"), "odd"),
        (MemoryError(), "not enough memory: ask for fewer workers"),
        (MemoryError("64 GB"), "not enough memory: 64 GB"),
        (ValueError("odd"), "ValueError: odd; this is a fault of the program: please tell it"),
    ],
)
def test_each_kind_of_failure_is_told_in_its_words(tmp_path: Path, error: Exception, told: str) -> None:
    for seed in (1, 2):
        write(recording(seed), tmp_path / f"{seed}.npz")
    one, two = (str(tmp_path / f"{seed}.npz") for seed in (1, 2))

    def work(task: Any) -> Any:
        if task.path == one:
            raise error
        return do(task)

    lines: list[str] = []
    how: dict[str, Any] = {"work": work, "tell": lines.append, "explain": lambda found: f"explained {found}"}
    found = run_corpus([one, two], AskTouch(), tmp_path / "t.parquet", **how)
    assert lines == [f"{one}: {told}"] == list(found.failures.values())
    # The others' parts wait there.
    assert found.folder == tmp_path / ".t.parquet.parts"
    assert found.n_frames == 40
    # One alone is told by the error that ends the run.
    lines.clear()
    with pytest.raises(InputError) as caught:
        run_corpus([one], AskTouch(), tmp_path / "u.parquet", **how)
    assert (str(caught.value), lines) == (f"{one}: {told}", [])


def test_only_what_a_run_leaves_is_cleared(tmp_path: Path) -> None:
    key = "0123456789abcdef" * 2
    ours = [f"{key}.survey.npz", f"{key}-000000.parquet", f"{key}-1234567.parquet"]
    others = [
        f"{key[1:]}.survey.npz",
        f"{key}-00000.parquet",
        f"{key}.npz",
        f"x{key}.survey.npz",
        f"{key}-000000.parquet~",
    ]
    for name in (*ours, *others):
        (tmp_path / name).touch()
    running._clear(tmp_path)
    assert sorted(os.listdir(tmp_path)) == sorted(others)


def test_where_the_parts_cannot_stand_it_is_told(tmp_path: Path) -> None:
    (tmp_path / ".t.parquet.parts").write_text("mine")
    with pytest.raises(InputError, match=r"\.t\.parquet\.parts: cannot be made a folder: file exists"):
        run_corpus(["a.npz"], AskTouch(), tmp_path / "t.parquet")
    assert (tmp_path / ".t.parquet.parts").read_text() == "mine"
