"""``varishold evaluate`` as a person runs it."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from tests.pressed_things import failed, recording, told

from varishold import Pad, Recording, write
from varishold.evaluation import peers
from varishold.solids import Cone, SquarePillar, ideal_frame

QUICK = ("--no-peers", "--shots", "0")


@pytest.fixture(scope="module", autouse=True)
def few_trees() -> Iterator[None]:
    """A peer's forest of a few trees answers in a tenth of the time."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(peers, "_TREES", 6)
        yield


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("evaluate")
    for k, day in enumerate(("mon", "tue", "wed")):
        write(recording(["disc", "bar"] * 4, k, days=[day]), path / f"{day}.npz")
    write(recording(["ring", "disc"] * 3, 7, days=["thu"]), path / "thu.npz")
    write(recording(["disc", "bar"] * 4, 8, (9, 9), days=["fri"]), path / "other.npz")
    done = told("learn", path / "mon.npz", "--label", "thing", "-o", path / "model.npz")
    assert done.exit_code == 0, done.output
    return path


def days(folder: Path) -> list[Path]:
    return [folder / f"{day}.npz" for day in ("mon", "tue", "wed")]


def test_figures_for_people(folder: Path) -> None:
    done = told("evaluate", *days(folder), "--label", "thing", "--group", "day", "--shots", "1,2")
    assert done.exit_code == 0, done.output
    lines = done.output.splitlines()
    assert lines[0] == "24 presses of 3 groups, 2 things"
    assert "right in groups that nothing was learned from" in lines[1]
    assert sum(line.startswith("  peer: ") for line in lines) == 9
    assert any("learned from 1 press a thing" in line and line.split()[6] == "-;" for line in lines)
    assert "over 3 groups" in lines[2]
    assert "flatters" not in done.output


def test_a_split_that_leaks_says_so_in_every_line_with_a_figure(folder: Path) -> None:
    done = told("evaluate", *days(folder), "--label", "thing", *QUICK)
    lines = done.output.splitlines()
    figures = [line for line in lines[1:] if not line.startswith(("warning", "note"))]
    assert len(figures) > 8
    assert all(line.endswith("[flatters: one session on both sides]") for line in figures)
    assert any(line.startswith("warning: no groups are given") for line in lines)
    assert any(line.startswith("note: no groups are given: no interval over groups") for line in lines)


def test_json_is_one_object_and_the_same_seed_gives_the_same_bytes(folder: Path) -> None:
    asked = ("evaluate", *days(folder), "--label", "thing", "--group", "day", "--json", "--seed", "3")
    # What the peers answer by one seed is compared where they are asked, in `test_evaluation`.
    two_days = ("evaluate", *days(folder)[:2], *asked[4:], *QUICK)
    assert told(*two_days).stdout == told(*two_days).stdout
    found = json.loads(told(*asked, "--shots", "2").stdout)
    assert found["seed"] == 3
    assert found["split"] == {"kind": "groups", "folds": 3}
    assert found["right"]["value"] > 0.8
    assert len(found["peers"]) == 9


def test_a_model_is_tested_and_what_it_does_not_know_is_a_stranger(folder: Path) -> None:
    done = told("evaluate", folder / "thu.npz", "--label", "thing", "--with", folder / "model.npz", "--json")
    found = json.loads(done.stdout)
    assert found["tested"] == "model"
    assert found["strangers"]["things"] == ["ring"]
    assert found["strangers"]["n_presses"] == 3
    assert found["right"]["n_presses"] == 3
    assert found["leaks"] == []
    again = told("evaluate", folder / "mon.npz", "--label", "thing", "--with", folder / "model.npz")
    assert "right by the model that was given  [flatters: learned from these]" in again.output


def test_the_shipped_names_are_tested(tmp_path: Path) -> None:
    rng = np.random.default_rng(0)
    solids = {"square-pillar": SquarePillar(12.0, 8.0), "Cone": Cone(14.0, 8.0)}
    names = list(solids) * 3
    ramp = np.array([0.0, 0.0, 10.0, 10.0, 0.0])[:, None, None]
    frames = np.concatenate([ramp * ideal_frame(solids[name], (24, 24), 1.0) for name in names])
    columns = {"form": np.array(names), "thing": np.array(["mug"] * 6)}
    press = np.repeat(np.arange(6), 5)
    pad = Pad(frames + rng.normal(0, 0.05, frames.shape))
    write(Recording({"pad": pad}, press=press, press_columns=columns), tmp_path / "forms.npz")
    done = told("evaluate", tmp_path / "forms.npz", "--label", "form", "--with", "shipped")
    assert done.exit_code == 0, done.output
    assert "100 % right by the shipped names" in done.output


def test_a_page_is_written_and_nothing_else_is_written_over(
    folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    asked = ("evaluate", folder / "thu.npz", "--label", "thing", "--with", folder / "model.npz")
    done = told(*asked, "--report", folder / "page.html")
    assert done.output.splitlines()[-1] == f"report: {folder / 'page.html'}"
    assert "What is taken for what" in (folder / "page.html").read_text()
    assert told(*asked, "--report", folder / "page.html").exit_code == 0
    said = failed(monkeypatch, capsys, *asked, "--report", folder / "mon.npz")
    assert "is there, and is no page of this program" in said
    assert "is read by this very call" in failed(monkeypatch, capsys, *asked, "--report", folder / "model.npz")
    assert "is read by this very call" in failed(monkeypatch, capsys, *asked, "--report", folder / "thu.npz")


def test_folders_are_groups(tmp_path: Path) -> None:
    for k, day in enumerate(("mon", "tue", "wed")):
        (tmp_path / day).mkdir()
        write(recording(["disc", "bar"] * 3, k, days=[day]), tmp_path / day / "presses.npz")
    done = told(
        "evaluate",
        tmp_path / "mon",
        tmp_path / "tue",
        tmp_path / "wed",
        "--label",
        "thing",
        "--group",
        "folder",
        *QUICK,
    )
    assert "18 presses of 3 groups" in done.output


def test_what_cannot_be_done_is_told_in_one_line(
    folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    all_days = ("evaluate", *days(folder))
    named = (*all_days, "--label", "thing")
    for arguments, message in (
        (all_days, "what names the things is not said: a column of the presses, or folder (--label)"),
        ((*all_days, "--label", "name"), "presses have no column 'name', known are: thing, day"),
        ((*named, "--group", "hour"), "presses have no column 'hour'"),
        ((*named, "--group", "thing"), "groups are the labels themselves"),
        ((*all_days, "--label", "folder"), "there is one thing only"),
        (("evaluate", folder / "mon.npz", "--label", "thing", "--group", "day"), "there is one group only, 'mon'"),
        ((*all_days, folder / "other.npz", "--label", "thing"), "presses of one sensor"),
        ((*named, "--seed", 2**32), "seed must be a whole number from 0 to 4294967295, got 4294967296 (--seed)"),
        ((*named, "--shots", "one"), "--shots must be numbers of presses between commas"),
        ((*named, "--with", "nothing.npz"), "nothing.npz: is neither 'shipped' nor a file"),
        ((*named, "--with", folder / "mon.npz"), "is no model file"),
        ((*named, "--with", "shipped"), "labels that are no shipped name: bar, disc; known are: cylinder"),
        ((*named, "--with", "shipped", "--position"), "nothing is learned: leave out --position"),
        ((*named, "--with", "shipped", "--no-peers"), "nothing is learned: leave out --no-peers"),
        ((*named, "--with", "shipped", "--workers", "2"), "nothing is learned: leave out --workers"),
        ((*named, "--workers", "2", "--cluster", "tcp://a:1"), "--cluster has its own: leave one out"),
        (
            ("evaluate", folder / "other.npz", "--label", "thing", "--with", folder / "model.npz"),
            "the model is of another sensor: pad 13 x 15",
        ),
        (
            (*all_days, "--label", "day", "--with", folder / "model.npz"),
            "the model knows none of these labels: mon, tue, wed; it knows bar, disc (--label)",
        ),
    ):
        assert message in failed(monkeypatch, capsys, *arguments)
