"""Tables of many recordings: a command asks for what its options say, and tells what it got."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import click
import numpy as np
import pytest
from tests.commands_said import said

from varishold.cli import corpus as command
from varishold.cli.app import app
from varishold.cli.options import refuse_alone
from varishold.corpus import AskMeasure, AskTouch, Outcome
from varishold.corpus.opened import Reading
from varishold.corpus.tasks import do_elsewhere
from varishold.errors import InputError
from varishold.skin import Skin

# Tables


@pytest.fixture
def asked(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> dict[str, Any]:
    """Note how a table is asked for, and answer with what the test says."""
    noted: dict[str, Any] = {"outcome": Outcome(7, 40, {"a.npz": {}}, {}, None)}

    def run_corpus(files: Any, ask: Any, output: Any, **how: Any) -> Outcome:
        noted.update(how, files=files, ask=ask, output=output)
        how["tick"](completed=1, total=2)
        return noted["outcome"]  # type: ignore[no-any-return]

    monkeypatch.chdir(tmp_path)
    for name in ("a.npz", "b.npz"):
        Path(name).touch()
    monkeypatch.setattr("varishold.corpus.run.run_corpus", run_corpus)
    monkeypatch.setattr("varishold.files.crew.processors", lambda: 5)
    monkeypatch.setattr("varishold.corpus.cluster.cluster", lambda address, *, number: (address, number))
    return noted


def test_measures_are_asked_for_as_the_options_say(asked: dict[str, Any]) -> None:
    assert said("measure", "a.npz", "-o", "t.parquet") == "t.parquet: 7 contacts in 40 frames of 1 recording\n"
    assert (asked["files"], asked["ask"], asked["output"]) == (["a.npz"], AskMeasure(32, None), Path("t.parquet"))
    assert (asked["reading"], asked["workers"], asked["keep_parts"]) == (Reading(None, None, None), 5, False)
    assert "work" not in asked
    words = ("--levels", 9, "--floor", 2.5, "--sensor", "mat", "--pitch-m", 0.002, "--shape", "4x5", "--workers", 3)
    said("measure", "a.npz", "b.npz", "-o", "t.parquet", *words, "--keep-parts")
    assert (asked["files"], asked["ask"]) == (["a.npz", "b.npz"], AskMeasure(9, 2.5))
    assert (asked["reading"], asked["workers"], asked["keep_parts"]) == (Reading("mat", (4, 5), 0.002), 3, True)


def test_names_are_asked_for_as_the_options_say(asked: dict[str, Any]) -> None:
    said("touch", "a.npz", "-o", "t.parquet")
    assert asked["ask"] == AskTouch("all", 32, None, False)
    Path("skin.toml").write_text('[skin]\nkind = "half-space"\n')
    words = ("--frames", "press", "--levels", 9, "--skin", "skin.toml", "--exact", "--shape", "4x5", "--pitch-m", 0.5)
    said("touch", "a.npz", "-o", "t.parquet", *words, "--sensor", "mat")
    assert asked["ask"] == AskTouch("press", 9, Skin("half-space"), True)
    assert asked["reading"] == Reading("mat", (4, 5), 0.5)


@pytest.mark.parametrize(
    ("words", "crew"),
    [
        (("--cluster", "tcp://a:1"), ("tcp://a:1", None)),
        (("--cluster", "local"), ("local", None)),
        (("--cluster", "local", "--workers", 3), ("local", 3)),
    ],
)
def test_a_cluster_works_instead(asked: dict[str, Any], words: tuple[object, ...], crew: object) -> None:
    said("measure", "a.npz", "-o", "t.parquet", *words)
    assert (asked["workers"], asked["work"]) == (crew, do_elsewhere)


def test_what_cannot_be_shared_is_refused(asked: dict[str, Any]) -> None:
    with pytest.raises(InputError, match="--cluster has its own: leave one out"):
        said("measure", "a.npz", "-o", "t.parquet", "--cluster", "tcp://a:1", "--workers", 2)
    with pytest.raises(InputError, match="standard input cannot be shared"):
        said("measure", "-", "-o", "t.parquet")
    assert "files" not in asked


def test_what_failed_is_told_and_the_status_is_1(asked: dict[str, Any], capsys: pytest.CaptureFixture[str]) -> None:
    asked["outcome"] = Outcome(7, 40, {"a.npz": {}, "b.npz": {}}, {"c": "c: is bad", "d": "d: too"}, Path("parts"))
    assert said("measure", "a.npz", "-o", "t.parquet", status=1).splitlines() == [
        "t.parquet: 7 contacts in 40 frames of 2 recordings",
        "note: c, d not in it; mend or leave out, and run again: the parts of the others wait in parts",
    ]
    told = json.loads(said("touch", "a.npz", "-o", "t.parquet", "--json", status=1))
    assert told == {
        "output": "t.parquet", "rows": 7, "frames": 40, "recordings": 2,
        "failures": {"c": "c: is bad", "d": "d: too"}, "parts": "parts",
    }  # fmt: skip
    asked["outcome"] = Outcome(7, 40, {"a.npz": {}}, dict.fromkeys("bcdefgh", "is bad"), Path("parts"))
    note = said("measure", "a.npz", "-o", "t.parquet", status=1).splitlines()[1]
    assert note.startswith("note: b, c, d, e, f and 2 more not in it; mend or leave out, and run again:")
    asked["outcome"] = Outcome(0, 0, {}, {}, None)
    assert said("measure", "a.npz", "-o", "t.parquet") == "t.parquet: 0 contacts in 0 frames of 0 recordings\n"
    assert json.loads(said("measure", "a.npz", "-o", "t.parquet", "--json"))["parts"] is None
    # One bad recording of several is told at once.
    asked["tell"]("a.npz: line 3\nis \x1b odd")
    assert capsys.readouterr().err == "varishold: a.npz: line 3 is \\x1b odd\n"
    with click.Context(app.commands["measure"]):
        assert asked["explain"](InputError("odd", parameter="shape")) == "odd (--shape ROWSxCOLS)"
        assert asked["explain"](InputError("odd")) == "odd"


def test_the_page_is_of_the_table_that_was_written(asked: dict[str, Any], monkeypatch: pytest.MonkeyPatch) -> None:
    pages: list[Any] = []
    monkeypatch.setattr("varishold.corpus.summary.summarize_names", lambda table, found: (table, found))
    monkeypatch.setattr(
        "varishold.report.write_corpus_report", lambda page, summary, **how: pages.append((page, summary, how))
    )
    lines = said("touch", "a.npz", "-o", "t.parquet", "--report", "p.html").splitlines()
    assert lines == ["t.parquet: 7 contacts in 40 frames of 1 recording", "report: p.html"]
    ((page, summary, how),) = pages
    assert (page, summary) == (Path("p.html"), (Path("t.parquet"), asked["outcome"]))
    assert how["title"] == "t.parquet"
    assert how["look"]("my file.npz", 9) == "varishold touch 'my file.npz' --frames 9 --report page.html"
    assert said("touch", "a.npz", "-o", "t.parquet", "--report", "p.html", "--json").count("\n") == 1
    assert len(pages) == 2
    said("touch", "a.npz", "-o", "t.parquet")
    assert len(pages) == 2


def test_what_is_for_tables_alone_is_refused_elsewhere() -> None:
    refuse_alone(workers=None, cluster=None, keep_parts=None)
    with pytest.raises(InputError, match="--keep-parts is for tables: name one with -o, or leave it out"):
        refuse_alone(workers=None, keep_parts=True)
    for word in ("--workers", "--cluster"):
        with pytest.raises(InputError, match=f"{word} is for tables"):
            said("touch", "a.npz", word, "3")


def test_who_works_is_said_once() -> None:
    spread = command.Spread(Path("t"), None, None, False, None, False)
    assert set(command._crew(replace(spread, workers=2))) == {"workers"}
    assert np.isin(["workers", "work"], list(command._crew(replace(spread, cluster="local", workers=1)))).all()
