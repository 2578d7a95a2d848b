"""Laws of a hand from a file: the built-in hand in one is the built-in hand; the second hand does what it can."""

from __future__ import annotations

import json
import pickle
from dataclasses import replace
from pathlib import Path

import mujoco
import numpy as np
import pytest
from tests.test_hand_file import refused, run, write_gripper

from varishold.cli.hand_file import require_library_of
from varishold.exploration import TOUCHES, Episode, grip_contacts, perceive
from varishold.exploration.hand_library import feel_library
from varishold.exploration.kept import keeper, kept_examples
from varishold.exploration.object_examples import example_setting, feel_once
from varishold.exploration.touches import touches_of
from varishold.hand import PAPER_22, HandDesign, HandSetting, grasp_object, hand_setting, read_hand, set_up
from varishold.hand.bench import Sensed
from varishold.hand.mjcf import MjcfHand
from varishold.perceive import Evidence, Library, Perceiver, read_library, write_library


def described(design: HandDesign, folder: Path) -> MjcfHand:
    """The built-in hand as an MJCF and a file."""
    spec = mujoco.MjSpec()
    spec.compiler.degree = False
    palm = spec.worldbody.add_body(name="palm")
    design.add_body(mujoco, spec, palm, replace(PAPER_22, switches=()), {})
    spec.compile()
    (folder / "hand.xml").write_text(spec.to_xml())
    text = ['mjcf = "hand.xml"', 'pads = "all"', "[palm]", 'body = "palm"', "origin_m = [0, 0, 0]"]
    for digit in design.digits.values():
        text += ["[[digits]]", f'name = "{digit.name}"', f"joints = {json.dumps(digit.parts)}"]
        text += ["opposed = true"] if digit.opposed else []
    for switch in PAPER_22.switches:
        text += ["[[switches]]", f'name = "{switch.name}"', f'part = "{switch.part}"']
        text += [f"y_m = {switch.y_m}", f"z_m = {switch.z_m}"] if switch.part == "palm" else []
    (folder / "paper.toml").write_text("\n".join(text))
    return read_hand(folder / "paper.toml")


@pytest.fixture(scope="module")
def same(tmp_path_factory: pytest.TempPathFactory) -> MjcfHand:
    return described(HandDesign(), tmp_path_factory.mktemp("paper"))


def test_the_built_in_hand_in_a_file_has_its_joints_parts_and_switches(same: MjcfHand) -> None:
    design = HandDesign()
    assert same.joints == design.joints
    assert same.parts == design.parts == same.pads
    assert same.layout.switches == PAPER_22.switches
    assert (same.pointer, same.supporter, same.tip) == (design.pointer, design.supporter, design.tip)
    assert same.opened() == pytest.approx(design.opened())
    assert same.tip_place_m[1] == pytest.approx(design.tip_place_m[1])
    # The tip's joints bend a little, as far as they can be straightened.
    assert same.tip_place_m[0] == pytest.approx(design.tip_place_m[0], abs=0.005)
    for digit in design.digits:
        assert np.sign(same.closing(digit)).tolist() == [1, 1, 1]
    for part in design.parts:
        assert same.pad_size_m(part)[0] == pytest.approx(design.pad_size_m(part)[0], abs=1e-9)


@pytest.mark.parametrize("seed", range(5))
def test_its_capsules_are_those_of_the_design_at_any_angles(same: MjcfHand, seed: int) -> None:
    design, rng = HandDesign(), np.random.default_rng(seed)
    angles = rng.uniform(-0.6, 1.5, len(design.joints))
    sensed = Sensed(rng.random(22) < 0.5, np.zeros(22), angles, np.zeros(6))
    ours, theirs = (grip_contacts(sensed, hand, PAPER_22) for hand in (design, same))
    assert ours.parts == theirs.parts
    for name in ("start_m", "end_m", "radius_m", "half_height_m", "touched"):
        np.testing.assert_allclose(getattr(theirs, name), getattr(ours, name), atol=1e-9)
    np.testing.assert_allclose(same.phalanges(angles).inward, design.phalanges(angles).inward, atol=1e-9)


def test_its_pads_lie_where_those_of_the_design_lie(same: MjcfHand) -> None:
    benches = [set_up("cylinder", 0.08, seed=1, setting=setting)[0] for setting in (HandSetting(), hand_setting(same))]
    for part in HandDesign().parts:
        for ours, theirs in zip(*(bench.pad_frame(part) for bench in benches), strict=True):
            np.testing.assert_allclose(theirs, ours, atol=1e-9)


def test_a_switch_feels_what_a_touch_sensor_would(same: MjcfHand) -> None:
    bench, rng = set_up("square-pillar", 0.08, seed=2, setting=hand_setting(same))
    bench.close_all()
    bench.advance(0.4)
    forces = dict(zip(same.layout.names, bench.wiring.forces_n(bench.data), strict=True))
    by_part: dict[str, float] = {}
    for switch in same.layout.switches:
        by_part[switch.part] = by_part.get(switch.part, 0.0) + forces[switch.name]
    felt = bench.object_forces_n()
    touched = [part for part in same.parts[:-1] if felt[part] > 0]
    assert len(touched) >= 3
    for part in touched:
        assert by_part[part] >= felt[part] - 1e-9
    assert all(force >= 0 for force in forces.values())
    assert rng is not None


def test_the_same_seed_gives_the_same_and_a_hand_can_be_sent_to_another_process(same: MjcfHand) -> None:
    setting = hand_setting(same, search=True)
    sent = pickle.loads(pickle.dumps(setting))
    assert sent == setting
    one, two = (grasp_object("box", 0.08, seed=6, setting=each) for each in (setting, sent))
    assert one.end.sensed.angles_rad.tobytes() == two.end.sensed.angles_rad.tobytes()
    assert one.end.sensed.forces_n.tobytes() == two.end.sensed.forces_n.tobytes()


@pytest.fixture(scope="module")
def three() -> MjcfHand:
    return read_hand("three-finger")


def test_the_second_hand_has_three_fingers_and_twelve_switches(three: MjcfHand) -> None:
    assert len(three.all_digits) == 3
    assert len(three.layout.switches) == 12
    assert list(three.steps) == [1, 2, 3, 4, 5]
    assert three.tip == "upper.distal"
    assert set(touches_of(three)) == set(TOUCHES)


@pytest.mark.parametrize(("name", "size_m"), [("cylinder", 0.08), ("square-pillar", 0.06)])
def test_the_second_hand_grasps_and_its_section_fits(three: MjcfHand, name: str, size_m: float) -> None:
    done = grasp_object(name, size_m, seed=4, setting=hand_setting(three, search=True, still=True))
    assert done.held
    contacts = grip_contacts(done.end.sensed, three, three.layout)
    assert contacts.touched.sum() >= 3


def test_every_touch_of_the_second_hand_says_something(three: MjcfHand, tmp_path: Path) -> None:
    setting = example_setting(three)
    felt = feel_once("cylinder", 0.08, seed=3, setting=setting)
    assert [evidence.touch for evidence in felt] == list(TOUCHES)
    grasp = felt[0].values
    assert {f"switch.{name}" for name in three.layout.names} <= set(grasp)
    assert {f"pad.{part}.on" for part in three.parts} <= set(grasp)
    assert "fit.circle.off" in grasp
    again = feel_once("cylinder", 0.08, seed=3, setting=setting)
    assert [dict(one.values) for one in felt] == [dict(one.values) for one in again]
    # Of what was made somebody looked at the clock.
    assert all((evidence.seconds is None) == evidence.failed for evidence in felt)
    assert Library.from_examples({"cylinder": [felt, again]}).seconds == {
        evidence.touch: evidence.seconds for evidence in felt if not evidence.failed
    }
    with keeper(tmp_path / "felt.jsonl", {3: felt}):
        assert kept_examples(tmp_path / "felt.jsonl") == {3: felt}


def test_a_hand_without_tip_and_pads_offers_grips_of_switches_alone(tmp_path: Path) -> None:
    hand = read_hand(write_gripper(tmp_path))
    setting = example_setting(hand)
    assert setting.pads is None
    assert not any(name.startswith("fingertip") for name in touches_of(hand))
    episode = Episode(*set_up("cylinder", 0.06, seed=3, setting=setting), setting)
    felt = episode.touch(TOUCHES["squeeze"])
    assert felt is not None
    evidence, surfaces = felt.touch.evidence(felt, setting)
    assert surfaces == {}
    assert {name for name in evidence.values if name.startswith("switch.")} == {"switch.l", "switch.r", "switch.p"}
    with pytest.raises(ValueError, match="no digit of this hand can come down"):
        TOUCHES["fingertip-edge"].make(episode.bench, episode.pose, setting)
    with pytest.raises(ValueError, match="unknown touch 'fingertip-edge'; known are grasp, squeeze, regrasp-higher"):
        perceive("cylinder", 0.06, seed=1, setting=setting, order=("grasp", "fingertip-edge"))


def few(hand: MjcfHand | None) -> Library:
    """A library of nearly nothing, said to be of a hand."""
    rng = np.random.default_rng(1)
    rows = {
        name: [
            [Evidence("grasp", {"switch.upper_distal": float(rng.random()), "fit.x": k + rng.normal()})]
            for _ in range(12)
        ]
        for k, name in enumerate(("a", "b"))
    }
    return Library.from_examples(rows, hand=None if hand is None else hand.identity)


def test_a_library_keeps_its_hand_and_is_refused_to_another(three: MjcfHand, tmp_path: Path) -> None:
    path = tmp_path / "own.npz"
    write_library(few(three), path)
    own = read_library(path)
    assert own.hand == three.identity
    assert own.with_object("c", [[Evidence("grasp", {"fit.x": 1.0})]]).hand == three.identity
    require_library_of(three, own, where="own.npz", given="three-finger")
    require_library_of(HandDesign(), few(None), where="shipped", given="")
    with pytest.raises(ValueError, match=r"own.npz: was felt by another hand, 'three-finger'; name that hand"):
        require_library_of(HandDesign(), own, where="own.npz", given="")
    changed = replace(three, identity="three-finger@0")
    with pytest.raises(ValueError, match="was felt by this hand before its files changed; make this hand's own with"):
        require_library_of(changed, own, where="own.npz", given="three-finger")
    touch = ("perceive", "cylinder", "--size-m", "0.06", "--library", str(path))
    assert "was felt by another hand, 'three-finger'" in refused(*touch)
    gripper = write_gripper(tmp_path)
    assert "varishold objects feel --hand" in refused(*touch, "--hand", str(gripper))
    assert "was felt by another hand" in refused(
        "objects", "taxels", "noise=.02", "--library", str(path), "-o", f"{tmp_path}/b.npz"
    )


def test_the_file_of_a_hand_may_name_its_library(three: MjcfHand, tmp_path: Path) -> None:
    gripper = write_gripper(tmp_path)
    gripper.write_text('library = "own.npz"\n' + gripper.read_text())
    hand = read_hand(gripper)
    assert hand.library == str(tmp_path / "own.npz")
    assert "own.npz: there is no such file" in refused("perceive", "box", "--size-m", "0.06", "--hand", str(gripper))
    write_library(few(hand), tmp_path / "own.npz")
    done = run(
        "perceive", "cylinder", "--size-m", "0.06", "--seed", "2", "--hand", str(gripper), "--json",
        "--report", f"{tmp_path}/page.html",
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    end = json.loads(done.stdout.splitlines()[-1])
    assert (end["hand"], end["true_object"]) == ("gripper", "cylinder")
    assert end["trace"][0]["touch"] == "grasp"
    assert (tmp_path / "page.html").stat().st_size > 10_000


def test_a_library_is_felt_and_used(three: MjcfHand, tmp_path: Path) -> None:
    setting = example_setting(three)
    counted: list[None] = []
    made = feel_library(
        setting, examples=2, lumps=1, processes=1, keep=tmp_path / "kept.jsonl", progress=lambda: counted.append(None)
    )
    assert len(counted) == 21
    assert made.hand == three.identity
    begun = len((tmp_path / "kept.jsonl").read_text().splitlines())
    assert begun == 21
    again = feel_library(setting, examples=2, lumps=1, processes=1, keep=tmp_path / "kept.jsonl")
    assert again.objects == made.objects
    done = perceive("cylinder", 0.08, seed=5, setting=setting, perceiver=Perceiver(made, refuse=False, most_touches=2))
    assert done.perception is not None
