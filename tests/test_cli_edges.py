"""The edges of the program: which commands there are, how errors and signals end it, what goes through unchanged."""

from __future__ import annotations

import errno
import io
import os
import signal
import sys
from importlib import import_module
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import click
import numpy as np
import pytest
from click.testing import CliRunner

from varishold.cli import app as program
from varishold.cli import interrupts, leaving, recordings
from varishold.cli.app import COMMAND_GROUPS, app
from varishold.cli.command import Commands
from varishold.cli.progress import progress_bar
from varishold.cli.touch import _keeping
from varishold.errors import InputError, Interrupted, MissingExtraError
from varishold.sensor import Sensor
from varishold.skin import Skin


def run(*words: str | Path) -> str:
    done = CliRunner().invoke(app, [str(word) for word in words])
    if done.exception is not None and not isinstance(done.exception, SystemExit):
        raise done.exception
    assert done.exit_code == 0, done.output
    return done.output


# Commands

NAMES = {
    "touch": {"touch", "touch export"},
    "perceive": {"perceive"},
    "objects": {"objects add", "objects feel", "objects list", "objects show", "objects taxels"},
    "grasp": {"grasp fit", "grasp predict", "grasp tables", "grasp export"},
    "paper": {"paper table"},
    "skin": {"skin press", "skin collect"},
    "sensor": {"sensor list", "sensor show", "sensor calibrate"},
    "hand": {"hand grasp", "hand collect"},
}


@pytest.mark.parametrize("group", NAMES)
def test_a_group_adds_its_commands(group: str) -> None:
    assert group in COMMAND_GROUPS
    alone = Commands()
    import_module(f"varishold.cli.{group}").register(alone)
    names = set()
    for name, command in alone.commands.items():
        if isinstance(command, Commands):
            names |= {f"{name} {sub}" for sub in command.commands}
            # Without a command a group shows its help.
            shown = CliRunner().invoke(alone, [name])
            assert shown.exit_code == 2
            assert command.help
            assert command.help in shown.stdout
        else:
            names.add(name)
    assert names == NAMES[group]


def test_words_are_two_only_where_a_command_has_two(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    told: list[Any] = []
    monkeypatch.setattr("varishold.cli.recordings.each_file", lambda files, work, heading: told.append(files))
    monkeypatch.setattr("varishold.cli.recordings.recording_files", lambda files: files)
    run("touch", "export.npz")
    run("touch", "./export", "more")
    assert told == [["export.npz"], ["./export", "more"]]
    assert "controller" in run("touch", "export", "--help")
    assert run("--version").startswith("varishold ")
    assert "Usage" in CliRunner().invoke(app, []).output


# How it ends


@pytest.mark.parametrize(
    ("raised", "status", "said"),
    [
        (InputError("a.csv: line 3\nis\tno number"), 1, "varishold: a.csv: line 3 is no number\n"),
        (MissingExtraError("install it"), 1, "varishold: install it\n"),
        (InputError("a\x1b[31mred"), 1, "varishold: a\\x1b[31mred\n"),
        (MemoryError(), 1, "varishold: not enough memory: ask for less at once\n"),
        (MemoryError("7 GB"), 1, "varishold: not enough memory: 7 GB\n"),
        (
            OSError(errno.ENOSPC, "No space left on device", "out.npz"),
            1,
            "varishold: out.npz: no space left on device\n",
        ),
        (OSError(errno.ENOSPC, "No space left on device"), 1, "varishold: standard output: no space left on device\n"),
        (OSError(errno.EFBIG, "File too large"), 1, "varishold: standard output: file too large\n"),
        (OSError("Odd"), 1, "varishold: odd\n"),
        (OSError("Failed to open '/Data/Ä.npz'"), 1, "varishold: failed to open '/Data/Ä.npz'\n"),
        (OSError(errno.EIO, "/Data/A is lost"), 1, "varishold: /Data/A is lost\n"),
        (BrokenPipeError(), 1, ""),
        (ModuleNotFoundError("No module named 'mujoco'", name="mujoco"), 1, None),
        (SystemExit(2), 2, ""),
        (SystemExit(None), 0, ""),
        (SystemExit("words"), 1, ""),
        (None, 0, ""),
    ],
)
def test_every_error_is_one_line_and_a_status(
    raised: BaseException | None, status: int, said: str | None, monkeypatch: pytest.MonkeyPatch
) -> None:
    silenced: list[int] = []

    def run_it(**_: Any) -> None:
        if raised is not None:
            raise raised

    out, err = io.StringIO(), io.StringIO()
    monkeypatch.setattr(program, "app", run_it)
    monkeypatch.setattr(program, "_silence", lambda: silenced.append(1))
    monkeypatch.setattr(sys, "stdout", out)
    monkeypatch.setattr(sys, "stderr", err)
    assert program.run() == status
    assert out.getvalue() == ""
    if said is None:
        assert err.getvalue().count("\n") == 1
        assert "pip install" in err.getvalue()
    else:
        assert err.getvalue() == said
    # Where the pipe is closed or the disk is full nothing more goes out.
    assert bool(silenced) == isinstance(raised, OSError)


def test_a_current_folder_that_is_gone_is_told(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "gone").mkdir()
    monkeypatch.chdir(tmp_path / "gone")
    (tmp_path / "gone").rmdir()
    monkeypatch.setattr(program, "app", lambda **_: os.getcwd())
    monkeypatch.setattr(program, "_silence", lambda: None)
    assert program.run() == 1
    assert capsys.readouterr().err == "varishold: the current folder: no such file or directory\n"


def test_a_module_that_is_no_extra_is_a_fault_of_ours(monkeypatch: pytest.MonkeyPatch) -> None:
    def run_it(**_: Any) -> None:
        raise ModuleNotFoundError("No module named 'varishold.nowhere'", name="varishold.nowhere")

    monkeypatch.setattr(program, "app", run_it)
    with pytest.raises(ModuleNotFoundError):
        program.run()


def test_closed_streams_are_nothing_and_a_poor_terminal_shows_codes(monkeypatch: pytest.MonkeyPatch) -> None:
    raw = io.BytesIO()
    shown = io.TextIOWrapper(raw, encoding="ascii")
    monkeypatch.setattr(program, "app", lambda **_: print("5 µm"))
    monkeypatch.setattr(sys, "stdout", shown)
    monkeypatch.setattr(sys, "stderr", None)
    assert program.run() == 0
    assert raw.getvalue() == b"5 \\xb5m\n"
    sys.stderr.close()
    monkeypatch.setattr(sys, "stdout", None)
    monkeypatch.setattr(sys, "stderr", io.StringIO())
    assert program.run() == 0
    sys.stdout.close()
    shown.detach()


def test_an_interruption_unwinds_once_and_ends_with_130(monkeypatch: pytest.MonkeyPatch) -> None:
    heard: list[Any] = []
    said: list[int] = []
    monkeypatch.setattr(interrupts, "listen", heard.append)
    monkeypatch.setattr(interrupts, "leave_at_once", lambda: heard.append("at once"))
    monkeypatch.setattr(interrupts, "say_interrupted", lambda: said.append(1))
    hook = sys.unraisablehook
    with interrupts.interruptible() as ended:
        (interrupt,) = heard
        assert sys.unraisablehook is not hook
        interrupt(signal.SIGINT)
    # A second Ctrl-C while it unwinds ends the process where it stands.
    assert heard[1:-1] == ["at once", "at once"]
    # And after it was said, without a second word.
    status: list[int] = []
    monkeypatch.setattr("os._exit", status.append)
    heard[-1](signal.SIGINT, None)
    assert status == [130]
    assert (ended.status, said, sys.unraisablehook) == (130, [1], hook)
    heard.clear()
    with interrupts.interruptible() as quiet:
        pass
    assert (quiet.status, said, heard[1:]) == (0, [1], ["at once"])
    with pytest.raises(ValueError, match="own"), interrupts.interruptible():
        raise ValueError("own")
    assert sys.unraisablehook is hook
    # What cannot be raised there ends it there.
    left: list[int] = []
    passed: list[Any] = []
    monkeypatch.setattr(interrupts, "leave", lambda *_: left.append(1))
    monkeypatch.setattr(sys, "__unraisablehook__", passed.append)
    with interrupts.interruptible():
        for kind in (ValueError, Interrupted):
            sys.unraisablehook(SimpleNamespace(exc_type=kind))  # type: ignore[arg-type]
    assert (left, len(passed)) == ([1], 2)


def test_leaving_says_one_line_and_ends_with_130(monkeypatch: pytest.MonkeyPatch) -> None:
    written: list[Any] = []
    monkeypatch.setattr(leaving.os, "write", lambda *what: written.append(what))
    monkeypatch.setattr(leaving, "_exit", written.append)
    leaving.leave(signal.SIGINT, None)
    assert written == [(2, b"varishold: interrupted\n"), 130]

    def closed(*what: Any) -> None:
        raise OSError("closed")

    monkeypatch.setattr(leaving.os, "write", closed)
    leaving.say_interrupted()
    set_: list[Any] = []
    monkeypatch.setattr(leaving.signal, "signal", lambda *what: set_.append(what))
    for before, told in ((signal.SIG_DFL, 1), (signal.SIG_IGN, 0)):
        monkeypatch.setattr(leaving.signal, "getsignal", lambda _, before=before: before)
        leaving.leave_at_once()
        assert set_ == [(number, leaving.leave) for number in leaving.ENDING] * told
        set_.clear()

    def elsewhere(*what: Any) -> None:
        raise ValueError("main thread only")

    monkeypatch.setattr(leaving.signal, "getsignal", lambda _: signal.SIG_DFL)
    monkeypatch.setattr(leaving.signal, "signal", elsewhere)
    leaving.listen(signal.SIG_IGN)
    last: list[Any] = []
    monkeypatch.setattr(leaving.atexit, "register", lambda *what: last.append(what))
    leaving.finish_undisturbed()
    assert last == [(leaving.listen, signal.SIG_IGN, (signal.SIGINT,))]


def test_the_program_hears_ctrl_c_from_its_beginning_to_its_end(monkeypatch: pytest.MonkeyPatch) -> None:
    import varishold.cli as package

    done: list[Any] = []
    monkeypatch.setattr(package, "leave_at_once", lambda: done.append("leave at once"))
    monkeypatch.setattr(package, "finish_undisturbed", lambda: done.append("undisturbed"))
    monkeypatch.setattr(program, "run", lambda: 7)
    monkeypatch.delenv("JOBLIB_MULTIPROCESSING", raising=False)
    with pytest.raises(SystemExit) as left:
        package.main()
    assert left.value.code == 7
    assert done == ["leave at once", "undisturbed"]
    # No process of joblib's is started, unless somebody says so.
    assert package.os.environ["JOBLIB_MULTIPROCESSING"] == "0"
    monkeypatch.setenv("JOBLIB_MULTIPROCESSING", "1")
    with pytest.raises(SystemExit):
        package.main()
    assert package.os.environ["JOBLIB_MULTIPROCESSING"] == "1"


# Several files


def test_one_bad_file_of_several_does_not_stop_the_rest(capsys: pytest.CaptureFixture[str]) -> None:
    done: list[str] = []

    def work(file: str) -> None:
        done.append(file)
        if file.startswith("bad"):
            raise InputError(f"{file}: is odd" if file == "bad1" else "line 3\nis odd")

    with pytest.raises(click.exceptions.Exit) as left:
        recordings.each_file(["a", "bad1", "bad2", "b"], work, heading=True)
    assert left.value.exit_code == 1
    assert done == ["a", "bad1", "bad2", "b"]
    out, err = capsys.readouterr()
    assert out.splitlines() == ["a:", "bad1:", "bad2:", "b:"]
    assert err.splitlines() == ["varishold: bad1: is odd", "varishold: bad2: line 3 is odd"]
    recordings.each_file(["a", "b"], done.append)
    recordings.each_file(["a"], done.append, heading=True)
    assert capsys.readouterr() == ("", "")
    with pytest.raises(InputError, match="bad1: is odd"):
        recordings.each_file(["bad1"], work)


def test_a_sensor_is_the_named_one_or_the_one_beside(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("varishold.sensor.finding.sensor_of", lambda name: ("named", name))
    monkeypatch.setattr("varishold.sensor.finding.find_sensor_file", lambda file: "s.toml" if file == "a.npz" else None)
    monkeypatch.setattr("varishold.sensor.finding.read_sensor", lambda path: ("read", path))
    assert recordings.sensor_for("a.npz", "weiss") == ("named", "weiss")
    assert recordings.sensor_for("a.npz", None) == ("read", "s.toml")
    monkeypatch.setattr("varishold.sensor.finding.sensor_inside", lambda file: ("inside", file))
    assert recordings.sensor_for("b.npz", None) == ("inside", "b.npz")
    assert recordings.sensor_beside("b.npz", None) is None


def test_what_a_recording_leaves_unsaid_its_sensor_says(tmp_path: Path) -> None:
    np.save(tmp_path / "a.npy", np.arange(40.0).reshape(2, 20))
    plain = recordings.read_recording(str(tmp_path / "a.npy"), None, shape=(4, 5), pitch_m=2e-3)
    assert plain.pads["pad"].shape == (4, 5)
    assert plain.pads["pad"].pitch_m == (2e-3, 2e-3)
    sensor = Sensor(shape=(2, 10), span=1.0, polarity="down", name="mat")
    known = recordings.read_recording(str(tmp_path / "a.npy"), sensor)
    assert known.pads["pad"].shape == (2, 10)
    assert known.pads["pad"].polarity == "down"
    assert known.notes == ("read with the sensor mat",)
    assert recordings.read_recording(str(tmp_path / "a.npy"), sensor, shape=(5, 4)).pads["pad"].shape == (5, 4)


# Touch


def test_touch_recognizes_as_its_options_say(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    told: dict[str, Any] = {}
    beside = Sensor(span=1.0, cover=Skin("layer", 2e-3, 0.45, 1e-3))

    def recognize(recording: Any, **how: Any) -> Any:
        told.update(how, recording=recording)
        return iter(("answer 1", "answer 2"))

    def read(file: str, sensor: Any, **how: Any) -> str:
        told.update(read=(file, sensor, how))
        return "recording"

    def shown(answers: Any, recording: Any, *, json: bool) -> None:
        told.update(shown=(list(answers), recording, json))

    monkeypatch.setattr("varishold.touch.recognize_recording", recognize)
    monkeypatch.setattr("varishold.cli.recordings.read_recording", read)
    monkeypatch.setattr("varishold.cli.recordings.sensor_for", lambda file, named: beside if named == "mat" else None)
    monkeypatch.setattr("varishold.cli.printing.print_answers", shown)
    monkeypatch.setattr(
        "varishold.report.write_touch_report", lambda path, kept, **how: told.update(page=(path, kept, how))
    )
    monkeypatch.setattr("varishold.skin.read_skin", lambda path: Skin("half-space"))
    path = tmp_path / "a.npz"
    path.write_bytes(b"")
    run("touch", path)
    assert told["read"] == (str(path), None, {"shape": None, "pitch_m": None})
    assert (told["frames"], told["levels"], told["skin"], told["exact"], told["sensor"]) == (
        "peak", 32, None, False, None,
    )  # fmt: skip
    assert told["shown"] == (["answer 1", "answer 2"], "recording", False)
    assert "page" not in told
    words = [
        "--frames",
        "all",
        "--levels",
        "12",
        "--exact",
        "--sensor",
        "mat",
        "--pitch-m",
        "2e-3",
        "--shape",
        "4x5",
        "--json",
    ]
    page, skin = tmp_path / "p.html", tmp_path / "skin.toml"
    skin.write_text("")
    assert run("touch", path, *words, "--report", page) == ""
    assert told["read"] == (str(path), beside, {"shape": (4, 5), "pitch_m": 2e-3})
    assert (told["frames"], told["levels"], told["exact"], told["sensor"]) == ("all", 12, True, beside)
    # The cover of the sensor, or the skin that is named.
    assert told["skin"] is beside.cover
    assert told["page"] == (page, ["answer 1", "answer 2"], {"recording": "recording", "skin": str(beside.cover)})
    assert told["shown"][2]
    assert run("touch", path, "--sensor", "mat", "--skin", skin, "--report", page) == f"report: {page}\n"
    assert told["skin"] == Skin("half-space")
    with pytest.raises(InputError, match=r"fitting forms through the skin needs a skin, or .skin. in a sensor file"):
        run("touch", path, "--exact")
    (tmp_path / "b.npz").write_bytes(b"")
    with pytest.raises(InputError, match="a report shows one recording; name one file"):
        run("touch", path, tmp_path / "b.npz", "--report", page)
    kept: list[Any] = []
    assert list(_keeping(iter("abc"), kept)) == kept == ["a", "b", "c"]


def test_an_export_asks_before_it_replaces_and_never_takes_its_inputs(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    told: dict[str, Any] = {}
    checked: list[Any] = []

    def write(wanted: Any, to: str, folder: Path, *, check: Any) -> list[Path]:
        told.update(wanted=wanted, to=to, folder=folder)
        check(folder / "pad.c")
        return [folder / "pad.c", folder / "pad.h"]

    monkeypatch.setattr("varishold.touch.writers.export", write)
    monkeypatch.setattr("varishold.files.check_output", lambda path, kind, **how: checked.append((path, kind, how)))
    monkeypatch.setattr("varishold.sensor.sensor_of", lambda name: Sensor(shape=(8, 9), span=2.0))
    out = tmp_path / "c"
    said = f"{out}: 2 files; README.md says what each is and how to build them\n"
    assert run("touch", "export", "--to", "c", "-o", out) == said
    assert (told["to"], told["folder"], told["wanted"].rows_and_cols, told["wanted"].levels) == ("c", out, (16, 16), 32)
    assert (told["wanted"].contacts, told["wanted"].weights, told["wanted"].sensor) == (2, "int8", None)
    assert checked == [(out / "pad.c", "source", {"inputs": [], "force": False})]
    sensor = tmp_path / "s.toml"
    sensor.write_text("")
    words = ["--levels", "9", "--contacts", "5", "--weights", "float32", "--force", "--sensor"]
    run("touch", "export", "--to", "c", "-o", out, *words, sensor)
    assert (told["wanted"].levels, told["wanted"].contacts, told["wanted"].weights) == (9, 5, "float32")
    assert told["wanted"].rows_and_cols == (8, 9)
    assert checked[-1][2] == {"inputs": [str(sensor)], "force": True}
    # A preset's name is no file.
    run("touch", "export", "--to", "c", "-o", out, "--sensor", "mat", "--shape", "8x9")
    assert checked[-1][2] == {"inputs": [], "force": False}


# The paper


def test_table_5_is_made_as_its_options_say(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    pytest.importorskip("mujoco", reason="MuJoCo is not installed; pip install -e '.[sim]'")
    told: dict[str, Any] = {}

    class Result:
        rows = ({"a": 1},)

        def __str__(self) -> str:
            return "the table"

        def to_dicts(self) -> Any:
            return iter(({"b": 2}, {"c": 3}))

    def made(name: str) -> Any:
        def make(**how: Any) -> Any:
            how.pop("progress")(1, 2)
            told.update(how, made=name)
            return Result()

        return make

    monkeypatch.setattr("varishold.paper.table5.table_5", made("table"))
    monkeypatch.setattr("varishold.paper.finger_length.finger_length_sweep", made("sweep"))
    monkeypatch.setattr("varishold.paper.table5.as_paper_table", lambda result: result)
    monkeypatch.setattr(
        "varishold.report.finger_length.draw_finger_lengths", lambda rows, path: told.update(drawn=(rows, path))
    )
    assert run("paper", "table", "5") == "the table\n"
    assert told == {"seed": 0, "grasps": 20, "repetitions": 2, "processes": None, "made": "table"}
    words = ["--seed", "4", "--grasps", "3", "--repetitions", "5", "--processes", "2", "--json"]
    assert run("paper", "table", "5", *words) == '{"a": 1}\n'
    assert told == {"seed": 4, "grasps": 3, "repetitions": 5, "processes": 2, "made": "table"}
    path = tmp_path / "f.png"
    assert run("paper", "table", "5", "--finger-length", path) == f"the table\nfigure: {path}\n"
    assert (told["made"], told["drawn"]) == ("sweep", ([{"b": 2}, {"c": 3}], path))
    assert run("paper", "table", "5", "--finger-length", path, "--json") == '{"b": 2}\n{"c": 3}\n'
    with pytest.raises(InputError, match="--finger-length belongs to Table 5, got Table 4"):
        run("paper", "table", "4", "--finger-length", path)


# Bars


def test_a_bar_is_shown_on_a_terminal_only(monkeypatch: pytest.MonkeyPatch) -> None:
    with progress_bar("work", 3) as update:
        update(advance=1)
    done: list[Any] = []

    class Bar:
        def __init__(self, *columns: Any, console: Any) -> None:
            done.append(("made", len(columns), console.stderr))

        def __enter__(self) -> Bar:
            return self

        def __exit__(self, *how: Any) -> None:
            done.append("closed")

        def add_task(self, what: str, total: int | None) -> int:
            done.append((what, total))
            return 7

        def update(self, task: int, **how: Any) -> None:
            done.append((task, how))

    monkeypatch.setattr("rich.progress.Progress", Bar)
    monkeypatch.setattr("sys.stderr", SimpleNamespace(isatty=lambda: True))
    with progress_bar("work", 3) as update:
        update(advance=1)
        update(completed=2, total=3)
    assert done == [
        ("made", 4, True), ("work", 3), (7, {"advance": 1}), (7, {"completed": 2, "total": 3}), "closed",
    ]  # fmt: skip


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("shape = [3, 4]", r"has frames of 4 x 4, not 3 x 4, which is the shape of the sensor "),
        ("gain_map = [[1, 2], [3, 4]]", r"has frames of 4 x 4, not 2 x 2, which is the shape of the sensor "),
        (
            "rest = 900",
            r"s\.toml: says rest 900, but .*p\.npz lies below that nearly everywhere, its first frame near 0",
        ),
    ],
)
def test_a_sensor_of_another_shape_or_rest_is_told_as_the_sensor_s(tmp_path: Path, text: str, told: str) -> None:
    frames = np.zeros((12, 4, 4))
    frames[6:, 1:3, 1:3] = 200.0
    np.savez(tmp_path / "p.npz", pressure=frames)
    (tmp_path / "s.toml").write_text(text)
    with pytest.raises(InputError, match=told) as raised:
        run("touch", tmp_path / "p.npz", "--sensor", tmp_path / "s.toml")
    assert "leave the shape out" not in str(raised.value)


def test_a_sensor_s_pitch_in_millimetres_is_asked_about(tmp_path: Path) -> None:
    frames = np.zeros((2, 8, 8))
    frames[1, 2:5, 2:5] = 200.0
    np.savez(tmp_path / "p.npz", pressure=frames)
    (tmp_path / "s.toml").write_text("pitch_m = 2")
    assert "is the pitch in millimetres?" in run("touch", tmp_path / "p.npz", "--sensor", tmp_path / "s.toml")


@pytest.mark.parametrize(
    "words",
    [
        ("touch", "export", "--to", "c", "-o", ""),
        ("touch", "export", "--to", "c", "--output="),
        ("grasp", "export", "m.json", "--to", "c", "--output", ""),
    ],
)
def test_a_folder_of_no_name_is_not_the_current_one(
    words: tuple[str, ...], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    done = CliRunner().invoke(app, list(words))
    assert done.exit_code == 2
    assert "names nothing" in done.output
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    "words",
    [
        ("touch", ""),
        ("touch", "a.csv", ""),
        ("info", ""),
        ("validate", ""),
        ("measure", "", "-o", "t.parquet"),
        ("learn", "", "--label", "folder", "-o", "m.npz"),
        ("evaluate", "", "--label", "folder"),
        ("convert", "", "b.npz"),
        ("replay", ""),
    ],
)
def test_a_recording_of_no_name_is_not_the_current_folder(
    words: tuple[str, ...], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    np.savez("a.npz", pressure=np.ones((2, 8, 8)))
    with pytest.raises(InputError, match=r"'' names no file; '\.' is the current folder"):
        run(*words)
    assert [each.name for each in tmp_path.iterdir()] == ["a.npz"]


@pytest.mark.parametrize("command", ["touch", "validate", "info"])
def test_of_several_the_folder_without_a_file_is_told_and_the_others_are_done(tmp_path: Path, command: str) -> None:
    frames = np.zeros((2, 8, 8))
    frames[1, 2:5, 2:5] = 200.0
    np.savez(tmp_path / "p.npz", pressure=frames)
    (tmp_path / "empty.npz").mkdir()
    done = CliRunner().invoke(app, [command, str(tmp_path / "empty.npz"), str(tmp_path / "p.npz")])
    assert done.exit_code == 1
    assert "p.npz" in done.stdout
    assert "empty.npz: is a folder" in done.output
