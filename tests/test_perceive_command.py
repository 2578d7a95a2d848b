"""``varishold perceive`` as a person and as a program run it."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import pytest

pytest.importorskip("mujoco", reason="MuJoCo is not installed; pip install -e '.[sim]'")

from varishold.cli import main
from varishold.exploration import TOUCHES, Grip
from varishold.hand import OBJECTS
from varishold.perceive import library_file, shipped_library, write_library

pytestmark = pytest.mark.skipif(
    not library_file._SHIPPED.is_file(), reason="no library of objects is shipped; python -m training.objects makes it"
)


@dataclass(frozen=True)
class Ran:
    returncode: int
    stdout: str
    stderr: str

    @property
    def lines(self) -> list[dict]:
        return [json.loads(line) for line in self.stdout.splitlines()]


@pytest.fixture
def run(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Callable[..., Ran]:
    def run_words(*words: str) -> Ran:
        monkeypatch.setattr(sys, "argv", ["varishold", "perceive", *words])
        with pytest.raises(SystemExit) as left:
            main()
        captured = capsys.readouterr()
        return Ran(int(left.value.code or 0), captured.out, captured.err)

    return run_words


def test_a_line_a_touch_and_the_answer_last(run: Callable[..., Ran]) -> None:
    done = run("hexagonal-prism", "--size-m", "0.07", "--seed", "3", "--json")
    assert done.returncode == 0, done.stderr
    *touches, end = done.lines
    assert list(end)[:6] == ["object", "size_m", "probability", "alternatives", "touches", "trace"]
    assert end["trace"] == touches
    assert end["touches"] == len(touches) >= 1
    assert (end["true_object"], end["true_size_m"], end["seed"]) == ("hexagonal-prism", 0.07, 3)
    first = touches[0]
    assert first["touch"] in ("grasp", "squeeze")
    assert set(first["probabilities"]) == set(OBJECTS)
    assert sum(first["probabilities"].values()) == pytest.approx(1)
    assert first["reasons"]
    assert isinstance(first["why"], str)
    low, high = first["size_interval_m"]
    assert low <= first["size_m"] <= high
    for here, after in pairwise(touches):
        assert here["verdict"] == "go on"
        assert here["next"]["touch"] == after["touch"] or after["touch"] == "squeeze"
    assert touches[-1]["next"] is None
    assert end["verdict"] == touches[-1]["verdict"] != "go on"
    pressed = [pad for pad in first["pads"].values() if pad is not None]
    assert pressed
    for pad in pressed:
        assert sum(pad["probability"].values()) == pytest.approx(1)
        assert pad["surface"] == max(pad["probability"], key=pad["probability"].__getitem__)


def test_the_same_seed_says_the_same_and_underscores_do(run: Callable[..., Ran]) -> None:
    first = run("square-pillar", "--size-m", "0.08", "--seed", "5", "--json")
    again = run("square_pillar", "--size-m", "0.08", "--seed", "5", "--json")
    assert first.returncode == 0, first.stderr
    assert first.stdout == again.stdout


def test_people_read_sentences(run: Callable[..., Ran]) -> None:
    done = run("cylinder", "--size-m", "0.09", "--seed", "2", "--place-known", "--most-touches", "1")
    assert done.returncode == 0, done.stderr
    assert "1 grasp: grasped it in five steps and lifted it;" in done.stdout
    assert "of 22 switches closed" in done.stdout
    assert "  stops: " in done.stdout
    assert "After 1 touch: " in done.stdout
    assert "it is a cylinder of 90 mm" in done.stdout
    assert done.stderr == ""


def test_touches_come_in_a_given_order(run: Callable[..., Ran]) -> None:
    words = ("box", "--size-m", "0.06", "--seed", "1", "--error", "1e-9", "--json")
    done = run(*words, "--order", "squeeze, fingertip_middle", "--most-touches", "2")
    assert done.returncode == 0, done.stderr
    assert [touch["touch"] for touch in done.lines[:-1]] == ["squeeze", "fingertip-middle"]
    assert done.lines[0]["next"] == {
        "touch": "fingertip-middle", "expected_nats": None, "expected_seconds": None, "along_with": None
    }  # fmt: skip
    assert done.lines[-1]["seconds"] == sum(touch["seconds"] for touch in done.lines[:-1]) > 4


def test_an_object_that_is_never_gripped_has_no_name(
    run: Callable[..., Ran], monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setattr(Grip, "make", lambda *_, **__: None)
    page = tmp_path / "r.html"
    done = run("sphere", "--size-m", "0.06", "--json", "--report", str(page))
    assert done.returncode == 0, done.stderr
    (end,) = done.lines
    assert (end["object"], end["size_m"], end["touches"], end["trace"]) == (None, None, 0, [])
    assert end["remarks"] == ["nothing was gripped"]
    assert "Nothing was gripped" in page.read_text()
    said = run("sphere", "--size-m", "0.06").stdout
    assert "Nothing was gripped: the hand missed or dropped the object" in said
    assert "It was a sphere of 60 mm." in said


def test_a_report_and_a_library_of_ones_own(run: Callable[..., Ran], tmp_path: Path) -> None:
    page, own = tmp_path / "r.html", tmp_path / "own.npz"
    write_library(shipped_library().only(["cylinder", "square-pillar"]), own)
    words = ("cylinder", "--size-m", "0.08", "--seed", "1", "--library", str(own), "--report", str(page))
    done = run(*words)
    assert done.returncode == 0, done.stderr
    assert done.stdout.splitlines()[-1] == f"report: {page}"
    assert "square pillar" in page.read_text()
    assert "triangular prism" not in page.read_text()


def test_a_page_without_pictures_says_why(
    run: Callable[..., Ran], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("MUJOCO_GL", "nothing")
    page = tmp_path / "r.html"
    done = run("cylinder", "--size-m", "0.09", "--most-touches", "1", "--report", str(page))
    assert done.returncode == 0, done.stderr
    assert "Pictures are left out. No picture: OpenGL cannot draw" in page.read_text()
    assert 'class="photo"' not in page.read_text()


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("plane", "--size-m", "0.07"), "a plane is only a face and has no body to grip"),
        (("cylinder", "--size-m", "0.3"), "size of the cylinder must lie in [0.035, 0.125] m"),
        (("cylinder", "--size-m", "nan"), "size of the cylinder must lie in [0.035, 0.125] m"),
        (("cylinder", "--size-m", "0.09", "--seed", "-1"), "seed must be a whole number from 0 on, got -1"),
        (("cylinder", "--size-m", "0.09", "--error", "0"), "error must lie between 0 and 1, got 0.0"),
        (("cylinder", "--size-m", "0.09", "--library", "no.npz"), "no.npz: there is no such file"),
        (("cylinder", "--size-m", "0.09", "--library", __file__), "is no NPZ file: it does not start like an archive"),
        (("cylinder", "--size-m", "0.09", "--report", "no/where.html"), "no/where.html: cannot write here"),
        (("cylinder", "--size-m", "0.09", "--report", "."), ".: cannot write here: it is a folder"),
        (("cylinder", "--size-m", "0.09", "--order", "grasp,kick"), f"of {', '.join(TOUCHES)}; got 'kick'"),
        (("cylinder", "--size-m", "0.09", "--order", ""), "got ''"),
        (
            ("cylinder", "--size-m", "0.09", "--order", "grasp,grasp"),
            "--order takes each touch once; got 'grasp' again",
        ),
        (("cylinder", "--size-m", "0.09", "--library", "."), ".: is a folder; name a file in it"),
        (("cylinder", "--size-m", "0.09", "--order", "fingertip-edge"), "--order must begin with grasp or squeeze"),
    ],
)
def test_bad_input_ends_in_one_line_before_anything_moves(
    run: Callable[..., Ran], monkeypatch: pytest.MonkeyPatch, words: tuple[str, ...], message: str
) -> None:
    from varishold.hand import Bench

    def moved(*_: object, **__: object) -> None:
        raise AssertionError("the hand moved")

    monkeypatch.setattr(Bench, "advance", moved)
    done = run(*words)
    assert done.returncode == 1
    assert message in done.stderr
    assert done.stderr.count("\n") == 1
    assert done.stdout == ""


def test_without_mujoco_one_line_says_what_to_install(run: Callable[..., Ran], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "mujoco", None)
    done = run("cylinder", "--size-m", "0.09")
    assert done.returncode == 1
    assert "pip install -e '.[sim]'" in done.stderr
    assert done.stderr.count("\n") == 1
