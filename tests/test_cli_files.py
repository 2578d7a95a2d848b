"""What commands read and write: an output is never an input, nothing foreign is replaced, several files are as one."""

from __future__ import annotations

import glob
import json
import os
import re
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, get_type_hints
from zipfile import ZipFile

import click
import numpy as np
import pytest
from tests.pressed_things import recording as pressed

from varishold.cli.app import app
from varishold.cli.command import Commands
from varishold.cli.files import Reads, Writes
from varishold.cli.recordings import recording_files
from varishold.errors import InputError
from varishold.files import KINDS, atomic_write, check_output, input_files, only_writer
from varishold.perceive import shipped_library, write_library
from varishold.recording import GraspTable, Pad, Recording, read_grasp_table, write, write_grasp_table
from varishold.sensor import Sensor, map_files, write_sensor


def commands() -> Iterator[tuple[str, click.Command]]:
    for name, command in app.commands.items():
        inner = command.commands if isinstance(command, Commands) else {"": command}
        for second, each in inner.items():
            assert each.callback is not None
            yield f"{name} {second}".strip(), each


COMMANDS = dict(commands())


@pytest.mark.parametrize("name", COMMANDS)
def test_every_path_of_every_command_is_said_to_be_read_or_written(name: str) -> None:
    command = COMMANDS[name]
    hints = get_type_hints(command.callback, include_extras=True)
    for parameter, hint in hints.items():
        marks = [mark for mark in getattr(hint, "__metadata__", ()) if isinstance(mark, Reads | Writes)]
        assert len(marks) <= 1
        if "Path" in str(hint):
            assert marks, f"{name}: {parameter} is neither Reads nor Writes"
        for mark in marks:
            if isinstance(mark, Writes):
                assert mark.kind in KINDS
                # A command that names its files itself, by the time, never meets one that is there.
                assert (
                    "force"
                    in {
                        each.name
                        for each in command.get_params(click.Context(command, help_option_names=["-h", "--help"]))
                    }
                    or name == "live"
                )


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    rng = np.random.default_rng(0)
    press = 9 * np.outer(np.hanning(8), np.hanning(8))
    write(Recording({"pad": Pad(rng.random((2, 8, 8)) + press, pitch_m=1e-3)}), tmp_path / "in.npz")
    switches = {f"switch.{k}": rng.random(20) < 0.5 for k in range(6)}
    write_grasp_table(GraspTable({"object": np.repeat(["cone", "cube"], 10), **switches}), tmp_path / "in.csv")
    (tmp_path / "skin.toml").write_text('[skin]\nkind = "half-space"\n')
    (tmp_path / "in.stl").write_text("solid")
    (tmp_path / "hand.toml").write_text('mjcf = "hand.xml"\n')
    np.save(tmp_path / "map.npy", np.zeros((4, 4)))
    return tmp_path


WRITERS = {
    "touch": (("touch", "in.npz", "--skin", "skin.toml", "--report"), ("in.npz", "skin.toml")),
    "touch table": (("touch", "in.npz", "--skin", "skin.toml", "-o"), ("in.npz", "skin.toml")),
    "measure": (("measure", "in.npz", "-o"), ("in.npz",)),
    "learn": (("learn", "in.npz", "--label", "folder", "-o"), ("in.npz",)),
    "recognize": (("recognize", "in.npz", "in.npz", "-o"), ("in.npz",)),
    "evaluate": (("evaluate", "in.npz", "--label", "folder", "--report"), ("in.npz",)),
    "grasp fit": (("grasp", "fit", "in.csv", "--label", "object", "-o"), ("in.csv",)),
    "skin press": (("skin", "press", "map.npy", "--skin", "skin.toml", "-o"), ("map.npy", "skin.toml")),
    "skin press picture": (("skin", "press", "map.npy", "--skin", "skin.toml", "--picture"), ("map.npy", "skin.toml")),
    "skin collect": (("skin", "collect", "--skin", "skin.toml", "--count", "1", "-o"), ("skin.toml",)),
    "perceive": (("perceive", "sphere", "--size-m", "0.07", "--library", "in.npz", "--report"), ("in.npz",)),
    "perceive mesh": (("perceive", "in.stl", "--report"), ("in.stl",)),
    "objects add": (("objects", "add", "in.stl", "--library"), ("in.stl",)),
    "objects feel": (("objects", "feel", "--hand", "hand.toml", "-o"), ("hand.toml",)),
    "objects taxels": (("objects", "taxels", "noise=.03", "--library", "in.npz", "-o"), ("in.npz",)),
    "hand collect": (("hand", "collect", "--objects", "cylinder", "-o"), ()),
    "hand grasp": (("hand", "grasp", "cylinder", "--size-m", "0.09", "--picture"), ()),
    "hand grasp pads": (("hand", "grasp", "cylinder", "--size-m", "0.09", "--pads"), ()),
    "paper table": (("paper", "table", "5", "--finger-length"), ()),
    "record": (("record", "replay:in.npz?speed=0", "-o"), ("in.npz",)),
    "convert": (("convert", "in.npz"), ("in.npz",)),
    "demo": (("demo", "touch", "--report"), ()),
    "sensor calibrate": (("sensor", "calibrate", "in.npz", "--kind", "even", "-o"), ("in.npz",)),
}


def test_every_command_that_writes_is_tried_here() -> None:
    writing = {
        name
        for name, command in COMMANDS.items()
        if any(
            isinstance(m, Writes)
            for h in get_type_hints(command.callback, include_extras=True).values()
            for m in getattr(h, "__metadata__", ())
        )
    }
    known = {*WRITERS, "grasp export", "touch export", "live"}
    assert all(any(each.startswith(name) for each in known) for name in writing), writing


@pytest.mark.parametrize("name", WRITERS)
def test_no_command_writes_over_what_it_reads_or_over_anything_foreign(run: Any, folder: Path, name: str) -> None:
    words, inputs = WRITERS[name]
    for read in inputs:
        os.symlink(folder / read, folder / "link.png")
        os.link(folder / read, folder / "hard.png")
        before = (folder / read).read_bytes()
        for written in (read, f"../{folder.name}/{read}", "link.png", "hard.png"):
            for force in ((), ("--force",)):
                status, _, told = run(*words, written, *force)
                assert status == 1
                assert "is read by this very call" in told
                assert told.count("\n") == 1
        assert (folder / read).read_bytes() == before
        (folder / "link.png").unlink()
        (folder / "hard.png").unlink()
    (folder / "mine.png").write_bytes(b"PK my own words <!doctype html>")
    status, _, told = run(*words, "mine.png")
    assert status == 1
    assert "is there, and is no" in told
    assert "(--force)" in told
    assert (folder / "mine.png").read_bytes() == b"PK my own words <!doctype html>"


def test_a_second_run_replaces_its_own_output(run: Any, folder: Path) -> None:
    for words in (
        ("grasp", "fit", "in.csv", "--label", "object", "-o", "model.json"),
        ("grasp", "export", "model.json", "--to", "verilog", "-o", "src"),
        ("grasp", "export", "model.json", "--to", "c", "-o", "src"),
        ("grasp", "export", "model.json", "--to", "json", "-o", "src"),
        ("touch", "in.npz", "--report", "page.html"),
        ("touch", "in.npz", "--workers", "1", "-o", "names.parquet"),
    ):
        for _ in range(2):
            status, _, told = run(*words)
            assert status == 0, told


@pytest.mark.parametrize("words", [("taxels", "noise=.03"), ("feel", "--examples", "10")])
def test_a_library_that_was_felt_is_not_replaced_unasked(run: Any, folder: Path, words: tuple[str, ...]) -> None:
    with ZipFile(folder / "felt.npz", "w") as made:
        made.comment = b"varishold library"
    before = (folder / "felt.npz").read_bytes()
    status, _, told = run("objects", *words, "-o", "felt.npz")
    assert status == 1
    own = {"taxels": "library that objects taxels made", "feel": "file that may be replaced unasked"}[words[0]]
    assert f"felt.npz: is there, and is no {own}" in told
    assert "(--force)" in told
    assert (folder / "felt.npz").read_bytes() == before


def test_what_may_be_replaced_by_force_is_said_by_help(run: Any) -> None:
    assert "Replace a file that is there." in run("objects", "feel", "--help")[1]
    assert "Replace a file that this command did not make." in run("objects", "taxels", "--help")[1]


def test_an_export_is_never_its_model_and_keeps_what_is_foreign(run: Any, folder: Path) -> None:
    run("grasp", "fit", "in.csv", "--label", "object", "-o", "model.json")
    model = (folder / "model.json").read_bytes()
    status, _, told = run("grasp", "export", "model.json", "--to", "json", "-o", ".")
    assert (status, told.count("\n")) == (1, 1)
    assert "is read by this very call" in told
    assert (folder / "model.json").read_bytes() == model
    (folder / "model.c").write_text("int mine;\n")
    status, _, told = run("grasp", "export", "model.json", "--to", "c", "-o", ".")
    assert status == 1
    assert "is no exported circuit" in told
    assert not (folder / "model.h").exists()
    assert run("grasp", "export", "model.json", "--to", "c", "-o", ".", "--force")[0] == 0


def test_an_exported_header_says_how_a_number_becomes_a_count(run: Any, folder: Path) -> None:
    rows = [f"{'ab'[k % 2]},{0.013 * k + k % 2}" for k in range(20)]
    (folder / "loads.csv").write_text("\n".join(["object,force_n.tip", *rows]))
    words = ("--label", "object", "--columns", "force_n.*", "--encode", "even", "-o", "loads.json")
    assert run("grasp", "fit", "loads.csv", *words)[0] == 0
    for to in ("c", "verilog", "json"):
        assert run("grasp", "export", "loads.json", "--to", to, "-o", to)[0] == 0
    for text in ((folder / "c" / "loads.h").read_text(), (folder / "verilog" / "loads.v").read_text()):
        assert re.search(r": force_n\.tip in whole steps of [0-9.e-]+, rounded down", text)
    assert json.loads((folder / "json" / "loads.json").read_text())["channels"] == ["force_n.tip"]


@pytest.mark.parametrize("command", ["learn", "evaluate"])
def test_commands_that_ask_for_no_shape_name_the_sensor_file(run: Any, folder: Path, command: str) -> None:
    (folder / "flat.csv").write_text("label,t_0,t_1,t_2,t_3\n" + "cup,1,2,3,4\ncan,4,3,2,1\n" * 4)
    status, _, told = run(
        command, "flat.csv", "--label", "label", *(["-o", "things.npz"] if command == "learn" else [])
    )
    assert status == 1
    assert told.endswith("NAME.ROW.COLUMN; in a sensor file: shape = [ROWS, COLUMNS] (--sensor)\n")
    assert "ROWSxCOLS" not in told


def test_what_plays_a_file_is_told_its_shape_in_its_address(run: Any, folder: Path) -> None:
    (folder / "flat.csv").write_text("1,2,3,4\n4,3,2,1\n")
    for words in (("record", "replay:flat.csv", "-o", "out.npz"), ("live", "replay:flat.csv", "--json")):
        status, _, told = run(*words)
        assert status == 1
        assert told.endswith(" (replay:FILE?shape=ROWSxCOLS)\n")
    # A source that says so itself says it once.
    assert run("record", "stdin:?dtype=uint16", "-o", "out.npz")[2].endswith(
        ": bare numbers need their shape, as in shape=16x16\n"
    )
    assert run("record", "replay:flat.csv?shape=2x2", "-o", "out.npz")[0] == 0


def test_several_files_folders_and_patterns_are_as_one(run: Any, folder: Path) -> None:
    (folder / "many").mkdir()
    for name in ("a.npz", "b.npz"):
        (folder / "many" / name).write_bytes((folder / "in.npz").read_bytes())
    (folder / "bad.csv").write_text("1,2\n3,4\n")
    status, out, told = run("touch", "many", "bad.csv", "in.n*", "--json")
    assert status == 1
    assert told.count("\n") == 1
    assert told.startswith("varishold: bad.csv: ")
    assert "(--shape ROWSxCOLS)" in told
    assert list(dict.fromkeys(json.loads(line)["file"] for line in out.splitlines())) == [
        "many/a.npz",
        "many/b.npz",
        "in.npz",
    ]


def test_a_model_is_learned_from_several_tables_as_from_one(run: Any, folder: Path) -> None:
    head, *rows = (folder / "in.csv").read_text().splitlines()
    (folder / "parts").mkdir()
    for name, part in (("1.csv", rows[:7]), ("2.csv", rows[7:])):
        (folder / "parts" / name).write_text("\n".join([head, *part]))
    learned = set()
    for tables in (["in.csv"], ["parts"], ["parts/*.csv"], ["parts/1.csv", "parts/2.csv"]):
        assert run("grasp", "fit", *tables, "--label", "object", "-o", "model.json")[0] == 0
        learned.add((folder / "model.json").read_text())
    assert len(learned) == 1
    (folder / "parts" / "2.csv").write_text(f"{head}\ncone,1,2,0,0,0,0\n")
    status, _, told = run("grasp", "fit", "parts", "--label", "object", "-o", "model.json")
    assert status == 1
    assert "parts/2.csv: line 2, column 'switch.1' must be 0 or 1" in told


def test_input_files(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    for name in ("b.csv", "a.csv", "c.txt", "[x].csv", "in/d.csv", "in/.hidden.csv"):
        Path(name).parent.mkdir(exist_ok=True)
        Path(name).write_text("1")
    assert input_files(["-", "b.csv", "*.csv", "b.csv"]) == ["-", "b.csv", "[x].csv", "a.csv"]
    assert input_files(["[x].csv"]) == ["[x].csv"]
    assert input_files(["in"], endings=(".csv",)) == ["in/d.csv"]
    assert input_files(["**/*.csv"])[-1] == "in/d.csv"
    for name, message in (("*.npz", "no file matches"), ("in", "without a file to read")):
        with pytest.raises(InputError, match=message):
            input_files([name], endings=(".npz",))


def test_of_a_folder_recordings_are_read_and_what_was_made_of_them_is_left_out(
    run: Callable[..., Any], tmp_path: Path
) -> None:
    """A model, a table and the maps of a sensor lie where the recordings are; who names one of them means it."""
    folder = tmp_path / "day"
    folder.mkdir()
    recording = pressed(["disc", "bar"] * 6, 3)
    write(recording, folder / "a.npz")
    gain = np.ones(recording.pads["pad"].shape)
    gain[2, 3] = 0.8
    write_sensor(Sensor(shape=(13, 15), gains=gain), folder / "mat.toml")
    assert run("learn", folder / "a.npz", "--label", "thing", "-o", folder / "things.npz")[0] == 0
    assert run("measure", folder / "a.npz", "-o", folder / "table.parquet", "--workers", 1)[0] == 0
    write_library(shipped_library().only(["sphere", "box"]), folder / "felt.npz")
    (folder / "grasps.csv").write_text(
        "object,size_m,seed,step,held,attempts,finger_scale,switch.a\ncone,.1,0,5,1,1,1,0\n"
    )
    status, said, told = run("info", "day")
    assert (status, said) == run("info", "day/a.npz")[:2]
    assert "and 1 more left out" in told
    for name in ("felt.npz", "grasps.csv", "mat.gains.csv", "table.parquet"):
        assert f"day/{name}" in told
    assert "left out: no recordings, but what was made of them" in told
    for name, what in (("things.npz", "learned model of this program"), ("table.parquet", "table of this program")):
        assert run("info", f"day/{name}")[2] == f"varishold: day/{name}: is a {what}, and no recording\n"
    (folder / "table.parquet").unlink()
    assert "day/things.npz" in run("info", "day")[2]
    (folder / "a.npz").unlink()
    assert "is a folder without a file to read" in run("info", "day")[2]


def test_a_pattern_that_goes_round_by_links_finds_each_file_once(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    for place in ("a/x.npz", "a/b/y.npz", "c/z.npz"):
        Path(place).parent.mkdir(parents=True, exist_ok=True)
        Path(place).write_text("1")
    os.symlink("..", "a/b/up")
    os.symlink("../a", "c/over")
    os.symlink("../c", "a/over")
    os.symlink("x.npz", "a/link.npz")
    plain = ["a/b/y.npz", "a/link.npz", "a/x.npz", "c/z.npz"]
    found = input_files(["**/*.npz"])
    assert set(plain) < set(found) <= {*plain, "a/over/z.npz", "c/over/b/y.npz", "c/over/link.npz", "c/over/x.npz"}
    assert input_files(["a/**/*.npz"]) == [name for name in found if name.startswith("a/")]


def test_a_recording_of_several_names_is_read_by_its_first_and_the_others_are_told(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    for name in ("day/a.npz", "day/b.npz"):
        Path(name).parent.mkdir(exist_ok=True)
        Path(name).write_bytes(name.encode())
    os.symlink("a.npz", "day/link.npz")
    os.symlink("day", "week")
    os.link("day/b.npz", "hard.npz")
    assert recording_files(["day", "week/a.npz", "hard.npz", "./day/b.npz", "none.npz", "none.npz"]) == [
        "day/a.npz",
        "day/b.npz",
        "none.npz",
    ]
    named = "day/link.npz, week/a.npz, hard.npz, ./day/b.npz"
    told = capsys.readouterr().err
    assert told == f"varishold: note: {named} left out: files that are read by another name\n"
    assert recording_files(["day/b.npz", "day/a.npz"]) == ["day/b.npz", "day/a.npz"]
    assert capsys.readouterr().err == ""


def test_without_links_a_pattern_finds_what_glob_does(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    for place in ("a/x.npz", "a/b/y.npz", "a/.hidden/z.npz", ".away/w.npz", "c d/e[1].npz", "c d/.f.npz", "top.csv"):
        Path(place).parent.mkdir(parents=True, exist_ok=True)
        Path(place).write_text("1")
    patterns = [
        "**",
        "**/*.npz",
        "*",
        "*/*",
        "a/**",
        "a/**/y*",
        "*.csv",
        "c d/*",
        "c d/.*",
        "?/*",
        "**/b/*",
        "[ac]*/**/*",
    ]
    for pattern in [*patterns, *(str(tmp_path / each) for each in patterns), "a/../a/*.npz"]:
        expected = sorted(name for name in glob.glob(pattern, recursive=True) if Path(name).is_file())
        assert sorted(input_files([pattern])) == expected, pattern


@pytest.mark.parametrize(
    ("text", "taken"), [("left hand, with glove\n- second try\n", False), ("# counts\n0 1\n", True), ("", True)]
)
def test_notes_in_words_beside_recordings_are_left_out(
    run: Callable[..., Any], tmp_path: Path, text: str, taken: bool
) -> None:
    (tmp_path / "day").mkdir()
    write(pressed(["disc", "bar"] * 6, 3), tmp_path / "day/a.npz")
    for encoding in ("utf-8", "utf-16"):
        (tmp_path / "day/Notes.TXT").write_text(text, encoding=encoding)
        status, _, told = run("info", "day")
        assert ("day/Notes.TXT left out: no recordings, but text without a line of numbers" in told) is not taken
        assert (status == 0) is not taken


def test_what_may_be_written(tmp_path: Path) -> None:
    for name, message in {
        "no/where.html": "there is no folder",
        ".": "is a folder",
        "nul\0byte": "is no file name",
    }.items():
        with pytest.raises(InputError, match=message):
            check_output(tmp_path / name, "page")
    check_output("/dev/null", "page")
    (tmp_path / "empty").touch()
    check_output(tmp_path / "empty", "page")


@pytest.mark.parametrize("force", [False, True])
def test_links_in_a_circle_and_names_too_long_are_refused_as_they_are_written(tmp_path: Path, force: bool) -> None:
    one, other, long = tmp_path / "One.npz", tmp_path / "Other.npz", tmp_path / ("N" * 300)
    one.symlink_to(other)
    other.symlink_to(one)
    for path, why in ((one, "too many levels of symbolic links"), (long, "file name too long")):
        with pytest.raises(InputError) as told:
            check_output(path, "recording", force=force)
        assert str(told.value) == f"{path}: cannot write here: {why}"
    with pytest.raises(InputError, match=f"^{one}: cannot write here: "), atomic_write(one):
        pass


def test_a_link_to_what_is_not_there_yet_may_be_written(tmp_path: Path) -> None:
    (tmp_path / "link.npz").symlink_to(tmp_path / "new.npz")
    check_output(tmp_path / "link.npz", "recording")


def test_nothing_is_recorded_into_a_circle_of_links(run: Any, folder: Path) -> None:
    Path("Loop.npz").symlink_to("Loop.npz")
    status, _, told = run("record", "sim:sphere?speed=0", "-o", "Loop.npz", "--frames", "10", "--force")
    assert (status, told) == (1, "varishold: Loop.npz: cannot write here: too many levels of symbolic links\n")
    assert not Path("Loop.npz.mcap").exists()


def test_presses_of_the_simulated_skin_are_recordings_and_recordings_are_no_presses(run: Any, folder: Path) -> None:
    assert run("skin", "collect", "-o", "made.npz", "--count", "2", "--shape", "8x8")[0] == 0
    assert run("convert", "made.npz", "plain.npz")[0] == 0
    assert run("convert", "plain.npz", "made.npz")[0] == 0
    status, _, told = run("skin", "collect", "-o", "made.npz", "--count", "2", "--shape", "8x8")
    assert status == 1
    assert "is there, and is no collection of presses" in told


def test_a_file_has_one_writer(tmp_path: Path) -> None:
    with only_writer(tmp_path / "a.csv"):
        with only_writer(tmp_path / "b.csv"):
            pass
        with pytest.raises(InputError, match="another process is writing"), only_writer(tmp_path / "a.csv"):
            pass
    with only_writer(tmp_path / "a.csv"):
        pass
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("text", ["=1+1", "+a", "-a", "@a", "'=1", "''=1", "'a", "\tx", "a=1"])
def test_labels_are_no_formulas_and_come_back_as_they_were(tmp_path: Path, text: str) -> None:
    path = tmp_path / "it.csv"
    write_grasp_table(GraspTable({"object": np.array([text, "b"]), "switch.a": np.array([True, False])}), path)
    cell = path.read_text().splitlines()[1].split(",")[0]
    assert cell.strip('"')[0] not in "=+-@"
    if text == text.strip():
        assert read_grasp_table(path).cells["object"][0] == text


def test_labels_cannot_steer_a_terminal(run: Any, folder: Path) -> None:
    text = (folder / "in.csv").read_text().replace("cone", "\x1b[31mcone\x07")
    (folder / "in.csv").write_text(text)
    run("grasp", "fit", "in.csv", "--label", "object", "-o", "model.json")
    for words in (
        ("predict", "model.json", "in.csv"),
        ("tables", "model.json"),
        ("predict", "in\x1b[2J.json", "in.csv"),
    ):
        _, out, told = run("grasp", *words)
        assert "\x1b" not in out + told
        assert "\x07" not in out + told


# Commands that read a recording with the sensor file that stands beside it.
BESIDE = (
    ("touch", "in.npz", "--report"),
    ("evaluate", "in.npz", "--label", "folder", "--with", "shipped", "--report"),
    ("learn", "in.npz", "--label", "folder", "-o"),
    ("learn", "model.npz", "--add", "cup", "in.npz", "-o"),
    ("recognize", "model.npz", "in.npz", "-o"),
    ("measure", ".", "-o"),
)


@pytest.mark.parametrize("words", BESIDE)
def test_nothing_takes_the_place_of_the_sensor_file_beside(run: Any, folder: Path, words: tuple[str, ...]) -> None:
    (folder / "sensor.toml").write_text('name = "mat"\n')
    for force in ((), ("--force",)):
        status, _, told = run(*words, "sensor.toml", *force)
        assert (status, told.count("\n")) == (1, 1)
    assert "is read by this very call" in told
    assert (folder / "sensor.toml").read_text() == 'name = "mat"\n'


def test_grasps_of_several_tables_are_answered(run: Any, folder: Path) -> None:
    table = "object,switch.a,switch.b\ncone,1,0\ncone,1,1\ncube,0,1\ncube,0,0\n"
    (folder / "tables").mkdir()
    for name in ("train.csv", "tables/1.csv", "tables/2.csv"):
        (folder / name).write_text(table)
    told = run("grasp", "fit", "train.csv", "--label", "object", "-o", "model.json")[1]
    assert "note: 4 different grasps do not tell whether a smaller circuit does as well" in told
    for mode in ("robust", "vote"):
        told = run("grasp", "fit", "train.csv", "--label", "object", "--mode", mode, "-o", "model.json")[1]
        assert "do not tell" not in told
    (folder / "tables" / "3.csv").write_text("object\ncone\n")
    status, out, told = run("grasp", "predict", "model.json", "tables", "--json")
    lines = [json.loads(line) for line in out.splitlines()]
    assert [(line["file"], line["row"], line["object"]) for line in lines] == [
        (f"tables/{k}.csv", row, name) for k in (1, 2) for row, name in enumerate(("cone", "cone", "cube", "cube"))
    ]
    assert (status, told.count("\n")) == (1, 1)
    assert "tables/3.csv: has none of the model's 2 columns" in told
    assert run("grasp", "predict", "model.json", "tables/1.csv") == (0, "cone\ncone\ncube\ncube\n", "")
    status, out, told = run("grasp", "predict", "model.json", "tables/1.csv", "--why")
    assert (status, told) == (0, "")
    assert [line for line in out.splitlines() if not line.startswith("  ")] == ["cone", "cone", "cube", "cube"]
    assert "  nearest training grasp: v1 (cone), 0 switches differ\n" in out


@pytest.mark.parametrize(
    ("name", "endings"),
    [
        ("touch table", ".parquet"),
        ("measure", ".parquet"),
        ("skin press", ".npz"),
        ("skin press picture", ".png"),
        ("skin collect", ".npz"),
        ("hand grasp", ".png"),
        ("hand grasp pads", ".npz"),
    ],
)
def test_what_is_written_is_called_as_what_it_is(run: Any, folder: Path, name: str, endings: str) -> None:
    words, _ = WRITERS[name]
    for written in ("new.csv", "new"):
        status, _, told = run(*words, written)
        assert (status, told) == (
            1,
            f"varishold: {written}: its name must end in {endings}, which is how it is written\n",
        )
        assert not (folder / written).exists()


def test_a_choice_that_there_is_not_is_told_with_those_there_are(run: Any, folder: Path) -> None:
    status, _, told = run("grasp", "fit", "in.csv", "--label", "object", "-o", "m.json", "--mode", "large")
    assert (status, told) == (
        2,
        "varishold: grasp fit: invalid value for '--mode': 'large' is not one of 'auto', 'paper', 'robust', 'vote' "
        "(varishold grasp fit --help)\n",
    )


@pytest.mark.parametrize("words", BESIDE)
@pytest.mark.parametrize("found", [True, False])
def test_what_a_sensor_file_names_is_read_too(run: Any, folder: Path, words: tuple[str, ...], found: bool) -> None:
    rows = "1,1\n1,1\n"
    (folder / "gains.csv").write_text(rows)
    (folder / ("sensor.toml" if found else "mat.toml")).write_text('gain_map = "gains.csv"\n')
    named = () if found else ("--sensor", "mat.toml")
    status, _, told = run(*words, "gains.csv", *named, "--force")
    assert (status, told.count("\n")) == (1, 1)
    assert "is read by this very call" in told
    assert (folder / "gains.csv").read_text() == rows


def test_a_measurement_is_no_map_of_the_sensor_that_it_gets(run: Any, folder: Path) -> None:
    (folder / "sensor.toml").write_text('rest = "rest.npz"\n')
    np.savez(folder / "rest.npz", np.zeros((8, 8)))
    before = (folder / "rest.npz").read_bytes()
    status, _, told = run("record", "replay:in.npz?speed=0", "-o", "rest.npz", "--force")
    assert (status, told.count("\n")) == (1, 1)
    assert "is read by this very call" in told
    assert (folder / "rest.npz").read_bytes() == before


def test_a_sensor_file_that_is_not_read_is_replaced_where_that_is_asked(run: Any, folder: Path) -> None:
    for name in ("sensor.toml", "mat.toml"):
        (folder / name).write_text('name = "mat"\n')
    assert run("touch", "in.npz", "--sensor", "mat.toml", "--report", "sensor.toml", "--force")[0] == 0


@pytest.mark.parametrize("beside", ["mat.gains.csv", "mat.rest.csv"])
def test_a_calibration_asks_before_it_replaces_a_foreign_map(run: Any, folder: Path, beside: str) -> None:
    (folder / beside).write_text("1,2\n")
    status, _, told = run("sensor", "calibrate", "in.npz", "--kind", "even", "-o", "mat.toml")
    assert status == 1
    assert told.startswith(f"varishold: {beside}: is there, and is no sensor file of this program")
    assert told.endswith("(--force)\n")
    assert (folder / beside).read_text() == "1,2\n"


def test_a_report_of_a_calibration_is_none_of_its_maps(run: Any, folder: Path) -> None:
    asked = ("sensor", "calibrate", "in.npz", "--kind", "even", "-o", "mat.toml", "--report", "mat.gains.csv")
    status, _, told = run(*asked)
    assert (status, told.count("\n")) == (1, 1)
    assert "is to be both a map of the sensor file and report" in told


def test_what_a_calibration_wrote_it_may_replace(tmp_path: Path) -> None:
    sensor = Sensor(gains=[[1.0, 2.0]], rest=[[0.0, 0.5]])
    *maps, whole = write_sensor(sensor, tmp_path / "mat.toml")
    assert set(maps) == set(map_files(whole))
    for path in (*maps, whole):
        check_output(path, "sensor")
