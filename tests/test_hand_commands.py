"""``varishold hand`` and ``varishold paper table 5`` as a person runs them."""

from __future__ import annotations

import importlib
import json
import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("mujoco", reason="MuJoCo is not installed; pip install -e '.[sim]'")

from varishold.cli import main
from varishold.errors import InputError, MissingExtraError
from varishold.hand import photograph
from varishold.hand.picture import tile


@dataclass(frozen=True)
class Ran:
    returncode: int
    stdout: str
    stderr: str


@pytest.fixture
def run(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Callable[..., Ran]:
    def run_words(*words: str) -> Ran:
        monkeypatch.setattr(sys, "argv", ["varishold", *words])
        with pytest.raises(SystemExit) as left:
            main()
        captured = capsys.readouterr()
        return Ran(int(left.value.code or 0), captured.out, captured.err)

    return run_words


def can_draw() -> bool:
    try:
        importlib.import_module("mujoco.egl").GLContext(8, 8).free()
    except Exception:
        return False
    return True


def test_a_grasp_prints_a_line_a_step_and_one_at_the_end(run: Callable[..., Ran]) -> None:
    done = run("hand", "grasp", "square-pillar", "--size-m", "0.07", "--seed", "3", "--json")
    assert done.returncode == 0, done.stderr
    lines = [json.loads(line) for line in done.stdout.splitlines()]
    assert [line["step"] for line in lines[:-1]] == [1, 2, 3, 4, 5]
    assert len(lines[0]["switches"]) == 22
    assert len(lines[0]["angles_rad"]) == 15
    end = lines[-1]
    assert (end["object"], end["size_m"], end["seed"], end["held"]) == ("square-pillar", 0.07, 3, True)


def test_people_get_a_table(run: Callable[..., Ran]) -> None:
    done = run("hand", "grasp", "cylinder", "--size-m", "0.09", "--place-known")
    assert done.returncode == 0, done.stderr
    assert "the wrist lifts" in done.stdout
    assert "the cylinder of 90 mm hangs in the hand" in done.stdout


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("grasp", "cylinder", "--size-m", "0.3"), "size of the cylinder must lie in [0.035, 0.125] m"),
        (("grasp", "plane", "--size-m", "0.07"), "a plane is only a face and has no body to grip"),
        (("grasp", "cylinder", "--size-m", "0.09", "--seed", "-1"), "seed must be a whole number from 0 on, got -1"),
        (("collect", "--objects", "cylinder:", "-o", "t.csv"), "--objects takes NAME:SIZE_M as in cylinder:0.09"),
        (("collect", "--objects", "cylinder:big", "-o", "t.csv"), "--objects takes NAME:SIZE_M as in cylinder:0.09"),
        (("collect", "--objects", "cylinder", "--steps", "x", "-o", "t.csv"), "--steps takes numbers between commas"),
        (("collect", "--objects", "cylinder", "-o", "no/where/t.csv"), "no/where"),
    ],
)
def test_bad_input_ends_in_one_line(run: Callable[..., Ran], words: tuple[str, ...], message: str) -> None:
    done = run("hand", *words)
    assert done.returncode == 1
    assert message in done.stderr
    assert done.stderr.count("\n") == 1


def test_collect_writes_a_table(run: Callable[..., Ran], tmp_path: Path) -> None:
    path = tmp_path / "t.csv"
    words = ("hand", "collect", "--objects", "cylinder:0.09,square-pillar", "--grasps", "2", "-o", str(path))
    done = run(*words, "--place-known", "--steps", "all", "--processes", "1")
    assert done.returncode == 0, done.stderr
    assert done.stdout.strip() == f"{path}: 20 rows, 16 held"
    assert len(path.read_text().splitlines()) == 21


@pytest.mark.skipif(not can_draw(), reason="OpenGL cannot draw without a screen here")
def test_a_picture_shows_five_steps(tmp_path: Path) -> None:
    path = tmp_path / "five.png"
    done = photograph("cylinder", 0.09, path, seed=3)
    assert len(done.steps) == 5
    assert path.read_bytes().startswith(b"\x89PNG\r\n\x1a\n")


def test_without_a_way_to_draw_the_message_says_so(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("MUJOCO_GL", "nothing")
    with pytest.raises(MissingExtraError, match=r"no picture: OpenGL cannot draw .* libegl1"):
        photograph("cylinder", 0.09, tmp_path / "x.png", seed=3)
    assert not (tmp_path / "x.png").exists()


def test_pictures_are_tiled_on_white() -> None:
    sheet = tile([np.zeros((2, 3, 3), np.uint8)] * 2, columns=1, gap=1)
    assert sheet.shape == (7, 5, 3)
    assert (sheet[3] == 255).all()


def test_table_5_is_printed_beside_the_papers(run: Callable[..., Ran]) -> None:
    done = run("paper", "table", "5", "--grasps", "1", "--repetitions", "1", "--processes", "1", "--json")
    assert done.returncode == 0, done.stderr
    rows = [json.loads(line) for line in done.stdout.splitlines()]
    assert [row["object"] for row in rows] == ["C1", "C2", "C3", "C4", "C5", "S1", "S2", "S3", "S4", "S5", "mean"]
    assert rows[0]["paper_percent"] == 0.0
    assert set(rows[0]["percent"]) == {"contact", "contact+coordinates", "surface", "surface+coordinates"}


def test_table_5_names_what_is_wrong(tmp_path: Path) -> None:
    from varishold.paper.table5 import table_5
    from varishold.report.finger_length import draw_finger_lengths

    with pytest.raises(InputError, match="grasps and repetitions must be at least 1, got 0 and 2"):
        table_5(grasps=0)
    with pytest.raises(InputError, match=r"unknown feature group \['smell'\]"):
        table_5(groups=("smell",))
    with pytest.raises(InputError, match=r"a figure's name must end in .png, .svg, .pdf"):
        draw_finger_lengths([], tmp_path / "figure.doc")
