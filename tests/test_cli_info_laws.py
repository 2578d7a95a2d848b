"""What ``info``, ``validate``, ``convert`` and ``sensor`` say, word by word, of what they were given."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import click
import numpy as np
import pytest
from click.testing import CliRunner
from hypothesis import given, settings
from hypothesis import strategies as st
from tests.loaded_rooms import load

from varishold.cli import info
from varishold.cli.app import app
from varishold.recording import Pad, Recording, read, write
from varishold.recording.inspection import PadSummary, Summary, TimeSummary, summarize
from varishold.sensor import PRESETS, Sensor, Skin, sensor_of, write_sensor

load("corpus", "evaluation", "learning", "live", "perceive", "report", "sensor", "skin", "touch")


def said(*words: object, status: int = 0) -> str:
    done = CliRunner().invoke(app, list(map(str, words)), catch_exceptions=False)
    assert done.exit_code == status, done.output
    return done.stdout


PAD = PadSummary("left", (4, 5), 20, 0, None, "uint8", 1.5, 200.0, 3, "up", True)
TIME = TimeSummary(0.0, 1.25, 50.0, 0.0012, 0, 0, 0, 0, ())
PLAIN = Summary("a.npz", "kPa", "", 7, (PAD,), None, None, (), (), ())


@pytest.mark.parametrize(
    ("found", "lines"),
    [
        (PLAIN, ["frames    7", "unit      kPa"]),
        (replace(PLAIN, sensor="mat"), ["frames    7", "unit      kPa", "sensor    mat"]),
        (
            replace(PLAIN, time=TIME),
            ["frames    7 in 1.25 s", "rate      50 Hz, jitter 1.2 ms", "unit      kPa"],
        ),
        (replace(PLAIN, time=replace(TIME, rate_hz=None)), ["frames    7 in 1.25 s", "unit      kPa"]),
        (replace(PLAIN, time=replace(TIME, jitter_s=None)), ["frames    7 in 1.25 s", "unit      kPa"]),
        (replace(PLAIN, n_presses=0), ["frames    7", "unit      kPa", "presses   0"]),
        (
            replace(PLAIN, n_presses=3, press_columns=("thing", "day")),
            ["frames    7", "unit      kPa", "presses   3, with thing, day"],
        ),
    ],
)
def test_what_is_known_of_a_recording_has_its_line(found: Summary, lines: list[str]) -> None:
    pad = "left      4 x 5 taxels, pitch unknown; uint8 from 1.5 to 200"
    assert info._lines(found) == [*lines, pad]
    more = replace(found, pads=(PAD, replace(PAD, name="a longer name")), notes=("one", "two"), faults=("three",))
    assert info._lines(more) == [
        *lines, pad, pad.replace("left     ", "a longer name"), "note: one", "note: two", "fault: three",
    ]  # fmt: skip


@pytest.mark.parametrize(
    ("how", "words"),
    [
        ({"on_grid": False}, "5 taxels on no grid, pitch unknown; uint8 from 1.5 to 200"),
        ({"n_taxels": 19}, "4 x 5 taxels, 19 of them in the field, pitch unknown; uint8 from 1.5 to 200"),
        ({"n_broken": 2}, "4 x 5 taxels, 2 broken, pitch unknown; uint8 from 1.5 to 200"),
        ({"pitch_m": (2e-3, 2e-3)}, "4 x 5 taxels, 2 mm apart; uint8 from 1.5 to 200"),
        ({"pitch_m": (2e-3, 3e-3)}, "4 x 5 taxels, rows 2 mm, columns 3 mm apart; uint8 from 1.5 to 200"),
        ({"polarity": "down"}, "4 x 5 taxels, pitch unknown; uint8 from 1.5 to 200, smaller is more pressure"),
    ],
)
def test_what_is_special_of_a_pad_is_said(how: dict[str, Any], words: str) -> None:
    assert info._pad_line(replace(PAD, **how)) == f"left      {words}"


@settings(max_examples=40)
@given(st.integers(1, 80), st.integers(1, 120), st.integers(0, 99))
def test_a_small_picture_has_the_highest_of_each_square(rows: int, cols: int, seed: int) -> None:
    frame = np.random.default_rng(seed).random((rows, cols))
    small = info._small(frame)
    step = 1
    while (rows + step - 1) // step > 24 or (cols + step - 1) // step > 36:
        step += 1
    assert small.shape == ((rows + step - 1) // step, (cols + step - 1) // step)
    for r, c in np.ndindex(*small.shape):
        assert small[r, c] == frame[r * step : (r + 1) * step, c * step : (c + 1) * step].max()


@pytest.mark.parametrize("polarity", ["up", "down"])
def test_a_frame_is_drawn_by_ten_signs(polarity: str, capsys: pytest.CaptureFixture[str]) -> None:
    heights = np.array([[0, 11, 22, 33, 44], [99, 88, 77, 66, 55]])
    shown = heights if polarity == "up" else 99 - heights
    valid = np.ones((2, 5), bool)
    valid[0, 2] = False
    frames = np.stack([np.full((2, 5), 0 if polarity == "up" else 99), shown])
    made = Recording({"p": Pad(frames, valid=valid, polarity=polarity)})
    info._draw(made, summarize(made).pads[0])
    # A taxel that does not work shows nothing.
    assert capsys.readouterr().out.splitlines() == ["frame 1 of p:", "  ..  --==", "@@%%##**++"]


def test_nothing_is_drawn_of_what_has_no_form(capsys: pytest.CaptureFixture[str]) -> None:
    flat = Recording({"p": Pad(np.ones((2, 3, 3)))})
    (pad,) = summarize(flat).pads
    info._draw(flat, pad)
    info._draw(flat, replace(pad, high=2.0, on_grid=False))
    assert capsys.readouterr().out == ""


def test_several_files_have_headings_and_programs_get_a_line_each(tmp_path: Path) -> None:
    for name in "ab":
        write(Recording({"p": Pad(np.arange(24).reshape(2, 3, 4))}, notes=("read",)), tmp_path / f"{name}.npz")
    one, two = tmp_path / "a.npz", tmp_path / "b.npz"
    lines = said("info", one, two).splitlines()
    assert (lines[0], lines[len(lines) // 2]) == (f"{one}:", f"{two}:")
    assert lines[1 : len(lines) // 2] == said("info", one).splitlines()
    told = [json.loads(line) for line in said("info", one, two, "--json").splitlines()]
    assert [line.pop("file") for line in told] == [str(one), str(two)]
    assert told[0] == json.loads(json.dumps(summarize(read(one)).to_dict()))


def test_a_shape_and_a_sensor_are_used(tmp_path: Path) -> None:
    np.save(tmp_path / "a.npy", np.arange(60).reshape(3, 20))
    write_sensor(Sensor(shape=(2, 10), span=1.0, name="mat"), tmp_path / "mat.toml")
    for command in ("info", "validate"):
        assert said(command, tmp_path / "a.npy", "--shape", "4x5")
        with pytest.raises(Exception, match="7"):
            said("info", tmp_path / "a.npy", "--shape", "7x7")
    assert "pad       4 x 5 taxels" in said("info", tmp_path / "a.npy", "--shape", "4x5")
    lines = said("info", tmp_path / "a.npy", "--sensor", tmp_path / "mat.toml")
    assert "pad       2 x 10 taxels" in lines
    assert "note: read with the sensor mat" in lines


def test_a_pitch_that_the_sensor_says_is_told_unless_the_recording_knows_its_own(tmp_path: Path) -> None:
    write_sensor(Sensor(pitch_m=(3e-3, 4e-3)), tmp_path / "mat.toml")
    for own, words in ((None, "rows 3 mm, columns 4 mm apart"), (5e-3, "5 mm apart")):
        write(Recording({"pad": Pad(np.ones((2, 3, 3)), pitch_m=own)}), tmp_path / "a.npz")
        lines = said("info", tmp_path / "a.npz", "--sensor", tmp_path / "mat.toml")
        assert f"pad       3 x 3 taxels, {words};" in lines
        told = json.loads(said("info", tmp_path / "a.npz", "--sensor", tmp_path / "mat.toml", "--json"))
        assert told["pads"][0]["pitch_m"] == [own or 3e-3, own or 4e-3]


def test_a_validation_counts_faults_of_all_files(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for name in "abc":
        write(Recording({"p": Pad(np.ones((2, 3, 3)))}), tmp_path / f"{name}.npz")
    files = [str(tmp_path / f"{name}.npz") for name in "abc"]
    faults = {"a.npz": ("one", "two"), "b.npz": (), "c.npz": ("three",)}
    monkeypatch.setattr(
        "varishold.recording.inspection.faults_of", lambda recording: faults[Path(recording.source).name]
    )
    lines = [f"{files[0]}: one", f"{files[0]}: two", f"{files[1]}: no fault found", f"{files[2]}: three"]
    assert said("validate", *files, status=1).splitlines() == lines
    told = [json.loads(line) for line in said("validate", *files, "--json", status=1).splitlines()]
    assert told == [{"file": files[k], "fault": fault} for k, fault in ((0, "one"), (0, "two"), (2, "three"))]
    assert said("validate", files[1], "--json") == ""
    with pytest.raises(click.exceptions.Exit):
        info.validate([files[2]])


# Converting


def test_a_conversion_says_what_it_wrote_and_what_was_lost(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    np.save(tmp_path / "a.npy", np.arange(60).reshape(3, 20))
    words = ("convert", tmp_path / "a.npy", tmp_path / "b.npz", "--shape", "4x5", "--pitch-m", "2e-3")
    same = f"{tmp_path / 'b.npz'}: 3 frames, read back and compared: "
    assert said(*words) == f"{same}the same\n"
    (pad,) = read(tmp_path / "b.npz").pads.values()
    assert (pad.frames.shape, pad.pitch_m) == ((3, 4, 5), (2e-3, 2e-3))
    asked: list[Any] = []

    def write_as(recording: Recording, output: Path, **how: Any) -> list[str]:
        asked.append((recording.n_frames, output, how["lossy"]))
        return ["times", "a unit"] if how["lossy"] else []

    monkeypatch.setattr("varishold.recording.conversion.convert", write_as)
    assert said(*words, "--lossy") == f"lost: times\nlost: a unit\n{same}the rest is the same\n"
    said(*words)
    assert asked == [(3, tmp_path / "b.npz", True), (3, tmp_path / "b.npz", False)]


# Sensors


def test_every_preset_is_listed_with_its_shape_and_pitch() -> None:
    lines, told = said("sensor", "list").splitlines(), said("sensor", "list", "--json").splitlines()
    assert len(lines) == len(told) == len(PRESETS)
    for name, line, text in zip(PRESETS, lines, told, strict=True):
        sensor, entry = sensor_of(name), json.loads(text)
        assert sensor.readings_shape is not None
        rows, cols = sensor.readings_shape
        pitch = None if sensor.pitch_m is None else list(sensor.pitch_m)
        assert entry == {
            "preset": name, "name": sensor.name, "shape": [rows, cols], "pitch_m": pitch, "polarity": sensor.polarity,
            "third_party": sensor.third_party, "notes": sensor.notes,
        }  # fmt: skip
        at = "" if pitch is None else f" at {1e3 * pitch[0]:.3g} mm"
        party = " (third-party)" if sensor.third_party else ""
        assert line.split() == f"{name} {rows} x {cols}{at} {sensor.name}{party}: {sensor.notes}".split()
        assert line[16] == " "
        assert line[17:].startswith(f"{rows} x {cols}")


@pytest.mark.parametrize(
    ("sensor", "lines"),
    [
        (Sensor(name="mat"), ["mat", "  taxels: unknown", "  nothing to undo"]),
        (
            Sensor(name="mat", shape=(4, 5), notes="soft", cover=Skin("half-space")),
            ["mat", "  taxels: 4 x 5", "  nothing to undo", f"  cover: {Skin('half-space')}", "  soft"],
        ),
    ],
)
def test_a_sensor_is_shown_in_words(sensor: Sensor, lines: list[str], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("varishold.sensor.sensor_of", lambda name: sensor)
    monkeypatch.setattr("varishold.sensor.words.undone_words", lambda known: ())
    assert said("sensor", "show", "mat").splitlines() == lines
    monkeypatch.setattr("varishold.sensor.words.undone_words", lambda known: ("gains", "rest"))
    shown = said("sensor", "show", "mat").splitlines()
    assert shown == [word for line in lines for word in (["  gains", "  rest"] if "nothing" in line else [line])]


def test_kinds_and_what_is_in_reach_are_listed(monkeypatch: pytest.MonkeyPatch) -> None:
    kinds = [
        SimpleNamespace(names=("a", "b"), title="first", example="a:1", missing="", found=[("a:7", "here")]),
        SimpleNamespace(names=("c",), title="second", example="c:1", missing="it lacks", found=[]),
    ]
    monkeypatch.setattr("varishold.live.reach.reachable_kinds", lambda: kinds)
    text = said("sources")
    head, rest = text.split("framings of serial skins, as in serial:PORT?preset=NAME:\n")
    assert head.splitlines() == [
        "kinds, each with an example (docs/live.md):", f"  {'a:1':42} first", f"  {'c:1':42} second", "  c: it lacks",
        "in reach now:", f"  {'a:7':42} here",
    ]  # fmt: skip
    told = [json.loads(line) for line in said("sources", "--json").splitlines()]
    assert told[:3] == [
        {"kind": ["a", "b"], "title": "first", "example": "a:1", "missing": None},
        {"kind": ["c"], "title": "second", "example": "c:1", "missing": "it lacks"},
        {"source": "a:7", "notes": "here"},
    ]
    framings = [entry for entry in told if "preset" in entry]
    assert len(rest.splitlines()) == len(framings) == len(told) - 3
    for line, entry in zip(rest.splitlines(), framings, strict=True):
        shapes = [" x ".join(map(str, shape)) if shape else "any" for shape in entry["pads"].values()]
        party = " (third-party)" if entry["third_party"] else ""
        words = (
            f"{entry['preset']} {entry['baud']} baud {' and '.join(shapes)} {entry['name']}{party}: {entry['notes']}"
        )
        assert line.split() == words.split()
    kinds[0].found = []
    assert "in reach now: nothing that tells of itself\n" in said("sources")


def test_a_unit_of_two_lines_is_said_in_one(tmp_path: Path) -> None:
    recording = Recording({"p": Pad(np.arange(24).reshape(2, 3, 4))}, unit="kPa\nfault: none", sensor="a\r\nb")
    write(recording, tmp_path / "a.npz")
    lines = said("info", tmp_path / "a.npz").splitlines()
    assert "unit      kPa fault: none" in lines
    assert "sensor    a b" in lines


# Where taxels stand

_GRID = np.stack(np.meshgrid(np.arange(4) * 4e-3, np.arange(3) * 4e-3), axis=-1).reshape(-1, 2)
_PLACES = {
    "right": (_GRID, ""),
    "millimetres": (1e3 * _GRID, "taxels are 4 m apart: are positions_m in millimetres?"),
    "twice": (_GRID[[0, 1, 2, 2, *range(4, 12)]], "positions_m of a sensor must differ: taxels 2 and 3 stand at one"),
    "a line": (np.arange(12)[:, None] * [4e-3, 0], "positions_m of a sensor stand on one line"),
    "far": (_GRID + np.array([2e3, 0]), "positions_m of a sensor must lie within 1000 m of its origin, got 2000"),
}


@pytest.mark.parametrize("by", ["recording", "sensor file"])
@pytest.mark.parametrize("case", _PLACES)
def test_validate_tells_of_places_where_no_taxels_stand(tmp_path: Path, case: str, by: str) -> None:
    places, fault = _PLACES[case]
    frames = np.random.default_rng(0).normal(5, 1, (9, 1, 12))
    pad = Pad(frames, positions_m=places) if by == "recording" else Pad(frames)
    write(Recording({"pad": pad}), tmp_path / "a.npz")
    words = []
    if by == "sensor file":
        (tmp_path / "s.toml").write_text(f"positions_m = {places.tolist()}\n")
        words = ["--sensor", tmp_path / "s.toml"]
    (line,) = said("validate", tmp_path / "a.npz", *words, status=bool(fault)).splitlines()
    assert (fault or "no fault found") in line
    # Touch refuses what cannot be, and info tells it or asks.
    if "apart" not in fault:
        done = CliRunner().invoke(app, ["touch", str(tmp_path / "a.npz"), *map(str, words)])
        assert (done.exception is not None and fault in str(done.exception)) == bool(fault)
    told = CliRunner().invoke(app, ["info", str(tmp_path / "a.npz"), *map(str, words)])
    assert fault in f"{told.stdout}{told.exception}"
    assert f"{told.stdout}{told.exception}".count(fault or "never said") == bool(fault)


@pytest.mark.parametrize("falls", [False, True])
@pytest.mark.parametrize("known", ["", "polarity = 'down'\nrest = 250", "rest = 250"])
def test_validate_and_info_tell_of_readings_that_touch_refuses(tmp_path: Path, falls: bool, known: str) -> None:
    y, x = np.mgrid[-6:7, -6:7]
    force = np.repeat([0.0, 1.0, 3.0, 0.0], 4)[:, None, None] * np.maximum(4.0 - np.hypot(x, y), 0.0)
    frames = 250 + (-20 if falls else 20) * force + np.random.default_rng(0).normal(0, 1, force.shape)
    write(Recording({"pad": Pad(frames)}), tmp_path / "a.npz")
    if known:
        (tmp_path / "sensor.toml").write_text(known)
    done = CliRunner().invoke(app, ["touch", str(tmp_path / "a.npz")])
    fault = "" if done.exception is None else str(done.exception).removeprefix(f"{tmp_path / 'a.npz'}: ")
    assert bool(fault) == (falls != ("down" in known))
    told = said("validate", tmp_path / "a.npz", status=bool(fault))
    assert told == f"{tmp_path / 'a.npz'}: {fault or 'no fault found'}\n"
    assert said("info", tmp_path / "a.npz").count(f"fault: {fault or 'none'}") == bool(fault)


@pytest.mark.parametrize("sensor_m", [None, 4e-3, 5e-3, 5.02e-3])
@pytest.mark.parametrize("own_m", [None, 5e-3])
def test_two_pitches_are_told(tmp_path: Path, own_m: float | None, sensor_m: float | None) -> None:
    file = tmp_path / "a.npz"
    write(Recording({"pad": Pad(np.random.default_rng(0).normal(5, 1, (9, 3, 4)), pitch_m=own_m)}), file)
    (tmp_path / "sensor.toml").write_text("" if sensor_m is None else f"pitch_m = {sensor_m}\n")
    fault = f"taxels are 5 mm apart by the recording, which is taken, and 4 mm by {tmp_path / 'sensor.toml'}"
    is_told = (own_m, sensor_m) == (5e-3, 4e-3)
    assert said("validate", file, status=is_told) == f"{file}: {fault if is_told else 'no fault found'}\n"
    assert said("info", file).count(fault) == is_told
    assert fault not in said("touch", file, "--frames", 0, "--pitch-m", 0.005)
    assert ("which is taken" in " ".join(said("touch", file, "--frames", 0).split())) == is_told


def test_validate_asks_about_a_pitch_in_millimetres(tmp_path: Path) -> None:
    write(Recording({"pad": Pad(np.random.default_rng(0).normal(5, 1, (9, 3, 4)), pitch_m=4.0)}), tmp_path / "a.npz")
    assert "4 m apart: is the pitch in millimetres?" in said("validate", tmp_path / "a.npz", status=1)
