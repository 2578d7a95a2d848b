"""The ten questions are answered as the rows are."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

import pyarrow.parquet as pq
import pytest
from tests.corpus_recordings import recording

from varishold.corpus import AskTouch, run_corpus
from varishold.recording import write

ROOT = Path(__file__).parents[1]
duckdb = pytest.importorskip("duckdb", reason="the example asks by DuckDB")
pytest.importorskip("polars", reason="the example asks by Polars")


def answers(*words: object) -> str:
    done = subprocess.run(
        [sys.executable, ROOT / "examples" / "ten_questions.py", *map(str, words)],
        env=os.environ | {"PYTHONIOENCODING": "utf-8"}, capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert done.stderr == ""
    return done.stdout


def test_ten_questions_are_asked_of_a_drawn_corpus() -> None:
    said = answers()
    assert re.findall(r"^(\d+)\. .*\?", said, re.MULTILINE) == [str(k) for k in range(1, 11)]
    assert re.match(r"\d+ contacts in 1280 frames of 4 recordings\n", said)
    for name in ("cylinder", "cone", "sphere", "pyramid"):
        assert re.search(rf"│ {name} +│ +\d+ │", said)


def test_they_are_asked_of_a_table_too(tmp_path: Path) -> None:
    write(recording(1), tmp_path / "a.npz")
    run_corpus([str(tmp_path / "a.npz")], AskTouch(), tmp_path / "names.parquet")
    said = answers(tmp_path / "names.parquet")
    names = pq.read_table(tmp_path / "names.parquet")["name"].to_pylist()
    for name in set(names):
        assert re.search(rf"│ {name} +│ +{names.count(name)} │", said)


def test_the_page_s_question_is_answered_as_it_stands(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    write(recording(1), tmp_path / "a.npz")
    run_corpus([str(tmp_path / "a.npz")], AskTouch(), tmp_path / "names.parquet")
    monkeypatch.chdir(tmp_path)
    page = (ROOT / "docs" / "corpora.md").read_text(encoding="utf-8")
    (question,) = re.findall(r"```sql\n(.*?)```", page, re.DOTALL)
    rows = duckdb.sql(question).fetchall()
    # Two presses were drawn, and each lasts ten frames of a fiftieth of a second at most.
    assert [round(begins, 1) for _, begins, *_ in rows] == [0.2, 0.6]
    assert all(0 < lasts < 0.2 for _, _, lasts, _ in rows)
    (asked,) = re.findall(r'duckdb\.sql\(\\"(.*)\\"\)', page)
    assert sum(n for _, n in duckdb.sql(asked).fetchall()) == pq.read_metadata(tmp_path / "names.parquet").num_rows
