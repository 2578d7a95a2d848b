"""``varishold learn`` and ``varishold recognize`` as a person runs them."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from tests.pressed_things import failed, recording, told

from varishold import write
from varishold.cli.learn import _in_words, _told_loss
from varishold.learning import Recognition


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("learn")
    write(recording(["disc", "bar"] * 12, 0), path / "learn.npz")
    write(recording(["bar", "disc"] * 4, 1), path / "new.npz")
    write(recording(["ring"] * 8, 2), path / "ring.npz")
    write(recording(["disc", "bar"] * 4, 3, (9, 9)), path / "other.npz")
    done = told("learn", path / "learn.npz", "--label", "thing", "-o", path / "model.npz")
    assert done.exit_code == 0, done.output
    return path


def test_learn_says_what_it_learned(folder: Path) -> None:
    done = told("learn", folder / "learn.npz", "--label", "thing", "--group", "day", "-o", folder / "again.npz")
    assert "24 presses of 2 things; held out, the true thing has p = " in done.output
    assert "no session was held out" not in done.output


def test_the_same_recordings_give_the_same_bytes(folder: Path) -> None:
    told("learn", folder / "learn.npz", "--label", "thing", "-o", folder / "second.npz")
    assert (folder / "second.npz").read_bytes() == (folder / "model.npz").read_bytes()
    assert (folder / "model.npz").stat().st_size < 2_000_000


def test_recognize_answers_every_press(folder: Path) -> None:
    done = told("recognize", folder / "model.npz", folder / "new.npz", "--json")
    assert done.exit_code == 0
    lines = [json.loads(line) for line in done.output.splitlines()]
    assert [line["label"] for line in lines] == ["bar", "disc"] * 4
    assert set(lines[0]) == {
        *("file", "press", "label", "probability", "alternatives", "p_value", "refused", "reasons", "nearest")
    }
    people = told("recognize", folder / "model.npz", folder / "new.npz").output.splitlines()
    assert len(people) == 8
    assert people[0].split()[1] == "bar"


def test_none_of_these(folder: Path) -> None:
    done = told("recognize", folder / "model.npz", folder / "ring.npz")
    assert done.output.count("none of these (p = ") >= 6


def test_a_class_is_added(folder: Path) -> None:
    done = told("learn", folder / "model.npz", "--add", "ring", folder / "ring.npz", "-o", folder / "three.npz")
    assert done.exit_code == 0, done.output
    assert "ring added from 8 presses; 3 things" in done.output
    lines = told("recognize", folder / "three.npz", folder / "ring.npz", "--json").output.splitlines()
    assert np.mean([json.loads(line)["label"] == "ring" for line in lines]) > 0.8


def test_folders_are_labels(tmp_path: Path) -> None:
    for name in ("disc", "bar"):
        (tmp_path / name).mkdir()
        for day in range(3):
            write(recording([name] * 2, 10 * day + len(name)), tmp_path / name / f"{day}.npz")
    done = told("learn", tmp_path / "disc", tmp_path / "bar", "--label", "folder", "-o", tmp_path / "m.npz")
    assert "12 presses of 2 things" in done.output


def test_what_cannot_be_done_is_told_in_one_line(
    folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    out = ("-o", folder / "never.npz")
    learn = ("learn", folder / "learn.npz")
    for arguments, message in (
        ((*learn, *out), "what names the things is not said: a column of the presses, or folder (--label)"),
        ((*learn, "--label", "name", *out), "presses have no column 'name', known are: thing, day"),
        ((*learn, "--label", "thing", "--group", "hour", *out), "presses have no column 'hour'"),
        ((*learn, "--label", "thing", "--group", "thing", *out), "groups are the labels themselves"),
        ((*learn, "--label", "thing", "--group", "thing", *out), "such as the session (--group)"),
        ((*learn, "--label", "folder", *out), "learn.npz: 'folder' names one thing only, 'learn"),
        (
            ("learn", folder / "model.npz", "--add", "ring", folder / "ring.npz", "--group", "day", *out),
            "leave out --group",
        ),
        (("learn", folder / "model.npz", "--add", "bar ", folder / "ring.npz", *out), "'bar' is known already"),
        ((*learn, folder / "other.npz", "--label", "thing", *out), "give presses of one sensor"),
        (("learn", folder / "ring.npz", "--label", "day", "-o", folder / "ring.npz"), "is read by this very call"),
        (("recognize", folder / "model.npz", folder / "other.npz"), "the model is of another sensor: pad 13 x 15"),
        (("recognize", folder / "new.npz", folder / "new.npz"), "is no model file"),
        ((*learn, "--add", "ring", folder / "ring.npz", *out), "is no model file"),
    ):
        assert message in failed(monkeypatch, capsys, *arguments)
    assert not (folder / "never.npz").exists()


def test_a_file_that_is_no_model_is_not_replaced(
    folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    said = failed(monkeypatch, capsys, "learn", folder / "learn.npz", "--label", "thing", "-o", folder / "new.npz")
    assert "is there, and is no learned model of this program" in said


def test_an_answer_in_words() -> None:
    reasons = (("a", 2.26), ("b", 0.5), ("c", -1.0), ("d", -2.0))
    found = Recognition("disc", 0.876, {"bar": 0.1, "ring": 0.02}, 0.5, False, reasons, "f, press 3", "disc", "p")
    assert _in_words(found) == "disc 0.88, else bar 0.10; a +2.3, b +0.5, c -1.0; most like f, press 3"
    assert _in_words(replace(found, alternatives={})) == "disc 0.88; a +2.3, b +0.5, c -1.0; most like f, press 3"
    assert _in_words(replace(found, nearest="f\nball 1.00", alternatives={})).endswith("most like f ball 1.00")
    refused = replace(found, refused=True, p_value=0.0123)
    assert _in_words(refused) == "none of these (p = 0.012); nearest is disc, most like f, press 3"
    assert _told_loss(0.5) == "held out, the true thing has p = 0.61 on the geometric mean"


def test_presses_are_numbered_and_answers_bear_their_file(folder: Path) -> None:
    done = told("recognize", folder / "model.npz", folder / "new.npz", folder / "ring.npz", "--json")
    lines = [json.loads(line) for line in done.stdout.splitlines()]
    assert [line["press"] for line in lines] == [*range(8), *range(8)]
    assert [line["file"] for line in lines] == [str(folder / "new.npz")] * 8 + [str(folder / "ring.npz")] * 8
    people = told("recognize", folder / "model.npz", folder / "new.npz", folder / "ring.npz").stdout.splitlines()
    assert people[0] == f"{folder / 'new.npz'}:"
    assert people[1].startswith("    0  bar ")


def test_a_class_is_added_to_one_model(
    folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    model = folder / "model.npz"
    arguments = ("learn", model, model, "--add", "ring", folder / "ring.npz", "-o", folder / "never.npz")
    said = failed(monkeypatch, capsys, *arguments)
    assert "to add a class name the one model to add to, got 2 files" in said


def test_what_is_not_held_out_is_noted(folder: Path) -> None:
    done = told("learn", folder / "learn.npz", "--label", "thing", "--error", "0.01", "-o", folder / "noted.npz")
    assert "note: no sessions are known: no session was held out" in done.output
    assert "note: 24 presses are too few to refuse anything at an error of 0.01: give 99 or more" in done.output
