"""Each command calls the library with what its options say and prints the answer; defaults are the library's."""

from __future__ import annotations

import inspect
import json
import os
from pathlib import Path
from types import SimpleNamespace
from typing import Any, get_type_hints

import numpy as np
import pytest
from click.testing import CliRunner
from tests.test_cli_files import COMMANDS

pytest.importorskip("mujoco", reason="MuJoCo is not installed; pip install -e '.[sim]'")

from varishold.cli.app import app
from varishold.cli.command import Option
from varishold.corpus import AskTouch
from varishold.errors import InputError
from varishold.hand import HandDesign, HandSetting, PadSetting
from varishold.paper.table5 import table_5
from varishold.perceive import Perceiver
from varishold.sensor import Sensor
from varishold.skin import PressDraw, Skin, Taxels, collect_presses, press
from varishold.solids import SOLIDS, Cone, Pose
from varishold.touch import find_contacts, recognize_recording
from varishold.touch.writers import Export


def run(*words: str | Path) -> str:
    done = CliRunner().invoke(app, [str(word) for word in words])
    if done.exception is not None and not isinstance(done.exception, SystemExit):
        raise done.exception
    assert done.exit_code == 0, done.output
    return done.output


def options(command: str) -> dict[str, tuple[Any, Any, Any]]:
    """Default, least and most of each option."""
    call = COMMANDS[command].callback
    assert call is not None
    hints, out = get_type_hints(call, include_extras=True), {}
    for parameter in inspect.signature(call).parameters.values():
        marks = getattr(hints[parameter.name], "__metadata__", ())
        info = next((mark for mark in marks if isinstance(mark, Option)), None)
        if info is not None:
            out[parameter.name] = (parameter.default, info.min, info.max)
    return out


def default_of(call: Any, name: str) -> Any:
    return inspect.signature(call).parameters[name].default


# Defaults


def test_commands_begin_with_the_library_s_own_defaults() -> None:
    touch, export = options("touch"), options("touch export")
    assert touch["levels"] == (default_of(find_contacts, "levels"), 4, 512)
    # The strongest frame, or with -o every frame.
    assert touch["frames"][0] is None
    assert default_of(recognize_recording, "frames") == "peak"
    assert AskTouch().frames == "all"
    assert AskTouch().levels == touch["levels"][0]
    usual = Export()
    assert export["levels"] == (usual.levels, 4, 512)
    assert export["contacts"] == (usual.contacts, 1, 64)
    assert export["weights"][0].value == usual.weights
    solid, presses, draw = options("skin press"), options("skin collect"), PressDraw(Skin("half-space"))
    assert solid["pitch_m"][0] == presses["pitch_m"][0] == draw.pitch_m == default_of(press, "pitch_m")
    assert solid["shape"][0] == presses["shape"][0] == "x".join(map(str, draw.shape))
    assert default_of(press, "shape") == draw.shape
    assert presses["slope"][0] == draw.slope
    assert presses["seed"] == (default_of(collect_presses, "seed"), 0, None)
    assert solid["seed"] == (0, 0, None)
    for name in ("x_m", "y_m", "yaw_rad", "tip_x", "tip_y"):
        assert solid[name][0] == getattr(Pose(), name)
    for name in ("crosstalk", "gain_spread", "bits", "dead", "stuck"):
        assert presses[name][0] == getattr(Taxels(), name)
    assert (solid["noise"][0], presses["noise"][0]) == (Taxels().noise, 0.01)
    assert (presses["count"], presses["processes"]) == ((1000, 1, None), (None, 1, None))
    felt = options("perceive")
    assert felt["error"][0] == default_of(Perceiver, "error")
    assert felt["most_touches"][0] == default_of(Perceiver, "most_touches")
    grasp, many = options("hand grasp"), options("hand collect")
    assert grasp["finger_scale"][0] == many["finger_scale"][0] == HandDesign().finger_scale
    assert grasp["still"][0] == many["still"][0] == HandSetting().still is False
    assert (many["grasps"], many["steps"][0]) == ((10, 1, 100_000), "5")
    for command in (grasp, many, felt, options("paper table")):
        assert command["seed"] == (0, None, None)
    table = options("paper table")
    assert table["grasps"] == (20, 1, None)
    assert table["repetitions"] == (2, 1, None)
    assert default_of(table_5, "processes") is table["processes"][0] is None
    fit = options("grasp fit")
    assert (fit["mode"][0].value, fit["levels"], fit["seed"]) == ("auto", (4, 1, 1024), (0, 0, None))


def test_no_command_does_unasked_what_takes_a_word_to_ask_for() -> None:
    for name in COMMANDS:
        for option, (default, _, _) in options(name).items():
            if isinstance(default, bool):
                assert default is False, (name, option)


# The skin


def pressed_by(monkeypatch: pytest.MonkeyPatch, *, modulus: float | None = None) -> dict[str, Any]:
    told: dict[str, Any] = {}

    def solve(body: Any, skin: Any, **how: Any) -> Any:
        told.update(how, body=body, skin=skin)
        contact = np.zeros((8, 12), bool)
        contact[2:5, 3:7] = True
        return SimpleNamespace(
            depth_m=1.25e-3, force_n=2.5, contact=contact, pressure=np.where(contact, 4.0, 0.0), rms_gap=3e-6,
            converged=True, shape=(4, 6), pitch_m=(2e-3, 1e-3), skin=skin, displacement_m=np.ones((8, 12)),
            gap_m=np.zeros((8, 12)), x_m=np.arange(12.0), y_m=np.arange(8.0),
        )  # fmt: skip

    def sense(made: Any, taxels: Any, *, seed: int) -> np.ndarray:
        told.update(taxels=taxels, seed=seed)
        return np.full((4, 6), 1.5)

    monkeypatch.setattr("varishold.skin.press", solve)
    monkeypatch.setattr("varishold.skin.sense", sense)
    if modulus is not None:
        monkeypatch.setattr("varishold.skin.read_skin", lambda path: Skin("half-space", youngs_modulus_pa=modulus))
    return told


def test_a_press_is_what_its_options_say(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    told = pressed_by(monkeypatch)
    said = json.loads(run("skin", "press", "cone", "--size-m", "0.02", "--json"))
    assert told["skin"] == Skin("layer", 6e-3, 0.45, 1e-3)
    assert (told["depth"], told["force"], told["shape"], told["pitch_m"]) == (1e-3, None, (32, 32), 1e-3)
    assert (told["pose"], told["taxels"], told["seed"]) == (Pose(), Taxels(), 0)
    assert isinstance(told["body"], Cone)
    # Twelve cells of a millimetre by half a millimetre.
    assert said == {
        "solid": "cone", "depth_m": 1.25e-3, "force_n": None, "area_m2": pytest.approx(12 * 1e-3 * 0.5e-3),
        "peak_pressure": 4.0, "peak_taxel": 1.5, "unit": "raw", "rms_gap": 3e-6, "converged": True,
    }  # fmt: skip
    words = [
        "--size-m",
        ".02",
        "--depth-m",
        "2e-3",
        "--x-m",
        ".001",
        "--y-m",
        "-.002",
        "--yaw-rad",
        ".3",
        "--tip-x",
        ".01",
        "--tip-y",
        "-.02",
    ]
    more = ["--shape", "9x11", "--pitch-m", "2e-3", "--noise", ".05", "--seed", "7"]
    out = run("skin", "press", "square_pillar", *words, *more, "-o", tmp_path / "p.npz")
    assert (told["depth"], told["shape"], told["pitch_m"]) == (2e-3, (9, 11), 2e-3)
    assert (told["pose"], told["taxels"], told["seed"]) == (
        Pose(0.001, -0.002, 0.3, 0.01, -0.02), Taxels(noise=0.05), 7
    )  # fmt: skip
    assert out.splitlines() == [
        "depth 1.25 mm, force unknown (the skin has no modulus), contact 6 mm2",
        "pressure at most 4, at the taxels 1.5 (in units of the contact modulus)",
        f"recording: {tmp_path / 'p.npz'}",
    ]
    with np.load(tmp_path / "p.npz") as kept:
        assert kept["pressure"].shape == (1, 4, 6)
        assert kept["truth.pressure"].max() == 4.0
        assert (kept["pitch_m"].tolist(), str(kept["unit"]), str(kept["sensor"])) == (
            [2e-3, 1e-3], "raw", "simulated layer",
        )  # fmt: skip
        assert (*kept["press.depth_m"], *kept["press.force_n"]) == (1.25e-3, 2.5)
        assert [kept[name].shape for name in ("truth.x_m", "truth.y_m", "truth.gap_m", "truth.displacement_m")] == [
            (12,),
            (8,),
            (8, 12),
            (8, 12),
        ]


def test_a_press_by_force_has_no_depth_of_its_own(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    told = pressed_by(monkeypatch, modulus=2e5)
    (tmp_path / "skin.toml").write_text("[skin]\n")
    words = ("skin", "press", "cone", "--size-m", "0.02", "--force-n", "3", "--skin", tmp_path / "skin.toml")
    out = run(*words)
    assert (told["depth"], told["force"]) == (None, 3.0)
    assert out.splitlines()[0] == "depth 1.25 mm, force 2.5 N, contact 6 mm2"
    assert out.splitlines()[1].endswith("(Pa)")
    said = json.loads(run(*words, "--json"))
    assert (said["force_n"], said["unit"]) == (2.5, "Pa")


def test_a_height_map_is_pressed_where_it_lies(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    told = pressed_by(monkeypatch)
    for ending in (".npy", ".csv", ".txt", ".NPY"):
        path = tmp_path / f"face{ending}"
        if ending.lower() == ".npy":
            with path.open("wb") as file:
                np.save(file, np.eye(5))
        else:
            np.savetxt(path, np.eye(5), delimiter=",")
        run("skin", "press", path)
        np.testing.assert_array_equal(told["body"], np.eye(5))
        assert told["pose"] is None
    with pytest.raises(InputError, match="a height map lies where it is; --x-m, --y-m, --yaw-rad and --tip-"):
        run("skin", "press", tmp_path / "face.npy", "--tip-y", "0.1")
    np.save(tmp_path / "tall.npy", np.diag(np.arange(3.0)))
    with pytest.raises(InputError, match=r"tall.npy: is 2 m high, of 1 m at most; write heights in metres"):
        run("skin", "press", tmp_path / "tall.npy")
    with pytest.raises(InputError, match=r"a cone is 1 m large at most, got 16; write --size-m in metres"):
        run("skin", "press", "cone", "--size-m", "16")
    with pytest.raises(InputError, match="a height map has its own size; --size-m is for solids"):
        run("skin", "press", tmp_path / "face.npy", "--size-m", "0.1")


def test_a_collection_of_presses_is_drawn_as_its_options_say(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    told: dict[str, Any] = {}

    def collect(path: Path, draw: PressDraw, count: int, **how: Any) -> int:
        told.update(how, path=path, draw=draw, count=count)
        how["advance"](1)
        return told.get("found", 0)

    monkeypatch.setattr("varishold.skin.collect_presses", collect)
    path = tmp_path / "p.npz"
    assert run("skin", "collect", "-o", path).splitlines() == [f"{path}: 1000 presses"]
    usual = PressDraw(Skin("layer", 6e-3, 0.45, 1e-3), taxels=Taxels(noise=0.01))
    assert told["draw"] == usual
    assert (told["count"], told["seed"], told["processes"], told["path"]) == (1000, 0, os.cpu_count() or 1, path)
    told["found"] = 5
    words = "--count 9 --shape 16x24 --pitch-m 2e-3 --slope .1 .2 --noise .02 --crosstalk .03 --gain-spread .04"
    more = "--bits 10 --dead .05 --stuck .06 --seed 3 --processes 2 --solids cone,plane"
    out = run("skin", "collect", "-o", path, *words.split(), *more.split())
    assert out.splitlines() == [f"{path}: 9 presses, 5 of them from an interrupted call"]
    assert told["draw"] == PressDraw(
        usual.skin, (16, 24), 2e-3, ("cone", "plane"), (4.0, 10.0), (0.1, 0.2),
        Taxels(noise=0.02, crosstalk=0.03, gain_spread=0.04, bits=10, dead=0.05, stuck=0.06),
    )  # fmt: skip
    assert (told["count"], told["seed"], told["processes"]) == (9, 3, 2)
    run("skin", "collect", "-o", path, "--size-taxels", "5", "7")
    assert told["draw"].size_taxels == (5.0, 7.0)
    assert told["draw"].solids == tuple(SOLIDS)


# The hand


class Held:
    """Stands for the hand: notes how it is asked to grasp."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self.told: dict[str, Any] = {}

        def grasp(name: str, size_m: float, *more: Any, **how: Any) -> Any:
            self.told = {"name": name, "size_m": size_m, "more": more, **how}
            return SimpleNamespace(attempts=[], held=True, name=name, size_m=size_m, steps=("steps",))

        monkeypatch.setattr("varishold.hand.grasp_object", grasp)
        monkeypatch.setattr("varishold.hand.photograph", grasp)
        monkeypatch.setattr("varishold.hand.rows.grasp_to_dicts", lambda done, setting: iter([{"a": 1}, {"b": 2}]))
        monkeypatch.setattr("varishold.hand.rows.pads_recording", lambda steps: steps)
        monkeypatch.setattr("varishold.recording.write", lambda made, path: self.told.update(written=(made, path)))


def test_a_grasp_is_what_its_options_say(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    held = Held(monkeypatch)
    assert (
        run("hand", "grasp", "cone_frustum", "--size-m", "0.06").splitlines()[-1].startswith("the cone-frustum of 60")
    )
    assert (held.told["name"], held.told["size_m"], held.told["seed"]) == ("cone-frustum", 0.06, 0)
    assert (held.told["setting"], held.told["more"]) == (HandSetting(search=True), ())
    assert held.told["pad_steps"] == (1, 2, 3, 4, 5)
    picture, pads = tmp_path / "a.png", tmp_path / "b.npz"
    words = ("--seed", "4", "--place-known", "--finger-scale", "1.2", "--still", "--picture", picture, "--pads", pads)
    out = run("hand", "grasp", "lump-7", "--size-m", "0.07", *words)
    setting = HandSetting(design=HandDesign(finger_scale=1.2), search=False, still=True)
    assert held.told["setting"].pads is not None
    assert held.told["setting"].pads.skin == PadSetting().skin
    assert (held.told["setting"].design, held.told["setting"].search) == (setting.design, False)
    assert held.told["setting"].still
    assert (held.told["seed"], held.told["more"], held.told["pad_steps"]) == (4, (picture,), (1, 2, 3, 4, 5))
    assert held.told["written"] == (("steps",), pads)
    assert out.splitlines()[-2:] == [f"picture: {picture}", f"pads: {pads}"]
    # Programs read lines, and nothing else.
    lines = run("hand", "grasp", "cone", "--size-m", "0.06", "--json", "--pads", pads).splitlines()
    assert [json.loads(line) for line in lines] == [{"a": 1}, {"b": 2}]


def test_a_collection_of_grasps_is_what_its_options_say(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    told: dict[str, Any] = {}

    class Table:
        def __init__(self) -> None:
            self.cells = {"held": np.array([True, False, True])}

        def __len__(self) -> int:
            return 3

    def collect(jobs: Any, output: Path, **how: Any) -> Any:
        told.update(how, jobs=jobs, output=output)
        how["progress"](1, 2)
        return Table()

    monkeypatch.setattr("varishold.hand.collect_grasps", collect)
    path = tmp_path / "g.csv"
    assert run("hand", "collect", "--objects", "cone", "-o", path).splitlines() == [f"{path}: 3 rows, 2 held"]
    assert [(job.name, job.size_m, job.seed) for job in told["jobs"]] == [("cone", 0.07, k) for k in range(10)]
    assert (told["setting"], told["steps"], told["processes"], told["anew"]) == (
        HandSetting(search=True), (5,), None, False,
    )  # fmt: skip
    words = "--grasps 2 --size-m .05 --size-m .06 --seed 3 --steps 2,5 --place-known --finger-scale .9 --still"
    run("hand", "collect", "--objects", "cone", "sphere", "-o", path, *words.split(), "--processes", "2", "--force")
    assert [(job.name, job.size_m, job.seed) for job in told["jobs"]] == [
        (name, size, seed) for name in ("cone", "sphere") for size in (0.05, 0.06) for seed in (3, 4)
    ]
    assert told["setting"] == HandSetting(design=HandDesign(finger_scale=0.9), search=False, still=True)
    assert (told["steps"], told["processes"], told["anew"]) == ((2, 5), 2, True)


# Sensors


def test_a_preset_is_listed_with_what_is_known_of_it(monkeypatch: pytest.MonkeyPatch) -> None:
    known = {
        "mat": Sensor(shape=(8, 9), pitch_m=(2e-3, 3e-3), name="The Mat", notes="soft"),
        "skin": Sensor(shape=(4, 5), polarity="down", name="A Skin", notes="thin", third_party=True),
    }
    monkeypatch.setattr("varishold.sensor.PRESETS", known)
    monkeypatch.setattr("varishold.sensor.sensor_of", known.__getitem__)
    lines = run("sensor", "list").splitlines()
    assert lines == [
        "mat              8 x 9 at 2 mm        The Mat: soft",
        "skin             4 x 5                A Skin (third-party): thin",
    ]
    told = [json.loads(line) for line in run("sensor", "list", "--json").splitlines()]
    assert told[0] == {
        "preset": "mat", "name": "The Mat", "shape": [8, 9], "pitch_m": [2e-3, 3e-3], "polarity": "up",
        "third_party": False, "notes": "soft",
    }  # fmt: skip
    assert (told[1]["pitch_m"], told[1]["polarity"], told[1]["third_party"]) == (None, "down", True)


def test_a_sensor_is_shown_in_words(monkeypatch: pytest.MonkeyPatch) -> None:
    cover = Skin("layer", 2e-3, 0.45, 1e-3)
    known = {
        "bare": Sensor(name="bare"),
        "full": Sensor(shape=(8, 9), name="full", span=10, dead_band=0.1, notes="a note", cover=cover),
    }
    monkeypatch.setattr("varishold.sensor.sensor_of", known.__getitem__)
    assert run("sensor", "show", "bare").splitlines()[1:] == ["  taxels: unknown", "  nothing to undo"]
    lines = run("sensor", "show", "full").splitlines()
    assert lines[1] == "  taxels: 8 x 9"
    assert lines[-2:] == [f"  cover: {cover}", "  a note"]
    assert "  nothing to undo" not in lines


@pytest.mark.parametrize(
    ("words", "name", "given"),
    [
        ("--kind even --pressure-pa 1e3,2e3 --pad left", "calibrate_even", {"pressure_pa": [1e3, 2e3]}),
        ("--kind even --pad left", "calibrate_even", {"pressure_pa": None}),
        ("--kind scale --force-n 1,2.5 --pad left", "calibrate_scale", {"force_n": [1.0, 2.5]}),
        ("--kind unlabelled --pad left", "calibrate_unlabelled", {}),
        ("--kind objects --object ball:0.02 --pad left", "calibrate_objects", {}),
    ],
)
def test_a_calibration_is_the_one_that_is_asked_for(
    words: str, name: str, given: dict[str, Any], monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    told: dict[str, Any] = {}

    def made(kind: str) -> Any:
        def calibrate(recordings: Any, *more: Any, **how: Any) -> Any:
            told.update(kind=kind, more=more, recordings=recordings, how=how)
            return SimpleNamespace(
                sensor=Sensor(span=7.0), presses=3, findings=["one", "two"], unknown=["three"], notes=["four"],
                to_dict=lambda: {"presses": 3},
            )  # fmt: skip

        return calibrate

    for each in ("calibrate_even", "calibrate_objects", "calibrate_scale", "calibrate_unlabelled"):
        monkeypatch.setattr(f"varishold.calibration.{each}", made(each))
    np.savez(tmp_path / "a.npz", pressure=np.ones((2, 4, 5)))
    np.save(tmp_path / "b.npy", np.ones((2, 20)))
    out = tmp_path / "s.toml"
    call = ("sensor", "calibrate", tmp_path / "a.npz", tmp_path / "b.npy", *words.split(), "-o", out)
    lines = run(*call, "--shape", "4x5", "--pitch-m", "2e-3").splitlines()
    base = told["how"].pop("sensor")
    assert (base.span, base.name) == (1.0, "")
    if name == "calibrate_objects":  # the one that takes long shows how far it is
        assert callable(told["how"].pop("tick"))
    assert (told["kind"], told["how"]) == (name, {"pad": "left", **given})
    assert [recording.pads["pad"].shape for recording in told["recordings"]] == [(4, 5), (4, 5)]
    assert told["recordings"][1].pads["pad"].pitch_m == (2e-3, 2e-3)
    assert len(told["more"]) == (name == "calibrate_objects")
    assert lines == ["3 presses", "found: one", "found: two", "not known: three", "note: four", f"written: {out}"]
    assert json.loads(run(*call, "--shape", "4x5", "--json")) == {"sensor": str(out), "presses": 3}
    other = [word for word in call if word not in ("--object", "ball:0.02")]
    other += [] if "objects" in words else ["--object", "ball:1"]
    with pytest.raises(InputError, match="--kind objects needs --object, as in --object ball"):
        run(*other)
