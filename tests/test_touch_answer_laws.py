"""Laws of an answer: sizes, angles, completed circles, tops, reasons and what a whole recording lets be known."""

from __future__ import annotations

import math
import re
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tests.test_report_touch import BLANK, answers_of, recording_of, surface_of

from varishold.levelset.contact import with_losses
from varishold.levelset.profile import Profile
from varishold.recording import Pad, Recording
from varishold.solids import Cone, ConeFrustum, Cylinder, Pose, Pyramid, Ridge, Solid, Sphere, ideal_frame
from varishold.touch import (
    contact_pose,
    find_contacts,
    inequality,
    next_threshold,
    recognize,
    recognize_recording,
)
from varishold.touch.bands import BANDS
from varishold.touch.cut import completed_circle, cut_sides
from varishold.touch.names import KINDS, NAMES, OUTLINE_OF
from varishold.touch.pad_frames import pad_frames
from varishold.touch.reasons import evidence
from varishold.touch.recognizer import surface_from
from varishold.touch.scale import as_learned, on_scale
from varishold.touch.signature import SIGNATURE_NAMES
from varishold.touch.top import top_height

SIDES = ("left", "right", "top", "bottom")


def grid(rows, cols, x=0.0, y=0.0, turn=0.0):
    """Coordinates along and across a direction, from a point (x, y) off the middle, in taxels."""
    v, u = np.mgrid[:rows, :cols].astype(float)
    u, v = u - (cols - 1) / 2 - x, v - (rows - 1) / 2 - y
    return u * math.cos(turn) + v * math.sin(turn), v * math.cos(turn) - u * math.sin(turn)


def steep(inside):
    """A face with borders about a taxel wide, from the distance to its border (positive inside)."""
    return np.clip(inside + 0.5, 0.0, 1.0)


def polygon_face(corners, size, turn, rows=60, cols=60):
    """A regular polygon of a circumscribed radius."""
    u, v = grid(rows, cols, turn=turn)
    apothem = size * math.cos(math.pi / corners)
    inside = np.full(u.shape, np.inf)
    for k in range(corners):
        angle = (2 * k + 1) * math.pi / corners
        inside = np.minimum(inside, apothem - (u * math.cos(angle) + v * math.sin(angle)))
    return steep(inside)


def said(frame, key, share=0.9, **options):
    (contact,) = find_contacts(frame, 64, **options)
    return surface_of(contact, key, share)


# ---- sizes


@pytest.mark.parametrize("turn", [0.0, 0.35, -0.6])
def test_sizes_of_flat_faces_are_theirs(turn):
    u, v = grid(60, 60, turn=turn)
    close = lambda *sizes: pytest.approx(sizes, rel=0.015)  # noqa: E731
    assert said(steep(18 - np.hypot(u, v)), "cylinder").size == close(36, 36)
    assert said(steep(np.minimum(15 - abs(u), 15 - abs(v))), "square-pillar").size == close(30, 30)
    oblong = steep(np.minimum(20 - abs(u), 9 - abs(v)))
    assert said(oblong, "rectangular-pillar").size == close(40, 18)
    # An ellipse has its axes, a hexagon its diagonal and its breadth, a triangle its side and its height.
    ring = np.hypot(u / 22, v / 11)
    assert said(
        steep((1 - ring) / np.hypot(u / 22**2, v / 11**2) * np.maximum(ring, 1e-9)), "elliptic-pillar"
    ).size == close(44, 22)
    assert said(polygon_face(6, 20, turn), "hexagonal-pillar").size == close(40, 20 * math.sqrt(3))
    assert said(polygon_face(3, 24, turn), "triangular-pillar").size == close(24 * math.sqrt(3), 36)


def test_a_section_without_breadth_is_a_line():
    from varishold.touch.surface import _sides

    assert _sides("rectangle", 0.0, np.array([[3.0, 0.0], [0.0, 0.0]])) == pytest.approx((6.0, 0.0))
    long, short = _sides("rectangle", 12.0, np.diag([3.0, 1 / 12]))
    assert (long, short) == pytest.approx((6 * math.sqrt(2), 12 / (6 * math.sqrt(2))))
    assert _sides("ellipse", math.pi * 6, np.diag([9 / 4, 4 / 4])) == pytest.approx((6, 4))


@given(st.floats(-1.5, 1.5), st.sampled_from([None, 0.5, (1.0, 2.0)]))
@settings(max_examples=15)
def test_the_long_side_points_along_the_face(turn, pitch):
    u, v = grid(48, 48, turn=turn)
    surface = said(steep(np.minimum(18 - abs(u), 8 - abs(v))), "rectangular-pillar", pitch=pitch)
    if isinstance(pitch, tuple):
        # Twice as far from column to column as from row to row: tangents halve.
        turn = math.atan2(math.sin(turn) * 1.0, math.cos(turn) * 2.0) if abs(math.cos(turn)) > 0.98 else None
    if turn is not None:
        assert abs((surface.orientation - turn + math.pi / 2) % math.pi - math.pi / 2) < 0.03
    assert -math.pi / 2 <= surface.orientation < math.pi / 2


@given(st.floats(-0.78, 0.78))
@settings(max_examples=10)
def test_a_square_points_along_one_of_its_sides(turn):
    u, v = grid(48, 48, turn=turn)
    surface = said(steep(np.minimum(13 - abs(u), 13 - abs(v))), "square-pillar")
    off = (surface.orientation - turn + math.pi / 4) % (math.pi / 2) - math.pi / 4
    assert abs(off) < 0.03
    assert -math.pi / 4 <= surface.orientation <= math.pi / 4
    assert said(steep(13 - np.hypot(u, v)), "cylinder").orientation is None


@pytest.mark.parametrize("turn", [0.0, 0.4, 1.2, -0.7, math.pi / 2])
def test_an_edge_points_along_its_border(turn):
    _, v = grid(30, 30, turn=turn)
    surface = said(5 * steep(-v), "edge")
    assert abs((surface.orientation - turn + math.pi / 2) % math.pi - math.pi / 2) < 0.06
    assert -math.pi / 2 <= surface.orientation < math.pi / 2
    assert said(np.ones((8, 8)), "plane").orientation is None
    line = np.zeros((1, 12))
    line[0, :5] = 3.0
    assert said(line, "edge").orientation == 0.0


def test_a_frustum_has_the_size_of_its_top():
    u, v = grid(80, 80)
    for top, base in ((20.0, 60.0), (32.0, 46.0)):
        round_ = np.clip((base / 2 - np.hypot(u, v)) / (base - top) * 2, 0, 1)
        surface = said(round_, "cone-frustum", floor=0.01)
        assert surface.size == pytest.approx((top, top), rel=0.04)
        square = np.clip((base / 2 - np.maximum(abs(u), abs(v))) / (base - top) * 2, 0, 1)
        assert said(square, "pyramid-frustum", floor=0.01).size == pytest.approx((top, top), rel=0.04)
    # Taken for a pillar it is as wide as half way up; for a cone, as at its foot.
    assert said(round_, "cylinder", floor=0.01).size[0] == pytest.approx(39, rel=0.02)
    assert said(round_, "cone", floor=0.01).size[0] == pytest.approx(46, rel=0.02)
    few = surface_of(find_contacts(round_, [0.9, 0.5], floor=0.01)[0], "cone-frustum")
    assert few.size[0] == pytest.approx(39, rel=0.02)


def a_profile(threshold, area, holes=None, parts=None, perimeter=None):
    n = len(threshold)
    measures = np.zeros(25 * n)
    measures[:n], measures[n : 2 * n] = threshold, area
    measures[2 * n : 3 * n] = np.sqrt(4 * np.pi * np.asarray(area, float)) if perimeter is None else perimeter
    counts = np.array([np.ones(n) if parts is None else parts, np.zeros(n) if holes is None else holes], dtype=np.int64)
    return Profile(measures, counts)


def with_profile(surface, profile):
    surface = replace(surface)
    surface.__dict__["profile"] = profile
    return surface


def test_the_middle_is_a_whole_section_nearest_half_height():
    (contact,) = find_contacts(np.pad([[1.0]], 3), 4, floor=0.0)
    surface = surface_of(contact)
    theta, area = np.array([0.9, 0.7, 0.52, 0.4, 0.1]), np.array([1.0, 2, 3, 4, 5])
    assert with_profile(surface, a_profile(theta, area)).middle == 2
    assert with_profile(surface, a_profile(theta, area, holes=[0, 0, 1, 0, 0])).middle == 3
    assert with_profile(surface, a_profile(theta, area, parts=[1, 1, 2, 2, 1])).middle == 1
    assert with_profile(surface, a_profile(theta, [0, 0, 0, 4, 5])).middle == 3
    # Where none is whole, the nearest that has an area.
    assert with_profile(surface, a_profile(theta, [0, 0, 0, 4, 5], holes=[1, 1, 1, 1, 1])).middle == 3
    assert with_profile(surface, a_profile(theta, [1, 2, 3, 4, 0])).lowest == 3
    assert with_profile(surface, a_profile(theta, area, holes=[1, 2, 3, 4, 5])).holes == 3


def test_intervals_follow_the_sensors_state():
    u, v = grid(40, 40)
    (contact,) = find_contacts(np.maximum(1 - np.hypot(u, v) / 12, 0), pitch=(0.003, 0.002))
    spread = BLANK.size_spread.copy()
    kind = [k.key for k in KINDS].index("cone")
    spread[kind, :, 0, 0] = (0.5, -0.25)
    spread[kind, :, 1, 0] = np.log([0.4, 0.8])
    spread[kind, 0, 1, 3] = 1.0
    maps = BLANK.map_spread.copy()
    maps[kind, :, 0, 0] = (-1.0, 0.5)
    maps[kind, :, 1, 0] = np.log([0.2, 0.1])
    inputs = np.zeros(len(SIGNATURE_NAMES))
    inputs[2] = math.log(2)
    surface = replace(
        surface_of(contact, "cone"), parameters=replace(BLANK, size_spread=spread, map_spread=maps), inputs=inputs
    )
    unit = math.sqrt(6e-6)
    long, short = surface.size
    halves = (0.8, 0.8)
    assert surface.size_interval[0] == pytest.approx((long + unit * (0.5 - halves[0]), long + unit * (0.5 + halves[0])))
    assert surface.size_interval[1] == pytest.approx(
        (short - unit * (0.25 + halves[1]), short + unit * (halves[1] - 0.25))
    )
    narrow = surface.size_interval_of(height_map=True)
    assert narrow[0] == pytest.approx((long - 1.2 * unit, long - 0.8 * unit))
    assert narrow[1] == pytest.approx((short + 0.4 * unit, short + 0.6 * unit))
    assert surface.size_of(height_map=True) == pytest.approx((long - unit, short + 0.5 * unit))
    assert surface.size_of(height_map=False) == surface.size
    # No size is less than nothing.
    spread[kind, :, 0, 0] = -1e3
    low, high = replace(surface, parameters=replace(BLANK, size_spread=spread)).size_interval[0]
    assert low == high == 0


# ---- names


@given(st.lists(st.floats(1e-6, 1), min_size=len(KINDS), max_size=len(KINDS)))
def test_names_and_outlines_hold_what_their_kinds_hold(weights):
    (contact,) = find_contacts(np.pad([[1.0]], 3), 4)
    logits = np.log(np.array(weights)) + 7.0
    surface = surface_from(contact, np.zeros(3), logits, BLANK)
    p = np.array(weights) / sum(weights)
    np.testing.assert_allclose(surface.kind_probability, p)
    by_name = {name: sum(q for q, kind in zip(p, KINDS, strict=True) if kind.name == name) for name in NAMES}
    assert surface.names == pytest.approx(by_name)
    assert surface.probability == pytest.approx(max(by_name.values()))
    assert by_name[surface.name] == pytest.approx(max(by_name.values()))
    shares = list(surface.names.values())
    assert shares == sorted(shares, reverse=True)
    assert surface.alternatives == {n: q for n, q in surface.names.items() if n != surface.name and q >= 0.01}
    best = max((q, k) for q, k in zip(p, range(len(KINDS)), strict=True) if KINDS[k].name == surface.name)[1]
    assert p[best] == p[[k for k in range(len(KINDS)) if KINDS[k].name == surface.name]].max()
    assert (surface.form, surface.section) in {
        (k.form, k.section) for q, k in zip(p, KINDS, strict=True) if k.name == surface.name and q == p[best]
    }
    for outline, share in surface.outlines.items():
        assert share == pytest.approx(sum(q for name, q in by_name.items() if OUTLINE_OF[name] == outline))
    assert surface.outline_probability == max(surface.outlines.values())
    held = [surface.names[name] for name in surface.answer_set]
    assert held == shares[: len(held)]
    assert sum(held) >= 0.9 - 1e-12
    assert sum(held[:-1]) < 0.9


# ---- circles that the pad cuts


@pytest.mark.parametrize(
    "sides", [("left",), ("right",), ("top",), ("bottom",), ("left", "top"), ("right", "bottom"), ("right", "top")]
)
@pytest.mark.parametrize("pitch", [None, 0.002, (0.003, 0.002)])
def test_a_cut_circle_is_completed(sides, pitch):
    high, wide = (1.0, 1.0) if pitch is None else np.broadcast_to(pitch, 2)
    rows, cols = 28, 34
    y = (np.arange(rows)[:, None] - (rows - 1) / 2) * high
    x = (np.arange(cols) - (cols - 1) / 2) * wide
    radius = 9 * max(high, wide)
    cx = {"left": -cols / 2 * wide, "right": cols / 2 * wide}.get(
        next((s for s in sides if s in ("left", "right")), ""), 0.3 * wide
    )
    cy = {"top": -rows / 2 * high, "bottom": rows / 2 * high}.get(
        next((s for s in sides if s in ("top", "bottom")), ""), -0.4 * high
    )
    # The middle lies two taxels inside the pad.
    cx -= np.sign(cx) * 2 * wide * (abs(cx) > wide)
    cy -= np.sign(cy) * 2 * high * (abs(cy) > high)
    # It goes on below zero: along its foot nothing is bent by what is cut off.
    frame = np.maximum(1 - ((x - cx) ** 2 + (y - cy) ** 2) / radius**2, -0.3)
    (contact,) = find_contacts(frame, 20, pitch=pitch, floor=0.05)
    assert cut_sides(contact) == tuple(side for side in SIDES if side in sides)
    for level in (6, 12, 19):
        theta = contact.profile.threshold[level]
        found = completed_circle(contact, level, sides)
        assert found == pytest.approx((cx, cy, 2 * radius * math.sqrt(1 - theta)), abs=0.12 * max(high, wide))
    surface = surface_of(contact, "sphere")
    assert surface.position == completed_circle(contact, 19, sides)[:2]
    assert surface.size == (completed_circle(contact, 19, sides)[2],) * 2
    # A pillar has its size at half height, and only what is round is completed.
    pillar = surface_of(contact, "cylinder")
    assert pillar.completed == completed_circle(contact, pillar.middle, sides)
    for key in ("square-pillar", "plane", "cone-frustum"):
        assert surface_of(contact, key).completed is None
    assert surface_of(contact, "square-pillar").position == tuple(contact.profile.centroid[19])


def test_a_side_cuts_where_the_contact_stands_high():
    for height, cut in ((0.25, ()), (0.35, ("left",))):
        frame = np.zeros((12, 12))
        frame[4:8, 2:6] = 1.0
        frame[4:8, :2] = height
        (contact,) = find_contacts(frame, floor=0.001)
        assert cut_sides(contact) == cut
    inner = np.zeros((12, 12))
    inner[4:8, 1:6] = 1.0
    assert cut_sides(find_contacts(inner)[0]) == ()
    # What is high at the border must be the contact's own.
    two = np.zeros((12, 20))
    two[4:8, 5:9] = 1.0
    two[4:8, 4] = two[4:8, :4] = 0.1
    two[0:2, 17:20] = 3.0
    contact = find_contacts(two, floor=0.05)[0]
    assert cut_sides(contact) == ()


def test_little_of_a_circle_is_not_completed():
    u, v = grid(20, 40)
    # Of a disc whose middle lies far outside, less than a quarter of the outline is seen.
    far = steep(30 - np.hypot(u, v + 36))
    (contact,) = find_contacts(far, 16)
    assert completed_circle(contact, 8, ("top",)) is None
    assert surface_of(contact, "cylinder").completed is None
    tiny = np.zeros((9, 9))
    tiny[3:6, 0] = 1.0
    assert completed_circle(find_contacts(tiny, 8)[0], 4, ("left", "right", "top", "bottom")) is None
    assert completed_circle(find_contacts(np.ones((5, 5)), 8)[0], 4, SIDES) is None


# ---- chords


def a_reference(theta, j, sigma):
    """Bulge and defect over the lowest section, one by one."""
    smooth = []
    for i, here in enumerate(theta):
        stop = next((k for k in range(len(theta)) if theta[k] <= here - 6 * sigma), len(theta))
        smooth.append(min(j[i : max(i, stop) + 1]))
    chord = [smooth[0] + (smooth[-1] - smooth[0]) * (theta[0] - t) / (theta[0] - theta[-1]) for t in theta]
    return smooth, chord


@given(st.integers(0, 2**31), st.integers(3, 12), st.sampled_from([0.0, 0.01, 0.05]), st.sampled_from([1.0, 2.5]))
@settings(max_examples=40)
def test_chords_are_those_of_the_reference(seed, n, sigma, taxel):
    rng = np.random.default_rng(seed)
    theta = np.sort(rng.uniform(0, 1, n))[::-1]
    area = np.sort(rng.uniform(0, 60, n))
    perimeter = rng.uniform(0, 30, n)
    result = inequality(a_profile(theta, area, perimeter=perimeter), taxel_area=taxel, sigma=sigma)
    used = area >= 4 * taxel
    np.testing.assert_array_equal(result.threshold, theta[used])
    np.testing.assert_allclose(result.sqrt_area, np.sqrt(area[used]))
    if used.sum() < 3:
        assert math.isnan(result.bulge_perimeter)
        assert math.isnan(result.defect_sqrt_area)
        return
    smooth, chord = a_reference(theta[used], perimeter[used], sigma)
    np.testing.assert_allclose(result.perimeter, smooth)
    np.testing.assert_allclose(result.perimeter_chord, chord, atol=1e-12)
    _, straight = a_reference(theta[used], np.sqrt(area[used]), 0.0)
    np.testing.assert_allclose(result.sqrt_area_chord, straight, atol=1e-12)
    apart = np.array(smooth) - chord
    assert result.bulge_perimeter == pytest.approx(max(apart.max(), 0) / smooth[-1], abs=1e-12)
    assert result.defect_perimeter == pytest.approx(max(-apart.min(), 0) / smooth[-1], abs=1e-12)
    apart = np.sqrt(area[used]) - straight
    assert result.bulge_sqrt_area == pytest.approx(max(apart.max(), 0) / math.sqrt(area[-1]), abs=1e-12)
    assert result.defect_sqrt_area == pytest.approx(max(-apart.min(), 0) / math.sqrt(area[-1]), abs=1e-12)


def test_an_outline_of_no_length_has_neither_bulge_nor_defect():
    flat = inequality(a_profile([0.9, 0.5, 0.1], [9.0, 9.0, 9.0], perimeter=[2.0, 1.0, 0.0]))
    assert (flat.bulge_perimeter, flat.defect_perimeter) == (0.0, 0.0)
    same = inequality(a_profile([0.5, 0.5, 0.5], [4.0, 9.0, 16.0]))
    np.testing.assert_array_equal(same.sqrt_area_chord, same.sqrt_area)


# ---- heights, depths and radii of height maps


def height_map(solid, key, *, noise=0.0, pose=None, pitch=1e-3, shape=(40, 40), depth=None):
    frame = ideal_frame(solid, shape, pitch, pose=pose or Pose(), depth_m=depth)
    frame = frame + np.random.default_rng(1).normal(0, noise, frame.shape)
    recording = recording_of([frame], unit="m", pitch_m=pitch)
    answer = answers_of(recording)[0]
    return replace(answer, surface=surface_of(answer.surface.contact, key))


@pytest.mark.parametrize(
    ("solid", "key", "top"),
    [
        (Cone(24e-3, 6e-3), "cone", 6e-3),
        (Sphere(40e-3), "sphere", 4e-3),
        (Ridge(30e-3, 14e-3, 5e-3), "ridge", 5e-3),
        (Cylinder(20e-3, 3e-3), "cylinder", 3e-3),
    ],
    ids=lambda value: value if isinstance(value, str) else "",
)
def test_a_top_is_as_high_as_it_is(solid: Solid, key: str, top: float):
    depth = 4e-3 if key == "sphere" else None
    answer = height_map(solid, key, depth=depth)
    assert answer.depth_m == pytest.approx(top, rel=0.012)
    # Higher than the highest taxel, which averages the tip away.
    if key != "cylinder":
        assert answer.depth_m > 0.999 * answer.surface.contact.peak
    low, high = answer.depth_interval_m
    assert low < top < high
    assert (low + high) / 2 == pytest.approx(answer.depth_m)
    noisy = height_map(solid, key, depth=depth, noise=2e-5)
    assert noisy.depth_m == pytest.approx(top, rel=0.03)
    assert noisy.depth_interval_m[1] - noisy.depth_interval_m[0] >= high - low
    height, half = top_height(answer.surface)
    assert (height, height - half) == pytest.approx((answer.depth_m, low))


@pytest.mark.parametrize(("solid", "key"), [(Cone, "cone"), (Pyramid, "pyramid")])
def test_a_tip_that_few_taxels_cover_is_as_high_as_it_is(solid, key):
    """Taxels, and straight lines between them, take the same area of every section of a tip."""
    rng = np.random.default_rng(5)
    for breadth, near in ((6e-3, 0.04), (8e-3, 0.02), (12e-3, 0.01)):
        for _ in range(4):
            pose = Pose(*rng.uniform(-1e-3, 1e-3, 2), yaw_rad=rng.uniform(0, 3))
            answer = height_map(solid(breadth, 2e-3), key, pose=pose)
            assert answer.depth_m == pytest.approx(2e-3, rel=near)
            low, high = answer.depth_interval_m
            assert low < 2e-3 < high


def test_where_a_part_is_hidden_the_highest_taxel_counts():
    answer = height_map(Cone(24e-3, 6e-3), "cone", pose=Pose(-14e-3, 0.0))
    assert any(answer.surface.contact.borders)
    assert top_height(answer.surface)[0] == answer.surface.contact.peak
    u, v = grid(30, 30)
    frame = np.maximum(1 - np.hypot(u, v) / 10, 0)
    field = np.ones((30, 30), bool)
    field[15, 20] = False
    assert top_height(said(frame, "cone", field=field))[0] == frame.max()
    few = surface_of(find_contacts(frame, [0.8, 0.6, 0.4, 0.2])[0], "cone")
    assert top_height(few)[0] == frame.max()
    five = surface_of(find_contacts(frame, [0.8, 0.65, 0.5, 0.35, 0.2])[0], "cone")
    assert top_height(five)[0] > frame.max()


def test_the_size_of_a_height_map_is_that_of_the_body():
    rng, off = np.random.default_rng(2), []
    for breadth in np.linspace(6e-3, 12e-3, 13):
        frame = ideal_frame(Cylinder(breadth, 1.5e-3), (16, 16), 1e-3, pose=Pose(*rng.uniform(-1e-3, 1e-3, 2)))
        noisy = frame + rng.normal(0, 2e-5, frame.shape)
        (answer,) = recognize_recording(recording_of([noisy], unit="m", pitch_m=1e-3), frames="all")
        assert answer.surface.name == "cylinder"
        off.append([abs(size[0] / breadth - 1) for size in (answer.size, answer.surface.size)])
        assert answer.size[0] == answer.size[1] == answer.to_dict()["size_m"][0]
    told, section = np.median(off, axis=0)
    assert told < 0.01
    assert told < section


def test_how_sure_a_height_is_follows_noise_and_steepness():
    u, v = grid(30, 30)
    plain = said(steep(8 - np.hypot(u, v)), "cylinder")
    contact = plain.contact
    steepness = (contact.peak - contact.floor) / math.sqrt(plain.area)
    assert top_height(plain)[1] == pytest.approx(max(0.35 * contact.sigma, 0.03 * steepness))
    noisy = steep(8 - np.hypot(u, v)) + np.random.default_rng(0).normal(0, 0.05, u.shape)
    surface = surface_of(find_contacts(noisy)[0], "cone")
    assert top_height(surface)[1] == pytest.approx(
        max(
            3.4 * surface.contact.sigma, 0.25 * (surface.contact.peak - surface.contact.floor) / math.sqrt(surface.area)
        )
    )
    stranger = surface_of(find_contacts(noisy)[0], "stranger")
    assert top_height(stranger)[1] >= 3.0 * stranger.contact.sigma
    # A flat top is the mean of what lies within six sigma of the highest taxel.
    flat = surface_of(find_contacts(noisy)[0], "cylinder")
    values = flat.contact.values[flat.contact.mask]
    near = values[values >= flat.contact.peak - 6 * flat.contact.sigma]
    assert top_height(flat)[0] == pytest.approx(near.mean())


def test_radii_are_those_of_circles_through_the_sections():
    for depth in (1e-3, 3e-3):
        answer = height_map(Sphere(40e-3), "sphere", depth=depth, pitch=5e-4, shape=(80, 80))
        assert answer.radius_m == pytest.approx(20e-3, rel=0.03)
        low, high = answer.radius_interval_m
        assert low < 20e-3 < high
        assert low * high == pytest.approx(answer.radius_m**2)
        top, half = top_height(answer.surface)
        (_, _), (small, large) = answer.size_interval
        off = 1 + math.hypot((large - small) / answer.size[1], half / (top - answer.surface.contact.floor))
        assert high / answer.radius_m == pytest.approx(off)
    assert height_map(Cone(24e-3, 6e-3), "cone").radius_m is None
    assert height_map(Cone(24e-3, 6e-3), "cone").radius_interval_m is None
    raw = answers_of(recording_of([np.pad(np.ones((4, 4)), 3)], pitch_m=1e-3))[0]
    assert (raw.radius_m, raw.depth_m, raw.depth_interval_m, raw.tilt_rad) == (None, None, None, None)


def test_a_fitted_radius_is_told_with_its_interval():
    class Fitted(type(surface_of(find_contacts(np.pad([[1.0]], 3), 4)[0]))):
        depth_m = 2e-3
        radius_m = 5e-3

    recording = recording_of([np.pad(np.ones((4, 4)), 3)], pitch_m=1e-3, unit="Pa")
    answer = answers_of(recording, "sphere")[0]
    assert (answer.radius_m, answer.radius_interval_m) == (None, None)
    fitted = Fitted(**{f: getattr(answer.surface, f) for f in answer.surface.__dataclass_fields__})
    answer = replace(answer, surface=fitted)
    assert answer.depth_m == 2e-3
    assert answer.radius_m == 5e-3
    assert answer.depth_interval_m is None
    low, high = answer.radius_interval_m
    assert low * high == pytest.approx(25e-6)
    assert 1.03 < high / 5e-3 < 1.15
    assert replace(answer, pitch_m=None).radius_m is None


@given(st.floats(0.02, 0.4), st.floats(-3, 3))
@settings(max_examples=10)
def test_a_leaning_face_leans_as_it_does(tilt, way):
    y, x = np.mgrid[:30, :30] - 14.5
    inside = (abs(x) < 9) & (abs(y) < 9)
    plane = 0.02 + 0.001 * math.tan(tilt) * (x * math.cos(way) + y * math.sin(way))
    recording = recording_of([np.where(inside, plane, 0.0)], unit="metre", pitch_m=0.001)
    answer = answers_of(recording, "square-pillar")[0]
    assert answer.tilt_rad == pytest.approx(tilt, abs=1e-6)
    assert answers_of(recording, "cone")[0].tilt_rad is None


@pytest.mark.parametrize(
    ("high", "wide", "told"), [(3, 3, True), (2, 5, False), (5, 2, False), (2, 2, False), (1, 9, False)]
)
def test_a_face_takes_three_rows_and_columns_to_lean(high, wide, told):
    frame = np.zeros((12, 12))
    frame[4 : 4 + high, 2 : 2 + wide] = 0.004
    answer = answers_of(recording_of([frame], unit="m", pitch_m=(0.002, 0.001)), "square-pillar")[0]
    assert (answer.tilt_rad is not None) == told
    if told:
        frame[4 : 4 + high, 2 : 2 + wide] += 0.0001 * np.arange(wide)
        answer = answers_of(recording_of([frame], unit="m", pitch_m=(0.002, 0.001)), "square-pillar")[0]
        assert answer.tilt_rad == pytest.approx(math.atan(0.1))


def test_a_force_is_the_sum_over_the_area():
    frame = np.zeros((12, 12))
    frame[4:8, 3:8] = 2.5
    recording = recording_of([frame], unit="kPa", pitch_m=(0.002, 0.001))
    assert answers_of(recording)[0].force_n == pytest.approx(20 * 2500 * 2e-6)
    assert answers_of(recording_of([frame], unit="kPa"))[0].force_n is None
    assert answers_of(recording_of([frame], pitch_m=0.002))[0].force_n is None


def test_an_answer_in_plain_values_has_both_units():
    u, v = grid(30, 30, x=4, y=-3)
    frame = np.maximum(1 - np.hypot(u / 9, v / 6), 0)
    known = answers_of(recording_of([frame], pitch_m=(0.003, 0.002)), "ridge")[0].to_dict()
    bare = answers_of(recording_of([frame]), "ridge")[0].to_dict()
    for told in (known, bare):
        assert told["position_taxels"] == pytest.approx([4, -3], abs=0.2)
    assert known["position_m"] == pytest.approx(
        [known["position_taxels"][0] * 0.002, known["position_taxels"][1] * 0.003]
    )
    assert known["area_m2"] == pytest.approx(known["area_taxels"] * 6e-6)
    assert known["size_m"] == pytest.approx([s * math.sqrt(6e-6) for s in known["size_taxels"]])
    for key in ("position_m", "size_m", "area_m2", "size_interval_m", "force_n", "depth_m", "radius_m", "tilt_rad"):
        assert bare[key] is None
    assert bare["area_taxels"] == pytest.approx(known["area_taxels"])
    assert known["size_interval_m"][0][0] < known["size_m"][0] < known["size_interval_m"][0][1]
    plane = answers_of(recording_of([frame], pitch_m=0.002), "plane")[0].to_dict()
    assert plane["size_interval_m"] is None
    assert known["probability"] == 0.9
    assert known["defect_sqrt_area"] >= 0


# ---- reasons


def numbers(text):
    return [float(n) for n in re.findall(r"-?\d+\.\d+", text)]


@pytest.mark.parametrize(
    ("key", "frame", "told"),
    [
        ("cone", lambda u, v: np.maximum(1 - np.hypot(u, v) / 16, 0), [0.5]),
        ("sphere", lambda u, v: np.maximum(1 - (u**2 + v**2) / 256, 0), [math.sqrt(0.5)]),
        ("stranger", lambda u, v: np.maximum(1 - np.hypot(u, v) / 16, 0), [0.5]),
        ("square-pillar", lambda u, v: np.clip(2 * (16 - np.maximum(abs(u), abs(v))), 0, 1), [1.0]),
        ("cone-frustum", lambda u, v: np.clip((16 - np.hypot(u, v)) / 8, 0, 1), [0.5]),
        ("ridge", lambda u, v: np.where(abs(u) < 16, np.maximum(1 - abs(v) / 8, 0), 0), [1.0, 0.1 / 0.7]),
    ],
    ids=lambda value: value if isinstance(value, str) else "",
)
def test_reasons_tell_how_sections_grow(key, frame, told):
    surface = said(frame(*grid(48, 48)), key, floor=1e-3)
    # In the order of the text: near the top against farther down.
    (growth,) = [r for r in surface.reasons if r.startswith("sections")]
    found = numbers(growth.split(";")[0].split(": ")[-1])
    if key == "ridge":
        near_length, near_breadth = found
        assert near_length == pytest.approx(1.0, abs=0.041)
        # From .9 of the way down to .3: breadths go with depth.
        assert near_breadth == pytest.approx(0.3 / 0.9, abs=0.07)
    else:
        assert found == pytest.approx(told, abs=0.041)
    assert ("apex exponent" in growth) == (
        key in ("cone", "sphere", "stranger", "ridge") and surface.exponent is not None
    )
    outline = [r for r in surface.reasons if r.startswith("outline ")]
    if surface.section == "unknown":
        assert not outline
    else:
        share = sum(
            q for q, kind in zip(surface.kind_probability, KINDS, strict=True) if kind.section == surface.section
        )
        assert outline == [f"outline {surface.section} ({share:.2f})"]


def test_what_fills_the_field_says_how_much_of_it():
    frame = np.zeros((20, 20))
    frame[:, :13] = 5.0
    field = np.ones((20, 20), bool)
    field[:, 18:] = False
    surface = said(frame, "edge", field=field)
    assert f"the contact covers {13 / 18:.0%} of the field" in surface.reasons


def test_small_contacts_are_doubted():
    frame = np.zeros((12, 12))
    frame[4:6, 4:7] = 5.0
    unsure = "taxels touch: the outline is hardly resolved"
    (caution,) = [r for r in said(frame, "cylinder").reasons if unsure in r]
    assert caution == f"only about {said(frame, 'cylinder').area:.0f} {unsure}"
    (strange,) = [r for r in said(frame, "stranger").reasons if "too small for a form" in r]
    across = said(frame, "stranger").breadths(said(frame, "stranger").lowest)[1]
    assert strange.startswith(f"{across:.1f} taxels across")
    u, v = grid(30, 30)
    large = steep(9 - np.hypot(u, v))
    for key in ("cylinder", "stranger"):
        assert not any(("taxels" in r and "only" in r) or "across" in r for r in said(large, key).reasons)


def test_a_ring_is_told_where_the_pressure_is_highest_along_it():
    u, v = grid(30, 30)
    ring = np.maximum(1 - abs(np.hypot(u, v) - 8) / 4, 0)
    told = "the pressure is highest along a ring, as under a flat face on a thick elastic skin"
    assert told in said(ring, "cylinder").reasons
    assert told not in said(ring, "stranger").reasons
    assert told not in said(np.maximum(1 - np.hypot(u, v) / 12, 0), "cone").reasons
    # A hole low down only, as under a hollow, is none.
    low = np.maximum(1 - np.hypot(u, v) / 12, 0)
    low[(np.hypot(u - 8, v) < 1.5)] = 0.0
    surface = said(low, "cone", floor=0.01)
    assert surface.profile.holes.any()
    assert told not in surface.reasons


def test_what_decided_is_told_from_the_nearest_other_name():
    frame = ideal_frame(Cone(18.0, 6.0), (32, 32), 1.0) + np.random.default_rng(3).normal(0, 0.05, (32, 32))
    surface = recognize(find_contacts(frame)[0])
    p = surface.kind_probability
    named = [k for k, kind in enumerate(KINDS) if kind.name == surface.name]
    others = [k for k, kind in enumerate(KINDS) if kind.name != surface.name]
    kind, rival = max(named, key=lambda k: p[k]), max(others, key=lambda k: p[k])
    weights = evidence(surface.inputs, surface.parameters, kind, rival)
    assert list(weights.values()) == sorted(weights.values(), reverse=True)
    for_it = [f"{group} {nats:+.1f}" for group, nats in weights.items() if nats >= 0.5][:3]
    against = [f"{group} {nats:+.1f}" for group, nats in weights.items() if nats <= -0.5]
    (told,) = [r for r in surface.reasons if r.startswith("told from")]
    other = KINDS[rival].key.replace("-", " ") if KINDS[rival].name == "unknown" else KINDS[rival].name
    expected = f"told from {other} ({p[rival]:.2f}) by {', '.join(for_it)} nats"
    assert told == expected + (f", against it {against[-1]}" if against else "")


# ---- where to cut next


def test_the_next_cut_lies_where_kinds_lie_apart():
    (contact,) = find_contacts(np.maximum(1 - np.hypot(*grid(32, 32)) / 12, 0), floor=0.02)
    surface = surface_of(contact, "cone", 0.5)
    p = np.zeros(len(KINDS))
    a, b = (k for k, kind in enumerate(KINDS) if kind.key in ("cone", "sphere"))
    p[[a, b]] = 0.5
    span = contact.peak - contact.floor
    cuts = contact.peak - span * np.arange(1, BANDS) / BANDS
    for band in range(BANDS):
        means = np.zeros((len(KINDS), len(SIGNATURE_NAMES)))
        last = next(k for k, name in enumerate(SIGNATURE_NAMES) if name.endswith(f"_{band}"))
        means[a, last] = 3.0
        asked = replace(surface, kind_probability=p, parameters=replace(BLANK, kind_means=means))
        # With the bands' ends all cut, the band that tells the two apart is halved.
        depth = (contact.peak - next_threshold(asked, cuts)) / span
        assert depth == pytest.approx((band + 0.5) / BANDS)
        # What is out of the question decides nothing: then the first of the equal gaps is halved.
        unlikely = p.copy()
        unlikely[[a, b]] = 0.995, 0.005
        depth = (contact.peak - next_threshold(replace(asked, kind_probability=unlikely), cuts)) / span
        assert depth == pytest.approx(0.5 / BANDS, abs=1e-9) or depth * BANDS % 1 == pytest.approx(0.5)
        # Kinds of one name need not be told apart.
        same = np.zeros(len(KINDS))
        same[[k for k, kind in enumerate(KINDS) if kind.name == "unknown"][:2]] = 0.5
        means[:] = 0.0
        means[next(k for k, kind in enumerate(KINDS) if kind.name == "unknown"), last] = 9.0
        blind = replace(asked, kind_probability=same, parameters=replace(BLANK, kind_means=means))
        assert next_threshold(blind, []) == pytest.approx(contact.peak - span / 2)


def test_a_gap_twice_as_wide_is_worth_four_times_as_much():
    (contact,) = find_contacts(np.maximum(1 - np.hypot(*grid(32, 32)) / 12, 0), floor=0.02)
    surface = surface_of(contact, "cone", 0.5)
    p = np.zeros(len(KINDS))
    a, b = (k for k, kind in enumerate(KINDS) if kind.key in ("cone", "sphere"))
    p[[a, b]] = 0.5
    span = contact.peak - contact.floor
    first, second = (
        next(k for k, n in enumerate(SIGNATURE_NAMES) if n.endswith(f"_{band}")) for band in (0, BANDS - 1)
    )
    # A narrow gap at the top, one twice as wide at the bottom, in between all is cut.
    cuts = contact.peak - span * np.concatenate([[0.04], np.linspace(0.04, 0.92, 200)])
    for apart, top in ((3.9, False), (4.1, True)):
        means = np.zeros((len(KINDS), len(SIGNATURE_NAMES)))
        means[a, first], means[a, second] = apart, 1.0
        asked = replace(surface, kind_probability=p, parameters=replace(BLANK, kind_means=means))
        chosen = (contact.peak - next_threshold(asked, cuts)) / span
        assert chosen == pytest.approx(0.02 if top else 0.96)


# ---- contacts on the scale from which names were learned


def test_a_very_large_contact_is_averaged_down():
    u, v = grid(120, 150, x=10, y=-5)
    frame = np.maximum(1 - np.hypot(u / 55, v / 30), 0)
    (contact,) = find_contacts(frame, pitch=(0.001, 0.002))
    coarse = as_learned(contact)
    # 105 taxels long: means of 4 x 4, so that about 32 remain at most.
    assert coarse.shape == (30, 38)
    assert coarse.pitch == (0.004, 0.008)
    values = coarse.frame.padded[1:-1, 1:-1]
    np.testing.assert_allclose(values[:30, :37], frame[:, :148].reshape(30, 4, 37, 4).mean(axis=(1, 3)))
    np.testing.assert_allclose(values[:, 37], frame[:, 148:].reshape(30, 4, 2).mean(axis=(1, 2)))
    assert coarse.floor == pytest.approx(max(contact.floor, 0.05 * contact.peak))
    assert coarse.profile.area[-1] == pytest.approx(contact.profile.area[-1], rel=0.03)
    small = find_contacts(np.maximum(1 - np.hypot(u / 20, v / 15), 0))[0]
    assert as_learned(small) is small
    low = find_contacts(np.maximum(1 - np.hypot(u / 20, v / 15), 0), floor=0.001)[0]
    raised = as_learned(low)
    assert raised.floor == pytest.approx(0.05 * low.peak)
    assert raised.shape == low.shape


@pytest.mark.parametrize("wide", [48, 49])
def test_up_to_48_taxels_are_seen_as_they_are(wide):
    frame = np.zeros((20, 60))
    frame[8:12, 4 : 4 + wide] = 1.0
    frame[1:3, 1] = 0.7
    contact = find_contacts(frame)[0]
    coarse = as_learned(contact)
    assert (coarse is contact) == (wide == 48)
    if wide == 49:
        assert coarse.shape == (10, 30)
        # It is the same contact, not the one beside it.
        assert coarse.n_taxels > 40


def test_a_mean_is_missing_where_most_of_its_taxels_are():
    frame = np.zeros((10, 60))
    frame[2:8, 2:58] = 1.0
    field = np.ones((10, 60), bool)
    field[4, 20:22] = field[4:6, 30:32] = False
    field[4, 40] = field[5, 40] = field[4, 41] = False
    coarse = as_learned(find_contacts(frame, field=field)[0])
    there = coarse.field
    # Half of the taxels are enough.
    assert there[2, 10]
    assert not there[2, 15]
    assert not there[2, 20]
    assert coarse.frame.padded[1:-1, 1:-1][2, 10] == pytest.approx(1.0)


# ---- a whole recording


def press_of(seed=0, n=24, noise=0.2, rest=0.0):
    """Quiet, then a cone that rises and falls."""
    rng = np.random.default_rng(seed)
    force = np.concatenate([np.zeros(8), np.linspace(0.2, 1, 8), np.linspace(0.9, 0, n - 16)])
    u, v = grid(24, 24)
    shape = np.maximum(1 - np.hypot(u, v) / 9, 0)
    return rest + 100 * force[:, None, None] * shape + rng.normal(0, noise, (n, 24, 24))


def test_a_press_is_answered_once_at_its_heaviest_frame():
    recording = Recording({"pad": Pad(press_of())}, time_s=np.arange(24) * 0.1)
    (answer,) = recognize_recording(recording, frames="press")
    assert answer.frame == 15
    assert answer.time_s == pytest.approx(1.5)
    assert answer.contact == 0
    assert answer.pad == "pad"
    alone = next(recognize_recording(recording, frames=15))
    assert answer.surface.size == pytest.approx(alone.surface.size)
    # The pool is the geometric mean over the press, each frame weighed by its height above the floor.
    logs, total = 0.0, 0.0
    reach = math.sqrt(alone.surface.area)
    for i in range(8, 24):
        for one in recognize_recording(recording, frames=i):
            x, y = one.surface.contact.peak_position
            if math.hypot(x - alone.surface.position[0], y - alone.surface.position[1]) < reach:
                weight = one.surface.contact.peak - one.surface.contact.floor
                logs = logs + weight * np.log(np.maximum(one.surface.kind_probability, 1e-12))
                total += weight
                break
    p = np.exp(logs / total)
    np.testing.assert_allclose(answer.surface.kind_probability, p / p.sum(), rtol=0.05, atol=2e-3)


def test_a_recording_that_begins_unloaded_is_zeroed():
    rng = np.random.default_rng(2)
    own = rng.uniform(20, 40, (24, 24))
    frames = press_of(rest=own)
    seen = pad_frames(Recording({"pad": Pad(frames)}))["pad"]
    np.testing.assert_allclose(seen.rest, np.median(frames[:8], axis=0))
    assert seen.notes == ("zeroed on frames 0 to 7, before the first touch",)
    np.testing.assert_allclose(seen.frame(15), frames[15] - seen.rest)
    np.testing.assert_allclose(seen.readings(15), frames[15] - seen.rest)
    assert seen.sigma == pytest.approx(0.2, rel=0.15)
    assert seen.valid is None
    # What is at rest at zero, within the noise, is left alone; and so is what has no three quiet frames.
    assert pad_frames(Recording({"pad": Pad(press_of())}))["pad"].rest is None
    assert pad_frames(Recording({"pad": Pad(frames[6:])}))["pad"].rest is None
    assert pad_frames(Recording({"pad": Pad(frames[5:])}))["pad"].rest is not None
    assert pad_frames(Recording({"pad": Pad(frames[15:18])}))["pad"].rest is None
    (note,) = pad_frames(Recording({"pad": Pad(frames[15:16])}))["pad"].notes
    assert note.startswith("a single frame")


def test_what_lies_on_the_pad_from_the_start_is_no_rest():
    frames = press_of(rest=30.0, noise=0.1)
    for side, kept in ((2, False), (1, True)):
        lying = frames.copy()
        lying[:, 2 : 2 + side, 2 : 2 + side] += 0.8
        seen = pad_frames(Recording({"pad": Pad(lying)}))["pad"]
        # Four taxels side by side touch; one rests high.
        assert (seen.rest is not None) == kept


def test_whole_numbers_stay_whole():
    frames = np.rint(press_of(rest=30.0, noise=1.0)).astype(np.uint16)
    seen = pad_frames(Recording({"pad": Pad(frames)}))["pad"]
    got = seen.readings(15)
    assert got.dtype == np.int64
    np.testing.assert_array_equal(got, frames[15].astype(int) - np.rint(seen.rest).astype(int))
    flat = pad_frames(Recording({"pad": Pad(frames[15:16])}))["pad"]
    assert flat.readings(0).dtype == np.uint16


def test_taxels_that_never_change_are_broken():
    frames = press_of()
    frames[:, 3, 4] = 7.0
    frames[:, 12, 12] = 0.0
    seen = pad_frames(Recording({"pad": Pad(frames)}))["pad"]
    expected = np.ones((24, 24), bool)
    expected[3, 4] = expected[12, 12] = False
    np.testing.assert_array_equal(seen.valid, expected)
    assert any("dead or stuck" in note for note in seen.notes)
    valid = np.ones((24, 24), bool)
    valid[20, 20] = False
    seen = pad_frames(Recording({"pad": Pad(frames, valid=valid)}))["pad"]
    np.testing.assert_array_equal(seen.valid, expected & valid)


def test_a_full_scale_is_where_many_readings_end():
    frames = np.minimum(press_of(noise=0.0), 60.0)
    seen = pad_frames(Recording({"pad": Pad(frames)}))["pad"]
    assert seen.full_scale == 60.0
    np.testing.assert_array_equal(seen.saturated(15), frames[15] >= 60.0)
    assert seen.saturated(0) is None
    answers = list(recognize_recording(Recording({"pad": Pad(frames)}), frames=15))
    n = int((frames[15] >= 60).sum())
    assert any(note == f"{n} taxels saturated: at least what is shown" for note in answers[0].frame_notes)


def test_notes_count_what_was_filled():
    frame = np.maximum(1 - np.hypot(*grid(24, 24)) / 9, 0)
    (contact,) = find_contacts(frame)
    repaired = np.zeros((24, 24), bool)
    for n, words in ((1, "1 broken taxel filled"), (2, "2 broken taxels filled")):
        repaired[12, 11 : 11 + n] = True
        (hurt,) = with_losses([contact], repaired=repaired)
        assert hurt.state.repaired == n
        from varishold.touch.recordings import _frame_notes

        knows = SimpleNamespace(
            sensors={"pad": None}, sensor=None, frames={"pad": SimpleNamespace(notes=(), gains=None)}
        )
        assert _frame_notes(hurt, "pad", knows) == (f"{words} from the neighbours",)


def test_poses_weigh_sections_by_their_height():
    theta = np.array([0.8, 0.6, 0.3])
    (contact,) = find_contacts(np.maximum(1 - np.hypot(*grid(32, 32, x=2)) / 12, 0), theta, floor=0.1)
    profile = contact.profile
    step = np.array([0.2, 0.25, 0.3])
    weight = (theta - 0.1) * step * profile.area
    pose = contact_pose(contact)
    x = (weight * profile.centroid[:, 0]).sum() / weight.sum()
    assert pose.position[0] == pytest.approx(x)
    assert pose.mean_area == pytest.approx(weight.sum() / ((theta - 0.1) * step).sum())
    spread = profile.covariance[:, 0, 0] + (profile.centroid[:, 0] - x) ** 2
    assert pose.covariance[0, 0] == pytest.approx((weight * spread).sum() / weight.sum())


FACES = {
    "cone": lambda u, v: 1 - np.hypot(u, v) / 40,
    "pyramid": lambda u, v: 1 - np.maximum(abs(u), abs(v)) / 40,
    "sphere": lambda u, v: 1 - (u**2 + v**2) / 1600,
    "ridge": lambda u, v: np.where(abs(u) < 40, 1 - abs(v) / 20, 0),
    "hip": lambda u, v: np.minimum(1 - abs(v) / 20, (40 - abs(u)) / 20),
    "lying-cylinder": lambda u, v: np.where(abs(u) < 40, 1 - v**2 / 400, 0),
    "cylinder": lambda u, v: 30.5 - np.hypot(u, v),
    "square-pillar": lambda u, v: 30.5 - np.maximum(abs(u), abs(v)),
    "rectangular-pillar": lambda u, v: np.minimum(38.5 - abs(u), 18.5 - abs(v)),
    "wedge": lambda u, v: 1 - abs(v) / 20 + 0 * u,
    "edge": lambda u, v: 5.0 * (v < 0) + 0 * u,
    "plane": lambda u, v: 1.0 + 0 * u + 0 * v,
}


@pytest.mark.parametrize("key", FACES)
def test_areas_grow_from_the_top_with_the_exponent_of_the_kind(key):
    """A ~ (theta_1 - theta)^k: sections of a point go with the square, of a line with the depth, of a flat top not."""
    kind = next(kind for kind in KINDS if kind.key == key)
    surface = said(np.clip(FACES[key](*grid(90, 90)), 0, 1), key, floor=1e-3)
    assert surface.exponent == pytest.approx(kind.exponent, abs=0.16)


@pytest.mark.parametrize("side", SIDES)
def test_an_edge_along_the_grid_points_along_it_at_every_border(side):
    """A face that ends sharply between two lines of taxels, and covers the pad's border on the other three sides."""
    frame = np.zeros((14, 18))
    frame[{"left": np.s_[:, :8], "right": np.s_[:, 10:], "top": np.s_[:6], "bottom": np.s_[8:]}[side]] = 3.0
    surface = said(frame, "edge")
    upright = side in ("left", "right")
    assert abs(surface.orientation) == pytest.approx(math.pi / 2 if upright else 0.0, abs=1e-9)
    # Another contact beside it does not turn it.
    if side == "left":
        frame[1:13, 10:12] = 2.0
        assert abs(said_first(frame, "edge").orientation) == pytest.approx(math.pi / 2, abs=1e-9)


def said_first(frame, key):
    return surface_of(find_contacts(frame, 64)[0], key)


@pytest.mark.parametrize("skirt", [0.0, 0.05, 0.1])
@pytest.mark.parametrize("radius", [2.5e-3, 4e-3])
def test_a_gel_s_skirt_does_not_widen_the_ball(skirt: float, radius: float) -> None:
    """Around a ball a gel hangs like a tent; its lowest section is no section of the ball."""
    pitch, depth = 1e-4, 7e-4
    y, x = (np.mgrid[:120, :120] - 59.5) * pitch
    cap = np.maximum(depth - radius + np.sqrt(np.maximum(radius**2 - x**2 - y**2, 0)), 0)
    reach = 13 * pitch
    tent = depth * np.exp(-np.maximum(np.hypot(x, y) - 0.5 * math.sqrt(8 * radius * depth), 0) / reach)
    frame = np.maximum(cap, skirt * tent) + np.random.default_rng(0).normal(0, 0.01 * depth, x.shape)
    recording = Recording({"pad": Pad(frame[None], pitch_m=pitch)}, unit="m")
    (answer,) = recognize_recording(recording)
    assert answer.surface.name == "sphere"
    assert answer.radius_m == pytest.approx(radius, rel=0.05)
    assert answer.radius_interval_m is not None
    assert answer.radius_interval_m[0] <= radius <= answer.radius_interval_m[1]


@pytest.mark.parametrize("side", [32, 96, 200])
def test_sizes_of_a_map_hold_however_fine_it_is(side):
    """How far sizes are off was learned on so many taxels: finer ones bring no other error."""
    held, off = [], []
    for seed in range(4):
        for share in (0.55, 0.7):
            breadth = share * side
            rng = np.random.default_rng([seed, side])
            for solid in (Cone(breadth, 0.2 * side), ConeFrustum(breadth, 0.5 * breadth, 0.2 * side)):
                frame = ideal_frame(solid, (side, side), 1.0)
                frame += 0.01 * frame.max() * rng.standard_normal(frame.shape)
                contact = find_contacts(frame)[0]
                surface = recognize(contact)
                true = breadth * (1 - contact.floor / (0.2 * side)) if isinstance(solid, Cone) else 0.5 * breadth
                (low, high), _ = surface.size_interval_of(height_map=True)
                held.append(low <= true <= high)
                off.append(surface.size_of(height_map=True)[0] / true - 1)
    assert np.mean(held) > 0.8
    assert abs(np.median(off)) < 0.01


def test_a_coarser_look_has_the_contacts_own_thresholds():
    u, v = grid(96, 96)
    contact = find_contacts(np.maximum(1 - np.hypot(u, v) / 40, 0), [0.8, 0.5, 0.2], floor=0.1, pitch=0.001)[0]
    coarse = on_scale(contact)
    assert coarse.profile.threshold.tolist() == [0.8, 0.5, 0.2]
    assert (coarse.floor, coarse.pitch) == (0.1, pytest.approx((0.003, 0.003)))
    assert coarse.profile.area == pytest.approx(contact.profile.area, rel=0.05)
    assert on_scale(find_contacts(np.maximum(1 - np.hypot(u, v) / 20, 0))[0]).shape == (96, 96)
