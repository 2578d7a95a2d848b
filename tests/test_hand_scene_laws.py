"""The scene that is built and the hand that is designed: their numbers."""

from __future__ import annotations

import math
from dataclasses import fields, replace
from typing import Any

import numpy as np
import pytest

pytest.importorskip("mujoco", reason="MuJoCo is not installed; pip install -e '.[sim]'")

import mujoco

from varishold.errors import InputError
from varishold.hand import PAPER_22, HandDesign, HandSetting, Randomization
from varishold.hand.digit import Digit
from varishold.hand.model import CARRIAGE, build
from varishold.hand.objects import OBJECTS, SIZE_RANGE_M, STRANGERS, TABLE_5_OBJECTS, graspable

DESIGN = HandDesign()
STILL = Randomization().draw(np.random.default_rng(0), n_switches=22, still=True)


def test_the_scene_s_numbers_are_those_that_its_grasps_were_made_with() -> None:
    """Physics that no law gives: changed, every collected grasp and every shipped object would be another's."""
    model = build(DESIGN, PAPER_22, graspable("cylinder", 0.08), STILL)
    option = model.opt
    assert (option.timestep, option.impratio, option.iterations, option.ls_iterations) == (0.002, 10, 30, 20)
    assert option.integrator == mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    assert option.cone == mujoco.mjtCone.mjCONE_ELLIPTIC
    for name in ("palm", "object.0", "palm_centre"):
        geom = model.geom(name)
        assert geom.condim[0] == 4
        assert geom.friction == pytest.approx([0.8, 0.006, 0.0001])
        assert geom.solref == pytest.approx([0.007, 1.0])
        assert geom.solimp == pytest.approx([0.9, 0.95, 0.001, 0.5, 2])
    table = model.geom("table")
    assert table.friction == pytest.approx([0.4, 0.005, 0.0001])
    assert table.condim[0] == 3
    felt = build(DESIGN, PAPER_22, graspable("sphere", 0.08), STILL).geom("table")
    assert felt.friction == pytest.approx([0.4, 0.005, 0.003])
    for name in CARRIAGE:
        drive, joint = model.actuator(name), model.joint(name)
        stiff, damping = (6000.0, 220.0) if name in ("reach", "shift", "raise") else (200.0, 8.0)
        assert drive.gainprm[0] == stiff
        assert drive.biasprm[:3] == pytest.approx([0, -stiff, -damping])
        assert joint.armature[0] == (1.0 if name in ("reach", "shift", "raise") else 0.05)
    assert model.body("arm").mass[0] == pytest.approx(1.0)
    # The palm's box and seven buttons.
    assert model.body("palm").mass[0] == pytest.approx(0.25 + 7 * 0.001)
    for name in ("arm", "palm", "index.distal", "thumb.proximal"):
        assert model.body_gravcomp[model.body(name).id] == 1.0
    for part, digit in DESIGN.digit_of.items():
        length, r = DESIGN.length_m(part), digit.radius_m
        volume = math.pi * r**2 * length + 4 / 3 * math.pi * r**3
        count = 2 if digit.breadth_m else 1
        assert model.body(part).mass[0] == pytest.approx(1000 * volume * count, rel=1e-6)
        site = model.site(part)
        breadth = 2 * r + digit.breadth_m / 2
        assert site.size == pytest.approx([length / 2 + 2 * r, 2 * r, breadth])
    for switch in PAPER_22.switches:
        if switch.part == "palm":
            assert model.site(switch.name).size[0] == pytest.approx(0.009)
    # What is only seen touches nothing.
    seen = [g for g in range(model.ngeom) if model.geom(g).name == ""]
    assert all(
        not (model.geom_contype[g] or model.geom_conaffinity[g])
        for g in seen
        if model.body(model.geom_bodyid[g]).name in ("table", "arm")
    )


def test_a_colliding_pair_of_bits_is_what_the_scene_allows() -> None:
    model = build(DESIGN, PAPER_22, graspable("cylinder", 0.08), STILL)
    bits = {}
    for g in range(model.ngeom):
        body = model.body(model.geom_bodyid[g]).name
        if body in DESIGN.joints:
            bits.setdefault(body, set()).add((int(model.geom_contype[g]), int(model.geom_conaffinity[g])))
    for part in DESIGN.joints:
        first, thumb = part.endswith("proximal"), part.startswith("thumb")
        assert bits[part] == {(0, 1) if first else (4, 1 | 2) if thumb else (2, 1 | 4)}
    assert (model.geom("palm").contype[0], model.geom("palm").conaffinity[0]) == (0, 1)
    assert (model.geom("object.0").contype[0], model.geom("object.0").conaffinity[0]) == (1, 0)


@pytest.mark.parametrize("name", [*OBJECTS, *STRANGERS, "lump-7"])
def test_an_object_in_the_scene_is_its_body(name: str) -> None:
    """Volumes and middles of mass of the parts, each as its own kind of geometry."""
    solid = graspable(name, 0.08)
    model = build(DESIGN, PAPER_22, solid, STILL)
    kinds = {"box": "BOX", "cylinder": "CYLINDER", "hull": "MESH"}
    rays = 0
    for k, part in enumerate(solid.body()):
        geom = model.geom(f"object.{k}")
        kind = kinds.get(part.kind, "SPHERE" if len(set(part.half_m)) == 1 else "ELLIPSOID")
        assert geom.type[0] == getattr(mujoco.mjtGeom, f"mjGEOM_{kind}")
        rays += 1
    assert rays == len(solid.body())
    # Rays from all sides meet the scene's object where they meet the solid's parts.
    data = mujoco.MjData(model)
    start = int(model.joint("object").qposadr[0])
    data.qpos[start : start + 7] = [2.0, 0.0, 0.0, 1, 0, 0, 0]
    mujoco.mj_forward(model, data)
    far = np.array([2.0, 0.0, 0.0])
    rng = np.random.default_rng(0)
    told, met = [], []
    object_ = model.body("object").id
    for _ in range(60):
        way = rng.normal(size=3)
        way /= np.linalg.norm(way)
        aim = np.array([0, 0, 0.3 * solid.top_m]) + rng.uniform(-0.02, 0.02, 3)
        at = aim - 0.3 * way
        told.append(float(np.min([part.hits(at[None], way) for part in solid.body()])))
        found = [
            mujoco.mj_rayMesh(model, data, g, at + far, way)
            if model.geom_type[g] == mujoco.mjtGeom.mjGEOM_MESH
            else mujoco.mju_rayGeom(
                data.geom_xpos[g], data.geom_xmat[g], model.geom_size[g], at + far, way, model.geom_type[g]
            )
            for g in range(model.ngeom)
            if model.geom_bodyid[g] == object_
        ]
        hits = [hit for hit in found if hit >= 0]
        met.append(min(hits) if hits else math.inf)
    np.testing.assert_allclose(met, told, atol=2e-5)
    assert np.isfinite(told).sum() > 30


# The design


def test_the_usual_hand_has_its_proportions() -> None:
    """The default hand is a definition: the shipped objects were learned with it."""
    lengths = {name: DESIGN.lengths_m(name).tolist() for name in DESIGN.digits}
    index = [0.046, 0.030, 0.026]
    assert lengths["index"] == lengths["ring"] == pytest.approx(index)
    assert lengths["middle"] == pytest.approx([1.05 * each for each in index])
    assert lengths["little"] == pytest.approx([0.92 * each for each in index])
    assert lengths["thumb"] == pytest.approx([0.040, 0.034, 0.028])
    heights = [DESIGN.digits[name].height_m for name in DESIGN.digits]
    assert heights == pytest.approx([0.033, 0.011, -0.011, -0.033, 0.006])
    assert [digit.radius_m for digit in DESIGN.digits.values()] == [0.008] * 4 + [0.009]
    assert [digit.breadth_m for digit in DESIGN.digits.values()] == [0.0] * 4 + [0.028]
    told = {field.name: getattr(DESIGN, field.name) for field in fields(DESIGN)}
    for name in ("fingers", "thumb"):
        told.pop(name)
    assert told == {
        "finger_scale": 1.0,
        "pointer": "index",
        "supporter": "little",
        "palm_m": (0.024, 0.084, 0.088),
        "knuckle_m": (-0.012, 0.052),
        "button_radius_m": 0.007,
        "button_rise_m": 0.003,
        "palm_above_middle_m": 0.005,
        "wrist_m": 0.10,
        "lift_rad": 0.5,
        "open_rad": (-0.65, 0.1, 0.1),
        "curl_rad": (1.7, 1.9, 1.5),
        "torque_nm": (0.55, 0.33, 0.24),
        "thumb_gain": 1.2,
        "thumb_gain_all": 2.6,
        "opening_nm": 0.15,
        "search_gain": 0.3,
        "joint_damping_nms": 0.06,
        "joint_armature_kg_m2": 1e-4,
        "friction": 0.8,
        "torsion_m": 0.006,
    }
    ranges = {field.name: getattr(Randomization(), field.name) for field in fields(Randomization)}
    assert ranges == pytest.approx(
        {
            "friction": 1.25,
            "torque": 1.2,
            "density": 1.5,
            "softness": 1.5,
            "threshold": 1.6,
            "switch_spread": 1.25,
            "forward_m": 0.003,
            "sideways_m": 0.005,
            "yaw_rad": math.radians(10),
            "search_m": 0.030,
            "search_rad": math.radians(20),
        }
    )
    assert SIZE_RANGE_M == (0.035, 0.125)
    names = ["cylinder"] * 5 + ["square-pillar"] * 5
    assert [name for name, _ in TABLE_5_OBJECTS] == names
    assert [size for _, size in TABLE_5_OBJECTS] == [0.07, 0.08, 0.09, 0.10, 0.11, 0.05, 0.06, 0.07, 0.08, 0.09]


@pytest.mark.parametrize(
    ("changes", "says"),
    [
        ({"palm_m": (0.02, math.inf, 0.08)}, "palm_m of a hand must be positive and finite"),
        ({"palm_m": (0.02, 0.0, 0.08)}, "palm_m of a hand must be positive and finite"),
        ({"friction": -0.1}, "friction of a hand must be positive and finite"),
        ({"knuckle_m": (math.nan, 0.05)}, "knuckle_m of a hand must be positive and finite"),
        ({"finger_scale": 0.49}, "finger_scale must lie in"),
        ({"finger_scale": 2.01}, "finger_scale must lie in"),
        ({"supporter": "thumb"}, "pointer and supporter must be among the fingers"),
        ({"thumb": Digit("palm", 0.0, opposed=True)}, "digits of a hand need names of their own"),
    ],
)
def test_what_cannot_be_a_hand_is_told(changes: dict[str, Any], says: str) -> None:
    with pytest.raises(InputError, match=says):
        replace(DESIGN, **changes)


def test_what_just_can_be_a_hand_is_one() -> None:
    for changes in (
        {"knuckle_m": (-0.02, -0.05)},
        {"palm_above_middle_m": -0.01},
        {"open_rad": (0.0, 0.0, -0.1)},
        {"finger_scale": 0.5},
        {"finger_scale": 2.0},
    ):
        replace(DESIGN, **changes)
    for wrong in ((0.03, 0.02), (0.03, 0.02, math.inf), (0.03, 0.02, -0.01), (0.03, 0.02, 0.02, 0.02)):
        with pytest.raises(InputError, match="a digit needs 3 phalanges and a radius"):
            Digit("odd", 0.0, wrong)  # type: ignore[arg-type]
    for changes in ({"relative_length": 0.0}, {"radius_m": -0.001}):
        with pytest.raises(InputError, match="a digit needs 3 phalanges and a radius"):
            Digit("odd", 0.0, **changes)
    with pytest.raises(InputError, match="most_attempts must be at least 1, got 0"):
        HandSetting(most_attempts=0)
    setting = HandSetting(most_attempts=1)
    assert (setting.search, setting.still, setting.pads, HandSetting().most_attempts) == (False, False, None, 3)
