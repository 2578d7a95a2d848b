"""Laws of touches without a simulation: words, falls, orders, capsules from joints, evidence from what was felt."""

from __future__ import annotations

from dataclasses import dataclass, field
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

pytest.importorskip("mujoco", reason="MuJoCo is not installed; pip install -e '.[sim]'")

from varishold.exploration import TOUCHES, Felt, PoseEstimate, examples, loop
from varishold.exploration import episode as episodes
from varishold.exploration.capsules import grip_contacts
from varishold.exploration.episode import Episode
from varishold.exploration.touch import surfaces_of
from varishold.exploration.touches import Fingertip, Grasp, Regrasp, Squeeze, fingertip, grasp, grip, regrasp
from varishold.hand import HandSetting, PadSetting
from varishold.hand.bench import Sensed
from varishold.hand.coordinates import phalanges
from varishold.perceive import Evidence, NextTouch

SETTING = HandSetting(pads=PadSetting())
LAYOUT, DESIGN = SETTING.layout, SETTING.design

# Words


@pytest.mark.parametrize(
    ("touch", "words"),
    [
        (TOUCHES["grasp"], "grasped it in five steps and lifted it"),
        (TOUCHES["squeeze"], "closed all digits about it"),
        (TOUCHES["regrasp-higher"], "gripped it 20 mm higher"),
        (TOUCHES["regrasp-lower"], "gripped it 20 mm lower"),
        (TOUCHES["regrasp-turned-45"], "gripped it from 45° round"),
        (TOUCHES["regrasp-turned-90"], "gripped it from 90° round"),
        (Regrasp(name="both", turn_rad=np.pi / 6, raise_m=-0.005), "gripped it from 30° round and 5 mm lower"),
        (Regrasp(name="neither"), "gripped it again"),
        (TOUCHES["fingertip-edge"], "came down on its top with a fingertip, 15 % of its breadth behind the near side"),
        (TOUCHES["fingertip-middle"], "came down on its top with a fingertip, in the middle"),
        (
            TOUCHES["fingertip-beyond"],
            "came down on its top with a fingertip, 120 % of its breadth behind the near side",
        ),
    ],
)
def test_a_touch_says_what_was_done(touch: Any, words: str) -> None:
    assert touch.done == words
    assert TOUCHES.get(touch.name, touch) is touch
    assert touch.begins == isinstance(touch, Grasp)
    assert touch.cost == 1.0


def sensed(on: tuple[str, ...] = ()) -> Sensed:
    angles = np.random.default_rng(0).uniform(0.1, 0.9, len(DESIGN.joints))
    n = len(LAYOUT.names)
    return Sensed(np.array([name in on for name in LAYOUT.names]), np.zeros(n), angles, np.zeros(6))


def test_a_fingertip_says_where_it_came_to_rest() -> None:
    tip = TOUCHES["fingertip-middle"]
    step: Any = SimpleNamespace(pads=None)
    for height, words in (
        (None, "met nothing"),
        (0.0, "came to rest 0 mm above the palm's middle"),
        (0.012, "came to rest 12 mm above the palm's middle"),
        (-0.012, "came to rest 12 mm below the palm's middle"),
    ):
        felt = Felt(tip, step, height)
        assert tip.felt_in_words(felt, {}) == words
        evidence, surfaces = tip.evidence(felt, SETTING)
        assert surfaces == {}
        assert evidence.touch == "fingertip-middle"
        assert evidence.values == {
            "tip.touched": float(height is not None),
            "tip.height": -0.1 if height is None else height,
        }
        assert evidence.remarks == ("fingertip-middle: nothing is known of all pads",)


# Pads


def pads(**frames: np.ndarray) -> Any:
    return SimpleNamespace(frames=frames, pitch_m=dict.fromkeys(frames, (2e-3, 2e-3)))


def test_a_pad_presses_nothing_or_something_or_is_not_to_be_believed() -> None:
    bump = np.zeros((8, 8))
    bump[2:6, 2:6] = 5e4
    step: Any = SimpleNamespace(pads=pads(a=bump, b=np.zeros((8, 8)), c=np.where(bump > 0, np.nan, 0.0), d=bump))
    felt = Felt(TOUCHES["grasp"], step)
    found = surfaces_of(felt.step, SETTING, ("a", "b", "c"))
    assert list(found) == ["a", "b"]
    assert found["a"] is not None
    assert found["b"] is None
    assert felt.missing(found, ("a", "b")) == ()
    assert felt.missing(found, ("a", "b", "c")) == ("grasp: nothing is known of pad c",)
    assert felt.missing(found, ("c", "d", "a")) == ("grasp: nothing is known of pad c, d",)
    assert felt.missing({}, ("c", "d")) == ("grasp: nothing is known of all pads",)
    assert found["a"].centre_m == pytest.approx((0, 0), abs=1e-6)


# Capsules


def test_capsules_are_the_phalanges_and_buttons_and_touch_where_their_switches_are_closed() -> None:
    some = LAYOUT.names[::3]
    here = sensed(tuple(some))
    contacts = grip_contacts(here, DESIGN, LAYOUT)
    place = phalanges(here.angles_rad, DESIGN)
    n = len(place.parts)
    buttons = [switch for switch in LAYOUT.switches if switch.part == "palm"]
    assert contacts.parts == (*place.parts, *(f"palm.{button.name}" for button in buttons))
    np.testing.assert_allclose(np.linalg.norm(contacts.end_m - contacts.start_m, axis=1)[:n], place.length_m)
    np.testing.assert_array_equal(contacts.end_m[n:], contacts.start_m[n:])
    np.testing.assert_array_equal(contacts.radius_m[:n], place.radius_m)
    assert (contacts.radius_m[n:] == DESIGN.button_radius_m).all()
    # A button's ball stands out of the palm by its radius, to x = 0.
    assert (contacts.start_m[n:, 0] == -DESIGN.button_radius_m).all()
    np.testing.assert_array_equal(contacts.start_m[n:, 1:], [(button.y_m, button.z_m) for button in buttons])
    closed = {switch.part for switch, name in zip(LAYOUT.switches, LAYOUT.names, strict=True) if name in some}
    for k, part in enumerate(place.parts):
        assert contacts.touched[k] == (part in closed)
        assert contacts.half_height_m[k] == place.radius_m[k] + DESIGN.digit_of[part].breadth_m / 2  # type: ignore[index]
    for k, button in enumerate(buttons):
        assert contacts.touched[n + k] == (button.name in some or LAYOUT.names[LAYOUT.switches.index(button)] in some)


def test_few_closed_switches_fit_no_section() -> None:
    step: Any = SimpleNamespace(sensed=sensed(tuple(LAYOUT.names[:1])), pads=None)
    evidence, surfaces = TOUCHES["squeeze"].evidence(Felt(TOUCHES["squeeze"], step), SETTING)
    assert surfaces == {}
    assert evidence.remarks == (
        "squeeze: nothing is known of all pads",
        "squeeze: fewer than three parts touch, so that no section can be fitted",
    )
    assert evidence.reasons == ()
    assert {name: value for name, value in evidence.values.items() if value} == {f"switch.{LAYOUT.names[0]}": 1.0}
    words = TOUCHES["squeeze"].felt_in_words(Felt(TOUCHES["squeeze"], step), {"a": None})
    assert words == f"1 of {len(LAYOUT.names)} switches closed, 0 of 1 pads pressed"
    named = SimpleNamespace(name="curved"), SimpleNamespace(name="flat")
    words = TOUCHES["squeeze"].felt_in_words(
        Felt(TOUCHES["squeeze"], step),
        {"a": None, "b": named[0], "c": named[1], "d": named[0]},  # type: ignore[dict-item]
    )
    assert words == f"1 of {len(LAYOUT.names)} switches closed, 3 of 4 pads pressed (1 flat, 2 curved)"


# Hands that move


@dataclass
class Moved:
    """A bench that notes what is asked of it."""

    target: dict[str, float] = field(default_factory=lambda: {"turn": 0.1, "raise": 0.2})
    design: Any = DESIGN
    layout: Any = LAYOUT
    circumstances: Any = field(default_factory=lambda: SimpleNamespace(forward_m=0.1, sideways_m=0.2, yaw_rad=0.3))
    time_s: float = 0.0


def test_a_regrasp_goes_from_where_the_hand_is_to_where_it_was_first(monkeypatch: pytest.MonkeyPatch) -> None:
    asked: dict[str, Any] = {}
    monkeypatch.setattr(regrasp, "regrasp", lambda bench, **how: asked.update(how) or ())
    touch = Regrasp(name="x", turn_rad=0.7, raise_m=-0.02)
    pose = PoseEstimate(turn_rad=1.0, raise_m=0.5, middle_m=(3.0, 4.0))
    assert touch.close(Moved(), pose, SETTING) == ()  # type: ignore[arg-type]
    assert asked == {
        "turn_rad": pytest.approx(1.6),
        "raise_m": pytest.approx(0.28),
        "by": "squeeze",
        "middle_m": (3.0, 4.0),
        "pads": SETTING.pads,
    }


def test_a_first_grip_is_made_where_the_object_is_found_and_keeps_where_the_palm_was(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(grasp, "five_step", lambda bench, pads: ("five", pads))
    monkeypatch.setattr(grasp, "squeeze", lambda bench, pads: ("squeeze", pads))
    for found, made in ((None, True), (SimpleNamespace(found=True), True), (SimpleNamespace(found=False), False)):
        monkeypatch.setattr(grasp, "come_before", lambda bench, setting, found=found: found)
        for touch, word in ((Grasp(name="g"), "five"), (Squeeze(name="s"), "squeeze")):
            pose = PoseEstimate()
            steps = touch.close(Moved(), pose, SETTING)  # type: ignore[arg-type]
            assert steps == ((word, SETTING.pads) if made else ())
            assert (pose.turn_rad, pose.raise_m) == ((0.1, 0.2) if made else (0.0, 0.0))


def test_a_grip_keeps_middle_and_breadth_and_is_none_where_nothing_is_felt(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(grip, "object_middle", lambda bench: (0.5, 0.6))
    last: Any = SimpleNamespace(felt=True, sensed=None)
    for steps, breadth in (
        ((), None),
        ((SimpleNamespace(felt=False),), None),
        ((None, last), (0.07, 1.0)),
        ((last,), None),
    ):
        monkeypatch.setattr(grip, "gripped", lambda sensed, design, layout, breadth=breadth: breadth)
        monkeypatch.setattr(Grasp, "close", lambda self, bench, pose, setting, steps=steps: steps)
        pose = PoseEstimate()
        felt = TOUCHES["grasp"].make(Moved(), pose, SETTING)  # type: ignore[arg-type]
        if steps and steps[-1].felt:
            assert felt == Felt(TOUCHES["grasp"], last)
            assert pose.middle_m == (0.5, 0.6)
            assert pose.breadth_m == (0.07 if breadth else 0.08)
        else:
            assert felt is None
            assert pose == PoseEstimate()


def test_a_fingertip_comes_down_behind_the_near_side(monkeypatch: pytest.MonkeyPatch) -> None:
    calls: list[Any] = []
    monkeypatch.setattr(fingertip, "let_go", lambda bench: calls.append("let go"))
    monkeypatch.setattr(fingertip, "move_round", lambda bench, middle, **how: calls.append((middle, how)))
    monkeypatch.setattr(fingertip, "object_middle", lambda bench: (9.0, 9.0))
    for touched in (True, False):
        tip = SimpleNamespace(step="step", touched=touched, height_m=0.03)
        monkeypatch.setattr(fingertip, "fingertip", lambda bench, tip=tip, **how: calls.append(how) or tip)
        for middle in (None, (1.0, 2.0)):
            calls.clear()
            touch = Fingertip(name="t", inward=0.25)
            felt = touch.make(Moved(), PoseEstimate(0.4, 0.3, middle, 0.06), SETTING)  # type: ignore[arg-type]
            assert calls == [
                "let go",
                (middle or (9.0, 9.0), {"turn_rad": 0.4, "raise_m": 0.3}),
                {"inward_m": pytest.approx(0.015), "pads": SETTING.pads},
            ]
            assert felt == Felt(touch, "step", 0.03 if touched else None)  # type: ignore[arg-type]


# Falls and orders


@dataclass(frozen=True, kw_only=True)
class Toy(Grasp):
    """A touch that misses so many times."""

    misses: list[str]

    def make(self, bench: Any, pose: PoseEstimate, setting: HandSetting) -> Felt | None:
        bench.time_s += 1.0
        if self.misses and self.misses.pop():
            return None
        pose.breadth_m = 0.123
        return Felt(self, SimpleNamespace(name=self.name))  # type: ignore[arg-type]


@pytest.mark.parametrize(("misses", "given_up"), [(0, False), (1, False), (2, False), (11, False), (12, True)])
def test_after_a_fall_the_object_stands_up_and_all_digits_close(
    monkeypatch: pytest.MonkeyPatch, misses: int, given_up: bool
) -> None:
    left = ["x"] * misses
    wanted, other = Toy(name="wanted", misses=left), Toy(name="squeeze", misses=left)
    monkeypatch.setitem(TOUCHES, "squeeze", other)
    stood: list[Any] = []
    monkeypatch.setattr(episodes, "stand_up", lambda *how: stood.append(how))
    fallen: list[str] = []
    watched: list[Any] = []
    bench: Any = SimpleNamespace(time_s=0.0)
    episode = Episode(
        bench,
        "rng",
        SETTING,
        lambda touch: fallen.append(touch.name),
        lambda bench, step: watched.append(step.name),  # type: ignore[arg-type, return-value]
    )
    episode.pose.breadth_m = 0.5
    felt = episode.touch(wanted)
    assert (felt is None) == given_up
    assert episode.drops == len(stood) == len(fallen) == misses
    assert fallen == ["wanted", *["squeeze"] * (misses - 1)][:misses]
    assert stood == [(bench, SETTING, "rng")] * misses
    # Each try takes a second, whether it holds or not.
    assert episode.seconds == misses + (felt is not None)
    if felt is not None:
        assert felt.touch is (other if misses else wanted)
        assert watched == [felt.touch.name]
        assert episode.pose.breadth_m == 0.123
    else:
        assert episode.pose == PoseEstimate()
        assert watched == []
    bare = Episode(bench, "rng", SETTING)  # type: ignore[arg-type]
    assert bare.touch(Toy(name="w", misses=["x"])) is not None


def test_an_example_holds_every_touch_that_was_made(monkeypatch: pytest.MonkeyPatch) -> None:
    made: list[Any] = []
    placed: list[Any] = []
    monkeypatch.setattr(examples, "set_up", lambda name, size_m, *, seed, setting: (Moved(), None))
    monkeypatch.setattr(examples, "stand_up_at", lambda bench, setting, place: placed.append(place))

    def make(self: Any, bench: Any, pose: Any, setting: Any) -> Felt | None:
        made.append((self.name, setting.pads is not None, id(pose)))
        bench.time_s += 2.0
        return None if self.name in missing else Felt(self, self.name)  # type: ignore[arg-type]

    for kind in (Grasp, Squeeze, Regrasp, Fingertip):
        monkeypatch.setattr(kind, "make", make)
    for missing in ((), ("grasp",), ("regrasp-higher",), ("squeeze",)):
        made.clear()
        got = examples.touch_all("ball", 0.05, seed=4, setting=SETTING)
        names = [name for name, _, _ in made]
        assert names[:2] == ["grasp", "squeeze"]
        assert placed[-1] == (0.1, 0.2, 0.3)
        if "squeeze" in missing:
            assert set(got) == {"grasp"}
            continue
        assert names[-2:] == ["squeeze", "fingertip-beyond"]
        assert sorted(names[2:-2]) == sorted(set(TOUCHES) - {"grasp", "squeeze", "fingertip-beyond"})
        assert set(got) == set(TOUCHES) - set(missing)
        # The last squeeze is only to hold it: its pads are not asked.
        assert [asked for _, asked, _ in made] == [True] * (len(made) - 2) + [False, True]
        assert {felt.seconds for felt in got.values()} == {2.0}
        # One estimate of the pose serves a grip and all that follows it.
        assert len({pose for _, _, pose in made[1:-2]}) == 1
    other = []
    made.clear()
    missing = ()
    for seed in range(6):
        made.clear()
        examples.touch_all("ball", 0.05, seed=seed, setting=SETTING)
        other.append(tuple(name for name, _, _ in made))
    assert len(set(other)) > 2


def test_the_next_touch_is_chosen_or_the_first_of_the_order_that_is_left() -> None:
    class Chooser:
        belief = SimpleNamespace(touches=("grasp", "fingertip-edge"))

        def plan(self, can: list[str]) -> NextTouch:
            self.can = can
            return NextTouch(can[0], 0.5)

    perceiver: Any = Chooser()
    assert loop._next(perceiver, None) == NextTouch("regrasp-higher", 0.5)
    assert perceiver.can == [name for name in TOUCHES if name not in ("grasp", "squeeze", "fingertip-edge")]
    assert loop._next(perceiver, ["grasp", "squeeze", "regrasp-lower"]) == "squeeze"
    assert loop._next(perceiver, ["fingertip-edge", "grasp"]) is None


def test_a_touch_counts_as_chosen_where_it_is_the_one_that_was_wanted(monkeypatch: pytest.MonkeyPatch) -> None:
    class Touched(Toy):
        def evidence(self, felt: Felt, setting: HandSetting) -> Any:
            return Evidence(self.name, {}), {}

    class Knower:
        prior = None

        def __init__(self) -> None:
            self.told: list[str] = []
            self.failures: list[str] = []
            self.belief = SimpleNamespace(touches=())

        def forget(self, *, pose: str | None = None) -> None:
            self.told.clear()

        def failed(self, name: str) -> None:
            self.failures.append(name)

        def feel(self, evidence: Evidence) -> str:
            self.told.append(evidence.touch)
            return f"update {len(self.told)}"

        @property
        def stopped(self) -> bool:
            return len(self.told) >= 3

        def plan(self, can: list[str]) -> NextTouch:
            return NextTouch("fingertip-edge", 0.25, 5.0)

        def answer(self) -> str:
            return "answer"

    monkeypatch.setattr(loop, "set_up", lambda name, size_m, *, seed, setting: (SimpleNamespace(time_s=0.0), None))
    monkeypatch.setattr(episodes, "stand_up", lambda *how: None)
    monkeypatch.setitem(TOUCHES, "grasp", Touched(name="grasp", misses=[]))
    monkeypatch.setitem(TOUCHES, "squeeze", Touched(name="squeeze", misses=[]))
    monkeypatch.setitem(TOUCHES, "fingertip-edge", Touched(name="fingertip-edge", misses=["", "x"]))
    knower: Any = Knower()
    seen: list[Any] = []
    done = loop.perceive("ball", 0.05, seed=7, perceiver=knower, setting=SETTING, on_touch=seen.append)
    # The fingertip misses once: a squeeze takes its place, and was not chosen.
    assert knower.told == ["grasp", "squeeze", "fingertip-edge"]
    assert knower.failures == ["fingertip-edge"]
    assert [touch.chosen_for for touch in done.touches] == [None, None, 0.25]
    assert [touch.then for touch in done.touches] == [("fingertip-edge", 0.25)] * 2 + [None]
    assert [touch.planned for touch in done.touches] == [NextTouch("fingertip-edge", 0.25, 5.0)] * 2 + [None]
    # The miss is part of what the squeeze took.
    assert [touch.seconds for touch in done.touches] == [1.0, 2.0, 1.0]
    assert done.seconds == 4.0
    assert [touch.update for touch in done.touches] == ["update 1", "update 2", "update 3"]
    assert (done.name, done.size_m, done.seed, done.drops, done.perception) == ("ball", 0.05, 7, 1, "answer")
    assert tuple(seen) == done.touches
    monkeypatch.setitem(TOUCHES, "grasp", Touched(name="grasp", misses=["x"] * 99))
    monkeypatch.setitem(TOUCHES, "squeeze", Touched(name="squeeze", misses=["x"] * 99))
    never = loop.perceive("ball", 0.05, seed=7, perceiver=Knower(), setting=SETTING)  # type: ignore[arg-type]
    assert (never.touches, never.perception, never.drops) == ((), None, 12)
