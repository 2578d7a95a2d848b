"""The hand at work, in simulation: grips, falls, other grips, pads, tables."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("mujoco", reason="MuJoCo is not installed; pip install -e '.[sim]'")

from varishold.errors import InputError
from varishold.hand import (
    PAPER_22,
    HandDesign,
    HandSetting,
    Job,
    PadSetting,
    Step,
    collect_grasps,
    grasp_object,
    run_jobs,
    set_up,
)
from varishold.hand.actions import approach, fingertip, five_step, let_go, regrasp, search, squeeze
from varishold.hand.bench import Bench
from varishold.hand.coordinates import contact_points, grip_circle, touching
from varishold.hand.features import FEATURE_GROUPS, features
from varishold.hand.rows import grasp_to_dicts, pads_recording, require_layout
from varishold.recording import read_grasp_table

SEARCHED = HandSetting(search=True)


@pytest.fixture(scope="module")
def steps() -> dict[str, tuple[Step, ...]]:
    setting = HandSetting(pads=PadSetting())
    return {
        "cylinder": grasp_object("cylinder", 0.09, seed=12, setting=setting).steps,
        "square-pillar": grasp_object("square-pillar", 0.07, seed=12, setting=setting).steps,
    }


def test_the_five_steps_move_the_fingers_that_the_paper_says(steps: dict[str, tuple[Step, ...]]) -> None:
    for done in steps.values():
        digits = [
            {
                joint.split(".")[0]
                for joint, on in zip(HandDesign().joints, touching(s.sensed, HandDesign(), PAPER_22), strict=True)
                if on
            }
            for s in done
        ]
        assert digits[0] == digits[1] == {"index", "thumb"}
        assert digits[2] == {"index", "thumb", "little"}
        assert digits[3] == {"thumb", "little"}
        assert digits[4] == {"index", "middle", "ring", "little", "thumb"}


def test_the_object_hangs_in_the_hand_from_the_lift_on(steps: dict[str, tuple[Step, ...]]) -> None:
    for done in steps.values():
        assert [step.held for step in done] == [False, True, True, True, True]
        assert all(step.felt for step in done)


def test_a_flat_face_presses_both_sides_of_the_palm_and_a_cylinder_one_line(
    steps: dict[str, tuple[Step, ...]],
) -> None:
    side = np.array([np.sign(switch.y_m) for switch in PAPER_22.switches])
    palm = np.array([switch.part == "palm" for switch in PAPER_22.switches])
    cylinder, pillar = (steps[name][-1].sensed.switches & palm for name in ("cylinder", "square-pillar"))
    assert not (cylinder[side > 0].any() and cylinder[side < 0].any())
    assert pillar[side > 0].any()
    assert pillar[side < 0].any()


def test_same_seed_same_bits() -> None:
    a, b = (grasp_object("square-pillar", 0.06, seed=3, setting=SEARCHED) for _ in range(2))
    for one, two in zip(a.steps, b.steps, strict=True):
        assert np.array_equal(one.sensed.forces_n, two.sensed.forces_n)
        assert np.array_equal(one.sensed.angles_rad, two.sensed.angles_rad)
    assert a.attempts[0].search == b.attempts[0].search


@pytest.mark.parametrize("seed", [1, 2, 3])
@pytest.mark.parametrize(("name", "size_m"), [("cylinder", 0.11), ("square-pillar", 0.05)])
def test_the_search_finds_and_the_grip_holds(name: str, size_m: float, seed: int) -> None:
    done = grasp_object(name, size_m, seed=seed, setting=SEARCHED)
    found = done.attempts[0].search
    assert found is not None
    assert found.found
    assert done.held
    assert done.attempts[-1].outcome == "held"


def test_an_object_that_is_taken_away_is_felt_to_be_gone() -> None:
    bench, _ = set_up("cylinder", 0.09, seed=5)

    def take_away(bench: Bench, step: Step) -> None:
        if step.number == 2:
            bench.place_object(1.0, 0.0, 0.0)

    done = five_step(bench, watch=take_away)
    assert len(done) == 3
    assert not done[-1].felt


def test_an_object_that_is_not_there_is_a_miss() -> None:
    bench, _ = set_up("cylinder", 0.09, seed=5, setting=SEARCHED)
    bench.place_object(1.0, 0.0, 0.0)
    assert not search(bench).found
    bench.reset()
    bench.place_object(1.0, 0.0, 0.0)
    done = five_step(bench)
    assert len(done) == 1
    assert not done[0].felt


def test_misses_are_retried_and_counted() -> None:
    # Fingers without friction hold nothing; every attempt is felt to fail.
    slippery = HandSetting(design=replace(HandDesign(), friction=0.01, torsion_m=1e-5), most_attempts=2)
    done = grasp_object("cylinder", 0.11, seed=1, setting=slippery)
    assert len(done.attempts) == 2
    assert not done.held
    assert [attempt.outcome for attempt in done.attempts] != ["held", "held"]
    last = list(grasp_to_dicts(done, slippery))[-1]
    assert last["attempts"] == 2
    assert last["outcome"] in ("missed", "dropped")


def test_another_grip_and_a_fingertip_on_the_top() -> None:
    bench, _ = set_up("square-pillar", 0.07, seed=4, setting=SEARCHED)
    assert search(bench).found
    five_step(bench)
    again = regrasp(bench, turn_rad=0.6, raise_m=-0.015)
    assert [step.felt for step in again] == [True] * 5
    let_go(bench)
    touch = fingertip(bench, pads=PadSetting())
    assert touch.touched
    assert touch.height_m == pytest.approx(bench.table_m + bench.solid.top_m, abs=0.004)
    assert touch.step.pads is not None
    assert touch.step.pads.force_n["index.distal"] > 0


def test_all_digits_hold_a_ball() -> None:
    bench, _ = set_up("sphere", 0.09, seed=4, setting=SEARCHED)
    assert search(bench).found
    approach(bench, most_m=0.03)
    assert [step.felt for step in squeeze(bench, lift=True)] == [True, True]
    assert bench.held


def test_pads_read_the_force_that_presses_them(steps: dict[str, tuple[Step, ...]]) -> None:
    for done in steps.values():
        pads = done[-1].pads
        assert pads is not None
        assert set(pads.frames) == set(HandDesign().parts)
        for part, frame in pads.frames.items():
            total = frame.sum() * pads.pitch_m[part] ** 2
            assert (frame == 0).all() if pads.force_n[part] < 0.1 else total <= 1.1 * pads.force_n[part]
        # A taxel's noise is 1 % of the peak; the palm's pad is wide enough to catch nearly all of its force.
        assert pads.frames["palm"].sum() * pads.pitch_m["palm"] ** 2 == pytest.approx(pads.force_n["palm"], rel=0.25)


def test_pads_make_a_recording(steps: dict[str, tuple[Step, ...]]) -> None:
    recording = pads_recording(steps["cylinder"])
    assert len(recording.pads) == 16
    assert recording.unit == "Pa"
    with pytest.raises(InputError, match="no step has pad frames; give the setting pads"):
        pads_recording(steps["cylinder"][:4])


def test_the_four_groups_describe_a_grasp(steps: dict[str, tuple[Step, ...]]) -> None:
    design = HandDesign()
    for name, group in FEATURE_GROUPS.items():
        round_, square = (
            features(steps[o][-1], name, design=design, layout=PAPER_22) for o in ("cylinder", "square-pillar")
        )
        assert bool(round_.on_off) == (group.sense == "contact")
        assert bool(round_.analog) == (group.coordinates or group.sense == "surface")
        assert round_.analog.keys() == square.analog.keys()
        if name == "contact+coordinates":
            assert round_.analog["coordinate.off"] < square.analog["coordinate.off"]
        if group.sense == "surface":
            assert round_.analog["surface.range"] < square.analog["surface.range"]


def test_features_say_what_they_lack(steps: dict[str, tuple[Step, ...]]) -> None:
    design = HandDesign()
    with pytest.raises(InputError, match="unknown feature group 'smell'; known are contact"):
        features(steps["cylinder"][-1], "smell", design=design, layout=PAPER_22)
    with pytest.raises(InputError, match="surface shape needs pad frames"):
        features(steps["cylinder"][0], "surface", design=design, layout=PAPER_22)


@pytest.mark.parametrize("size_m", [0.07, 0.11])
def test_the_grips_circle_is_the_cylinder(size_m: float) -> None:
    bench, _ = set_up("cylinder", size_m, seed=21, setting=SEARCHED)
    assert search(bench).found
    approach(bench, most_m=0.03)
    end = five_step(bench)[-1].sensed
    circle = grip_circle(contact_points(end, bench.design, bench.layout))
    assert circle is not None
    assert circle.diameter_m == pytest.approx(size_m, rel=0.03)
    assert np.abs(circle.off_m).max() < 0.01 * size_m


def test_a_table_is_the_same_however_it_was_collected(tmp_path: Path) -> None:
    jobs = [Job(name, 0.08, seed) for name in ("cylinder", "square-pillar") for seed in range(3)]
    straight = collect_grasps(jobs, tmp_path / "a.csv", processes=1)
    collect_grasps(jobs[:2] + jobs[4:], tmp_path / "b.csv", processes=1)
    counts: list[int] = []
    collect_grasps(jobs, tmp_path / "b.csv", processes=2, progress=lambda done, _: counts.append(done))
    assert (tmp_path / "a.csv").read_bytes() == (tmp_path / "b.csv").read_bytes()
    assert counts == [5, 6]

    def stop(done: int, _: int) -> None:
        if done == 2:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        collect_grasps(jobs, tmp_path / "c.csv", processes=1, progress=stop)
    assert len(read_grasp_table(tmp_path / "c.csv")) == 2
    assert len(straight) == 6
    table = read_grasp_table(tmp_path / "a.csv")
    assert len(table.names("switch.*")) == 22
    assert len(table.names("angle_rad.*")) == 15
    assert table.cells["held"].all()
    require_layout(table, PAPER_22)


def _job_seed(job: Job) -> int:
    return job.seed


def test_jobs_come_back_in_order_from_several_processes() -> None:
    jobs = [Job("cylinder", 0.08, seed) for seed in range(9)]
    assert list(run_jobs(jobs, _job_seed, processes=1)) == list(range(9))


def test_collecting_names_what_is_wrong(tmp_path: Path) -> None:
    jobs = [Job("cylinder", 0.08, 0)]
    path = tmp_path / "t.csv"
    collect_grasps(jobs, path, processes=1)
    with pytest.raises(InputError, match=r"t.csv: was collected with another finger_scale than 1.1"):
        collect_grasps(jobs, path, setting=HandSetting(design=HandDesign(finger_scale=1.1)))
    with pytest.raises(InputError, match=r"t.csv: was collected with another searched than 1"):
        collect_grasps(jobs, path, setting=SEARCHED)
    with pytest.raises(InputError, match=r"t.csv: holds steps \[5\] of cylinder, not \[1, 5\]"):
        collect_grasps(jobs, path, steps=(1, 5))
    path.write_text("object,switch.a,switch.b\nx,0,1\n")
    with pytest.raises(InputError, match=r"t.csv: has 2 switches \(among them a\), not the 22 of the layout paper-22"):
        collect_grasps(jobs, path)
    other = tmp_path / "u.csv"
    with pytest.raises(InputError, match="nothing to collect"):
        collect_grasps([], other)
    with pytest.raises(InputError, match="seed must be a whole number from 0 on, got -1"):
        collect_grasps([Job("cylinder", 0.08, -1)], other)
    with pytest.raises(InputError, match="size of the cylinder must lie"):
        collect_grasps([Job("cylinder", 0.8, 0)], other)
    with pytest.raises(InputError, match=r"steps must be among 1 .. 5, got \[7\]"):
        collect_grasps(jobs, other, steps=(7,))
    with pytest.raises(InputError, match="processes must be at least 1, got 0"):
        collect_grasps(jobs, other, processes=0)
    assert not other.exists()


def test_what_is_unstable_is_told_and_leaves_no_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    with pytest.raises(InputError, match="the simulation of this hand became unstable"):
        grasp_object("cylinder", 0.06, seed=0, setting=HandSetting(design=HandDesign(torque_nm=1e6)))
    assert not list(tmp_path.iterdir())
