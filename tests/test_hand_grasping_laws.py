"""Setting an object up, coming before it, and trying again: on a bench whose world is the test's."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from tests.scripted_bench import ScriptedBench

pytest.importorskip("mujoco", reason="MuJoCo is not installed; pip install -e '.[sim]'")

from varishold.hand import HandDesign, HandSetting, Randomization, grasping
from varishold.hand.objects import graspable

DESIGN = HandDesign()
ALL = tuple(DESIGN.digits)
FINGERS = ("index", "middle", "ring", "little")


def test_an_object_is_set_before_the_palm_or_somewhere_to_be_searched(monkeypatch: pytest.MonkeyPatch) -> None:
    bench = ScriptedBench()
    known, unknown = HandSetting(), HandSetting(search=True)
    grasping.stand_up_at(bench, known, (0.002, -0.003, 0.1))
    # Its nearest side 4 mm before the palm, and what chance adds.
    assert bench.log == [("reset",), ("place", pytest.approx(0.04 + 0.004 + 0.002), -0.003, 0.1)]
    bench.log.clear()
    grasping.stand_up_at(bench, unknown, (0.02, -0.03, 0.2))
    assert bench.log == [("reset",), ("put", {"reach": -0.05}), ("place", pytest.approx(0.12), -0.03, 0.2)]
    bench.log.clear()
    grasping.stand_up(bench, known, np.random.default_rng(5))
    told = Randomization().draw_place(np.random.default_rng(5))
    assert bench.log[1] == ("place", pytest.approx(0.044 + told[0]), told[1], told[2])
    wide = Randomization().draw_place(np.random.default_rng(5), search=True)
    grasping.stand_up(bench, unknown, np.random.default_rng(5))
    assert bench.log[-1] == ("place", pytest.approx(0.10 + wide[0]), wide[1], wide[2])


@pytest.mark.parametrize("name", ["cylinder", "square-pillar", "box", "hexagonal-prism", "triangular-prism", "pyramid"])
@pytest.mark.parametrize("yaw", [0.0, 0.4, -0.9, 2.0])
def test_the_near_side_of_a_solid_is_where_a_ray_from_the_palm_first_meets_it(name: str, yaw: float) -> None:
    solid = graspable(name, 0.08)
    # Seen from the solid the palm lies against the way x, turned back.
    way = np.array([math.cos(yaw), -math.sin(yaw), 0.0])
    aside = np.array([-way[1], way[0], 0.0])
    lines = np.linspace(-0.08, 0.08, 801)[:, None] * aside - 1.0 * way
    reach = []
    for height in np.linspace(1e-4, solid.top_m - 1e-4, 12):
        starts = lines + np.array([0.0, 0.0, height])
        reach.append(1.0 - np.min([part.hits(starts, way) for part in solid.body()]))
    assert grasping._near_side(solid, yaw) == pytest.approx(max(reach), abs=2e-4)


def test_a_hand_comes_before_what_it_knows_or_found(monkeypatch: pytest.MonkeyPatch) -> None:
    done: list[Any] = []
    state = {"found": True, "palm": True}

    def fake(name: str, answer: Any) -> Any:
        def call(bench: Any, **how: Any) -> Any:
            done.append((name, how))
            return answer()

        return call

    found = type("Found", (), {"found": property(lambda self: state["found"])})()
    monkeypatch.setattr(grasping, "search", fake("search", lambda: found))
    monkeypatch.setattr(grasping, "approach", fake("approach", lambda: state["palm"]))
    monkeypatch.setattr(grasping, "square_up", fake("square up", lambda: 0.0))
    bench = ScriptedBench()
    assert grasping.come_before(bench, HandSetting()) is None
    assert done == [("approach", {"most_m": 0.03}), ("square up", {})]
    done.clear()
    state["palm"] = False
    grasping.come_before(bench, HandSetting())
    assert done == [("approach", {"most_m": 0.03})]
    done.clear()
    state["palm"] = True
    # After a search it stands square already; after one in vain it goes nowhere.
    assert grasping.come_before(bench, HandSetting(search=True)) is found
    assert done == [("search", {}), ("approach", {"most_m": 0.03})]
    done.clear()
    state["found"] = False
    assert grasping.come_before(bench, HandSetting(search=True)) is found
    assert done == [("search", {})]


def test_a_grasp_is_tried_until_it_holds_or_as_often_as_is_set(monkeypatch: pytest.MonkeyPatch) -> None:
    bench = ScriptedBench()
    ends: list[list[bool]] = []
    stood: list[int] = []
    monkeypatch.setattr(grasping, "set_up", lambda *a, **k: (bench, "rng"))
    monkeypatch.setattr(grasping, "stand_up", lambda b, s, rng: stood.append(1))
    monkeypatch.setattr(grasping, "come_before", lambda b, s: None)

    def steps(b: Any, **how: Any) -> Any:
        told = how | {"watch": None}
        assert told == {"pads": None, "pad_steps": (5,), "watch": None}
        return tuple(
            type("S", (), {"felt": felt, "number": k, "held": felt})() for k, felt in enumerate(ends.pop(0), start=1)
        )

    monkeypatch.setattr(grasping, "five_step", steps)
    for tries, outcomes, held in (
        ([[True] * 5], ["held"], True),
        ([[False], [True] * 5], ["missed", "held"], True),
        ([[True, True, False], [False], [True, False]], ["dropped", "missed", "dropped"], False),
        ([[True, True, True, True, False], [True] * 5], ["dropped", "held"], True),
    ):
        ends[:] = [list(each) for each in tries]
        stood.clear()
        done = grasping.grasp("cylinder", 0.08, seed=1)
        assert [attempt.outcome for attempt in done.attempts] == outcomes
        assert len(stood) == len(outcomes) - 1
        assert done.held == held
        assert done.end is done.steps[-1]
    ends[:] = [[False]] * 2
    twice = grasping.grasp("cylinder", 0.08, seed=1, setting=replace(HandSetting(), most_attempts=2))
    assert len(twice.attempts) == 2
    lost = type("Found", (), {"found": False})()
    monkeypatch.setattr(grasping, "come_before", lambda b, s: lost)
    nothing = grasping.grasp("cylinder", 0.08, seed=1, setting=replace(HandSetting(), most_attempts=1))
    assert [(a.outcome, a.steps, a.search) for a in nothing.attempts] == [("missed", (), lost)]
    assert (nothing.end.number, nothing.end.name, nothing.held) == (0, "search", False)
