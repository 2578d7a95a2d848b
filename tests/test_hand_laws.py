"""Laws of the hand: the model that is built is the hand that is designed; places, features and rows by hand."""

from __future__ import annotations

import math
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

pytest.importorskip("mujoco", reason="MuJoCo is not installed; pip install -e '.[sim]'")

import mujoco

from varishold.errors import InputError
from varishold.hand import LAYOUTS, HandDesign, HandSetting, PadSetting, Randomization, Step
from varishold.hand.bench import Sensed
from varishold.hand.coordinates import contact_points, feels_held, grip_circle, gripped, phalanges, touching
from varishold.hand.features import FEATURE_GROUPS, features
from varishold.hand.layouts.paper_22 import PAPER_22
from varishold.hand.model import build
from varishold.hand.objects import SIZE_RANGE_M, graspable
from varishold.hand.pads import PadFrames, _cells_a_taxel, pad_shape, surface_before
from varishold.hand.rows import grasp_rows, grasp_table, grasp_to_dicts, pads_recording, require_layout
from varishold.skin import Skin

DESIGN = HandDesign()
STILL = Randomization().draw(np.random.default_rng(0), n_switches=22, still=True)


@pytest.fixture(scope="module")
def cylinder():
    model = build(DESIGN, PAPER_22, graspable("cylinder", 0.08), STILL)
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    return model, data


# ---- the model


@given(st.integers(0, 2**31))
@settings(max_examples=10)
def test_phalanges_stand_where_the_model_moves_them(cylinder, seed):
    model, _ = cylinder
    data = mujoco.MjData(model)
    rng = np.random.default_rng(seed)
    angles = rng.uniform(DESIGN.open_rad * 5, DESIGN.curl_rad * 5)
    for joint, angle in zip(DESIGN.joints, angles, strict=True):
        data.joint(joint).qpos[0] = angle
    mujoco.mj_forward(model, data)
    told = phalanges(angles, DESIGN)
    assert told.parts == DESIGN.joints
    for k, part in enumerate(told.parts):
        body = data.body(part)
        np.testing.assert_allclose(body.xpos, told.start_m[k], atol=1e-9)
        np.testing.assert_allclose(body.xmat.reshape(3, 3)[:, 0], told.along[k], atol=1e-9)
        assert told.along[k] @ told.inward[k] == pytest.approx(0, abs=1e-12)
        assert told.length_m[k] == DESIGN.length_m(part)
        assert told.opposed[k] == (part.split(".")[0] == DESIGN.thumb.name)
        middle = told.start_m[k] + told.along[k] * told.length_m[k] / 2 + told.inward[k] * told.radius_m[k]
        np.testing.assert_allclose(told.middle_m[k], middle)
    # A joint that bends more turns the rest of its digit toward the inner side.
    k = int(rng.integers(len(angles)))
    more = angles.copy()
    more[k] += 1e-6
    moved = phalanges(more, DESIGN)
    assert (moved.along[k] - told.along[k]) @ told.inward[k] == pytest.approx(1e-6, rel=1e-3)


def geoms_of(model, body):
    return [g for g in range(model.ngeom) if model.body(model.geom_bodyid[g]).name == body]


def test_every_phalanx_is_a_capsule_of_its_length(cylinder):
    model, _ = cylinder
    for digit in DESIGN.digits.values():
        for k, part in enumerate(digit.parts):
            found = geoms_of(model, part)
            assert len(found) == (2 if digit.breadth_m else 1)
            for g, sign in zip(found, (-1, 1), strict=False):
                assert model.geom_type[g] == mujoco.mjtGeom.mjGEOM_CAPSULE
                assert model.geom_size[g][:2] == pytest.approx([digit.radius_m, DESIGN.length_m(part) / 2])
                height = sign * digit.breadth_m / 2
                np.testing.assert_allclose(model.geom_pos[g], [DESIGN.length_m(part) / 2, 0, height], atol=1e-9)
            joint = model.joint(part)
            assert joint.range == pytest.approx([DESIGN.open_rad[k], DESIGN.curl_rad[k]])
            assert joint.damping[0] == DESIGN.joint_damping_nms
            assert joint.armature[0] == DESIGN.joint_armature_kg_m2
            # The site takes up all contacts of its phalanx and reaches no farther than a breadth beyond it.
            site = model.site(part)
            assert site.pos == pytest.approx([DESIGN.length_m(part) / 2, 0, 0])
            assert site.size[0] >= DESIGN.length_m(part) / 2 + digit.radius_m
            assert min(site.size[1], site.size[2] - digit.breadth_m / 2) >= digit.radius_m


def test_palm_buttons_stand_out_of_the_palm_at_the_layouts_places(cylinder):
    model, data = cylinder
    thickness, breadth, height = DESIGN.palm_m
    palm = model.geom("palm")
    assert palm.size == pytest.approx([thickness / 2, breadth / 2, height / 2])
    # The buttons' tops lie in the plane x = 0, the palm so much behind it.
    assert data.geom("palm").xpos[0] + thickness / 2 == pytest.approx(-DESIGN.button_rise_m)
    for switch in PAPER_22.switches:
        sensor = model.sensor(switch.name)
        assert model.sensor_type[sensor.id] == mujoco.mjtSensor.mjSENS_TOUCH
        site = model.site(int(model.sensor_objid[sensor.id]))
        assert site.name == (switch.name if switch.part == "palm" else switch.part)
        if switch.part == "palm":
            button = data.geom(switch.name).xpos
            np.testing.assert_allclose(button, [-DESIGN.button_radius_m, switch.y_m, switch.z_m], atol=1e-9)
            np.testing.assert_allclose(data.site(switch.name).xpos, button, atol=1e-9)
            assert model.geom(switch.name).size[0] == DESIGN.button_radius_m < model.site(switch.name).size[0]
    assert model.nsensor == 22


def may_touch(model, one, other):
    a, b = (geoms_of(model, name)[0] for name in (one, other))
    return bool(model.geom_contype[a] & model.geom_conaffinity[b] or model.geom_contype[b] & model.geom_conaffinity[a])


def test_what_can_touch_what(cylinder):
    model, _ = cylinder
    for part in DESIGN.parts:
        assert may_touch(model, part, "object")
        assert not may_touch(model, part, "table")
    assert may_touch(model, "object", "table")
    # Fingers meet the thumb, and neither itself nor another finger; what is next to the palm meets no digit.
    assert may_touch(model, "index.distal", "thumb.distal")
    assert may_touch(model, "thumb.middle", "little.middle")
    assert not may_touch(model, "index.distal", "middle.distal")
    assert not may_touch(model, "index.distal", "index.middle")
    assert not may_touch(model, "index.proximal", "thumb.proximal")
    assert not may_touch(model, "palm", "index.distal")


def test_circumstances_are_factors_on_the_physics():
    solid = graspable("cylinder", 0.08)
    plain = build(DESIGN, PAPER_22, solid, STILL)
    other = build(DESIGN, PAPER_22, solid, replace(STILL, friction=1.2, density=2.0, softness=1.5))
    ratio = lambda name, of: other.__getattribute__(name)[of] / plain.__getattribute__(name)[of]  # noqa: E731
    finger, thing = geoms_of(plain, "index.distal")[0], geoms_of(plain, "object")[0]
    for g in (finger, thing):
        assert plain.geom_friction[g][:2] == pytest.approx([DESIGN.friction, DESIGN.torsion_m])
        assert ratio("geom_friction", g)[0] == pytest.approx(1.2)
        assert ratio("geom_friction", g)[1:] == pytest.approx([1, 1])
        assert ratio("geom_solref", g) == pytest.approx([1.5, 1])
        # Contacts must not be stiffer than two time steps.
        assert plain.geom_solref[g][0] >= 2 * plain.opt.timestep
    assert other.body("object").mass[0] == pytest.approx(2 * plain.body("object").mass[0])
    volume = math.pi * 0.04**2 * solid.top_m
    assert plain.body("object").mass[0] == pytest.approx(300 * volume, rel=1e-6)
    assert other.body("palm").mass[0] == plain.body("palm").mass[0]


@pytest.mark.parametrize("name", ["cylinder", "sphere", "cone", "box"])
def test_the_table_offers_every_object_at_the_hands_height(name):
    model = build(DESIGN, PAPER_22, graspable(name, 0.07), STILL)
    middle = float(model.body("object").ipos[2])
    assert model.body("table").pos[2] + middle == pytest.approx(-DESIGN.palm_above_middle_m)
    # Only what is round all over needs felt to stand.
    table = model.geom("table")
    rolls = name == "sphere"
    assert (table.condim[0] == 6) == rolls
    assert (table.friction[2] > 1e-3) == rolls
    assert not table.rgba[3]


def test_carriage_and_wrist_move_along_their_axes(cylinder):
    model, _ = cylinder
    at = {}
    for name in ("reach", "shift", "raise", "turn", "roll", "wrist"):
        data = mujoco.MjData(model)
        data.joint(name).qpos[0] = 0.1
        mujoco.mj_forward(model, data)
        at[name] = data.body("palm").xpos.copy(), data.body("palm").xmat.reshape(3, 3).copy()
    for axis, name in enumerate(("reach", "shift", "raise")):
        np.testing.assert_allclose(at[name][0], 0.1 * np.eye(3)[axis], atol=1e-9)
    c, s = math.cos(0.1), math.sin(0.1)
    np.testing.assert_allclose(at["turn"][1], [[c, -s, 0], [s, c, 0], [0, 0, 1]], atol=1e-9)
    np.testing.assert_allclose(at["roll"][1], [[1, 0, 0], [0, c, -s], [0, s, c]], atol=1e-9)
    # The wrist lifts what lies before the palm, about an axis behind it.
    np.testing.assert_allclose(at["wrist"][1], [[c, 0, -s], [0, 1, 0], [s, 0, c]], atol=1e-9)
    np.testing.assert_allclose(at["wrist"][0], [DESIGN.wrist_m * (c - 1), 0, DESIGN.wrist_m * s], atol=1e-9)


# ---- what is felt


def felt(closed=(), angles=None, layout=PAPER_22):
    on = np.array([name in closed for name in layout.names])
    angles = np.zeros(len(DESIGN.joints)) if angles is None else np.asarray(angles, float)
    return Sensed(on, on.astype(float), angles, np.zeros(6))


def test_what_is_held_is_as_broad_as_the_digits_are_apart():
    rng = np.random.default_rng(0)
    angles = rng.uniform(0.1, 0.6, len(DESIGN.joints))
    y = dict(zip(DESIGN.joints, phalanges(angles, DESIGN).middle_m[:, 1], strict=True))
    sensed = felt(("index_distal", "ring_middle", "thumb_distal", "thumb_middle"), angles)
    assert touching(sensed, DESIGN, PAPER_22).sum() == 4
    upper = max(y["index.distal"], y["ring.middle"])
    lower = min(y["thumb.distal"], y["thumb.middle"])
    assert gripped(sensed, DESIGN, PAPER_22) == pytest.approx((upper - lower, (upper + lower) / 2))
    for alone in (("index_distal",), ("thumb_distal",), ("palm_centre", "thumb_distal"), ()):
        assert gripped(felt(alone, angles), DESIGN, PAPER_22) is None
        assert not feels_held(felt(alone, angles), DESIGN, PAPER_22)


def at_breadth(breadth):
    """Angles of index finger and thumb at which they are so far apart."""
    low, high = 0.0, 0.8
    for _ in range(60):
        middle = (low + high) / 2
        angles = np.zeros(len(DESIGN.joints))
        for k, joint in enumerate(DESIGN.joints):
            if joint.split(".")[0] in ("index", "thumb"):
                angles[k] = middle
        found = gripped(felt(("index_distal", "thumb_distal"), angles), DESIGN, PAPER_22)[0]
        low, high = (middle, high) if found > breadth else (low, middle)
    return angles


@pytest.mark.parametrize(
    ("breadth", "palm", "before", "held"),
    [
        (0.033, False, None, True),
        (0.031, False, None, False),
        (0.011, True, None, True),
        (0.009, True, None, False),
        (0.041, False, 0.080, True),
        (0.039, False, 0.080, False),
        (0.033, False, 0.050, True),
        (0.031, False, 0.050, False),
    ],
)
def test_digits_that_met_hold_nothing(breadth, palm, before, held):
    closed = ("index_distal", "thumb_distal")
    sensed = felt(closed, at_breadth(breadth))
    earlier = None if before is None else felt(closed, at_breadth(before))
    assert feels_held(sensed, DESIGN, PAPER_22, before=earlier, palm=palm) == held
    if palm:
        touched = felt((*closed, "palm_centre"), at_breadth(breadth))
        assert feels_held(touched, DESIGN, PAPER_22) == held


def frames_of(forces=(), frames=None):
    given_ = frames or {}
    force = dict.fromkeys(DESIGN.parts, 0.0) | dict(forces)
    shapes = {part: given_.get(part, np.zeros((8, 10))) for part in DESIGN.parts}
    return PadFrames(shapes, dict.fromkeys(DESIGN.parts, 0.002), force)


def test_pads_tell_where_along_a_phalanx_it_touches():
    frame = np.zeros((8, 10))
    frame[:, 7] = 3.0
    frame[2, 9] = 24.0
    pads = frames_of({"index.middle": 0.2, "thumb.distal": 0.11, "ring.distal": 0.09}, {"index.middle": frame})
    contacts = contact_points(felt(), DESIGN, PAPER_22, pads=pads)
    assert contacts.parts == ("index.middle", "thumb.distal")
    place = phalanges(np.zeros(len(DESIGN.joints)), DESIGN)
    k = place.parts.index("index.middle")
    # Columns 7 and 9, of equal weight, lie 3.5 taxels beyond the middle.
    np.testing.assert_allclose(contacts.point_m[0], place.middle_m[k] + 3.5 * 0.002 * place.along[k])
    np.testing.assert_allclose(contacts.point_m[1], place.middle_m[place.parts.index("thumb.distal")])
    assert contacts.slack_m.tolist() == [0, 0]
    by_switch = contact_points(felt(("index_middle", "thumb_distal")), DESIGN, PAPER_22)
    assert by_switch.slack_m == pytest.approx([DESIGN.length_m(part) / 2 for part in by_switch.parts])
    assert grip_circle(contact_points(felt(("index_middle",)), DESIGN, PAPER_22)) is None


# ---- features


def step_of(sensed, pads=None):
    return Step(5, "grip", sensed, True, True, pads)


def test_features_of_each_group():
    angles = at_breadth(0.06)
    closed = ("index_proximal", "thumb_proximal", "middle_proximal")
    y, x = np.mgrid[:8, :10]
    bowl = 1e5 * (1 - ((x - 4.5) / 6) ** 2) + 0 * y
    frames = {"index.proximal": bowl, "thumb.proximal": np.full((8, 10), 5e4)}
    pads = frames_of({"index.proximal": 1.0, "thumb.proximal": 1.0}, frames)
    step = step_of(felt(closed, angles), pads)
    skin = PadSetting().skin
    told = {group: features(step, group, design=DESIGN, layout=PAPER_22) for group in FEATURE_GROUPS}
    for group, got in told.items():
        assert bool(got.on_off) == group.startswith("contact")
        assert any(name.startswith("surface.") for name in got.analog) == group.startswith("surface")
        assert any(name.startswith("coordinate.") for name in got.analog) == group.endswith("coordinates")
    assert [name for name, on in told["contact"].on_off.items() if on] == [
        f"switch.{n}" for n in PAPER_22.names if n in closed
    ]
    # A confined layer is so many times as stiff as its material: curvature is the pressure's over that.
    nu, e = skin.poisson, skin.youngs_modulus_pa
    stiffness = e * (1 - nu) / ((1 + nu) * (1 - 2 * nu)) / skin.thickness_m
    bend = 1e5 * 2 / (6 * 0.002) ** 2 / stiffness
    decades = math.log10(1 + bend)
    surface = told["surface"].analog
    assert surface["surface.sharpest"] == pytest.approx(decades, rel=1e-6)
    assert surface["surface.flattest"] == pytest.approx(0, abs=1e-6)
    assert surface["surface.range"] == pytest.approx(1.0)
    assert surface["surface.spread"] == pytest.approx(1.0)
    with pytest.raises(InputError, match="unknown feature group 'all'"):
        features(step, "all", design=DESIGN, layout=PAPER_22)
    with pytest.raises(InputError, match="needs pad frames"):
        features(step_of(felt(closed, angles)), "surface", design=DESIGN, layout=PAPER_22)


def test_coordinates_are_how_far_the_phalanges_are_off_the_circle():
    rng = np.random.default_rng(3)
    angles = rng.uniform(0.2, 0.7, len(DESIGN.joints))
    closed = ("index_proximal", "index_middle", "thumb_proximal", "thumb_middle", "ring_distal")
    step = step_of(felt(closed, angles))
    told = features(step, "contact+coordinates", design=DESIGN, layout=PAPER_22).analog
    contacts = contact_points(step.sensed, DESIGN, PAPER_22)
    circle = grip_circle(contacts)
    size = max(circle.diameter_m, 0.02)
    off = dict(zip(contacts.parts, np.abs(circle.off_m) / size, strict=True))
    for joint in DESIGN.joints:
        assert told[f"coordinate.{joint}.off"] == pytest.approx(off.get(joint, 0.0))
    assert told["coordinate.off"] == pytest.approx(math.sqrt(np.mean(np.square(list(off.values())))))
    beyond = np.maximum(np.abs(circle.beside_m) - contacts.slack_m, 0).max() / size
    assert told["coordinate.beyond"] == pytest.approx(beyond)
    nothing = features(step_of(felt()), "contact+coordinates", design=DESIGN, layout=PAPER_22).analog
    assert set(nothing.values()) == {0.0}


# ---- rows


def a_grasp(ends):
    """A grasp whose last attempt came to these steps: (number, held)."""
    steps = [Step(n, f"step {n}", felt(("index_distal",) if held else ()), held, held) for n, held in ends]
    attempt = SimpleNamespace(steps=tuple(steps), outcome="held", search=None)
    told = {"name": "cone", "size_m": 0.06, "seed": 4, "held": ends[-1][1]}
    return SimpleNamespace(**told, steps=tuple(steps), end=steps[-1], attempts=(attempt, attempt))


@pytest.mark.parametrize(
    ("ends", "asked", "told"),
    [
        ([(1, 0), (2, 1), (3, 1), (4, 1), (5, 1)], (5,), [5]),
        ([(1, 0), (2, 1), (3, 1), (4, 1), (5, 1)], (2, 4), [2, 4]),
        # A grasp that ended sooner has a row of its end.
        ([(1, 0), (2, 1), (3, 0)], (5,), [3]),
        ([(1, 0), (2, 1), (3, 0)], (2, 5), [2, 3]),
        ([(1, 0), (2, 1), (3, 0)], (2, 3), [2, 3]),
        ([(1, 0), (2, 1), (3, 0)], (3, 5), [3]),
    ],
)
def test_a_row_a_wanted_step_and_one_for_an_early_end(ends, asked, told):
    setting = HandSetting()
    rows = grasp_rows(a_grasp([(n, bool(h)) for n, h in ends]), setting, steps=asked)
    assert [row["step"] for row in rows] == told
    for row in rows:
        assert (row["object"], row["size_m"], row["seed"], row["attempts"]) == ("cone", 0.06, 4, 2)
        assert row["held"] == bool(dict(ends)[row["step"]])
        assert row["switch.index_distal"] == row["held"]
        assert row["finger_scale"] == setting.design.finger_scale
        assert (row["searched"], row["still"]) == (int(setting.search), int(setting.still))
    table = grasp_table(rows)
    assert table.cells["object"].dtype.kind == "U"
    assert table.cells["held"].dtype == np.bool_
    assert table.cells["size_m"].dtype == np.float64
    require_layout(table, PAPER_22)
    odd = {name: cell for name, cell in table.cells.items() if name != "switch.palm_centre"}
    with pytest.raises(InputError, match=r"has 21 switches .*not the 22 of the layout paper-22"):
        require_layout(type(table)(odd, "t.csv"), PAPER_22)


def test_a_grasp_in_plain_values_counts_attempts_and_steps():
    setting = HandSetting()
    lines = list(grasp_to_dicts(a_grasp([(1, False), (2, True)]), setting))
    assert [(line["attempt"], line["step"]) for line in lines[:-1]] == [(1, 1), (1, 2), (2, 1), (2, 2)]
    assert lines[-1]["attempts"] == 2
    assert lines[-1]["held"] is True
    assert lines[1]["switches"]["index_distal"] == 1
    assert len(lines[0]["angles_rad"]) == len(DESIGN.joints)


def test_pads_of_steps_become_a_recording():
    frames = [frames_of(frames={"index.distal": np.full((8, 10), k)}) for k in (1.0, 2.0)]
    steps = [step_of(felt(), pads) for pads in (frames[0], None, frames[1])]
    recording = pads_recording(steps)
    assert recording.n_frames == 2
    assert recording.unit == "Pa"
    assert recording.pads["index_distal"].frames[:, 0, 0].tolist() == [1.0, 2.0]
    assert recording.pads["palm"].pitch_m == (0.002, 0.002)
    with pytest.raises(InputError, match="no step has pad frames"):
        pads_recording([step_of(felt())])


# ---- objects and pads


def test_objects_have_sizes_for_the_hand():
    low, high = SIZE_RANGE_M
    for size in (low, high):
        assert graspable("cylinder", size) is not None
    for size in (low - 1e-6, high + 1e-6):
        with pytest.raises(InputError, match="size of the cylinder must lie in"):
            graspable("cylinder", size)
    assert graspable("lump-123456789", 0.07).body()
    assert len({str(graspable(f"lump-{k}", 0.07)) for k in (1, 2)}) == 2
    for name in ("lump-", "lump-x", "lump-1234567890", "lump-1 ", "lumps"):
        with pytest.raises(InputError, match="unknown object"):
            graspable(name, 0.07)


def test_the_palms_buttons_are_mirrored_and_apart():
    palm = {(s.y_m, s.z_m) for s in PAPER_22.switches if s.part == "palm"}
    assert palm == {(-y, z) for y, z in palm} == {(y, -z) for y, z in palm}
    assert sorted(np.bincount([round(1e3 * y) + 15 for y, _ in palm])[[0, 15, 30]].tolist()) == [2, 2, 3]
    for y, z in palm:
        assert abs(y) < DESIGN.palm_m[1] / 2
        assert abs(z) < DESIGN.palm_m[2] / 2
    assert all(s.y_m == s.z_m == 0 for s in PAPER_22.switches if s.part != "palm")
    for layout in LAYOUTS.values():
        assert all(s.part in DESIGN.parts for s in layout.switches)


def test_pads_cover_their_parts():
    setting = PadSetting()
    for part in DESIGN.parts:
        rows, cols = pad_shape(part, DESIGN, setting)
        pitch = setting.palm_pitch_m if part == "palm" else setting.phalanx_pitch_m
        if part == "palm":
            high, wide = DESIGN.palm_m[2], DESIGN.palm_m[1]
        else:
            digit = DESIGN.digit_of[part]
            high, wide = 2 * digit.radius_m + digit.breadth_m, DESIGN.length_m(part)
        assert abs(rows * pitch - high) <= pitch / 2 + 1e-9
        assert abs(cols * pitch - wide) <= pitch / 2 + 1e-9
    tiny = pad_shape("index.distal", DESIGN, PadSetting(phalanx_pitch_m=0.05))
    assert tiny == (4, 4)
    # Cells at least as fine as the taxels lie deep, and never fewer than two.
    for pitch, depth, cells in (
        (0.002, 0.001, 2),
        (0.004, 0.001, 4),
        (0.0041, 0.001, 5),
        (0.002, 0.004, 2),
        (0.002, 0.0, 2),
    ):
        assert _cells_a_taxel(pitch, Skin("layer", 4e-3, 0.45, depth)) == cells


@pytest.mark.parametrize("gap", [0.0, 0.004])
def test_the_surface_before_a_pad_is_the_objects(gap):
    """A cylinder of 80 mm before a pad that looks at it square: r - sqrt(r^2 - u^2) below its nearest line."""
    solid = graspable("cylinder", 0.08)
    bench = SimpleNamespace(
        solid=solid,
        pad_frame=lambda part: (
            np.array([0.0, 0, 0]),
            np.array([0, 1.0, 0]),
            np.array([0, 0, 1.0]),
            np.array([1.0, 0, 0]),
        ),
        object_pose=lambda: (np.array([0.04 + gap, 0.0, -solid.top_m / 2]), np.eye(3)),
    )
    height = surface_before(bench, "palm", (6, 10), 0.004)
    assert height.shape == (12, 20)
    u = (np.arange(20) + 0.5 - 10) * 0.002
    depth = 0.04 - np.sqrt(0.04**2 - u**2)
    expected = np.maximum(-gap - depth, (-gap - depth).max() - 0.012)
    np.testing.assert_allclose(height, np.broadcast_to(expected, (12, 20)), atol=1e-6)
    far = SimpleNamespace(**{**vars(bench), "object_pose": lambda: (np.array([0.06, 0.0, 0.0]), np.eye(3))})
    assert surface_before(far, "palm", (6, 10), 0.004) is None


@given(st.integers(0, 2**31), st.booleans())
@settings(max_examples=20)
def test_a_place_is_drawn_within_its_range_and_factors_in_logarithm(seed, search):
    ranges = Randomization()
    drawn = [ranges.draw(np.random.default_rng([seed, k]), n_switches=3, search=search) for k in range(40)]
    reach = (
        (ranges.search_m, ranges.search_m, ranges.search_rad)
        if search
        else (ranges.forward_m, ranges.sideways_m, ranges.yaw_rad)
    )
    for name, most in zip(("forward_m", "sideways_m", "yaw_rad"), reach, strict=True):
        values = np.array([getattr(c, name) for c in drawn])
        assert np.abs(values).max() <= most
        assert np.ptp(values) > most
        assert values.min() < 0 < values.max()
    for name in ("friction", "torque", "density", "softness", "threshold"):
        values = np.array([getattr(c, name) for c in drawn])
        most = getattr(ranges, name)
        assert 1 / most <= values.min() < 1 < values.max() <= most
    for wrong in ({"friction": 0.99}, {"search_m": -0.001}, {"density": math.nan}):
        with pytest.raises(InputError, match="of a randomization must be at least"):
            Randomization(**wrong)
    Randomization(friction=1.0, search_m=0.0)
