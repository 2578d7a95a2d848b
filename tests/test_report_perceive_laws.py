"""The drawings and words of `varishold perceive` and `sensor calibrate` read back: numbers stand where they belong."""

from __future__ import annotations

import math
import re
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tests.reading_svg import area_of, box_of, drawn, legible, of_class, paths_of, picture_of, said

from varishold._counted import counted
from varishold.calibration.result import Calibration, Curve, Finding
from varishold.perceive import NONE_OF_THESE, GripContacts, fit_section
from varishold.perceive.perceiver import BeliefUpdate, Perception
from varishold.report import render_calibration_report
from varishold.report.belief_chart import belief_chart, size_strip
from varishold.report.colours import css, shade
from varishold.report.grip_drawing import SECTION_OF, grip_drawing
from varishold.report.quantities import percent
from varishold.report.response_plot import response_plot
from varishold.report.taxel_map import taxel_map
from varishold.sensor import Power, Sensor

pytest.importorskip("mujoco", reason="MuJoCo is not installed; pip install -e '.[sim]'")

from varishold.exploration import TOUCHES, Exploration, Felt, MadeTouch
from varishold.hand import LAYOUTS, HandDesign, HandSetting
from varishold.hand.pads import PadFrames
from varishold.report.exploration_words import (
    answer_in_words,
    in_words,
    information,
    size_in_words,
    spoken,
    truth_in_words,
    verdict_in_words,
    was_right,
    with_article,
)
from varishold.report.pad_hand import SURFACE_COLOURS, pad_hand, tip_pad
from varishold.report.perceive_report import render_perceive_report
from varishold.touch import SURFACES, PadSurface

# ---- belief over the touches


def beliefs_of(rows):
    return [{f"object-{k}": p / sum(row) for k, p in enumerate(row)} for row in rows]


ROWS = st.integers(2, 8).flatmap(
    lambda n: st.lists(st.lists(st.floats(0.001, 1), min_size=n, max_size=n), min_size=1, max_size=5)
)


@given(ROWS, st.booleans())
@settings(max_examples=40)
def test_every_belief_stands_at_its_height_over_its_touch(rows, narrow):
    beliefs = beliefs_of(rows)
    touches = [f"touch {k}" for k in range(len(rows))]
    root = drawn(belief_chart(beliefs, touches, narrow=narrow))
    names, n = list(beliefs[0]), len(rows)
    words = dict(zip(said(root), root.iter("text"), strict=True))
    # The axis: 0 to 100 %, evenly, each number beside its line.
    y_of = {
        int(text.split("\u202f")[0]): float(words[text].get("y")) - 3.5
        for text in said(root)
        if re.fullmatch(r"\d+\u202f%", text) and words[text].get("text-anchor") == "end"
    }
    assert sorted(y_of) == [0, 25, 50, 75, 100]
    height = lambda p: y_of[0] + (y_of[100] - y_of[0]) * p  # noqa: E731
    assert [y_of[p] for p in (25, 50, 75)] == pytest.approx([height(p) for p in (0.25, 0.5, 0.75)], abs=0.06)
    rules = [box_of(root, each) for each in (*of_class(root, "base"), *of_class(root, "rule"))]
    assert sorted(box[1] for box in rules) == pytest.approx(sorted(y_of.values()), abs=0.06)
    assert box_of(root, of_class(root, "base")[0])[1] == pytest.approx(y_of[0], abs=0.06)
    left, right = rules[0][0], rules[0][2]
    x = np.linspace(left, right, n + 1)
    # Touches are named under their places, in a narrow window numbered; before the first nothing is known.
    told = ["before", *(map(str, range(1, n + 1)) if narrow else touches)]
    under = [e for e in root.iter("text") if float(e.get("y")) > y_of[0] + 10]
    assert ["".join(e.itertext()) for e in under] == told
    assert [float(e.get("x")) for e in under] == pytest.approx(x, abs=0.06)
    assert [e.get("text-anchor") for e in under] == ["start"] + ["middle"] * n
    # A line an object, from alike.
    shown = [name for name in names if max(row[name] for row in beliefs) >= 0.05]
    shown = sorted(
        sorted(shown, key=lambda name: -max(row[name] for row in beliefs))[:6], key=lambda name: -beliefs[-1][name]
    )
    lines = of_class(root, "line")
    assert len(lines) == len(names)
    assert len(of_class(root, "rest")) == len(names) - len(shown)
    for rank, name in enumerate(shown):
        (line,) = [each for each in lines if f"k{rank}" in each.get("class").split()]
        p = [1 / len(names), *(row[name] for row in beliefs)]
        (points,) = paths_of(line.get("d"))
        np.testing.assert_allclose(points, np.column_stack([x, [height(q) for q in p]]), atol=0.11)
        spots = [e for e in of_class(root, "spot") if f"k{rank}" in e.get("class").split()]
        np.testing.assert_allclose([[float(e.get("cx")), float(e.get("cy"))] for e in spots], points[1:], atol=0.06)
        (end,) = [e for e in of_class(root, "end") if f"k{rank}" in e.get("class").split()]
        assert "".join(end.itertext()) == (in_words(name) if narrow else f"{in_words(name)} {percent(p[-1])}")
        assert float(end.get("x")) - right == 10
    # The likeliest is painted last, over the others.
    painted = [next(c for c in each.get("class").split() if c != "line") for each in lines]
    assert painted == ["rest"] * (len(names) - len(shown)) + [f"k{k}" for k in reversed(range(len(shown)))]
    label = root.get("aria-label")
    assert label.startswith(
        f"Probability of each object over {counted(n, 'touch')}; at the end {in_words(shown[0])} "
        f"{percent(beliefs[-1][shown[0]])}"
    )
    # Labels lie as near to their lines as the room that each needs lets them.
    ends = [
        (float(e.get("y")) - 4, height(beliefs[-1][name])) for name, e in zip(shown, of_class(root, "end"), strict=True)
    ]
    assert [at for at, _ in ends] == sorted(at for at, _ in ends)
    for at, wanted in ends:
        assert abs(at - wanted) <= 16 * len(shown) + 0.1
        assert y_of[100] - 0.1 <= at <= y_of[0] + 0.1
    if len(shown) == 1:
        assert ends[0][0] == pytest.approx(ends[0][1], abs=0.11)


def test_labels_that_have_room_stand_at_the_ends_of_their_lines():
    root = drawn(belief_chart([{"a": 0.6, "b": 0.3, "c": 0.1}], ["grasp"]))
    spots = [float(e.get("cy")) for e in reversed(of_class(root, "spot"))]
    ends = [float(e.get("y")) - 4 for e in of_class(root, "end")]
    assert ends == pytest.approx(spots, abs=0.06)
    # Two that end together move apart by a line, the likelier above.
    root = drawn(belief_chart([{"a": 0.5, "b": 0.5}], ["grasp"]))
    upper, lower = (float(e.get("y")) for e in of_class(root, "end"))
    assert lower - upper == pytest.approx(16, abs=0.11)


def test_a_chart_is_wide_or_narrow_and_labels_have_room():
    rows = beliefs_of([[0.4, 0.35, 0.25], [0.5, 0.3, 0.2]])
    for narrow, least, most in ((False, 800, 1000), (True, 300, 420)):
        root = drawn(belief_chart(rows, ["grasp", "regrasp turned 45"], narrow=narrow))
        _, _, wide, _ = map(float, root.get("viewBox").split())
        assert least <= wide <= most
        legible(root)


# ---- size


@given(st.floats(0.02, 0.2), st.floats(0.0005, 0.03), st.floats(0.0005, 0.03), st.floats(0.02, 0.2))
@settings(max_examples=40)
def test_sizes_stand_where_the_axis_says(size, below, above, true):
    root = drawn(size_strip(size, (size - below, size + above), true))
    mm = lambda metres: f"{1e3 * metres:.0f}"  # noqa: E731
    ticks = [(float("".join(t.itertext())), float(t.get("x"))) for t in root.iter("text")]
    (mm0, x0), *_, (mm1, x1) = ticks
    at = lambda metres: x0 + (x1 - x0) * (1e3 * metres - mm0) / (mm1 - mm0)  # noqa: E731
    assert [mm for mm, _ in ticks] == list(range(round(mm0), round(mm1) + 1, 20))
    assert [x for _, x in ticks] == pytest.approx([at(mm / 1e3) for mm, _ in ticks], abs=0.11)
    left, _, right, _ = box_of(root, of_class(root, "interval")[0])
    assert left == pytest.approx(at(size - below), abs=0.2)
    assert right == pytest.approx(max(at(size + above), left + 2), abs=0.3)
    median = box_of(root, of_class(root, "median")[0])
    assert median[0] == median[2] == pytest.approx(at(size), abs=0.2)
    assert paths_of(of_class(root, "true")[0].get("d"))[0][0][0] == pytest.approx(at(true), abs=0.2)
    base = box_of(root, of_class(root, "base")[0])
    _, _, wide, _ = map(float, root.get("viewBox").split())
    assert base[0] == wide - base[2] == 8
    low, high = min(0.03, size - below, true), max(0.13, size + above, true)
    assert (at(low), at(high)) == pytest.approx((base[0], base[2]), abs=0.2)
    assert len(ticks) == math.floor(high / 0.02 + 1e-9) - math.ceil(low / 0.02 - 1e-9) + 1
    for element in of_class(root, "base")[1:]:
        (stroke,) = paths_of(element.get("d"))
        assert stroke[0][1] == base[1] < stroke[1][1]
    # The interval lies about the axis, the median across it, the truth above, pointing down at it.
    _, upper, _, lower = box_of(root, of_class(root, "interval")[0])
    assert (upper + lower) / 2 == base[1] == (median[1] + median[3]) / 2
    assert median[1] < upper
    point, *rest = paths_of(of_class(root, "true")[0].get("d"))[0]
    assert upper >= point[1] - 5
    assert all(corner[1] < point[1] < base[1] for corner in rest)
    assert (rest[0][0] + rest[1][0]) / 2 == pytest.approx(point[0])
    assert (
        root.get("aria-label")
        == f"Size {mm(size)} mm, with 95 % between {mm(size - below)} and {mm(size + above)} mm; truly {mm(true)} mm"
    )
    legible(root)


def test_a_size_without_interval_is_not_drawn():
    assert size_strip(0.05, None, 0.05) is None
    assert size_strip(None, (0.04, 0.06), 0.05) is None
    narrow = drawn(size_strip(0.05, (0.05, 0.05), 0.05))
    left, _, right, _ = box_of(narrow, of_class(narrow, "interval")[0])
    assert right - left == 2


# ---- the grip from above


def gripped(distance, n=7, height=0.0, touched=None):
    """Capsules of 8 mm radius lying against a convex thing whose surface is so far from (45, 0) mm, by angle."""
    angle = np.linspace(-2.6, 2.6, n)
    middle = np.array([0.045, 0.0])
    out = np.column_stack([np.cos(angle), np.sin(angle)])
    along = np.column_stack([-np.sin(angle), np.cos(angle)])
    centre = middle + (distance(angle) + 0.008)[:, None] * out
    z = np.full((n, 1), height) if np.isscalar(height) else np.asarray(height)[:, None]
    start = np.hstack([centre - 0.004 * along, z])
    end = np.hstack([centre + 0.004 * along, z])
    touched = np.ones(n, bool) if touched is None else touched
    return GripContacts(
        tuple(f"d{k}.distal" for k in range(n)), start, end, np.full(n, 0.008), touched, np.full(n, 0.001)
    )


def metres(root):
    """Return a function from screen points to metres in the palm's frame, by the bar of 20 mm and the palm's plate."""
    left, _, right, _ = box_of(root, of_class(root, "bar")[0])
    scale = (right - left) / 0.02
    _, py0, px1, py1 = box_of(root, of_class(root, "palm")[0])
    # Its front stands 3 mm behind the palm's origin; its middle is the palm's.
    origin = np.array([px1 + 0.003 * scale, (py0 + py1) / 2])
    return (lambda p: (np.asarray(p) - origin) / scale * [1, -1]), scale


@pytest.mark.parametrize("shift", [0.0, 0.06])
def test_a_grip_is_drawn_to_scale(shift):
    contacts = gripped(lambda a: np.full_like(a, 0.03 + shift / 2), touched=np.array([True] * 6 + [False]))
    root = drawn(grip_drawing(contacts, "cylinder"))
    to_metres, scale = metres(root)
    assert said(root) == ["20\u202fmm"]
    px0, py0, px1, py1 = box_of(root, of_class(root, "palm")[0])
    assert px1 - px0 == pytest.approx(0.014 * scale, abs=0.1)
    assert py1 - py0 == pytest.approx(0.084 * scale, abs=0.3)
    parts = of_class(root, "part")
    assert len(parts) == 7
    assert [kind for p in parts for kind in p.get("class").split() if kind != "part"] == ["off"] + ["on"] * 6
    order = [6, 0, 1, 2, 3, 4, 5]
    for k, part in zip(order, parts, strict=True):
        (corners,) = paths_of(part.get("d"))
        a, b, c, d = (to_metres(corners[i]) for i in (0, 1, 2, 3))
        start, end, r = contacts.start_m[k, :2], contacts.end_m[k, :2], contacts.radius_m[k]
        # Sides run along both flanks, and half circles of the part's radius close its ends.
        assert (a + d) / 2 == pytest.approx(start, abs=3e-4)
        assert (b + c) / 2 == pytest.approx(end, abs=3e-4)
        assert np.linalg.norm(a - d) == pytest.approx(2 * r, abs=4e-4)
        assert np.dot(a - d, end - start) == pytest.approx(0, abs=4e-6)
        radii = [float(v) for v in re.findall(r"A([\d.]+) ([\d.]+) 0 0 0", part.get("d"))[0]]
        assert radii == pytest.approx([r * scale] * 2, abs=0.06)
        # An arc drawn the other way would cut into the part.
        assert area_of(corners[:4]) < 0
    fit = fit_section(contacts, "circle")
    (section,) = of_class(root, "section")
    (outline,) = paths_of(section.get("d"))
    points = to_metres(outline)
    assert len(points) == 72
    np.testing.assert_allclose(np.linalg.norm(points - fit.middle_m, axis=1), fit.size_m / 2, atol=3e-4)
    assert np.ptp(np.arctan2(*(points - fit.middle_m).T)) > 6
    legible(root)
    # It is drawn as large as fits, centred.
    boxes = np.array([box_of(root, e) for e in (*parts, section)])
    wide, high = 360, 300
    assert root.get("viewBox") == f"0 0 {wide} {high}"
    assert root.get("aria-label") == "The grip from above: 6 of 7 parts touch"
    low, top = np.minimum(boxes[:, :2].min(axis=0), box_of(root, of_class(root, "palm")[0])[:2])
    assert min(low, top) > 14 - 1


def test_a_grip_always_shows_the_palm_and_the_room_of_open_fingers():
    ends = np.array([[0.01, 0.0, 0.0], [0.02, 0.0, 0.0]])
    root = drawn(grip_drawing(GripContacts(("a",), ends[:1], ends[1:], np.array([0.005]), np.array([False])), "cone"))
    to_metres, _ = metres(root)
    left, bottom = to_metres([14, 286])
    right, top = to_metres([346, 14])
    assert left <= -0.03 + 1e-4
    assert right >= 0.12 - 1e-4
    assert bottom <= -0.075 + 1e-4
    assert top >= 0.075 - 1e-4
    # One pair of sides fits, the other is centred.
    assert (left + right) / 2 == pytest.approx(0.045, abs=1e-3)
    assert (bottom + top) / 2 == pytest.approx(0.0, abs=1e-3)
    assert min((right - left) - 0.15, (top - bottom) - 0.15) == pytest.approx(0, abs=1e-3)


def test_what_reaches_far_is_drawn_whole():
    for far in ([0.25, 0.0], [0.02, 0.2], [0.02, -0.2], [-0.1, 0.0]):
        start = np.array([[*far, 0.0], [0.02, 0.01, 0.0]])
        contacts = GripContacts(("a", "b"), start, start + 0.001, np.full(2, 0.008), np.array([True, False]))
        root = drawn(grip_drawing(contacts, "cone"))
        legible(root)
        to_metres, _ = metres(root)
        (corners,) = paths_of(of_class(root, "on")[0].get("d")) or [None]
        assert to_metres(corners[:4]).mean(axis=0) == pytest.approx(start[0, :2] + 0.0005, abs=5e-4)


@pytest.mark.parametrize(
    ("name", "n_corners"), [("square-pillar", 4), ("box", 4), ("hexagonal-prism", 6), ("triangular-prism", 3)]
)
def test_a_section_with_corners_is_drawn_as_it_was_fitted(name, n_corners):
    contacts = gripped(lambda a: 0.025 + 0.006 * np.cos(2 * a + 0.4), 9)
    root = drawn(grip_drawing(contacts, name))
    to_metres, _ = metres(root)
    fit = fit_section(contacts, SECTION_OF[name][0])
    (section,) = of_class(root, "section")
    points = to_metres(paths_of(section.get("d"))[0])
    assert len(points) == n_corners
    assert points.mean(axis=0) == pytest.approx(fit.middle_m, abs=5e-4)
    from varishold.perceive import GRIP_SECTIONS

    corners = GRIP_SECTIONS[fit.section].corners
    turn = complex(math.cos(fit.turn_rad), math.sin(fit.turn_rad))
    expected = (corners[:, 0] + 1j * corners[:, 1]) * turn * fit.size_m + complex(*fit.middle_m)
    np.testing.assert_allclose(points[:, 0] + 1j * points[:, 1], expected, atol=3e-4)


def test_what_grows_with_height_is_drawn_at_both_ends_of_what_touches():
    heights = np.array([-0.02, 0.02, -0.02, 0.02, -0.02, 0.02, -0.02, 0.02, 0.0])
    angle = np.linspace(-2.6, 2.6, 9)
    contacts = gripped(lambda a: 0.03 - 0.4 * heights, 9, heights)
    fit = fit_section(contacts, "circle", grows=True)
    assert fit.growth == pytest.approx(-0.8, abs=0.1)
    root = drawn(grip_drawing(contacts, "cone"))
    to_metres, _ = metres(root)
    sections = of_class(root, "section")
    assert ["else" in s.get("class").split() for s in sections] == [False, True, True]
    breadths = [np.ptp(to_metres(paths_of(s.get("d"))[0])[:, 0]) for s in sections]
    expected = [fit.size_m, fit.size_m - 0.02 * fit.growth, fit.size_m + 0.02 * fit.growth]
    assert breadths == pytest.approx(expected, abs=4e-4)
    # A cylinder is not drawn at several heights, nor what hardly grows.
    assert len(of_class(drawn(grip_drawing(contacts, "cylinder")), "section")) == 1
    straight = gripped(lambda a: np.full_like(a, 0.03), 9, heights)
    assert len(of_class(drawn(grip_drawing(straight, "cone")), "section")) == 1
    assert len(angle) == 9


def test_lower_parts_are_drawn_first_and_what_touches_on_top():
    heights = np.array([0.03, 0.01, 0.02, 0.0, 0.015])
    touched = np.array([False, True, True, False, True])
    contacts = gripped(lambda a: np.full_like(a, 0.03), 5, heights, touched)
    root = drawn(grip_drawing(contacts, "cylinder"))
    to_metres, _ = metres(root)
    middles = (contacts.start_m[:, :2] + contacts.end_m[:, :2]) / 2
    painted = [
        int(np.argmin(np.linalg.norm(middles - to_metres(paths_of(p.get("d"))[0][:4]).mean(axis=0), axis=1)))
        for p in of_class(root, "part")
    ]
    assert painted == [3, 0, 1, 4, 2]


def test_parts_that_meet_another_digit_are_told_from_those_on_the_object():
    contacts = gripped(lambda a: np.full_like(a, 0.03), 7)
    meeting = replace_start(contacts)
    root = drawn(grip_drawing(meeting, "cylinder"))
    kinds = sorted(kind for p in of_class(root, "part") for kind in p.get("class").split() if kind != "part")
    assert kinds == ["on"] * 5 + ["other"] * 2


def replace_start(contacts):
    """Lay the second part upon the first."""
    start, end = contacts.start_m.copy(), contacts.end_m.copy()
    start[1], end[1] = start[0] + [0.001, 0, 0], end[0] + [0.001, 0, 0]
    return GripContacts(contacts.parts, start, end, contacts.radius_m, contacts.touched, contacts.half_height_m)


def test_a_part_as_long_as_nothing_is_a_disc():
    point = np.array([[0.05, 0.02, 0.0]])
    root = drawn(grip_drawing(GripContacts(("a",), point, point, np.array([0.009]), np.array([True])), "cone"))
    (disc,) = of_class(root, "part")
    to_metres, scale = metres(root)
    assert disc.tag == "circle"
    assert to_metres([float(disc.get("cx")), float(disc.get("cy"))]) == pytest.approx([0.05, 0.02], abs=3e-4)
    assert float(disc.get("r")) == pytest.approx(0.009 * scale, abs=0.06)


# ---- the pads


def a_surface(name="curved", share=0.7, radius=0.02):
    p = [share if surface == name else (1 - share) / 3 for surface in SURFACES]
    bounds = None if radius is None else (radius / 2, radius * 2)
    return PadSurface(
        np.log(p) + 3, (10.0, 0.0), (1.0, 1.0), radius, bounds, np.zeros(3), (0.0, 0.0), 1.0, 0.5, (False,) * 4, ()
    )


def a_hand(pressed):
    design = HandDesign()
    frames, pitch = {}, {}
    rng = np.random.default_rng(3)
    for k, part in enumerate((*design.parts, *(() if "palm" in design.parts else ("palm",)))):
        shape = (20, 20) if part == "palm" else (7, 14 - k % 3)
        pitch[part] = 0.004 if part == "palm" else 0.002
        frames[part] = rng.uniform(1, 900, shape) if part in pressed else np.zeros(shape)
    return design, PadFrames(frames, pitch, dict.fromkeys(frames, 1.0))


def pads_of(drawing):
    return [drawn(svg) for svg in re.findall(r"<svg .*?</svg>", str(drawing), re.S)]


def test_pads_stand_side_by_side_in_their_true_sizes():
    pressed = ("index.distal", "thumb.distal", "palm")
    design, pads = a_hand(pressed)
    layout = LAYOUTS[HandSetting().layout.name]
    surfaces = {part: a_surface() if part in pressed else None for part in pads.frames}
    drawing = pad_hand(pads, surfaces, {"palm": True}, design, layout)
    assert "pressed: " in str(drawing)
    for part in pressed:
        assert f"{part} curved" in str(drawing)
    thumb, palm, fingers = pads_of(drawing)
    expected = [[list(reversed(design.thumb.parts))], [["palm"]], [list(f.parts) for f in design.fingers]]
    per_metre = set()
    for root, rows in zip((thumb, palm, fingers), expected, strict=True):
        _, _, wide, _ = map(float, root.get("viewBox").split())
        assert root.get("style") == f"--w: {wide:.0f}"
        boxes = [box_of(root, each) for each in root if each.tag == "image" or each.get("class") == "idle"]
        assert len(boxes) == sum(map(len, rows))
        it, lowest = iter(boxes), -1.0
        for row in rows:
            right = 0.0
            here = [next(it) for _ in row]
            for part, box in zip(row, here, strict=True):
                shape, pitch = pads.frames[part].shape, pads.pitch_m[part]
                per_metre |= {
                    round((box[2] - box[0]) / (shape[1] * pitch), -2),
                    round((box[3] - box[1]) / (shape[0] * pitch), -2),
                }
                assert box[0] - right == pytest.approx(7, abs=0.11)
                assert box[1] == pytest.approx(here[0][1], abs=0.06)
                right = box[2]
            # Under each row there is room for a bar and two lines of text.
            assert here[0][1] - lowest >= (6.9 if lowest < 0 else 43.9)
            lowest = max(box[3] for box in here)
            assert right <= wide - 6.4
        _, _, _, high = map(float, root.get("viewBox").split())
        assert high - lowest >= 43.4
        inside = [e for e in root.iter() if e.tag in ("image", "rect", "circle", "text")]
        assert all(
            0 <= box_of(root, e)[0] and box_of(root, e)[2] <= wide and box_of(root, e)[3] <= high for e in inside
        )
    assert per_metre == {3600}


def test_a_thumb_is_seen_mirrored_and_height_goes_up():
    pressed = ("index.distal", "thumb.distal")
    design, pads = a_hand(pressed)
    peak = max(frame.max() for frame in pads.frames.values())
    thumb, _, fingers = pads_of(pad_hand(pads, {}, {}, design, LAYOUTS[HandSetting().layout.name]))
    for root, part, mirrored in ((thumb, "thumb.distal", True), (fingers, "index.distal", False)):
        (image,) = root.iter("image")
        pixels = picture_of(image)
        seen = pads.frames[part][::-1, ::-1] if mirrored else pads.frames[part][::-1]
        places = (seen / peak) ** 0.7
        assert np.abs(pixels[..., :3].astype(int) - shade(np.round(places * 95) / 95)).max() <= 1
        assert not list(root.iter("text"))


@pytest.mark.parametrize("name", SURFACES)
def test_under_a_pad_stands_how_likely_each_surface_is(name):
    frame = np.ones((7, 14))
    surface = a_surface(name, 0.64, 0.0234)
    root = drawn(tip_pad(frame, 0.002, surface))
    left, top, right, bottom = box_of(root, next(root.iter("image")))
    bars = [each for each in root.iter("rect") if each.get("fill")]
    assert [bar.get("fill") for bar in bars] == [SURFACE_COLOURS[s] for s in SURFACES]
    shares = [(box_of(root, bar)[2] - box_of(root, bar)[0]) / (right - left) for bar in bars]
    assert shares == pytest.approx([0.64 if s == name else 0.12 for s in SURFACES], abs=0.002)
    edges = [box_of(root, bar)[0] for bar in bars]
    assert edges == pytest.approx(left + (right - left) * np.cumsum([0, *shares[:3]]), abs=0.06)
    assert all(bottom < box_of(root, bar)[1] < bottom + 8 for bar in bars)
    words = said(root)
    assert words[0] == f"{name} 64\u202f%"
    assert next(root.iter("text")).get("style") == f"fill:{SURFACE_COLOURS[name]}"
    assert words[1:] == (["r 23\u202fmm"] if name == "curved" else [])
    assert root.get("aria-label") == f"The pad of the fingertip: {name}"
    # As large as fits, centred.
    assert (left + right) / 2 == pytest.approx(180, abs=0.11)
    assert right - left == pytest.approx(300, abs=0.2) or bottom - top == pytest.approx(196, abs=0.2)
    assert (right - left) / (bottom - top) == pytest.approx(2, rel=0.01)
    legible(root)
    rim = box_of(root, of_class(root, "rim")[0])
    assert rim == pytest.approx((left, top, right, bottom))
    tall = drawn(tip_pad(np.ones((14, 7)), 0.002, surface))
    left, top, right, bottom = box_of(tall, next(tall.iter("image")))
    assert bottom - top == pytest.approx(196, abs=0.2)
    assert (top + bottom + 44) / 2 == pytest.approx(150, abs=0.2)
    legible(tall)


def test_a_tip_that_felt_nothing_says_so():
    root = drawn(tip_pad(np.zeros((7, 14)), 0.002, None))
    assert root.get("aria-label") == "The pad of the fingertip: nothing"
    assert len(of_class(root, "idle")) == 1
    assert not list(root.iter("image"))
    weak = drawn(tip_pad(1e-3 * np.arange(98.0).reshape(7, 14), 0.002, None))
    assert picture_of(next(weak.iter("image")))[0, -1, :3].tolist() == shade(1.0).tolist()
    flat = a_surface("curved", 0.9, None)
    assert said(drawn(tip_pad(np.ones((7, 14)), 0.002, flat))) == ["curved 90\u202f%"]


def test_switches_stand_at_their_places_and_tell_their_state():
    design, pads = a_hand(("palm",))
    layout = LAYOUTS[HandSetting().layout.name]
    closed = {name: k % 3 == 0 for k, name in enumerate(layout.names)}
    thumb, palm, fingers = pads_of(pad_hand(pads, {}, closed, design, layout))
    told = {}
    for root in (thumb, palm, fingers):
        for circle in of_class(root, "switch"):
            name, state = re.fullmatch(r"switch (.*): (closed|open)", circle.find("title").text).groups()
            told[name] = (root, circle, state)
    assert set(told) == set(layout.names)
    for name, (_, circle, state) in told.items():
        assert state == ("closed" if closed[name] else "open")
        assert ("on" in circle.get("class").split()) == closed[name]
    left, top, right, bottom = box_of(palm, next(palm.iter("image")))
    for switch in layout.switches:
        root, circle, _ = told[switch.name]
        at = np.array([float(circle.get("cx")), float(circle.get("cy"))])
        if switch.part == "palm":
            # Seen from inside: the palm's y to the right, z up, 3600 units to a metre.
            assert at == pytest.approx(
                [(left + right) / 2 + 3600 * switch.y_m, (top + bottom) / 2 - 3600 * switch.z_m], abs=0.11
            )
        else:
            pads_here = [box_of(root, each) for each in root if each.tag == "image" or each.get("class") == "idle"]
            parts = (
                list(reversed(design.thumb.parts)) if root is thumb else [p for f in design.fingers for p in f.parts]
            )
            box = pads_here[parts.index(switch.part)]
            assert at == pytest.approx([box[2] - 8, box[1] + 8], abs=0.11)
    nothing = pad_hand(a_hand(())[1], {}, {}, design, layout)
    assert "pressed: none" in str(nothing)
    assert "<image" not in str(nothing)


# ---- words


def an_exploration(
    name="cone",
    n=2,
    object_="cone",
    verdict="sure",
    *,
    size=0.061,
    p=0.93,
    drops=0,
    then=None,
    known=("cone", "l-block"),
    p_value=0.3,
):
    probability = {known[0]: p, known[1]: 1 - p}
    felt = Felt(TOUCHES["fingertip-middle"], SimpleNamespace(sensed=None, pads=None), None)
    updates = [
        BeliefUpdate("grasp", probability, size, (0.058, 0.064), p_value, verdict, "it is enough", ("cone fits",))
        for _ in range(n)
    ]
    touches = tuple(
        MadeTouch(felt, {}, None, update, None, then if k == n - 1 else ("regrasp-lower", 0.2))
        for k, update in enumerate(updates)
    )
    perception = Perception(object_, p, size, (0.058, 0.064), {}, tuple(updates), ())
    return Exploration(name, 0.06, 5, touches, drops, perception)


def test_an_answer_is_told_in_a_sentence():
    plain = lambda told: told.replace("\u202f", " ")  # noqa: E731
    assert plain(answer_in_words(an_exploration())) == (
        "After 2 touches: a cone, 61 mm (58 to 64), with a probability of 93 %."
    )
    assert plain(answer_in_words(an_exploration(n=1))).startswith("After 1 touch: a cone")
    assert plain(answer_in_words(an_exploration(p=0.9999))).endswith("with a probability of more than 99.9 %.")
    known = an_exploration(p=0.97)
    left = replace(known, perception=replace(known.perception, probability=0.88))
    assert plain(answer_in_words(left)).endswith("with a probability of 88 % (97 % were it one of those it knows).")
    unsure = answer_in_words(an_exploration(verdict="go on"))
    assert plain(unsure) == (
        "After 2 touches: most likely a cone, 61 mm (58 to 64), with a probability of 93 %; it stopped without being "
        "sure. No other touch was left."
    )
    for drops, times in ((1, "once"), (2, "twice"), (3, "3 times")):
        lost = answer_in_words(an_exploration(verdict="go on", drops=drops, then=("grasp", 0.1)))
        assert lost.endswith(f"The hand lost the object {times} and gave up.")
    doubt = answer_in_words(an_exploration("torus", object_=NONE_OF_THESE, p_value=0.0002))
    assert "but only less than 0.1 % of touches" in plain(doubt)
    none = answer_in_words(an_exploration("torus", object_=NONE_OF_THESE))
    assert plain(none) == (
        "After 2 touches: none of the 2 objects it knows. The nearest would be a cone, but only 30 % of touches of one "
        "are as odd."
    )


def test_an_answer_is_right_where_it_is_the_truth():
    assert was_right(an_exploration()) is True
    assert was_right(an_exploration("l-block")) is False
    assert was_right(an_exploration("torus")) is False
    assert was_right(an_exploration("torus", object_=NONE_OF_THESE)) is True
    assert was_right(an_exploration(object_=NONE_OF_THESE)) is False
    assert truth_in_words(an_exploration()) == "Right: it is a cone of 60 mm; the size is 1.7 % off."
    assert truth_in_words(an_exploration("l-block")) == "Wrong: it is an L-block of 60 mm."
    assert truth_in_words(an_exploration(size=None)) == "Right: it is a cone of 60 mm."
    assert truth_in_words(replace(an_exploration(size=None), size_m=0.0699863)) == "Right: it is a cone of 70 mm."
    assert truth_in_words(replace(an_exploration(size=None), size_m=0.0625)) == "Right: it is a cone of 62.5 mm."
    assert truth_in_words(an_exploration("torus", object_=NONE_OF_THESE, size=None)) == (
        "Right: it is a torus of 60 mm, which the library does not know."
    )


@pytest.mark.parametrize(
    ("text", "written"),
    [
        (lambda: size_in_words(None, (0.1, 0.2)), "size unknown"),
        (lambda: size_in_words(0.07, None), "70 mm"),
        (lambda: size_in_words(0.07, (0.0684, 0.0731), digits=1), "70.0 mm (68.4 to 73.1)"),
        (lambda: information(math.log(2)), "0.69 nats (1.00 bits)"),
        (lambda: information(-0.5), "−0.50 nats (−0.72 bits)"),
        (lambda: with_article("box"), "a box"),
        (lambda: with_article("octagon"), "an octagon"),
        (lambda: in_words("lump-3"), "lump (number 3)"),
        (lambda: in_words("assembly-12"), "assembly (number 12)"),
        (
            lambda: spoken("cone-frustum is not cone; regrasp-lower", ["cone", "cone-frustum"]),
            "cone frustum is not cone; regrasp lower",
        ),
    ],
)
def test_how_it_is_said(text, written):
    assert text() == written


def test_it_is_said_whether_it_goes_on():
    go, stop = an_exploration(verdict="go on", then=("grasp", 0.1)), an_exploration()
    assert verdict_in_words(go.touches[-1]) == "goes on"
    assert verdict_in_words(an_exploration(verdict="go on").touches[-1]) == "would go on, but no touch is left"
    assert verdict_in_words(stop.touches[-1]) == "stops"


def page_of(sequence, **named):
    page = render_perceive_report(sequence, **named)
    facts = dict(re.findall(r"<dt>([^<]*)</dt><dd>([^<]*)</dd>", page[: page.index("</header>")]))
    notes = re.findall(
        r"<li>([^<]*)</li>", page[: page.index('<article class="card touch"')] if "<article" in page else page
    )
    return page, facts, [note for note in notes if note]


def test_the_head_of_a_page_tells_the_answer_and_the_truth():
    page, facts, notes = page_of(an_exploration(), error=0.01)
    assert re.search(r"<h1>(.*)</h1>", page)[1] == "A cone of 61\u202fmm"
    assert facts == {"object": "cone, 60\u202fmm", "seed": "5", "touches": "2", "accepted error": "1\u202f%"}
    assert '<p class="truth right">Right' in page
    assert notes == ["none"] or not any("Pictures" in note or "After a miss" in note for note in notes)
    page, facts, notes = page_of(an_exploration("l-block", drops=1))
    assert '<p class="truth wrong">Wrong' in page
    assert facts["missed or dropped"] == "1 time"
    assert any(note.startswith("After a miss or a fall") for note in notes)
    _, facts, _ = page_of(an_exploration(drops=3))
    assert facts["missed or dropped"] == "3 times"
    assert "accepted error" not in facts
    page, _, _ = page_of(an_exploration("torus", object_=NONE_OF_THESE))
    assert "<h1>None of the objects it knows</h1>" in page
    page, _, _ = page_of(an_exploration(size=None))
    assert "<h1>A cone</h1>" in page
    page, _, notes = page_of(Exploration("cone", 0.06, 5, (), 2, None))
    assert "<h1>Nothing was gripped</h1>" in page
    assert '<p class="truth open">It was' in page
    assert not any(note.startswith("After a miss") for note in notes)


def test_a_card_of_a_touch_tells_what_was_believed():
    sequence = an_exploration(then=None)
    chosen = replace(sequence.touches[1], chosen_for=0.25)
    page, _, _ = page_of(replace(sequence, touches=(sequence.touches[0], chosen)))
    cards = page.split('<article class="card touch"')[1:]
    assert [re.match(r' id="(t\d)"', card)[1] for card in cards] == ["t1", "t2"]
    first, second = (dict(re.findall(r"<dt>([^<]*)</dt><dd>([^<]*)</dd>", card)) for card in cards)
    assert first["size"] == "61 mm (58 to 64)"
    assert first["just as odd"] == "30\u202f% of touches of a cone"
    entropy = -(0.93 * math.log(0.93) + 0.07 * math.log(0.07))
    assert first["entropy of the name"] == information(entropy)
    assert "chosen for" not in first
    assert second["chosen for"] == information(0.25)
    assert re.search(r'<h2 id="t1-name">(.*)</h2>', cards[0])[1].startswith("1 · ")
    assert '<p class="sure">cone 93\u202f%</p>' in cards[0]
    shares = re.findall(
        r'class="what">([^<]*)</span><span class="bar" style="--p: ([\d.]+)"></span><span class="p">([^<]*)<', cards[0]
    )
    assert shares == [("cone", "0.9300", "93\u202f%"), ("L-block", "0.0700", "7\u202f%")]
    assert f"<p>regrasp lower: expected to tell {information(0.2)} about the name</p>" in cards[0]
    assert "Next touch" not in cards[1]
    assert "brightest" not in cards[0]
    certain = an_exploration(p=1.0)
    assert information(0.0) in page_of(certain)[0]


def test_the_pad_of_a_fingertip_stands_on_its_card_with_its_peak():
    sequence = an_exploration(n=1)
    _, pads = a_hand(("middle.distal",))
    tip = HandSetting().design.tip
    step = SimpleNamespace(sensed=None, pads=PadFrames({tip: pads.frames[tip] + 1500.0}, {tip: 0.002}, {tip: 1.0}))
    touch = replace(
        sequence.touches[0], felt=Felt(TOUCHES["fingertip-middle"], step, 0.01), surfaces={tip: a_surface("edge")}
    )
    page, _, _ = page_of(replace(sequence, touches=(touch,)))
    peak = (pads.frames[tip] + 1500.0).max()
    assert f"brightest {peak / 1e3:.3g}\u202fkPa".replace(".00", "") in page
    assert "The pad of the fingertip: edge" in page
    assert 'class="screen grip"' not in page


# ---- maps and the response of a calibrated sensor


@given(st.integers(1, 30), st.integers(1, 30), st.floats(-5, 5), st.floats(0.1, 10))
@settings(max_examples=20)
def test_a_map_fills_its_screen_from_low_dark_to_high_light(rows, cols, low, span):
    values = np.linspace(low, low + span, rows * cols).reshape(rows, cols)
    values[0, 0] = np.nan
    root = drawn(taxel_map(values, low, low + span, label="a & b"))
    (image,) = root.iter("image")
    pixels = picture_of(image)
    assert pixels[0, 0, 3] == 0
    places = np.round(np.clip((values.ravel()[1:] - low) / span, 0, 1) * 95) / 95
    far = np.abs(pixels.reshape(-1, 4)[1:, :3].astype(int) - shade(places))
    assert far.max(initial=0) <= 6
    left, top, right, bottom = box_of(root, image)
    assert (right - left) / (bottom - top) == pytest.approx(cols / rows, rel=0.01)
    assert max((right - left) / 332, (bottom - top) / 272) == pytest.approx(1, abs=0.01)
    assert root.get("aria-label") == "a & b"
    assert (left + right, top + bottom) == pytest.approx((360, 300), abs=0.5)


def test_a_map_of_one_value_is_drawn_all_the_same():
    root = drawn(taxel_map(np.ones((2, 2)), 1.0, 1.0, label="even"))
    assert (picture_of(next(root.iter("image")))[..., 3] == 255).all()


def curve_of(stress, reading):
    return Curve(np.asarray(stress, float), np.asarray(reading, float))


@pytest.mark.parametrize("kind", [None, "power"])
@pytest.mark.parametrize(("saturation", "most"), [(None, 1.0), (0.6, 1.0), (None, 1.5)])
def test_a_response_goes_through_its_axes(kind, saturation, most):
    response = Sensor().response if kind is None else Power(0.5)
    curve = curve_of([0.1, 0.5, most], [0.2, 0.55, 0.9])
    root = drawn(response_plot(response, curve, 0.0, saturation))
    ticks = [
        (float("".join(t.itertext())), float(t.get("y")) - 3.5)
        for t in root.iter("text")
        if t.get("text-anchor") == "end"
    ]
    assert [value for value, _ in ticks] == [0, 0.25, 0.5, 0.75, 1]
    (_, y0), *_, (_, y1) = ticks
    rules = [box_of(root, each) for each in (*of_class(root, "base"), *of_class(root, "rule"))]
    assert sorted(box[1] for box in rules) == pytest.approx(sorted(y for _, y in ticks), abs=0.06)
    assert len(of_class(root, "base")) == 1
    assert box_of(root, of_class(root, "base")[0])[1] == pytest.approx(y0, abs=0.06)
    left, right = rules[0][0], rules[0][2]
    to_axes = lambda p: ((p[:, 0] - left) / (right - left) * most, (y0 - p[:, 1]) / (y0 - y1))  # noqa: E731
    (line,) = paths_of(of_class(root, "curve")[0].get("d"))
    stress, reading = to_axes(line)
    np.testing.assert_allclose(stress, np.linspace(0, most, len(stress)), atol=0.001)
    expected = np.minimum(response.reading(stress), np.inf if saturation is None else saturation)
    np.testing.assert_allclose(reading, expected, atol=0.012)
    assert len(line) >= 100
    dots = np.array([[float(d.get("cx")), float(d.get("cy"))] for d in of_class(root, "dot")])
    np.testing.assert_allclose(
        np.column_stack(to_axes(dots)), np.column_stack([curve.stress, curve.reading]), atol=0.002
    )
    (straight,) = paths_of(of_class(root, "chord")[0].get("d"))
    x, y = to_axes(straight)
    assert x == pytest.approx(y, abs=0.003)
    assert x[0] == pytest.approx(0, abs=1e-3)
    # The straight line ends where the axes end.
    assert straight[1][0] == pytest.approx(right, abs=0.1) or straight[1][1] == pytest.approx(8, abs=0.2)
    legible(root)
    assert "dead band" not in "".join(said(root))
    assert "above a dead band of 2 %" in said(drawn(response_plot(response, curve, 0.02, None)))[-1]


def a_calibration(kind="even", **changes):
    before = np.array([[0.5, 1.5, np.nan], [1.0, 1.0, 2.0]])
    return Calibration(
        kind=kind,
        sensor=Sensor(**changes),
        presses=12,
        findings=(
            Finding("dead_band", 0.03, 0.002, "what is not felt", share=True),
            Finding("exponent", 0.81, 0.01, "how it bends"),
        ),
        unknown=("the cover",),
        notes=("it was warm",),
        before=before,
        after=1 + 0.1 * (before - 1),
        error=np.zeros((2, 3)),
        residual=np.array([[0.02, 0.04, np.nan], [0.0, 0.02, 0.02]]),
        curve=None,
    )


@pytest.mark.parametrize("kind", ["even", "objects", "unlabelled", "scale"])
def test_a_calibration_page_tells_what_was_found_and_shows_it_on_one_scale(kind):
    found = a_calibration(kind)
    page = render_calibration_report(found, title="my mat")
    assert "<h1>my mat</h1>" in page
    facts = dict(re.findall(r"<dt>([^<]*)</dt><dd>([^<]*)</dd>", page))
    assert facts["presses"] == "12"
    assert facts["taxels"] == "unknown"
    assert facts["response"] == found.sensor.response.kind
    rows = [re.findall(r"<td[^>]*>([^<]*)</td>", row) for row in re.findall(r"<tr>(.*?)</tr>", page)[1:]]
    assert rows == [
        ["dead band", "3\u202f%", "0.2\u202f%", "what is not felt"],
        ["exponent", "0.81", "0.01", "how it bends"],
    ]
    assert "Not known: the cover." in page
    assert "It was warm." in page
    before, after, left = (drawn(svg) for svg in re.findall(r'<svg class="screen taxels".*?</svg>', page, re.S))
    values = np.concatenate([m[np.isfinite(m)] for m in (found.before, found.after)])
    low, high = np.quantile(values, (0.01, 0.99))
    for root, shown, ends in (
        (before, found.before, (low, high)),
        (after, found.after, (low, high)),
        (left, found.residual, (0, np.quantile([0, 0.02, 0.02, 0.02, 0.04], 0.99))),
    ):
        pixels = picture_of(next(root.iter("image")))
        known = np.isfinite(shown)
        np.testing.assert_array_equal(pixels[..., 3] > 0, known)
        places = np.round(np.clip((shown[known] - ends[0]) / (ends[1] - ends[0]), 0, 1) * 95) / 95
        assert np.abs(pixels[known][:, :3].astype(int) - shade(places)).max() <= 6
    assert f"from {low:.3g} (dark) to {high:.3g} (light)" in page
    spread = lambda m: percent(float(np.nanstd(m)))  # noqa: E731
    words = re.findall(r"<figcaption><span>(.*?)</span>", page)
    assert words[0].startswith("Before: ")
    assert words[0].endswith(f"Taxels differ by {spread(found.before)}.")
    assert words[1].endswith(f"Taxels differ by {spread(found.after)}.")
    assert "on the mean 2\u202f% of a press" in words[2]
    assert 'id="response"' not in page
    shaped = a_calibration(kind, shape=(2, 3))
    page = render_calibration_report(replace(shaped, curve=curve_of([0.5], [0.5])), title="my mat")
    assert "2 × 3" in page
    assert 'id="response"' in page


def test_a_calibration_of_nothing_says_so():
    nothing = np.full((2, 2), np.nan)
    page = render_calibration_report(
        replace(a_calibration(), before=nothing, after=nothing, residual=nothing), title="t"
    )
    assert page.count("No taxel was pressed enough.") == 2
    assert "from 0 (dark) to 1 (light)" in page
    assert "on the mean 0\u202f% of a press" in page
    even = np.ones((2, 2))
    page = render_calibration_report(replace(a_calibration(), before=even, after=even, residual=0 * even), title="t")
    assert "Taxels differ by 0\u202f%" in page
    assert css(0.0) == "#101122"
