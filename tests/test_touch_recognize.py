"""Recognition: laws of the signature, names of clean surfaces, answers and their contracts."""

from __future__ import annotations

import json
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from varishold.errors import InputError
from varishold.recording import Pad, Recording
from varishold.solids import (
    Cone,
    ConeFrustum,
    Cylinder,
    Edge,
    LyingCylinder,
    Plane,
    Pose,
    Pyramid,
    PyramidFrustum,
    RectangularPillar,
    Ridge,
    Solid,
    Sphere,
    SquarePillar,
    Wedge,
    ideal_frame,
)
from varishold.touch import (
    KINDS,
    NAMES,
    SIGNATURE_GROUPS,
    SIGNATURE_NAMES,
    contact_signature,
    find_contacts,
    recognize,
    recognize_recording,
)

SOLIDS: list[Solid] = [
    Cylinder(14.0, 3.0),
    SquarePillar(13.0, 3.0),
    RectangularPillar(18.0, 9.0, 3.0),
    Sphere(40.0),
    Cone(18.0, 5.0),
    Pyramid(17.0, 5.0),
    Ridge(20.0, 10.0, 4.0),
    ConeFrustum(20.0, 9.0, 4.0),
    PyramidFrustum(19.0, 8.0, 4.0),
    LyingCylinder(30.0, 60.0),
    Edge(3.0),
    Wedge(14.0, 4.0),
    Plane(3.0),
]


def frame_of(solid: Solid, *, noise: float = 0.005, seed: int = 0, yaw: float = 0.3) -> np.ndarray:
    depth = min(solid.top_m, 4.0)
    frame = ideal_frame(solid, (32, 32), 1.0, depth_m=depth, pose=Pose(0.6, -1.2, yaw))
    return frame + np.random.default_rng(seed).normal(0, noise * frame.max(), frame.shape)


@pytest.mark.parametrize("solid", SOLIDS, ids=lambda s: type(s).__name__)
def test_a_clean_surface_has_its_name(solid: Solid) -> None:
    surface = recognize(find_contacts(frame_of(solid))[0])
    assert surface.name == solid.name
    assert surface.probability > 0.8
    assert sum(surface.names.values()) == pytest.approx(1)
    assert surface.reasons
    assert all("nan" not in reason for reason in surface.reasons)


def test_every_number_of_a_signature_has_a_name_and_a_group() -> None:
    assert len(SIGNATURE_NAMES) == len(SIGNATURE_GROUPS) == len(set(SIGNATURE_NAMES))


@settings(max_examples=25)
@given(
    st.sampled_from(SOLIDS[:10]),
    st.integers(0, 3),
    st.booleans(),
    st.floats(1e-4, 1e4),
    st.floats(1e-4, 1e-1),
)
def test_the_signature_does_not_depend_on_turns_mirrors_units_or_pitch(
    solid: Solid, turns: int, mirrored: bool, gain: float, pitch: float
) -> None:
    frame = frame_of(solid)
    other = np.rot90(frame[:, ::-1] if mirrored else frame, turns) * gain
    one = contact_signature(find_contacts(frame)[0])
    two = contact_signature(find_contacts(other, pitch=pitch)[0])
    np.testing.assert_allclose(two, one, rtol=1e-5, atol=1e-5)


def border_inputs(frame: np.ndarray, field: np.ndarray | None = None) -> list[float]:
    signature = contact_signature(find_contacts(frame, floor=0.5, field=field)[0])
    names = ["side_1", "side_2", "side_3", "side_4", "opposite"]
    return [float(signature[SIGNATURE_NAMES.index(name)]) for name in names]


def test_a_contact_tells_how_much_of_each_side_of_the_field_it_covers() -> None:
    frame = np.zeros((16, 20))
    frame[:8, 5:15] = 1.0
    assert border_inputs(frame) == [0.5, 0, 0, 0, 0]
    frame[:, 5:15] = 1.0
    assert border_inputs(frame) == [0.5, 0.5, 0, 0, 0.5]
    assert border_inputs(np.ones((16, 20))) == [1, 1, 1, 1, 1]
    inside = np.zeros((16, 20))
    inside[4:9, 5:15] = 1.0
    assert border_inputs(inside) == [0] * 5


@settings(max_examples=30)
@given(st.lists(st.tuples(st.integers(0, 15), st.integers(0, 19)), min_size=1, max_size=3))
def test_a_missing_taxel_hardly_changes_what_a_contact_covers_of_the_sides(missing: list[tuple[int, int]]) -> None:
    frame = np.zeros((16, 20))
    frame[:, 5:15] = 1.0
    field = np.ones(frame.shape, bool)
    field[tuple(np.transpose(missing))] = False
    np.testing.assert_allclose(border_inputs(frame, field), border_inputs(frame), atol=1e-12)


def test_sizes_and_places_are_those_of_the_solid() -> None:
    pitch = 2e-3
    frame = ideal_frame(RectangularPillar(30e-3, 16e-3, 3e-3), (32, 32), pitch, pose=Pose(4e-3, -6e-3, 0.5))
    surface = recognize(find_contacts(frame, pitch=pitch)[0])
    assert surface.name == "rectangular pillar"
    assert surface.size == (pytest.approx(30e-3, abs=1e-3), pytest.approx(16e-3, abs=1e-3))
    assert surface.position == (pytest.approx(4e-3, abs=2e-4), pytest.approx(-6e-3, abs=2e-4))
    assert surface.orientation == pytest.approx(0.5, abs=0.02)
    low, high = surface.size_interval[0]
    assert low < 30e-3 < high
    frustum = recognize(find_contacts(ideal_frame(ConeFrustum(20.0, 9.0, 4.0), (32, 32), 1.0))[0])
    assert frustum.size[0] == pytest.approx(9.0, abs=0.8)


@pytest.mark.parametrize("yaw", [-0.6, -0.2, 0.0, 0.35, 0.7])
def test_a_square_lies_as_it_was_turned(yaw: float) -> None:
    surface = recognize(find_contacts(frame_of(SquarePillar(14.0, 3.0), yaw=yaw))[0])
    assert surface.orientation is not None
    assert math.remainder(surface.orientation - yaw, math.pi / 2) == pytest.approx(0, abs=0.05)


def test_a_border_lies_as_it_was_turned() -> None:
    surface = recognize(find_contacts(frame_of(Edge(3.0), yaw=0.3))[0])
    assert surface.orientation is not None
    assert math.remainder(surface.orientation - (0.3 + math.pi / 2), math.pi) == pytest.approx(0, abs=0.05)


def test_only_what_can_occur_is_named() -> None:
    contact = find_contacts(frame_of(Cone(18.0, 5.0)))[0]
    surface = recognize(contact, among=("sphere", "plane"))
    assert surface.name in ("sphere", "plane")
    assert {name for name, p in surface.names.items() if p > 0} <= {"sphere", "plane"}
    with pytest.raises(InputError, match="among holds 'teapot', which is no name; names are cylinder"):
        recognize(contact, among=("teapot",))
    with pytest.raises(InputError, match="among is empty"):
        recognize(contact, among=())


def test_the_answers_of_a_recording() -> None:
    frames = np.stack([frame_of(SOLIDS[0]) * share for share in (0.01, 0.5, 1.0, 0.6, 0.01)])
    frames -= 0.0
    recording = Recording({"tip": Pad(frames, pitch_m=(1e-3, 1e-3))}, time_s=np.arange(5) / 10, unit="kPa")
    (peak,) = recognize_recording(recording)
    assert (peak.frame, peak.time_s, peak.pad, peak.contact) == (2, 0.2, "tip", 0)
    said = json.loads(json.dumps(peak.to_dict(), allow_nan=False))
    assert said["name"] == "cylinder"
    assert said["force_n"] == pytest.approx(frames[2].sum() * 1e3 * 1e-6, rel=0.05)
    assert said["size_m"][0] == pytest.approx(14e-3, abs=1e-3)
    assert said["size_taxels"][0] == pytest.approx(14, abs=1)
    assert said["depth_m"] is None
    assert said["radius_m"] is None
    assert sum(said["alternatives"].values()) + said["probability"] <= 1.01
    everything = list(recognize_recording(recording, frames="all"))
    assert {answer.frame for answer in everything} >= {1, 2, 3}
    (press,) = recognize_recording(recording, frames="press")
    assert press.frame == 2
    assert press.surface.name == "cylinder"
    named = Recording(recording.pads, press=np.array([0, 0, -1, 1, 1]))
    assert [answer.frame for answer in recognize_recording(named, frames="press")] == [1, 3]
    (third,) = recognize_recording(recording, frames=3)
    assert third.frame == 3
    raw = Recording({"pad": Pad(frames)})
    said = next(iter(recognize_recording(raw))).to_dict()
    assert all(value is None for key, value in said.items() if key.endswith(("_m", "_m2", "_n")))


def test_a_height_map_has_a_depth_and_a_radius() -> None:
    frame = ideal_frame(Sphere(40e-3), (32, 32), 1e-3, depth_m=3e-3)
    recording = Recording({"gel": Pad(frame[None], pitch_m=(1e-3, 1e-3))}, unit="m")
    said = next(iter(recognize_recording(recording))).to_dict()
    assert said["depth_m"] == pytest.approx(3e-3, rel=0.02)
    assert said["radius_m"] == pytest.approx(20e-3, rel=0.1)


def test_names_cover_the_contract() -> None:
    assert set(NAMES) == {
        "cylinder",
        "square pillar",
        "rectangular pillar",
        "frustum of a cone",
        "frustum of a pyramid",
        "sphere",
        "cone",
        "pyramid",
        "ridge",
        "hip",
        "lying cylinder",
        "edge",
        "plane",
        "unknown",
    }
    assert len({kind.key for kind in KINDS}) == len(KINDS)


def test_noise_on_a_skirt_makes_no_contacts() -> None:
    y, x = np.mgrid[-60:60, -60:60]
    frame = np.exp(-(x**2 + y**2) / 1200) + np.random.default_rng(0).normal(0, 0.01, x.shape)
    assert len(find_contacts(frame, floor=0.05 * frame.max())) > 10
    assert len(find_contacts(frame)) == 1
    assert len(list(recognize_recording(Recording({"pad": Pad(frame[None])})))) == 1


@pytest.mark.parametrize(("solid", "height"), [(Cone(18e-3, 6e-3), 6e-3), (Pyramid(18e-3, 6e-3), 6e-3)])
def test_the_depth_of_a_height_map_reaches_the_tip_that_taxels_average_away(solid: Solid, height: float) -> None:
    frame = ideal_frame(solid, (32, 32), 1e-3, depth_m=height)
    (answer,) = recognize_recording(Recording({"gel": Pad(frame[None], pitch_m=(1e-3, 1e-3))}, unit="m"), frames="all")
    assert frame.max() < 0.97 * height
    assert answer.depth_m == pytest.approx(height, rel=0.01)
    low, high = answer.depth_interval_m
    assert low < height < high


@pytest.mark.parametrize(("rest", "name"), [(4.0, "plane"), (30.0, "cone"), (1.0, "cone")])
def test_a_high_rest_may_be_a_plane_that_is_pressed(rest: float, name: str) -> None:
    frame = ideal_frame(Cone(18.0, 6.0), (32, 32), 1.0) / 6.0
    surface = recognize(find_contacts(rest + frame)[0])
    assert surface.name == name
    if name == "plane":
        assert surface.probability == pytest.approx(0.55, abs=0.01)
        assert "cone" in surface.answer_set


def test_what_is_too_small_for_a_form_is_not_called_strange() -> None:
    frame = np.zeros((32, 32))
    frame[10:12, 10:13] = [[9, 0, 0], [9, 9, 9]]
    frame[12, 10] = 9
    surface = recognize(find_contacts(frame)[0])
    assert surface.name == "unknown"
    assert any("too small for a form" in reason for reason in surface.reasons)


def test_levels_above_the_contact_are_told() -> None:
    frame = np.zeros((12, 12))
    frame[3:9, 3:9] = 1.0
    (contact,) = find_contacts(frame, [2.0, 1.5])
    with pytest.raises(InputError, match="above the contact's peak, 1"):
        _ = recognize(contact).reasons
    assert repr(contact) == "Contact(peak=1 at (3, 3), n_taxels=36, levels=2)"
    assert repr(recognize(find_contacts(frame)[0])).startswith("Surface('square pillar', probability=")


@pytest.mark.parametrize("levels", [1, 4, [0.5] * 4, [1e9], [2.0, 3.0], [0.01, 0.02], np.linspace(0.1, 0.9, 32)])
def test_thresholds_change_no_name(levels: int | list[float]) -> None:
    y, x = np.mgrid[:16, :16]
    ball = np.maximum(1.0 - np.hypot(x - 8.0, y - 7.5) ** 2 / 25.0, 0.0)
    frame = ball + np.random.default_rng(0).normal(0.0, 0.01, ball.shape)
    own, given = (recognize(find_contacts(frame, cut)[0]) for cut in (32, levels))
    assert given.name == own.name == "sphere"
    assert given.probability == pytest.approx(own.probability, abs=1e-9)


@pytest.mark.parametrize("scale", [1e-140, 1e95])
def test_the_unit_changes_no_name(scale: float) -> None:
    y, x = np.mgrid[-8:9, -8:9]
    cone = np.maximum(6.0 - np.hypot(x, y), 0.0)
    one, other = (recognize(find_contacts(frame)[0]) for frame in (cone, scale * cone))
    assert one.name == other.name
    assert one.probability == pytest.approx(other.probability, abs=1e-9)
