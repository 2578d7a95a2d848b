"""The bench and its model: what motors get, how time passes, what is felt, and the numbers of the scene."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

pytest.importorskip("mujoco", reason="MuJoCo is not installed; pip install -e '.[sim]'")

import mujoco

from varishold.errors import InputError
from varishold.hand import PAPER_22, HandDesign, Randomization, SwitchSetting
from varishold.hand.bench import Bench
from varishold.hand.coordinates import phalanges
from varishold.hand.model import CARRIAGE
from varishold.hand.objects import graspable

DESIGN = HandDesign()
STILL = Randomization().draw(np.random.default_rng(0), n_switches=22, still=True)


@pytest.fixture
def bench() -> Bench:
    made = Bench(graspable("cylinder", 0.08), replace(STILL, torque=1.1))
    made.place_object(1.0, 0.0, 0.0)
    return made


def motor(bench: Bench, part: str) -> float:
    return float(bench.data.ctrl[bench.model.actuator(part).id])


# Motors and time


def test_motors_get_the_usual_torque_by_gain_and_chance(bench: Bench) -> None:
    for joint in DESIGN.joints:
        assert motor(bench, joint) == -0.15
    bench.put_digits(closed_digits={"index": 1.0, "thumb": 2.6}, open_digits=("ring",))
    for digit, gain in (("index", 1.0), ("thumb", 2.6)):
        for part, torque in zip(DESIGN.digits[digit].parts, DESIGN.torque_nm, strict=True):
            assert motor(bench, part) == pytest.approx(gain * 1.1 * torque)
    assert motor(bench, "ring.distal") == motor(bench, "middle.distal") == -0.15
    bench.close_all()
    for digit in DESIGN.digits.values():
        gain = 2.6 if digit.opposed else 1.0
        assert motor(bench, digit.parts[1]) == pytest.approx(gain * 1.1 * 0.33)


def test_a_posed_digit_is_drawn_to_its_angles_by_at_most_the_usual_torque(bench: Bench) -> None:
    bench.put_digits(posed_digits={"index": (-0.6, 0.2, 1.5)})
    for k, (part, wanted) in enumerate(zip(DESIGN.digits["index"].parts, (-0.6, 0.2, 1.5), strict=True)):
        bench._hold_poses()
        pull = 0.6 * (wanted - DESIGN.open_rad[k])
        assert motor(bench, part) == pytest.approx(np.clip(pull, -DESIGN.torque_nm[k], DESIGN.torque_nm[k]))
        assert abs(pull) < DESIGN.torque_nm[k] or part == "index.distal"
    bench.advance(0.5)
    angles = dict(zip(DESIGN.joints, bench.sense().angles_rad, strict=True))
    assert angles["index.middle"] == pytest.approx(0.2, abs=0.02)
    assert angles["index.distal"] == pytest.approx(1.5, abs=0.05)
    # Opened or closed, it is held no longer.
    bench.put_digits(open_digits=("index",))
    bench.advance(0.01)
    assert motor(bench, "index.distal") == -0.15
    bench.put_digits(posed_digits={"index": (0.0, 0.0, 0.0)})
    bench.put_digits(closed_digits={"index": 0.3})
    bench.advance(0.01)
    assert motor(bench, "index.distal") == pytest.approx(0.3 * 1.1 * 0.24)


def test_time_passes_in_hundredths_and_the_carriage_goes_evenly(bench: Bench) -> None:
    seen: list[tuple[float, float]] = []
    step = bench._mj.mj_step

    class Counting:
        def __getattr__(self, name: str) -> Any:
            return getattr(mujoco, name)

        def mj_step(self, model: Any, data: Any, steps: int) -> None:
            drive = {name: float(data.ctrl[bench.model.actuator(name).id]) for name in CARRIAGE}
            seen.append((drive["reach"], drive["wrist"]))
            assert steps == 5
            step(model, data, steps)

    bench._mj = Counting()
    begun = bench.data.time
    bench.advance(0.1, carriage={"reach": 0.05, "wrist": -0.2})
    assert bench.data.time - begun == pytest.approx(0.1)
    np.testing.assert_allclose(seen, np.outer(np.arange(1, 11) / 10, [0.05, -0.2]))
    assert bench.target["reach"] == pytest.approx(0.05)
    bench.advance(0.5)
    assert bench.sense().carriage[[0, 5]] == pytest.approx([0.05, -0.2], abs=1e-3)
    seen.clear()
    bench.advance(0.001)
    bench.advance(0.016)
    assert len(seen) == 3


def test_what_was_closed_is_remembered_until_it_is_cleared(bench: Bench) -> None:
    forces = np.zeros(22)

    class Pressing:
        def __getattr__(self, name: str) -> Any:
            return getattr(mujoco, name)

        def mj_step(self, model: Any, data: Any, steps: int) -> None:
            data.sensordata[:] = forces

    bench._mj = Pressing()
    names = list(PAPER_22.names)
    on, off = bench.on_n[0], bench.on_n[0] * 0.5
    palm, thumb = names.index("palm_finger_upper"), names.index("thumb_middle")
    forces[[palm, thumb]] = 1.01 * on
    bench.advance(0.01)
    assert set(np.flatnonzero(bench.closed)) == {palm, thumb}
    assert (bench.palm_touched(), bench.palm_sides()) == (True, (True, False))
    assert bench.digit_touched("thumb")
    assert not bench.digit_touched("index")
    assert bench.part_touched("thumb.middle")
    assert not bench.part_touched("thumb.distal")
    assert bench.sense().switches[palm]
    assert bench.sense().forces_n[thumb] == pytest.approx(1.01 * on)
    forces[:] = [1.01 * off if k == thumb else 0.99 * off if k == palm else 0.99 * on for k in range(22)]
    bench.advance(0.01)
    # One keeps closed above the lower threshold; the palm's was seen though it has opened.
    assert set(np.flatnonzero(bench.closed)) == {thumb}
    assert bench.palm_touched()
    bench.seen[:] = False
    assert not bench.palm_touched()
    forces[names.index("palm_thumb_lower")] = 2 * on
    bench.advance(0.01)
    assert bench.palm_sides() == (False, True)


def test_thresholds_follow_the_setting_and_chance() -> None:
    chance = replace(STILL, threshold=1.5, switch_spread=tuple(np.linspace(0.8, 1.2, 22)))
    made = Bench(graspable("cylinder", 0.08), chance, setting=SwitchSetting(0.4, 0.6))
    np.testing.assert_allclose(made.on_n, 0.4 * 1.5 * np.linspace(0.8, 1.2, 22))
    np.testing.assert_allclose(made._off_n, 0.6 * made.on_n)
    assert (SwitchSetting().on_n, SwitchSetting().off_fraction) == (0.25, 0.5)
    SwitchSetting(off_fraction=1.0)
    for wrong in ({"on_n": 0.0}, {"on_n": math.inf}, {"off_fraction": 0.0}, {"off_fraction": 1.01}):
        with pytest.raises(InputError, match="of a switch must"):
            SwitchSetting(**wrong)


def test_a_reset_hand_is_as_it_began(bench: Bench) -> None:
    fresh = bench.sense()
    bench.put_digits(closed_digits={"index": 1.0}, posed_digits={"thumb": (0.0, 0.0, 0.0)})
    bench.put_carriage({"reach": 0.03, "turn": 0.2})
    assert bench.sense().carriage.tolist() == [0.03, 0.0, 0.0, 0.2, 0.0, 0.0]
    assert float(bench.data.ctrl[bench.model.actuator("turn").id]) == 0.2
    bench.advance(0.2)
    bench.seen[:] = bench.closed[:] = True
    bench.reset()
    now = bench.sense()
    np.testing.assert_allclose(now.angles_rad, np.tile(DESIGN.open_rad, 5))
    np.testing.assert_array_equal(now.carriage, fresh.carriage)
    assert not bench.seen.any()
    assert not bench.closed.any()
    assert bench.target == dict.fromkeys(CARRIAGE, 0.0)
    bench.advance(0.01)
    assert motor(bench, "index.distal") == motor(bench, "thumb.distal") == -0.15


# Places


def test_an_object_stands_where_it_is_put(bench: Bench) -> None:
    bench.place_object(0.3, -0.1, 0.7)
    at, turn = bench.object_pose()
    np.testing.assert_allclose(at, [0.3, -0.1, bench.table_m])
    c, s = math.cos(0.7), math.sin(0.7)
    np.testing.assert_allclose(turn, [[c, -s, 0], [s, c, 0], [0, 0, 1]], atol=1e-12)
    assert bench.table_m == pytest.approx(-0.08 - 0.005)
    at[:] = 0
    assert bench.object_pose()[0][0] == pytest.approx(0.3)


def test_ahead_is_along_the_heading_and_aside_to_its_left(bench: Bench) -> None:
    bench.target |= {"reach": 0.1, "shift": -0.2, "turn": 0.4}
    c, s = math.cos(0.4), math.sin(0.4)
    assert bench.ahead(0.05, 0.02) == pytest.approx(
        {"reach": 0.1 + 0.05 * c - 0.02 * s, "shift": -0.2 + 0.05 * s + 0.02 * c}
    )
    assert bench.ahead(0.05) == pytest.approx({"reach": 0.1 + 0.05 * c, "shift": -0.2 + 0.05 * s})


def test_pads_lie_on_the_inner_sides(bench: Bench) -> None:
    rng = np.random.default_rng(1)
    bench.data.qpos[bench._joints] = angles = rng.uniform(0.0, 0.6, 15)
    mujoco.mj_forward(bench.model, bench.data)
    place = phalanges(angles, DESIGN)
    for k, part in enumerate(DESIGN.joints):
        middle, along, up, outward = bench.pad_frame(part)
        np.testing.assert_allclose(middle, place.middle_m[k], atol=1e-9)
        np.testing.assert_allclose(along, place.along[k], atol=1e-9)
        np.testing.assert_allclose(outward, place.inward[k], atol=1e-9)
        np.testing.assert_allclose(up, [0, 0, 1], atol=1e-9)
    middle, across, up, outward = bench.pad_frame("palm")
    np.testing.assert_allclose([middle, across, up, outward], [[0, 0, 0], [0, 1, 0], [0, 0, 1], [1, 0, 0]], atol=1e-9)


def test_the_force_on_each_part_is_the_objects_own() -> None:
    made = Bench(graspable("cylinder", 0.08), STILL)
    made.place_object(0.046, 0.0, 0.0)
    made.advance(0.2)
    made.close_all()
    made.advance(0.5)
    forces = made.object_forces_n()
    assert set(forces) == set(DESIGN.parts)
    by_switch = dict(zip(PAPER_22.names, made.sense().forces_n, strict=True))
    for part in ("index.distal", "thumb.middle", "little.proximal", "ring.middle"):
        assert forces[part] == pytest.approx(by_switch[part.replace(".", "_")], rel=1e-6, abs=1e-9)
    buttons = sum(force for name, force in by_switch.items() if name.startswith("palm"))
    assert forces["palm"] >= buttons - 1e-6
    assert forces["palm"] > 0.5
    made.advance(0.4, carriage={"wrist": 0.5})
    assert made.held
    # Far from the palm it is in no hand, though it lies on no table either.
    made.data.qpos[made._object : made._object + 3] = [0.3, 0.0, 0.5]
    mujoco.mj_forward(made.model, made.data)
    assert not made.held
    assert set(made.object_forces_n().values()) == {0.0}
    made.data.qpos[made._object : made._object + 7] = [0.09, 0.0, -0.08, 1, 0, 0, 0]
    mujoco.mj_forward(made.model, made.data)
    assert made.held
    made.place_object(0.09, 0.0, 0.0)
    made.advance(0.05)
    assert not made.held
