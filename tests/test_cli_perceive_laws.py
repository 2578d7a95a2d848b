"""What ``varishold perceive`` prints of made-up touches, which orders it takes, and when it takes pictures."""

from __future__ import annotations

import json
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner

pytest.importorskip("mujoco", reason="MuJoCo is not installed; pip install -e '.[sim]'")

from varishold.cli import perceive as commands
from varishold.cli.app import app
from varishold.cli.thing import thing_to_touch
from varishold.errors import InputError, MissingExtraError
from varishold.hand import HandSetting
from varishold.perceive import NextTouch
from varishold.touch import SURFACES


def a_touch(
    *,
    verdict: str = "go on",
    then: tuple[str, float | None] | None = ("squeeze", 0.5),
    probability: dict[str, float] | None = None,
    size: Any = (0.07, (0.06, 0.08)),
    pads: bool = True,
) -> Any:
    update = SimpleNamespace(
        touch="grasp", probability=probability or {"cone": 0.6, "box": 0.3, "sphere": 0.09, "torus": 0.01},
        size_m=size[0], size_interval_m=size[1], p_value=0.4, verdict=verdict, why="it is not sure",
        reasons=("one", "two"),
    )  # fmt: skip
    surface = SimpleNamespace(
        name="flat", radius_m=0.02, force_n=1.5, posterior=lambda: np.linspace(0.1, 0.4, len(SURFACES))
    )
    felt = SimpleNamespace(
        step=SimpleNamespace(sensed=SimpleNamespace(switches=np.array([True, False, True, True]))),
        height_m=0.03,
        touch=SimpleNamespace(name="grasp", done="it grasps", felt_in_words=lambda felt, surfaces: "felt 3 switches"),
    )
    surfaces = {"palm": surface, "index.distal": None} if pads else {}
    planned = None if then is None else NextTouch(then[0], then[1] or 0.0, 3.2, "fingertip-edge")
    return SimpleNamespace(
        update=update, felt=felt, surfaces=surfaces, then=then, chosen_for=0.7, seconds=4.5, planned=planned
    )


def an_answer(*touches: Any, perceived: bool = True, drops: int = 0) -> Any:
    perception = SimpleNamespace(
        object="cone", pose=None, size_m=0.07, probability=0.97, alternatives={"box": 0.02},
        size_interval_m=(0.065, 0.075),
        remarks=("odd",), trace=[touch.update for touch in touches],
    )  # fmt: skip
    return SimpleNamespace(
        perception=perception if perceived else None, touches=touches, drops=drops, name="cone", size_m=0.08, seed=5,
        senses=(), also_right=(), seconds=4.5 * len(touches),
    )  # fmt: skip


def test_a_touch_is_told_in_three_lines_and_what_comes_next() -> None:
    lines = commands.touch_lines(2, a_touch())
    assert [style for style, _ in lines] == ["bold", None, None, "dim"]
    assert lines[0][1] == "2 grasp: it grasps; felt 3 switches (4.5 s)"
    # Three names at most, and none that is hardly likely.
    assert lines[1][1] == "  cone 0.60, box 0.30, sphere 0.09; 70 mm (60 to 80)"
    assert lines[2][1] == "  goes on: it is not sure"
    assert lines[3][1].startswith("  next: squeeze, expected to tell 0.50 nats")
    assert lines[3][1].endswith(" in 3.2 s, with fingertip-edge in view after it")
    for share, told in ((0.005, "box 0.01"), (0.0049, "")):
        (_, line), *_ = commands.touch_lines(1, a_touch(probability={"cone": 1 - share, "box": share}))[1:]
        assert ("box" in line) == bool(told)
    last = commands.touch_lines(1, a_touch(verdict="sure", then=None, probability={"cone": 0.001}, size=(None, None)))
    assert len(last) == 3
    assert last[1][1] == "  cone 0.00; size unknown"


def test_a_touch_is_a_json_line() -> None:
    told = commands.touch_to_dict(a_touch())
    assert json.loads(json.dumps(told)) == told
    palm = told["pads"].pop("palm")
    assert palm["probability"] == dict(zip(SURFACES, np.linspace(0.1, 0.4, len(SURFACES)).tolist(), strict=True))
    assert (palm["surface"], palm["radius_m"], palm["force_n"]) == ("flat", 0.02, 1.5)
    assert told == {
        "touch": "grasp", "probabilities": {"cone": 0.6, "box": 0.3, "sphere": 0.09, "torus": 0.01}, "size_m": 0.07,
        "size_interval_m": [0.06, 0.08], "p_value": 0.4, "verdict": "go on", "why": "it is not sure",
        "reasons": ["one", "two"], "chosen_for_nats": 0.7,
        "next": {
            "touch": "squeeze", "expected_nats": 0.5, "expected_seconds": 3.2, "along_with": "fingertip-edge"
        }, "seconds": 4.5,
        "switches_closed": 3, "height_m": 0.03, "pads": {"index.distal": None},
    }  # fmt: skip
    none = commands.touch_to_dict(a_touch(then=None, size=(None, None)))
    assert (none["next"], none["size_interval_m"]) == (None, None)


def test_the_answer_is_the_last_json_line() -> None:
    touches = (a_touch(), a_touch(), a_touch(verdict="sure", then=None))
    told = commands.answer_to_dict(an_answer(*touches, drops=1), [{"a": 1}])
    assert told == {
        "object": "cone", "size_m": 0.07, "probability": 0.97, "alternatives": {"box": 0.02}, "touches": 3,
        "trace": [{"a": 1}], "size_interval_m": [0.065, 0.075], "verdict": "sure", "why": "it is not sure", "drops": 1,
        "senses": [], "seconds": 13.5,
        "remarks": ["odd"], "true_object": "cone", "true_size_m": 0.08, "right": True, "seed": 5, "pose": None,
    }  # fmt: skip
    seen = an_answer(*touches)
    seen.senses = (("camera", {"cone": 0.4, "box": 0.6}), ("touch", {"cone": 1.0}))
    assert commands.answer_to_dict(seen, [])["senses"] == [
        {"source": "camera", "probabilities": {"cone": 0.4, "box": 0.6}},
        {"source": "touch", "probabilities": {"cone": 1.0}},
    ]
    nothing = commands.answer_to_dict(an_answer(perceived=False, drops=3), [])
    assert (nothing["object"], nothing["size_m"], nothing["probability"], nothing["alternatives"]) == (
        None, None, None, {},
    )  # fmt: skip
    assert (nothing["verdict"], nothing["why"], nothing["size_interval_m"]) == (None, None, None)
    assert (nothing["remarks"], nothing["touches"], nothing["right"]) == (["nothing was gripped"], 0, None)


def test_an_order_is_of_touches_that_are_known_each_once_and_begins_with_a_grip() -> None:
    def perceiver(*touches: str) -> Any:
        return SimpleNamespace(library=SimpleNamespace(touches=touches))

    every = perceiver("grasp", "squeeze", "fingertip-edge", "smell")
    assert commands._order(None, every, HandSetting()) is None
    assert commands._order(" grasp, fingertip_edge", every, HandSetting()) == ("grasp", "fingertip-edge")
    assert commands._order("squeeze", every, HandSetting()) == ("squeeze",)
    for text, says in (
        ("grasp,smell", "--order takes touches between commas, of grasp, squeeze, fingertip-edge; got 'smell'"),
        ("grasp,regrasp-higher", "got 'regrasp-higher'"),
        ("grasp,squeeze,grasp", "--order takes each touch once; got 'grasp' again"),
        ("fingertip-edge,grasp", "--order must begin with grasp or squeeze, for nothing is held before"),
    ):
        with pytest.raises(InputError) as caught:
            commands._order(text, every, HandSetting())
        assert says in str(caught.value)
    with pytest.raises(InputError, match=r"the library must know the first touch, grasp, .*it knows squeeze, smell"):
        commands._order(None, perceiver("squeeze", "smell"), HandSetting())


class Watched:
    """Stands for the exploration: two touches, or none."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch, *touches: Any, **answer: Any) -> None:
        self.told: dict[str, Any] = {}

        def perceive(name: str, size_m: float, **how: Any) -> Any:
            self.told = {"name": name, "size_m": size_m, **how}
            for touch in touches:
                if how["watch"] is not None:
                    how["watch"]("bench", "step")
                how["on_touch"](touch)
            return an_answer(*touches, **answer)

        monkeypatch.setattr("varishold.exploration.perceive", perceive)
        monkeypatch.setattr(
            "varishold.report.write_perceive_report", lambda path, sequence, **how: self.told.update(page=(path, how))
        )


def run(*words: str | Path) -> str:
    done = CliRunner().invoke(app, ["perceive", *(str(word) for word in words)], env={"COLUMNS": "200"})
    if done.exception is not None and not isinstance(done.exception, SystemExit):
        raise done.exception
    assert done.exit_code == 0, done.output
    return done.output


def test_a_file_that_is_no_mesh_is_told_so_and_a_folder_takes_no_name_away(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.chdir(tmp_path)
    for name in ("cup.glb", "cone.step"):
        with pytest.raises(InputError, match=rf"^{name}: is no mesh by its name; it must end in .stl, .obj, .ply$"):
            thing_to_touch(name, 0.06, None, quiet=True)
    Path("cone").mkdir()
    assert thing_to_touch("cone", 0.06, None, quiet=True) == ("cone", 0.06)


def test_the_command_explores_as_its_options_say(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    seen = Watched(monkeypatch, a_touch(), a_touch(verdict="sure", then=None))
    out = run("square_pillar", "--size-m", "0.07").splitlines()
    assert (seen.told["name"], seen.told["size_m"], seen.told["seed"], seen.told["order"]) == (
        "square-pillar", 0.07, 0, None,
    )  # fmt: skip
    assert seen.told["watch"] is None
    setting: HandSetting = seen.told["setting"]
    assert (setting.search, setting.pads is not None, setting.still) == (True, True, False)
    perceiver = seen.told["perceiver"]
    assert (perceiver.error, perceiver.most_touches, perceiver.strangers) == (0.01, 4, 0.1)
    assert [line.split()[0] for line in out if "it grasps" in line] == ["1", "2"]
    assert "note: odd" in out
    assert sum(line.startswith("  next:") for line in out) == 1
    words = ["--seed", "3", "--error", ".05", "--most-touches", "2", "--order", "squeeze,grasp", "--place-known"]
    words += ["--strangers", "0"]
    run("cone", "--size-m", "0.06", *words)
    assert (seen.told["seed"], seen.told["order"]) == (3, ("squeeze", "grasp"))
    assert not seen.told["setting"].search
    perceiver = seen.told["perceiver"]
    assert (perceiver.error, perceiver.most_touches, perceiver.strangers) == (0.05, 2, 0.0)
    lines = [json.loads(line) for line in run("cone", "--size-m", "0.06", "--json").splitlines()]
    assert [line.get("touch") for line in lines] == ["grasp", "grasp", None]
    assert lines[2]["trace"] == lines[:2]
    nothing = Watched(monkeypatch, perceived=False, drops=3)
    out = run("cone", "--size-m", "0.06").splitlines()
    assert not any(line.startswith("note") for line in out)
    assert out[0].startswith("Nothing was gripped")
    assert nothing.told["order"] is None


def test_a_page_has_a_picture_of_each_touch_or_says_why_not(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    seen = Watched(monkeypatch, a_touch(), a_touch())
    made: list[Any] = []

    class Taker:
        def __init__(self, bench: Any, camera: Any) -> None:
            made.append(camera)

        def take(self, bench: Any) -> str:
            return "picture"

        def close(self) -> None:
            made.append("closed")

    monkeypatch.setattr("varishold.hand.picture.Photographer", Taker)
    monkeypatch.setattr("varishold.hand.scene.take_scene", lambda bench: ("scene",))
    page = tmp_path / "p.html"
    out = run("cone", "--size-m", "0.06", "--report", page, "--error", "0.02").splitlines()
    assert out[-1] == f"report: {page}"
    path, how = seen.told["page"]
    assert path == page
    assert (how["pictures"], how["no_pictures"], how["error"]) == (["picture"] * 2, None, 0.02)
    assert how["scenes"] == [("scene",)] * 2
    (camera, closed) = made
    assert (camera.width, camera.height, camera.distance_m, camera.look_at_m) == (480, 400, 0.40, (0.05, 0.0, 0.01))
    assert closed == "closed"
    assert "report" not in run("cone", "--size-m", "0.06", "--report", page, "--json")

    tried: list[int] = []

    def cannot(bench: Any, camera: Any) -> Any:
        tried.append(1)
        raise MissingExtraError("no way to draw")

    monkeypatch.setattr("varishold.hand.picture.Photographer", cannot)
    run("cone", "--size-m", "0.06", "--report", page)
    _, how = seen.told["page"]
    assert (how["pictures"], how["no_pictures"]) == ([], "no way to draw")
    assert how["scenes"] == [("scene",)] * 2
    # Once is enough.
    assert tried == [1]


def test_on_a_terminal_it_says_what_it_is_doing(monkeypatch: pytest.MonkeyPatch) -> None:
    said: list[str] = []

    class Status:
        def start(self) -> None:
            said.append("start")

        def stop(self) -> None:
            said.append("stop")

        def update(self, text: str) -> None:
            said.append(text)

    class Console:
        def __init__(self, **how: Any) -> None:
            self.how = how

        def status(self, text: str) -> Status:
            assert self.how == {"stderr": True}
            said.append(text)
            return Status()

        def print(self, text: str, **how: Any) -> None:
            said.append("line")

    monkeypatch.setattr("rich.console.Console", Console)
    monkeypatch.setattr("sys.stderr", SimpleNamespace(isatty=lambda: True))
    show = commands._Show(False, "squeeze")
    with show:
        show.touch(a_touch())
        show.touch(a_touch(verdict="sure", then=None))
    assert said == [
        "touch 1: squeeze …", "start", "stop", "line", "line", "line", "line", "touch 2: squeeze …", "start",
        "stop", "line", "line", "line", "stop",
    ]  # fmt: skip
    monkeypatch.setattr("sys.stderr", SimpleNamespace(isatty=lambda: False))
    said.clear()
    quiet = commands._Show(False, "grasp")
    with quiet:
        quiet.touch(a_touch())
    assert said == ["line"] * 4


def test_a_right_answer_is_green_and_a_wrong_one_red(monkeypatch: pytest.MonkeyPatch) -> None:
    said: list[Any] = []
    console = SimpleNamespace(print=lambda text, **how: said.append((how.pop("style"), how)))
    monkeypatch.setattr("rich.console.Console", lambda **how: console)
    plain = {"markup": False, "soft_wrap": True}
    right, wrong, none = an_answer(a_touch()), an_answer(a_touch()), an_answer(perceived=False, drops=3)
    wrong.name = "box"
    for sequence, colour in ((right, "green"), (wrong, "red")):
        said.clear()
        commands._Show(False, "grasp").answer(sequence)
        assert said == [("yellow", plain), ("bold", plain), (colour, plain)]
    said.clear()
    commands._Show(False, "grasp").answer(none)
    assert said == [("bold", plain), (None, plain)]
