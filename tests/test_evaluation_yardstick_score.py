"""What answers to the yardstick's frames are worth, and what is said of functions that do not answer."""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
from collections.abc import Callable, Iterator
from functools import cache
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from click.testing import CliRunner

from varishold import InputError
from varishold.cli.app import app, run
from varishold.errors import Interrupted
from varishold.evaluation.yardstick import (
    FRAMES,
    ROWS,
    SEED,
    YardstickScore,
    load_function,
    media,
    read_answer,
    score_function,
    score_functions,
    shipped_names,
)
from varishold.evaluation.yardstick.forms import KINDS
from varishold.evaluation.yardstick.loading import exits_raised
from varishold.evaluation.yardstick.media import clean_frames
from varishold.evaluation.yardstick.rows import distorted

SMALL = {"shapes": [(16, 16)], "frames": 1, "seed": 3}
COUNTED = [row for row in ROWS if row.counted]


@pytest.fixture(scope="module", autouse=True)
def drawn_once() -> Iterator[None]:
    """Every frame before its faults is drawn once for all tests: that it is the same again has a test of its own."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(media, "_draw", cache(media._draw))
        yield


@pytest.fixture(scope="module")
def truths() -> dict[bytes, tuple[str, ...]]:
    """What is true of every frame of the small yardstick, by its readings."""
    known = {}
    for row in ROWS:
        for medium in ("ideal", "cover"):
            read, true = distorted(row, *clean_frames(medium, 16, row.change, 1, 3), medium, 3)
            known |= {frame.tobytes(): names for frame, names in zip(read, true, strict=True)}
    return known


def scored(function: Callable, **options) -> YardstickScore:
    return score_function(function, **{**SMALL, **options})


class TestScore:
    def test_who_knows_the_truth_is_always_right(self, truths) -> None:
        (found,) = scored(lambda frame: truths[frame.tobytes()][-1]).shapes
        assert found.right.value == found.outline == 1.0
        assert found.calibration_error == found.unknown == found.sure_wrong == 0.0
        assert {row.right for row in found.rows} == {1.0}
        assert [row.name for row in found.rows] == [row.name for row in ROWS]
        assert {row.frames for row in found.rows} == {2 * len(KINDS)}

    def test_a_constant_answer_scores_its_share(self, truths) -> None:
        (found,) = scored(lambda frame: {"sphere": 0.95}).shapes
        share = 1 / len(KINDS)
        for row in found.rows:
            assert row.right == pytest.approx(2 * share if row.name == "rounded by half" else share)
            assert row.sure_wrong == pytest.approx(1 - row.right)
            assert row.outline == pytest.approx(4 * share)
        assert found.right.value == pytest.approx(share * (len(COUNTED) + 1) / len(COUNTED))
        assert found.calibration_error == pytest.approx(0.95 - found.right.value)

    def test_unknown_is_never_right_and_never_a_wrong_name(self) -> None:
        (found,) = scored(lambda frame: "unknown").shapes
        assert (found.right.value, found.outline, found.unknown, found.sure_wrong) == (0, 0, 1, 0)

    def test_doubtful_errors_are_not_sure(self) -> None:
        assert scored(lambda frame: {"sphere": 0.9}).shapes[0].sure_wrong == 0

    def test_an_outline_of_its_own_counts(self, truths) -> None:
        (found,) = scored(lambda frame: ("sphere", "plane")).shapes
        planes = [("plane" in true or "unknown" in true) for true in truths.values()]
        assert found.outline == pytest.approx(np.mean(planes), abs=0.01)

    def test_rows_that_are_not_counted_do_not_count(self, truths) -> None:
        lost = {row.name for row in ROWS if not row.counted}
        known = {}
        for row in ROWS:
            for medium in ("ideal", "cover"):
                read, _ = distorted(row, *clean_frames(medium, 16, row.change, 1, 3), medium, 3)
                known |= {frame.tobytes(): row.name for frame in read}
        (found,) = scored(
            lambda frame: "unknown" if known[frame.tobytes()] in lost else truths[frame.tobytes()][0]
        ).shapes
        assert found.right.value == 1.0
        assert {row.name for row in found.rows if row.right == 0} == lost

    def test_many_at_once_and_one_by_one_score_alike(self) -> None:
        one = scored(lambda frame: "edge" if frame[0].max() > 0.5 else "cone")
        many = scored(lambda frames: ["edge" if frame[0].max() > 0.5 else "cone" for frame in frames], batch=True)
        assert one.to_dict() == many.to_dict()

    def test_several_functions_score_as_each_alone(self) -> None:
        functions = {"one": lambda frame: "cone", "two": lambda frame: "edge" if frame[0].max() > 0.5 else "plane"}
        found = score_functions(functions, **SMALL)
        assert [one.to_dict() for one in found] == [scored(f, tested=name).to_dict() for name, f in functions.items()]
        with pytest.raises(InputError, match="functions must hold one"):
            score_functions({}, **SMALL)
        with pytest.raises(InputError, match="functions must be a Mapping, each by what it is called, got list"):
            score_functions(list(functions.values()), **SMALL)
        with pytest.raises(InputError, match="mine: is no function but str"):
            score_functions({"mine": "odd:names"}, **SMALL)

    def test_the_shipped_names_answer_as_they_do(self) -> None:
        (found,) = scored(shipped_names).shapes
        assert found.right.value > 0.85
        assert found.right.low < found.right.value < found.right.high
        assert shipped_names(np.zeros((16, 16))) == {"unknown": 1.0}

    def test_what_a_function_does_to_its_frame_changes_nothing(self) -> None:
        def spoils(frame):
            frame[:] = 0
            return "cone"

        assert scored(spoils).to_dict() == scored(lambda frame: "cone").to_dict()

    def test_steps_add_up(self) -> None:
        steps = []
        scored(lambda frame: "cone", tick=lambda **change: steps.append(change))
        assert steps[0]["total"] == sum(step["advance"] for step in steps[1:])

    def test_only_standard_frames_are_standard(self) -> None:
        assert YardstickScore("f", FRAMES, SEED, ()).standard
        assert not YardstickScore("f", FRAMES - 1, SEED, ()).standard
        assert not YardstickScore("f", FRAMES, 0, ()).standard

    @pytest.mark.parametrize(
        "options",
        [
            {"shapes": [(9, 9)]},
            {"shapes": []},
            {"shapes": (16, 16)},
            {"frames": 0},
            {"frames": 2.5},
            {"seed": -1},
            {"seed": "a"},
        ],
    )
    def test_what_is_not_drawn_is_told(self, options) -> None:
        with pytest.raises(InputError, match=f"{next(iter(options))} must be"):
            scored(lambda frame: "cone", **options)


class TestAnswers:
    def test_ridge_and_hip_are_one_name(self) -> None:
        told = read_answer({"ridge": 0.3, "hip": 0.3, "sphere": 0.4})
        assert (told.name, told.outline) == ("ridge", "oblong")
        assert told.probability == pytest.approx(0.6)

    def test_of_equally_likely_names_the_first_of_the_table_counts(self) -> None:
        assert read_answer({"sphere": 0.5, "cylinder": 0.5}).name == "cylinder"

    def test_the_outline_is_what_the_names_make_likeliest(self) -> None:
        told = read_answer({"edge": 0.4, "cone": 0.3, "sphere": 0.3})
        assert (told.name, told.outline) == ("edge", "round")

    def test_numbers_of_numpy_are_numbers(self) -> None:
        assert read_answer({"cone": np.float32(0.5), "edge": np.int64(0)}).probability == 0.5

    @pytest.mark.parametrize(
        ("answer", "told"),
        [
            (None, "an answer must be a name, or a mapping of names to probabilities, got NoneType"),
            (3, "got int"),
            (["cone"], "got list"),
            ("Cone", "'Cone' is no name of the table; known are: cylinder"),
            ({1: 0.5}, "1 is no name of the table"),
            ({}, "the answer names nothing"),
            ({"cone": float("nan")}, "the probability of 'cone' must be a number from 0 to 1, got nan"),
            ({"cone": -0.1}, "got -0.1"),
            ({"cone": 1.1}, "got 1.1"),
            ({"cone": "1"}, "got '1'"),
            ({"cone": True}, "got True"),
            ({"cone": 0.7, "edge": 0.7}, "probabilities must sum to 1 at most, got 1.4"),
            (("cone", "oval"), "'oval' is no outline; known are: round"),
            (("cone", "round", 1), "got tuple"),
            ({"cone": 10**400}, "the probability of 'cone' must be a number from 0 to 1, got 1000"),
        ],
    )
    def test_nonsense_is_told_with_its_frame(self, answer: object, told: str) -> None:
        where = "; it is the answer to frame 0 of row 'clean', ideal, 16 x 16"
        with pytest.raises(InputError, match=f"mine:f: .*{re.escape(told)}.*{where}"):
            scored(lambda frame: answer, tested="mine:f")

    def test_what_a_function_raises_is_told_with_its_frame(self) -> None:
        asked = []

        def fails(frame):
            asked.append(frame)
            if len(asked) > 30:
                raise KeyError("lost")
            return "cone"

        with pytest.raises(
            InputError, match=r"mine:f: raised KeyError: 'lost' \(.*test_evaluation_yardstick_score.py, line \d+\)"
        ) as told:
            scored(fails, tested="mine:f")
        assert str(told.value).endswith(" at frame 4 of row 'gain spread 10 %', ideal, 16 x 16")

    @pytest.mark.parametrize("kind", [GeneratorExit, SystemExit, type("Odd", (BaseException,), {})])
    def test_whatever_a_function_throws_ends_in_one_line(self, kind: type[BaseException]) -> None:
        def fails(frame):
            raise kind("a\nb" + "x" * 10_000)

        with pytest.raises(InputError, match=f"mine:f: raised {kind.__name__}: a") as told:
            scored(fails, tested="mine:f")
        assert len(str(told.value)) < 1000

    def test_a_function_that_would_end_the_process_unseen_is_told(self) -> None:
        leave = os._exit
        with pytest.raises(
            InputError, match=r"mine:f: raised SystemExit: it asked to end .* status 0 .* at frame 0 of"
        ):
            scored(lambda frame: os._exit(0), tested="mine:f")
        assert os._exit is leave

    @pytest.mark.skipif(not hasattr(os, "fork"), reason="a process is copied")
    def test_processes_of_a_function_end_as_they_would(self) -> None:
        def copies(frame):
            child = os.fork()
            if child == 0:
                os._exit(7)
            assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 7
            return "cone"

        with exits_raised():
            assert copies(None) == "cone"

    @pytest.mark.parametrize("kind", [KeyboardInterrupt, Interrupted])
    def test_who_is_interrupted_threw_nothing(self, kind: type[BaseException]) -> None:
        def stops(frame):
            raise kind

        with pytest.raises(kind):
            scored(stops)

    def test_an_answer_that_fails_when_it_is_read_is_told_with_its_frame(self) -> None:
        class Odd(dict):
            def items(self):
                raise RuntimeError("no items")

        with pytest.raises(
            InputError, match=r"mine:f: the answer to frame 0 of .*, of type Odd, cannot be read: raised R"
        ):
            scored(lambda frame: Odd(cone=1.0), tested="mine:f")

    def test_too_few_answers_are_told(self) -> None:
        for answer in (["cone"], "cone", None):
            with pytest.raises(InputError, match="mine:f: must answer a list of 13 answers to row 'clean', ideal"):
                scored(lambda frames, answer=answer: answer, tested="mine:f", batch=True)


MINE = """
value = 3
class inner:
    def names(frame):
        return "cone"
def names(frame):
    print("not a part of the answer")
    return {"cone": 0.75}
def nothing(frame):
    pass
"""


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder of one's own, in which nothing stays imported."""
    for name, text in (("mine_a", MINE), ("mine_b", "import no_such_thing"), ("mine_c", "1 / 0"), ("mine_d", "def (")):
        (tmp_path / f"{name}.py").write_text(text)
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("sys.path", [path for path in sys.path if path])
    before = set(sys.modules)
    yield tmp_path
    for name in set(sys.modules) - before:
        if name.startswith("mine_"):
            del sys.modules[name]


def told(*arguments: str) -> SimpleNamespace:
    asked = ("evaluate", "--distortions", "--shape", "16x16", "--frames", "1", "--seed", "3", *arguments)
    return CliRunner().invoke(app, asked)


class TestCommand:
    def test_figures_for_people(self, folder: Path) -> None:
        done = told("--with", "mine_a:names")
        assert done.exit_code == 0, done.output
        lines = done.stdout.splitlines()
        assert lines[0] == "yardstick of distortions, version 1: mine_a:names"
        assert lines[2] == "16 x 16, noise 2%, 26 frames a row, seed 3"
        assert sum(" *  " in line for line in lines) == len(ROWS) - len(COUNTED)
        (mean,) = (line for line in lines if line.startswith("  mean of counted rows"))
        assert mean.split()[4] == f"{100 * (len(COUNTED) + 1) / len(COUNTED) / len(KINDS):.1f}"
        assert lines[-1].startswith("note: figures to be published are made with --frames 40 and --seed 1972")

    def test_one_json_object_and_nothing_that_the_function_prints(self, folder: Path) -> None:
        done = told("--with", "mine_a:names", "--json")
        found = json.loads(done.stdout)
        assert found["version"] == 1
        assert not found["standard"]
        (one,) = found["shapes"]
        assert one["shape"] == [16, 16]
        assert len(one["rows"]) == len(ROWS)
        assert one["rows"][0] == {
            "name": "clean",
            "counted": True,
            "frames": 26,
            "right": round(1 / 13, 6),
            "outline": round(4 / 13, 6),
            "unknown": 0.0,
            "sure_wrong": 0.0,
        }
        assert one["score"]["counted_rows"] == len(COUNTED)
        assert told("--with", "mine_a:names", "--json").stdout == done.stdout

    def test_what_compiled_code_prints_is_no_part_of_the_object_either(self, folder: Path) -> None:
        (folder / "mine_e.py").write_text(
            "import os\ndef names(frame):\n    os.write(1, b'RAW\\n')\n    return 'cone'\n"
        )
        command = [sys.executable, "-m", "varishold", "evaluate", "--distortions", "--shape", "16x16", "--frames", "1"]
        done = subprocess.run(
            [*command, "--json", "--with", "mine_e:names"], cwd=folder, capture_output=True, text=True, check=True
        )
        assert json.loads(done.stdout)["tested"] == "mine_e:names"
        assert "RAW" in done.stderr

    def test_the_shipped_names_are_the_default(self) -> None:
        assert told("--json").stdout == told("--with", "shipped", "--json").stdout

    def test_a_function_within_another_thing_is_found(self, folder: Path) -> None:
        assert told("--with", "mine_a:inner.names").exit_code == 0

    def test_what_cannot_be_scored_is_told_in_one_line(
        self, folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
    ) -> None:
        for words, message in (
            ("--with mine", "mine: name a function as package.module:function, without .py (--with)"),
            ("--with mine_a.py:names", "without .py (--with)"),
            ("--with=", "name a function as package.module:function"),
            ("--with mine_z:names", "there is no module mine_z, neither installed nor in this folder (--with)"),
            ("--with mine_a.b:names", "there is no module mine_a.b, "),
            ("--with mine_a:gone", "mine_a:gone: module mine_a has no gone (--with)"),
            ("--with mine_a:value", "mine_a:value: is no function but int (--with)"),
            ("--with mine_b:f", "importing mine_b raised ModuleNotFoundError: No module named 'no_such_thing'"),
            ("--with mine_c:f", "importing mine_c raised ZeroDivisionError: division by zero"),
            ("--with mine_d:f", "importing mine_d raised SyntaxError"),
            ("--with mine_a:nothing", "mine_a:nothing: an answer must be a name, or a mapping of names to"),
            ("--shape 9x9", "--shape must be 16x16, 32x32 or both, got '9x9'"),
            ("some.npz", "--distortions draws its own frames: leave out recordings"),
            ("--label thing", "--distortions draws its own frames: leave out --label"),
            ("--no-peers", "--distortions draws its own frames: leave out --no-peers"),
        ):
            asked = ["varishold", "evaluate", "--distortions", "--frames", "1", *words.split()]
            monkeypatch.setattr("sys.argv", asked)
            assert run() == 1
            said = capsys.readouterr().err
            assert message in said
            assert said.count("\n") == 1

    def test_its_options_are_for_it_alone(
        self, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
    ) -> None:
        for words, message in (
            ("some.npz --label thing --frames 3", "--frames is for --distortions alone"),
            ("some.npz --label thing --shape both", "--shape is for --distortions alone"),
        ):
            monkeypatch.setattr("sys.argv", ["varishold", "evaluate", *words.split()])
            assert run() == 1
            assert message in capsys.readouterr().err
        assert CliRunner().invoke(app, ["evaluate"]).exit_code == 2


def test_nothing_is_run_but_what_was_asked_for(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(folder)
    load_function("mine_a:names")
    assert not {"mine_b", "mine_c", "mine_d"} & set(sys.modules)


def test_the_example_of_the_page_is_scored(folder: Path) -> None:
    page = (Path(__file__).parents[1] / "docs" / "yardstick.md").read_text(encoding="utf-8")
    (block,) = re.findall(r"```python\n(.*?)```", page, re.DOTALL)
    (folder / "mine_page.py").write_text(block)
    done = told("--with", "mine_page:names", "--json")
    (found,) = json.loads(done.stdout)["shapes"]
    assert 0.2 < found["score"]["right"] < 0.6
    assert found["score"]["outline"] > 0.6
