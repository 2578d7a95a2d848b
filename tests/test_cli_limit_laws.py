"""Options' limits and defaults beside what they are asked of, the guard of files, and which files a name stands for."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import click
import pytest
from click.testing import CliRunner
from tests.commands_said import said
from tests.test_cli_calls import options

from varishold.cli import grasp, recordings
from varishold.cli.app import COMMAND_GROUPS
from varishold.cli.command import Argument, Command, Commands, Option
from varishold.cli.files import Reads, Writes, with_option
from varishold.cli.named import table_files
from varishold.corpus import AskMeasure
from varishold.errors import FormatError, InputError
from varishold.evaluation.yardstick import FRAMES, SEED
from varishold.levelset import find_contacts
from varishold.recording import FORMATS


def test_what_means_the_same_has_the_same_limits_everywhere() -> None:
    levels = {name: options(name)["levels"] for name in ("touch", "touch export", "measure", "live")}
    assert set(levels.values()) == {(AskMeasure().levels, 4, 512)}
    # A contact of the fewest and of the most is measured.
    for few_or_most in (4, 512):
        assert find_contacts([[0.0, 1.0], [2.0, 3.0]], few_or_most) is not None
    ports = {options(name)["port"] for name in ("live", "replay")}
    assert ports == {(None, 0, 2**16 - 1)}
    workers = {options(name)["workers"] for name in ("touch", "measure")}
    assert workers == {(None, 1, 4096)}
    errors = {options(name)["error"] for name in ("learn", "evaluate")}
    assert errors == {(None, 0.001, 0.5)}
    assert options("measure")["floor"] == (AskMeasure().floor, 0.0, None)
    assert options("replay")["speed"] == (1.0, 0.0, 1e6)
    assert (options("record")["frames"], options("record")["seconds"]) == ((None, 1, None), (None, 0.0, None))
    drawn = options("evaluate")
    assert (drawn["frames"], drawn["seed"]) == ((None, 1, 10_000), (None, 0, None))
    assert (FRAMES, SEED) == (40, 1972)
    assert (options("live")["host"][0], options("live")["folder"][0]) == ("127.0.0.1", Path())


def test_a_default_that_the_help_names_is_the_one_that_holds() -> None:
    told = " ".join(said("evaluate", "-h").split())
    assert f"Default: 0; with --distortions {SEED}." in told
    assert f"Default: {FRAMES}." in told


@pytest.mark.parametrize("group", COMMAND_GROUPS)
def test_each_group_registers_what_the_program_then_has(group: str) -> None:
    from importlib import import_module

    alone = Commands()
    import_module(f"varishold.cli.{group}").register(alone)
    assert alone.commands
    shown = [words[0] for line in said("-h").splitlines() if (words := line.split())]
    for name in alone.commands:
        assert name.split()[0] in shown


# The guard


@dataclass
class Call:
    """What a guarded command was given."""

    told: dict[str, Any]


def command_of(call: Call) -> Command:
    def command(
        read: Annotated[str, Argument("what is read"), Reads()],
        more: Annotated[list[str] | None, Option("what is read too"), Reads()] = None,
        page: Annotated[Path | None, Option("a page"), Writes("page")] = None,
        picture: Annotated[
            Path | None, Option("a picture", name="--picture-file", short="-p"), Writes("picture")
        ] = None,
        shape: Annotated[str | None, Option("a shape")] = None,
        pitch_m: Annotated[float | None, Option("a pitch", name="--the-pitch", short="-m")] = None,
    ) -> None:
        call.told.update(read=read, more=more, page=page, picture=picture)
        if shape is not None:
            raise FormatError("odd", parameter=shape)

    return Command("command", callback=command)


def run(call: Call, folder: Path, *words: object) -> str:
    done = CliRunner().invoke(command_of(call), [str(word) for word in words])
    return str(done.exception) if done.exception is not None else ""


def test_an_output_is_no_input_no_other_output_and_nothing_foreign(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    for name in ("a", "b", "c"):
        Path(name).write_text("mine")
    call = Call({})
    assert run(call, tmp_path, "a", "--more", "b", "--page", "p.html", "-p", "q.png") == ""
    assert call.told == {"read": "a", "more": ["b"], "page": Path("p.html"), "picture": Path("q.png")}
    call.told.clear()
    for words, told in (
        (("a", "--page", "a"), "a: is read by this very call"),
        (("a", "--more", "b", "--page", "b"), "b: is read by this very call"),
        (("a", "--more", "b", "-p", "b"), "b: is read by this very call"),
        (("a", "--page", "c"), "c: is there, and is no"),
        (("a", "--page", "x", "-p", "x"), "x: is to be both page and picture; name two files"),
        (("a", "--page", "x", "-p", tmp_path / "x"), "x: is to be both page and picture; name two files"),
    ):
        assert told in run(call, tmp_path, *words)
        # Before the command has begun.
        assert call.told == {}
    assert run(call, tmp_path, "a", "--page", "c", "--force") == ""
    assert "is read by this very call" in run(call, tmp_path, "a", "--page", "a", "--force")


@pytest.mark.parametrize(
    ("parameter", "told"),
    [
        ("shape", "odd (--shape ROWSxCOLS)"),
        ("pitch_m", "odd (--the-pitch)"),
        ("picture", "odd (--picture-file)"),
        ("read", "odd"),
        ("unknown", "odd"),
    ],
)
def test_an_error_names_the_option_that_would_mend_it(
    parameter: str, told: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    assert run(Call({}), tmp_path, "a", "--shape", parameter) == told
    with click.Context(command_of(Call({}))):
        assert with_option(InputError("odd", parameter=parameter)) == told
        assert with_option(InputError("odd")) == "odd"
    # Where no command runs, no option mends anything.
    assert with_option(InputError("odd", parameter=parameter)) == "odd"


@pytest.mark.parametrize(
    ("kind", "given", "told"),
    [
        ("source", "replay:flat.csv", "odd (replay:FILE?shape=ROWSxCOLS)"),
        ("source", "lsl:skin", "odd"),
        ("sensor", None, "odd; in a sensor file: shape = [ROWS, COLUMNS] (--sensor)"),
        ("recordings", "flat.csv", "odd"),
    ],
)
def test_what_a_command_reads_tells_where_a_shape_is_said(kind: str, given: str | None, told: str) -> None:
    def command(what: str) -> None:
        """Read something."""

    command.__annotations__["what"] = Annotated[str, Argument("what is read"), Reads(kind)]
    with click.Context(Command("odd", callback=command)) as context:
        context.params = {"what": given}
        assert with_option(InputError("odd", parameter="shape")) == told


# Which files


def test_a_folder_stands_for_its_recordings_each_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    folder = Path("in")
    folder.mkdir()
    endings = [ending for known in FORMATS.values() for ending in known.suffixes]
    assert {".npz", ".csv", ".mcap"} <= set(endings)
    for name in ("b.npz", "a.csv", "note.txt", "page.html"):
        (folder / name).touch()
    got = recordings.recording_files(["in", "in/b.npz", "in/note.txt", "-"])
    # What is named is taken, whatever its ending.
    assert [Path(name).name for name in got if not name.endswith(".txt")] == ["a.csv", "b.npz", "-"]
    assert got.count(str(folder / "note.txt")) == 1
    assert not any(name.endswith(".html") for name in got)
    assert [Path(name).name for name in table_files(["in"])] == ["a.csv"]


def test_what_is_read_upright_is_read_with_its_sensor(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(recordings, "sensor_for", lambda file, named: f"sensor {named} of {file}")
    monkeypatch.setattr(recordings, "read_recording", lambda file, sensor: f"{file} by {sensor}")
    monkeypatch.setattr("varishold.sensor.recordings.upright_recording", lambda recording, sensor: (recording, sensor))
    expected = ("a.npz by sensor mat of a.npz", "sensor mat of a.npz")
    assert recordings.read_with_sensor("a.npz", "mat") == expected
    assert recordings.read_upright("a.npz", "mat") == expected


# Grasps


@pytest.fixture
def table(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    rows = [f"{name},{day},{a},{b},{a / 2 + b}" for day in "xy" for name, a, b in (("cone", 1, 0), ("cube", 0, 1)) * 2]
    Path("t.csv").write_text("\n".join(["object,day,switch.a,switch.b,n", *rows]) + "\n")
    return Path("t.csv")


def test_a_model_of_grasps_is_fitted_as_the_options_say(table: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    asked: dict[str, Any] = {}
    plain = __import__("varishold.grasp", fromlist=["fit_model"]).fit_model

    def fit(grasps: Any, **how: Any) -> Any:
        asked.update(how, columns_read=sorted(grasps.columns))
        return plain(grasps, label=how["label"])

    monkeypatch.setattr("varishold.grasp.fit_model", fit)
    lines = said("grasp", "fit", "t.csv", "--label", "object", "-o", "m.json").splitlines()
    assert lines[0].startswith("m.json: 8 grasps of 2 objects, 2 columns, 2 switches, mode ")
    usual = {"group": None, "columns": None, "mode": grasp.Mode.auto, "encode": None, "levels": 4, "seed": 0}
    assert {name: asked[name] for name in usual} == usual
    assert asked["columns_read"] == ["day", "n", "object", "switch.a", "switch.b"]
    words = (
        "--mode",
        "vote",
        "--group",
        "day",
        "--columns",
        "switch.*",
        "--encode",
        "even",
        "--levels",
        3,
        "--seed",
        7,
    )
    said("grasp", "fit", "t.csv", "--label", "object", "-o", "m.json", *words, "--seed", 7)
    own = {"group": "day", "columns": "switch.*", "mode": "vote", "encode": "even", "levels": 3, "seed": 7}
    assert {name: asked[name] for name in own} == own
    assert asked["columns_read"] == ["day", "object", "switch.a", "switch.b"]
    said("grasp", "fit", "t.csv", "--label", "object", "-o", "m.json", "--columns", "switch.a")
    assert asked["columns_read"] == ["object", "switch.a"]


def test_rows_are_numbered_and_doubt_is_marked(table: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    class Answer:
        def __init__(self, name: str, rejected: bool) -> None:
            self.object, self.rejected, self.why = name, rejected, ()

        def to_dict(self) -> dict[str, Any]:
            return {"object": self.object}

    class Model:
        def answer_file(self, file: str, *, why: bool) -> Any:
            # Some rows at a time.
            return iter([[Answer("a", False), Answer("b", True)], [], [Answer("c\x1b", False)]])

    monkeypatch.setattr("varishold.grasp.read_model", lambda path: Model())
    Path("u.csv").touch()
    Path("m.json").touch()
    assert said("grasp", "predict", "m.json", "t.csv") == "a\nb ?\nc\\x1b\n"
    assert said("grasp", "predict", "m.json", "t.csv", "u.csv").splitlines()[::4] == ["t.csv:", "u.csv:"]
    lines = [json.loads(line) for line in said("grasp", "predict", "m.json", "t.csv", "u.csv", "--json").splitlines()]
    assert [(line["row"], line["object"], line["file"]) for line in lines] == [
        (row, name, file) for file in ("t.csv", "u.csv") for row, name in enumerate(("a", "b", "c\x1b"))
    ]


def test_an_exported_circuit_is_named_by_its_model_and_checked_first(
    table: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    checked: list[Any] = []
    said("grasp", "fit", "t.csv", "--label", "object", "-o", "my_model.json")
    monkeypatch.setattr("varishold.files.check_output", lambda path, kind, **how: checked.append((path, kind, how)))
    lines = said("grasp", "export", "my_model.json", "--to", "c", "-o", "out", "--force").splitlines()
    assert all(Path(line).name.startswith("my_model") for line in lines)
    assert all(Path(line).exists() for line in lines)
    assert [path for path, *_ in checked] == [Path(line) for line in lines]
    assert all(
        (kind, how) == ("circuit", {"inputs": [Path("my_model.json")], "force": True}) for _, kind, how in checked
    )
    shown = said("grasp", "tables", "my_model.json")
    assert "cone" in shown
    assert "cube" in shown


@pytest.mark.parametrize(
    ("model", "to", "told"),
    [
        ("stdint", "c", "note: called m_stdint, for 'stdint' is a header of C"),
        ("int", "c", "note: called m_int, for 'int' is a word of C, C++ or Verilog"),
        ("int", "verilog", "note: called m_int, for 'int' is a word of C, C++ or Verilog"),
        ("stdint", "verilog", ""),
        ("stdints", "c", ""),
    ],
)
def test_a_circuit_that_cannot_be_called_as_its_model_is_told_so(table: Path, model: str, to: str, told: str) -> None:
    said("grasp", "fit", "t.csv", "--label", "object", "-o", f"{model}.json")
    lines = said("grasp", "export", f"{model}.json", "--to", to, "-o", "out").splitlines()
    assert [line for line in lines if line.startswith("note: called")] == [told] * bool(told)
    assert Path("out", f"{'m_' * bool(told)}{model}.{'h' if to == 'c' else 'v'}").exists()
