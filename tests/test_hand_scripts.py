"""What the hand's actions tell it to do, step by step, on a bench whose world is the test's."""

from __future__ import annotations

import importlib
import math
from typing import Any

import numpy as np
import pytest
from tests.scripted_bench import ScriptedBench, angles_at

pytest.importorskip("mujoco", reason="MuJoCo is not installed; pip install -e '.[sim]'")

from varishold.hand import HandDesign
from varishold.hand.actions import (
    approach,
    fingertip,
    five_step,
    let_go,
    move_round,
    object_middle,
    open_hand,
    regrasp,
    square_up,
    squeeze,
)
from varishold.hand.coordinates import phalanges

DESIGN = HandDesign()
ALL = tuple(DESIGN.digits)
FINGERS = ("index", "middle", "ring", "little")


def near(entry: dict[str, float], **told: float) -> bool:
    return entry == pytest.approx(told, abs=1e-9)


# Grasping


def test_five_steps_are_the_papers() -> None:
    grip = angles_at(0.04, -0.04)
    bench = ScriptedBench(world=lambda b: ("index_distal", "thumb_distal"), angles=grip)
    seen: list[int] = []
    steps = five_step(bench, watch=lambda b, step: seen.append(step.number))
    assert bench.log == [
        ("digits", {"index": 1.0, "thumb": 1.2}, (), {}),
        ("go", 0.4, {}),
        ("go", 0.4, {"wrist": 0.5}),
        ("go", 0.1, {}),
        ("digits", {"little": 1.0}, (), {}),
        ("go", 0.3, {}),
        ("digits", {}, ("index",), {}),
        ("go", 0.25, {}),
        ("digits", {"index": 1.0, "middle": 1.0, "ring": 1.0, "little": 1.0, "thumb": 2.6}, (), {}),
        ("go", 0.4, {}),
    ]
    assert seen == [step.number for step in steps] == [1, 2, 3, 4, 5]
    assert [step.name for step in steps] == [
        "thumb and index finger grasp",
        "the wrist lifts",
        "the little finger grasps too",
        "the index finger is removed",
        "thumb and all fingers grasp",
    ]
    assert all(step.felt and step.held and step.pads is None for step in steps)
    assert steps[2].sensed.carriage[5] == 0.5


def test_a_grasp_ends_where_nothing_is_felt_any_more_unless_it_is_to_go_on() -> None:
    # What is held shrinks below half of its breadth of the step before: it has slipped out.
    for breadths, go_on, count in (
        ((0.08, 0.08, 0.039, 0.08, 0.08), False, 3),
        ((0.08, 0.08, 0.041, 0.041, 0.041), False, 5),
        ((0.08, 0.08, 0.039, 0.08, 0.08), True, 5),
    ):
        bench = ScriptedBench(world=lambda b: ("index_distal", "thumb_distal"))
        left = iter(breadths)

        def world(b: ScriptedBench, left: Any = left) -> tuple[str, ...]:
            # The second step lets time pass twice.
            if b.log[-1] != ("go", 0.1, {}):
                breadth = next(left)
                b.angles = angles_at(breadth / 2, -breadth / 2)
            return ("index_distal", "thumb_distal")

        bench.world = world
        steps = five_step(bench, go_on=go_on)
        assert len(steps) == count
        assert [step.felt for step in steps] == [
            k == 0 or breadths[k] > max(0.032, 0.5 * breadths[k - 1]) for k in range(count)
        ]
    nothing = ScriptedBench()
    assert [step.felt for step in five_step(nothing)] == [False]


def test_a_squeeze_closes_all_and_lifts_if_asked() -> None:
    everything = {"index": 1.0, "middle": 1.0, "ring": 1.0, "little": 1.0, "thumb": 2.6}
    bench = ScriptedBench(world=lambda b: ("index_distal", "thumb_distal"), angles=angles_at(0.04, -0.04))
    (step,) = squeeze(bench)
    assert bench.log == [("digits", everything, (), {}), ("go", 0.5, {})]
    assert (step.number, step.name, step.felt) == (1, "thumb and all fingers grasp", True)
    bench.log.clear()
    _, two = squeeze(bench, lift=True)
    assert bench.log == [("digits", everything, (), {}), ("go", 0.5, {}), ("go", 0.5, {"wrist": 0.5})]
    assert (two.number, two.name, two.felt) == (2, "the wrist lifts", True)
    # Felt after the lift is what is no less than half as broad as before it.
    slipping = ScriptedBench()

    def world(b: ScriptedBench) -> tuple[str, ...]:
        half = 0.02 if b.target["wrist"] else 0.045
        b.angles = angles_at(half, -half)
        return ("index_distal", "thumb_distal")

    slipping.world = world
    assert [step.felt for step in squeeze(slipping, lift=True)] == [True, False]


# Moving


def test_open_hand_opens_every_digit() -> None:
    bench = ScriptedBench()
    open_hand(bench)
    open_hand(bench, seconds=0.7)
    assert bench.log == [("digits", {}, ALL, {}), ("go", 0.15, {}), ("digits", {}, ALL, {}), ("go", 0.7, {})]


@pytest.mark.parametrize("turn", [0.0, 0.6])
def test_an_approach_goes_on_until_a_switch_closes(turn: float) -> None:
    """By 1.2 mm a hundredth of a second along its heading; 2 mm more where the palm touches."""

    def away(b: ScriptedBench) -> float:
        return math.cos(turn) * b.target["reach"] + math.sin(turn) * b.target["shift"]

    palm = ScriptedBench(world=lambda b: ("palm_centre",) if away(b) > 0.0101 else ())
    palm.target["turn"] = turn
    assert approach(palm, most_m=0.03)
    moves = palm.moves()
    assert [seconds for seconds, _ in moves] == [0.01] * 9 + [0.04]
    assert near(moves[0][1], reach=0.0012 * math.cos(turn), shift=0.0012 * math.sin(turn))
    assert away(palm) == pytest.approx(9 * 0.0012 + 0.002)
    # A finger ends it, without a push.
    finger = ScriptedBench(world=lambda b: ("ring_distal",) if away(b) > 0.0101 else ())
    finger.target["turn"] = turn
    assert not approach(finger, most_m=0.03)
    assert away(finger) == pytest.approx(9 * 0.0012)
    # Nothing in the way: so far and no farther.
    nothing = ScriptedBench()
    nothing.target["turn"] = turn
    assert not approach(nothing, most_m=0.03)
    assert away(nothing) == pytest.approx(0.03, abs=0.0013)
    assert away(nothing) >= 0.03
    other = ScriptedBench(world=lambda b: ("palm_centre",) if away(b) > 0.0101 else ())
    other.target["turn"] = turn
    approach(other, most_m=0.03, push_m=0.01)
    assert away(other) == pytest.approx(9 * 0.0012 + 0.01)
    # What was closed at its beginning counts; what was seen before does not.
    begun = ScriptedBench()
    begun.seen[:] = True
    assert not approach(begun, most_m=0.001)
    begun.closed[20] = True
    assert approach(begun, most_m=0.01)
    assert begun.moves()[-1][0] == 0.04


def test_squaring_up_turns_toward_the_side_that_does_not_touch() -> None:
    """By .06 rad about the column that touches, whose other side comes forward, until both touch or the other does."""
    for touching, sign in ((("palm_finger_upper",), 1), (("palm_thumb_lower",), -1)):
        both = ScriptedBench(
            world=lambda b, touching=touching: (
                (*touching, "palm_thumb_upper", "palm_finger_lower") if abs(b.target["turn"]) > 0.15 else touching
            )
        )
        both.seen[:] = np.array([name in touching for name in both.layout.names])
        assert square_up(both) == pytest.approx(sign * 0.18)
        assert both.target["turn"] == pytest.approx(sign * 0.18)
        seconds, first = both.moves()[0]
        assert seconds == 0.04
        assert near(first, reach=0.015 * 0.06, shift=0.0, turn=sign * 0.06)
        never = ScriptedBench(world=lambda b, touching=touching: touching)
        never.seen[:] = np.array([name in touching for name in never.layout.names])
        assert square_up(never) == pytest.approx(sign * 0.36)
        # Turned too far, the other side alone touches: back is no way.
        over = ScriptedBench(
            world=lambda b, touching=touching, sign=sign: (
                (("palm_thumb_upper",) if sign > 0 else ("palm_finger_upper",))
                if abs(b.target["turn"]) > 0.1
                else touching
            )
        )
        over.seen[:] = np.array([name in touching for name in over.layout.names])
        assert square_up(over) == pytest.approx(sign * 0.12)
    for none in ((), ("palm_centre",), ("palm_finger_upper", "palm_thumb_upper")):
        bench = ScriptedBench(world=lambda b, none=none: none)
        bench.seen[:] = np.array([name in none for name in bench.layout.names])
        assert square_up(bench) == 0.0
        assert not bench.log


def test_a_turn_that_loses_touch_finds_it_again_within_four_millimetres() -> None:
    bench = ScriptedBench()
    bench.seen[:] = np.array([name == "palm_finger_upper" for name in bench.layout.names])
    assert square_up(bench) == pytest.approx(0.06)
    told = bench.moves()
    assert told[0][0] == 0.04
    assert [seconds for seconds, _ in told[1:]] == [0.01] * 4
    again = ScriptedBench(
        world=lambda b: ("palm_finger_upper", "palm_thumb_upper") if b.target["reach"] > 0.0025 else ()
    )
    again.seen[:] = np.array([name == "palm_finger_upper" for name in again.layout.names])
    square_up(again)
    assert again.moves()[-1][0] == 0.04
    assert again.target["reach"] == pytest.approx(0.0009 + 2 * 0.0012 + 0.001, abs=2e-4)


# Another grip


def test_the_middle_is_half_a_breadth_ahead_and_as_far_aside_as_it_is_felt() -> None:
    bench = ScriptedBench(angles=angles_at(0.05, -0.02))
    bench.closed[:] = np.array([name in ("index_distal", "thumb_distal") for name in bench.layout.names])
    bench.target |= {"reach": 0.1, "shift": 0.2, "turn": 0.5}
    c, s = math.cos(0.5), math.sin(0.5)
    assert object_middle(bench) == pytest.approx((0.1 + c * 0.035 - s * 0.015, 0.2 + s * 0.035 + c * 0.015), abs=1e-6)
    bench.closed[:] = False
    assert object_middle(bench) == pytest.approx((0.1 + c * 0.04, 0.2 + s * 0.04))


def test_letting_go_sets_down_opens_and_steps_back() -> None:
    bench = ScriptedBench()
    bench.target |= {"wrist": 0.5, "turn": 0.3}
    let_go(bench)
    assert bench.log[:4] == [("go", 0.5, {"wrist": 0.0}), ("go", 0.1, {}), ("digits", {}, ALL, {}), ("go", 0.3, {})]
    assert bench.log[4][1] == 0.3
    assert near(bench.log[4][2], reach=-0.11 * math.cos(0.3), shift=-0.11 * math.sin(0.3))
    assert len(bench.log) == 5
    # From above it rises first, turns back behind the object, and comes down.
    above = ScriptedBench()
    above.target |= {"roll": 1.5, "raise": 0.02}
    let_go(above)
    moves = above.moves()[3:]
    assert [seconds for seconds, _ in moves] == [0.3, 0.5, 0.4]
    assert near(moves[0][1], **{"raise": 0.12})
    assert near(moves[1][1], reach=-0.22, shift=0.0, roll=0.0)
    assert near(moves[2][1], **{"raise": 0.0})


def test_going_round_ends_clear_of_the_object_and_faces_it() -> None:
    bench = ScriptedBench()
    move_round(bench, (0.2, 0.1), turn_rad=0.7, raise_m=-0.01)
    ((seconds, told),) = bench.moves()
    assert seconds == 0.6
    away = 0.11 + 0.04
    assert near(told, reach=0.2 - away * math.cos(0.7), shift=0.1 - away * math.sin(0.7), turn=0.7, **{"raise": -0.01})


def test_a_regrasp_lets_go_goes_round_searches_and_grasps(monkeypatch: pytest.MonkeyPatch) -> None:
    done: list[Any] = []
    found = [True]

    def note(name: str, answer: Any) -> Any:
        def call(bench: Any, *where: Any, **how: Any) -> Any:
            done.append((name, *where, how))
            return answer() if callable(answer) else answer

        return call

    module = importlib.import_module("varishold.hand.actions.regrasp")
    for name, answer in (
        ("let_go", None),
        ("move_round", None),
        ("search", lambda: type("Found", (), {"found": found[0]})()),
        ("approach", True),
        ("squeeze", "squeezed"),
        ("five_step", "five"),
    ):
        monkeypatch.setattr(module, name, note(name, answer))
    bench = ScriptedBench()
    bench.target |= {"turn": 0.2, "raise": 0.01}
    assert module.regrasp(bench, turn_rad=0.5, raise_m=-0.02, middle_m=(0.3, 0.4), pad_steps=(1, 5)) == "five"
    assert [each[0] for each in done] == ["let_go", "move_round", "search", "approach", "five_step"]
    assert done[1][1] == (0.3, 0.4)
    assert done[1][2] == pytest.approx({"turn_rad": 0.7, "raise_m": -0.01})
    assert done[2][1] == pytest.approx({"most_m": 0.14})
    assert done[3][1] == {"most_m": 0.03}
    assert done[4][1] == {"pads": None, "pad_steps": (1, 5)}
    done.clear()
    assert module.regrasp(bench, by="squeeze") == "squeezed"
    assert done[1][1] == pytest.approx((0.04 * math.cos(0.2), 0.04 * math.sin(0.2)))
    found[0] = False
    done.clear()
    assert module.regrasp(bench) == ()
    assert done[-1][0] == "search"
    assert regrasp is module.regrasp


# The fingertip


def test_a_fingertip_comes_down_on_what_it_stands_behind() -> None:
    def world(b: ScriptedBench) -> tuple[str, ...]:
        if b.target["roll"] == 0:
            return ("palm_centre",) if b.target["reach"] > 0.06 else ()
        return ("index_distal",) if b.target["raise"] < 0.0305 else ()

    bench = ScriptedBench(world=world, angles=np.zeros(15))
    felt = fingertip(bench, inward_m=0.02)
    moves = bench.moves()
    # Forward until it touches and back, up, folded, over the object, and down by a tenth of a metre a second.
    touched = next(k for k, (seconds, _) in enumerate(moves) if seconds == 0.3)
    at = moves[touched - 1][1]["reach"]
    assert near(moves[touched][1], reach=at - 0.12, shift=0.0)
    assert moves[touched + 1] == (0.5, {"raise": 0.10, "wrist": 0.0})
    over = moves[touched + 2]
    tip = DESIGN.knuckle_m[0] + 0.046 + 0.030 + 0.013
    assert over[0] == 0.5
    assert near(over[1], reach=at - 0.12 + 0.12 + 0.02 - tip, shift=1.5 * 0.022, roll=math.pi / 2)
    down = moves[touched + 3 :]
    assert down[0] == (0.01, pytest.approx({"raise": 0.099}))
    assert [seconds for seconds, _ in down] == [0.01] * 70 + [0.05]
    assert bench.target["raise"] == pytest.approx(0.029)
    (pose,) = [entry for entry in bench.log if entry[0] == "digits" and entry[3]]
    assert pose[3] == {"index": (0.0, 0.0, 0.0), "thumb": (1.7, 1.9, 1.5)}
    assert pose[2] == ("middle", "ring", "little")
    assert felt.touched
    place = phalanges(np.zeros(15), DESIGN)
    assert felt.height_m == pytest.approx(0.029 + place.middle_m[place.parts.index("index.distal"), 1])
    assert (felt.step.number, felt.step.name) == (1, "fingertip")
    # Meeting nothing it ends eight centimetres below the palm's zero; by default 15 mm behind the face.
    nothing = ScriptedBench()
    missed = fingertip(nothing)
    assert not missed.touched
    assert nothing.target["raise"] == pytest.approx(-0.08, abs=0.0011)
    assert nothing.moves()[-1][0] == 0.01
    went = nothing.target["reach"]
    assert went == pytest.approx(0.20 + 0.015 - tip, abs=0.0013)
