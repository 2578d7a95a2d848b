"""The page of `varishold touch` read back: every mark, number, colour and word against the frame and its answer."""

from __future__ import annotations

import base64
import json
import math
import re
from dataclasses import replace
from itertools import pairwise
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tests.reading_svg import area_of, box_of, drawn, even, legible, of_class, paths_of, picture_of, said, screen_points
from tests.test_report_touch import Page, answers_of, dome, recording_of, ring, surface_of

from varishold.levelset.contact import with_losses
from varishold.report import draw_contact_card, render_touch_report, stack_sections
from varishold.report.axonometry import stacked_slices, view_of
from varishold.report.chord_plot import chord_plot
from varishold.report.colours import shade
from varishold.report.measures import _with_interval, measures
from varishold.report.outline_plot import outline_plot
from varishold.report.picture import png_data_uri
from varishold.report.quantities import angle, area, length, number, percent, prefixed, reading
from varishold.report.screen import fit, scale_bar
from varishold.report.section_stack import MOST_LEVELS
from varishold.report.taxel_image import Marks, taxel_image, thumbnail
from varishold.report.touch_report import MOST_CARDS, MOST_ROWS
from varishold.report.wording import bars, sentence
from varishold.touch import find_contacts

UNITS = {"µm": 1e-6, "mm": 1e-3, "m": 1.0, "mm²": 1e-6, "µm²": 1e-12, "m²": 1.0, "taxels": 1.0, "taxel": 1.0}
UNITS |= {
    "nPa": 1e-9,
    "µPa": 1e-6,
    "mPa": 1e-3,
    "Pa": 1.0,
    "kPa": 1e3,
    "MPa": 1e6,
    "GPa": 1e9,
    "mN": 1e-3,
    "N": 1.0,
    "": 1.0,
}
UNITS |= {"µN": 1e-6, "nN": 1e-9, "kN": 1e3, "nm": 1e-9, "km": 1e3, "MN": 1e6, "GN": 1e9}


def value_of(text):
    """Read a quantity back."""
    number_, _, unit = text.replace("−", "-").replace("\u202f", " ").strip().partition(" ")
    return float(number_) * UNITS[unit.strip()]


def stack_of(frame, levels=9, **options):
    return stack_sections(find_contacts(np.asarray(frame, float), levels, **options)[0])


def lightness(colours):
    """Relative luminance of CSS colours."""
    c = np.array([list(bytes.fromhex(colour[1:])) for colour in colours]) / 255
    return np.where(c <= 0.04045, c / 12.92, ((c + 0.055) / 1.055) ** 2.4) @ [0.2126, 0.7152, 0.0722]


LOP = dome((20, 30), (8.0, 21.0), 6.0)
OBLONG = {"pitch": (0.003, 0.002)}
FRAMES = {
    "dome": LOP,
    "ring": ring((26, 24)),
    "corner": dome((18, 22), (0.0, 21.0), 7.0),
    "tall": dome((40, 9), (25, 4), 7),
}


# ---- what all drawings of a contact share


@pytest.mark.parametrize("frame", FRAMES.values(), ids=FRAMES)
@pytest.mark.parametrize("pitch", [None, 0.002, (0.003, 0.002), (0.001, 0.004)])
def test_a_stack_is_its_contact_in_units_of_the_smaller_spacing(frame, pitch):
    stack = stack_of(frame, pitch=pitch)
    contact, (rows, cols) = stack.contact, np.shape(frame)
    high, wide = (1.0, 1.0) if pitch is None else np.broadcast_to(pitch, 2) / np.min(pitch)
    assert stack.step == pytest.approx((wide, high))
    assert stack.size == pytest.approx((cols * wide, rows * high))
    np.testing.assert_array_equal(stack.values, frame)
    inside = np.zeros((rows, cols), bool)
    inside[contact.window] = contact.mask
    row, col = np.nonzero(inside)
    ends = [max(col.min() - 1, 0), max(row.min() - 1, 0), min(col.max() + 2, cols), min(row.max() + 2, rows)]
    left, top, width, height = stack.window
    assert [left / wide, top / high, (left + width) / wide, (top + height) / high] == pytest.approx(ends)
    np.testing.assert_allclose(stack.threshold, contact.profile.threshold[stack.level])
    np.testing.assert_allclose(stack.height, (stack.threshold - contact.floor) / (contact.peak - contact.floor))
    assert np.all(np.diff(stack.height) < 0)
    assert np.all(np.diff(lightness(stack.colours)) < 0)


def test_the_colour_scale_begins_anew_at_the_contacts_floor():
    stack = stack_of(LOP + 30.0, floor=100.0)
    floor, peak = stack.floor, stack.peak
    at = stack.place(np.array([0.0, floor / 2, floor - 1e-6, floor, (floor + peak) / 2, peak, 2 * peak]))
    assert np.all(np.diff(at)[:-1] > 0)
    assert at[-1] == at[-2] == 1
    assert at[0] > 0
    # There is a step in lightness at the border of the contact, larger than all below it.
    assert at[3] - at[2] > at[2] - at[0]
    assert at[4] - at[3] == pytest.approx(at[5] - at[4])
    assert at[1] - at[0] == pytest.approx(at[2] - at[1], abs=1e-6)
    assert np.isnan(stack.place(np.array([np.nan]))[0])
    assert stack.place(np.array([-50.0]))[0] == at[0]


def test_at_most_so_many_sections_are_drawn_evenly_chosen():
    assert len(stack_of(LOP, 32)) == MOST_LEVELS == 32
    fine = stack_of(LOP, 63)
    assert len(fine) == 32
    assert list(fine.level) == list(range(0, 63, 2))
    assert list(stack_of(LOP, 31).level) == list(range(31))


# ---- pictures of taxels


@pytest.mark.parametrize("frame", FRAMES.values(), ids=FRAMES)
@pytest.mark.parametrize("pitch", [None, (0.003, 0.002)])
def test_every_taxel_is_drawn_in_its_colour_at_its_place(frame, pitch):
    stack = stack_of(frame, pitch=pitch)
    none = np.zeros(np.shape(frame), bool)
    root = drawn(taxel_image(stack, marks=Marks(none, none), unit_m=None, label="a frame"))
    (image,) = root.iter("image")
    pixels = picture_of(image)
    expected = shade(stack.place(stack.values))
    assert pixels.shape[:2] == np.shape(frame)
    assert np.abs(pixels[..., :3].astype(int) - expected).max() <= 6
    assert (pixels[..., 3] == 255).all()
    pad = box_of(root, of_class(root, "pad")[0])
    assert box_of(root, image) == pytest.approx(pad, abs=0.02)
    left, top, right, bottom = pad
    assert (right - left) / (bottom - top) == pytest.approx(stack.size[0] / stack.size[1], rel=0.01)
    scale = (right - left) / stack.size[0]
    (outline,) = of_class(root, "now")
    area_ = sum(area_of(part) for part in screen_points(root, outline)) / scale**2
    assert area_ == pytest.approx(
        stack.contact.profile.area[-1] / np.prod(stack.contact.spacing) * np.prod(stack.step), rel=0.03
    )
    window = np.array(box_of(root, of_class(root, "window")[0])) - [left, top, left, top]
    wl, wt, ww, wh = stack.window
    assert window / scale == pytest.approx([wl, wt, wl + ww, wt + wh], abs=0.05)
    legible(root)
    assert root.get("aria-label") == "a frame"
    assert not of_class(root, "dead") + of_class(root, "full") + of_class(root, "ends")


@pytest.mark.parametrize("pitch", [None, (0.003, 0.002)])
def test_broken_taxels_are_crossed_out_and_saturated_ones_wear_a_caret(pitch):
    stack = stack_of(LOP, pitch=pitch)
    broken, full = np.zeros((2, 20, 30), bool)
    broken[3, 25] = broken[17, 0] = True
    full[8, 20] = full[0, 29] = full[19, 3] = True
    root = drawn(taxel_image(stack, marks=Marks(broken, full), unit_m=None, label="a frame"))
    left, top, right, bottom = box_of(root, of_class(root, "pad")[0])
    taxel = np.array([(right - left) / 30, (bottom - top) / 20])
    for kind, where in (("dead", broken), ("full", full)):
        strokes = screen_points(root, of_class(root, kind)[0])
        places = np.argwhere(where)
        assert len(strokes) == 2 * len(places)
        for (row, col), one, two in zip(places, strokes[::2], strokes[1::2], strict=True):
            ends = (np.concatenate([one, two]) - [left, top]) / taxel - [col, row]
            assert ends.min() > 0.1
            assert ends.max() < 0.9
            # Both are symmetric about the taxel's upright middle, and large enough to be seen.
            assert (ends[:, 0].min() + ends[:, 0].max()) / 2 == pytest.approx(0.5, abs=0.02)
            assert np.ptp(ends[:, 0]) >= 0.45
            a, b, c, d = ends
            if kind == "dead":
                assert (a + b) / 2 == pytest.approx([0.5, 0.5], abs=0.03)
                assert (c + d) / 2 == pytest.approx([0.5, 0.5], abs=0.03)
                assert a[1] < b[1]
                assert c[1] > d[1]
                assert c[0] < d[0]
            else:
                # Two strokes that meet in a point, above both feet.
                assert b == pytest.approx(c, abs=0.03)
                assert b[1] < a[1]
                assert c[1] < d[1]
                assert a[1] == pytest.approx(d[1], abs=0.03)
                assert a[0] < b[0] < d[0]
    legible(root)


@pytest.mark.parametrize("n", [0, 1, 600, 601])
def test_marks_are_told_where_they_are_drawn(n):
    stack = stack_of(dome((30, 30)))
    where = np.zeros(900, bool)
    where[:n] = True
    where = where.reshape(30, 30)
    none = np.zeros((30, 30), bool)
    for kind, words, marks in (
        ("dead", "× broken and filled", Marks(where, none)),
        ("full", "^ saturated", Marks(none, where)),
    ):
        root = drawn(taxel_image(stack, marks=marks, unit_m=None, label="a frame"))
        shown = 1 <= n <= 600
        assert bool(of_class(root, kind)) == shown
        assert marks.legend == (f"; {words}" if shown else "")
    both = Marks(where, where, ("left",)) if n == 1 else Marks(none, none, ("left",))
    assert both.legend.endswith("; orange border: cut there")
    assert both.legend.count(";") == (3 if n == 1 else 1)


@pytest.mark.parametrize("side", ["left", "right", "top", "bottom"])
def test_the_side_that_cuts_a_contact_is_drawn_along_it(side):
    stack = stack_of(LOP, **OBLONG)
    none = np.zeros((20, 30), bool)
    root = drawn(taxel_image(stack, marks=Marks(none, none, (side,)), unit_m=None, label="a frame"))
    (line,) = screen_points(root, of_class(root, "ends")[0])
    pad, window = (
        dict(zip(("left", "top", "right", "bottom"), box_of(root, of_class(root, c)[0]), strict=True))
        for c in ("pad", "window")
    )
    along, across = (1, 0) if side in ("left", "right") else (0, 1)
    assert line[:, across] == pytest.approx([pad[side]] * 2, abs=0.05)
    ends = ("top", "bottom") if along else ("left", "right")
    assert sorted(line[:, along]) == pytest.approx([window[end] for end in ends], abs=0.05)


def test_gaps_of_the_field_stay_empty_in_every_picture():
    field = np.ones((20, 30), bool)
    field[2:5, 4:9] = False
    stack = stack_sections(find_contacts(LOP, 9, field=field)[0])
    none = np.zeros((20, 30), bool)
    (image,) = drawn(taxel_image(stack, marks=Marks(none, none), unit_m=None, label="")).iter("image")
    np.testing.assert_array_equal(picture_of(image)[..., 3] > 0, field)


@pytest.mark.parametrize("frame", FRAMES.values(), ids=FRAMES)
@pytest.mark.parametrize("pitch", [None, (0.003, 0.002)])
def test_outlines_lie_over_the_taxels_of_the_window(frame, pitch):
    stack = stack_of(frame, pitch=pitch)
    root = drawn(outline_plot(stack, unit_m=None, label="outlines"))
    (image,) = root.iter("image")
    assert image.get("class") == "dim"
    left, top, wide, high = stack.window
    rows = slice(round(top / stack.step[1]), round((top + high) / stack.step[1]))
    cols = slice(round(left / stack.step[0]), round((left + wide) / stack.step[0]))
    pixels = picture_of(image)
    assert np.abs(pixels[..., :3].astype(int) - shade(stack.place(stack.values[rows, cols]))).max() <= 6
    x0, y0, x1, y1 = box_of(root, image)
    scale = (x1 - x0) / wide
    assert (y1 - y0) / high == pytest.approx(scale, rel=0.01)
    levels = of_class(root, "level")
    unit = min(stack.contact.spacing)
    for element in levels:
        i = int(element.get("data-i"))
        assert element.get("stroke") == stack.colours[i]
        parts = [(part - [x0, y0]) / scale + [left, top] for part in screen_points(root, element)]
        profile, level = stack.contact.profile, stack.level[i]
        slack = (profile.perimeter[level] / unit + 4) * max(wide, high) / 400
        assert sum(area_of(part) for part in parts) == pytest.approx(profile.area[level] / unit**2, abs=slack)
    legible(root)


@pytest.mark.parametrize("most", [9, 32, 33, 64, 65, 130])
def test_thumbnails_show_the_window_in_at_most_32_taxels(most):
    stack = stack_of(np.pad(np.full((most - 2, 3), 5.0) + np.linspace(0, 1, most - 2)[:, None], 1))
    pixels = picture_of(thumbnail(stack))
    _left, _top, wide, high = stack.window
    assert (wide, high) == (5, most)
    every = math.ceil(most / 32)
    assert pixels.shape[:2] == (math.ceil(most / every), math.ceil(5 / every))
    assert pixels.shape[0] <= 32
    shown = shade(stack.place(stack.values[::every, ::every]))
    assert np.abs(pixels[..., :3].astype(int) - shown).max() <= 24


@given(st.lists(st.one_of(st.floats(-1, 2), st.just(math.nan)), min_size=1, max_size=9), st.integers(2, 255))
@settings(max_examples=30)
def test_a_map_is_drawn_in_the_nearest_colour_of_its_scale(values, colours):
    pixels = picture_of(png_data_uri(np.array([values]), colours))[0]
    for value, pixel in zip(values, pixels, strict=True):
        assert (pixel[3] == 255) == math.isfinite(value)
        if math.isfinite(value):
            step = round(min(max(value, 0), 1) * (colours - 1))
            assert abs(step / (colours - 1) - min(max(value, 0), 1)) <= 0.5001 / (colours - 1)
            assert tuple(pixel[:3]) == tuple(shade(step / (colours - 1)))


@given(*(st.floats(-50, 50) for _ in range(2)), *(st.floats(0.5, 300) for _ in range(2)), st.floats(0, 40))
def test_a_window_is_fitted_into_the_screen_whole_centred_and_as_large_as_may_be(left, top, wide, high, below):
    place = fit((left, top, wide, high), below=below)
    x0, y0 = place.left + place.scale * left, place.top + place.scale * top
    x1, y1 = x0 + place.scale * wide, y0 + place.scale * high
    assert min(x0, y0) >= 10
    assert x1 <= 350
    assert y1 <= 290 - below + 1e-9
    assert x0 - 0 == pytest.approx(360 - x1)
    assert y0 == pytest.approx(300 - below - y1)
    # One pair of sides lies at the padding, which is alike on all sides.
    assert min(x0, y0) < 20
    told = [float(n) for n in re.findall(r"-?[\d.]+(?:e-?\d+)?", place.transform(50))]
    assert told == pytest.approx([place.left, place.top, place.scale / 50], rel=1e-4, abs=0.006)


@given(st.floats(1e-5, 1.0), st.floats(1.0, 300.0), st.booleans())
def test_a_scale_bar_is_as_long_as_it_says(unit_m, size, metres):
    place = fit((0.0, 0.0, size, size), below=20)
    root = drawn(f'<svg viewBox="0 0 360 300">{scale_bar(place, unit_m if metres else None)}</svg>')
    (bar,) = of_class(root, "bar")
    left, top, right, bottom = box_of(root, bar)
    told = value_of(said(root)[0])
    length_ = told / unit_m if metres else told
    assert right - left == pytest.approx(length_ * place.scale, abs=0.06)
    digits = f"{told:.1e}"
    assert digits[0] in "125"
    assert digits[2] == "0"
    # At the lower left, with its number beside it, beneath the picture.
    assert (left, bottom) == (14, 286)
    assert 280 <= top < bottom
    (text,) = root.iter("text")
    assert 3 <= float(text.get("x")) - right <= 12
    assert float(text.get("y")) == bottom


# ---- the stack of slabs


@given(st.floats(-4, 4), st.floats(0.1, 1.4), st.integers(4, 40), st.integers(4, 40))
@settings(max_examples=30)
def test_the_view_is_a_parallel_projection(azimuth, elevation, rows, cols):
    frame = np.zeros((rows, cols))
    frame[1:-1, 1:-1] = 1 + 0.001 * np.arange(cols - 2)
    stack = stack_of(frame, 4)
    view = view_of(stack, azimuth=azimuth, elevation=elevation)
    origin, one = np.array(view.middle), np.ones(1)
    at = lambda x, y, z: view.project(one * (origin[0] + x), one * (origin[1] + y), z)[0]  # noqa: E731
    middle = at(0, 0, 0.5)
    assert middle == pytest.approx([180, 150])
    # The pad's x and y and its height are three directions at right angles, equally long, seen from one side.
    axes = np.column_stack([at(1, 0, 0.5) - middle, at(0, 1, 0.5) - middle, (at(0, 0, 1) - at(0, 0, 0)) / view.top])
    np.testing.assert_allclose(axes @ axes.T, view.scale**2 * np.eye(2), atol=1e-9 * view.scale**2)
    # Height goes up, more so the lower the eye; the pad is seen from above.
    assert axes[:, 2] == pytest.approx([0, -view.scale * math.cos(elevation)])
    assert np.linalg.det(axes[:, :2]) == pytest.approx(view.scale**2 * math.sin(elevation))
    # A turn by the azimuth.
    assert axes[0, :2] == pytest.approx(view.scale * np.array([math.cos(azimuth), -math.sin(azimuth)]))
    assert view.sink(0.3) == pytest.approx((at(0, 0, 0.7) - at(0, 0, 1.0))[1])


@pytest.mark.parametrize(
    "frame", [FRAMES["dome"], FRAMES["tall"], dome((12, 60), (6, 30), 28), np.pad(np.ones((5, 5)), 1)]
)
def test_the_stack_fills_its_screen(frame):
    """From all sides together: turned about, it comes near the border somewhere, and never beyond."""
    stack = stack_of(frame, 4)
    left, top, wide, high = stack.window
    x, y = left + wide * np.array([0, 1, 0, 1]), top + high * np.array([0, 0, 1, 1])
    most = np.zeros(4)
    for azimuth in np.linspace(-math.pi, math.pi, 73):
        view = view_of(stack, azimuth=azimuth)
        at = np.concatenate([view.project(x, y, z) for z in (0.0, 1.0)])
        most = np.maximum(
            most, [180 - at[:, 0].min(), at[:, 0].max() - 180, 150 - at[:, 1].min(), at[:, 1].max() - 150]
        )
    assert most[0] == pytest.approx(most[1], abs=1)
    assert most[2] == pytest.approx(most[3], abs=1)
    assert most[0] <= 175
    assert most[2] <= 141
    assert most[0] >= 172 or most[2] >= 138
    height = view_of(stack).top / math.sqrt(wide * high)
    assert 0.4 < height < 0.9


@pytest.mark.parametrize("frame", FRAMES.values(), ids=FRAMES)
def test_slabs_stand_at_their_heights_with_walls_down_to_the_next(frame):
    stack = stack_of(frame, 6)
    view = view_of(stack)
    root = drawn(stacked_slices(stack, label="stack"))
    groups = [each for each in root.iter("g") if each.get("data-i") is not None]
    heights = [*stack.height.tolist(), 0.0]
    for group in groups:
        i = int(group.get("data-i"))
        rim = group[-1]
        assert rim.get("class") == "rim"
        assert rim.get("fill") == stack.colours[i]
        drawn_parts = screen_points(root, rim)
        expected = [view.project(*p.T, heights[i]) for p in stack.outlines[i]]
        area_ = sum(abs(area_of(part)) for part in drawn_parts)
        assert area_ == pytest.approx(sum(abs(area_of(part)) for part in expected), rel=0.02, abs=2)
        for part, whole in zip(drawn_parts, expected, strict=False):
            assert part.min(axis=0) == pytest.approx(whole.min(axis=0), abs=0.16)
            assert part.max(axis=0) == pytest.approx(whole.max(axis=0), abs=0.16)
        # Walls are a darker tone of the slab's colour.
        shades = lightness([wall.get("fill") for wall in group[:-1]])
        assert np.all(shades < lightness([stack.colours[i]]))
        assert np.all(np.diff(shades) > 0)
        assert all(wall.get("fill") == wall.get("stroke") for wall in group[:-1])
        # What is seen of a wall is as wide as the outline across the screen, and as high as the slab.
        sink = view.sink(heights[i] - heights[i + 1])
        seen = sum(abs(area_of(part)) for wall in group[:-1] for part in screen_points(root, wall))
        across = sum(np.abs(np.diff(np.append(part[:, 0], part[0, 0]))).sum() / 2 for part in expected)
        # To a tenth of a unit at each end of each strip.
        assert seen == pytest.approx(across * sink, rel=0.06, abs=8)


def test_walls_are_seen_where_they_face_the_eye_and_lightest_toward_the_light():
    stack = stack_of(dome((40, 40), (19.5, 19.5), 15.0), 4)
    view = view_of(stack, azimuth=0.0)
    root = drawn(stacked_slices(stack, label="stack"))
    view = view_of(stack)
    group = next(each for each in root.iter("g") if each.get("data-i") == str(len(stack) - 1))
    middle = view.project(np.array([20.0]), np.array([20.0]), float(stack.height[-1]))[0]
    places, shades = [], []
    for wall in group[:-1]:
        for part in screen_points(root, wall):
            upper = part[: len(part) // 2]
            assert np.mean(upper[:, 1]) >= middle[1] - 1, "a wall behind the slab"
            places.append(np.mean(upper[:, 0]) - middle[0])
            shades.append(lightness([wall.get("fill")])[0])
    # The light comes from the left front: walls to the left are lighter than those to the right.
    order = np.argsort(places)
    shades = np.array(shades)[order]
    assert len(set(shades.tolist())) >= 3
    assert shades[0] > shades[-1]
    lightest = np.array(places)[order][np.argmax(shades)]
    assert lightest < 0
    after = shades[np.argmax(shades) :]
    assert np.all(np.diff(after) <= 0)


@pytest.mark.parametrize(
    ("frame", "pitch"),
    [(FRAMES["dome"], None), (FRAMES["tall"], None), (LOP, (0.003, 0.002)), (dome((60, 60), (30, 30), 26), None)],
)
def test_the_ground_is_the_window_with_a_grid_of_taxels_and_an_axis_of_the_threshold(frame, pitch):
    stack = stack_of(frame, 5, pitch=pitch)
    view = view_of(stack)
    root = drawn(stacked_slices(stack, label="what it is"))
    assert root.get("aria-label") == "what it is"
    left, top, wide, high = stack.window
    x, y = left + wide * np.array([0, 1, 1, 0]), top + high * np.array([0, 0, 1, 1])
    corners = view.project(x, y, 0.0)
    (ground,) = screen_points(root, of_class(root, "ground")[0])
    np.testing.assert_allclose(ground[:4], corners, atol=0.1)
    lines = screen_points(root, of_class(root, "grid")[0])
    # Each line joins two opposite sides; together they are all borders of taxels, or every so many of them.
    across = [k * stack.step[0] for k in range(1000) if left - 1e-9 <= k * stack.step[0] <= left + wide + 1e-9]
    down = [k * stack.step[1] for k in range(1000) if top - 1e-9 <= k * stack.step[1] <= top + high + 1e-9]
    every = max(1, round(max(wide / stack.step[0], high / stack.step[1]) / 10))
    expected = [
        view.project(np.array([at, at]), np.array([top, top + high]), 0.0)
        for at in across
        if round(at / stack.step[0]) % every == 0
    ] + [
        view.project(np.array([left, left + wide]), np.array([at, at]), 0.0)
        for at in down
        if round(at / stack.step[1]) % every == 0
    ]
    assert len(lines) == len(expected)
    for line, told in zip(lines, expected, strict=True):
        np.testing.assert_allclose(line, told, atol=0.051)
    (axis,) = screen_points(root, of_class(root, "axis")[0])
    west = corners[np.argmin(corners[:, 0])]
    np.testing.assert_allclose(axis, [west, west - [0, view.sink(1.0)]], atol=0.06)
    low, top_ = [(text, screen_points(root, text)[0][0]) for text in root.iter("text")]
    assert ["".join(text.itertext()) for text, _ in (low, top_)] == ["δ", "θ₁"]
    for (text, at), end in zip((low, top_), axis, strict=True):
        assert text.get("text-anchor") == "end"
        assert 2 < end[0] - at[0] < 12
        assert abs(at[1] - end[1]) < 6


# ---- growth against the chord


def growth_plot(growth, usable=None, heights=None):
    n = len(growth)
    heights = np.linspace(0.95, 0.05, n) if heights is None else np.asarray(heights)
    stack = SimpleNamespace(height=heights, peak=9.0, floor=1.0, colours=tuple(f"#0000{k:02x}" for k in range(n)))
    stack = type("Stack", (SimpleNamespace,), {"__len__": lambda self: n})(**vars(stack))
    usable = np.ones(n, bool) if usable is None else np.asarray(usable)
    return drawn(
        chord_plot(
            stack, np.asarray(growth, float), usable, label="growth & co", tick=number, theta=lambda t: f"{t:g} N"
        )
    )


def ticks_of(root):
    """Return (value, y) of each tick of the upright axis."""
    return [
        (value_of("".join(t.itertext())), float(t.get("y")) - 3.5) for t in root.iter("text") if float(t.get("x")) < 40
    ]


@given(st.floats(1e-3, 1e4), st.integers(2, 12), st.integers(0, 2**31))
@settings(max_examples=40)
def test_points_of_growth_stand_where_their_axes_say(most, n, seed):
    rng = np.random.default_rng(seed)
    growth = most * np.sort(rng.uniform(0.05, 1, n))
    root = growth_plot(growth)
    values, at = np.array(ticks_of(root)).T
    assert values[0] == 0
    np.testing.assert_allclose(np.diff(values), values[1], rtol=0.02)
    assert values[-1] >= growth[-1] * 0.995
    assert values[-2] < growth[-1] * 1.005
    assert 3 <= len(values) - 1 <= 6 or len(values) == 3
    even(at)
    dots = of_class(root, "dot")
    assert [int(d.get("data-i")) for d in dots] == list(range(n))
    y = np.array([float(d.get("cy")) for d in dots])
    x = np.array([float(d.get("cx")) for d in dots])
    read = (at[0] - y) / (at[0] - at[-1]) * values[-1]
    np.testing.assert_allclose(read, growth, atol=0.006 * values[-1])
    # The threshold falls from left, at its top, to right, at the standard plane.
    base = next(each for each in of_class(root, "base") if "v4" in each.get("d"))
    ends = [part[0] for part in screen_points(root, base)]
    np.testing.assert_allclose(x, ends[0][0] + (ends[1][0] - ends[0][0]) * (1 - np.linspace(0.95, 0.05, n)), atol=0.06)
    low, high = (t for t in root.iter("text") if "N" in "".join(t.itertext()))
    assert "".join(low.itertext()) == "θ₁ 9 N"
    assert "".join(high.itertext()) == "δ 1 N"
    assert float(low.get("x")) == ends[0][0]
    assert float(high.get("x")) == ends[1][0]
    (curve,) = paths_of(of_class(root, "curve")[0].get("d"))
    np.testing.assert_allclose(curve, np.column_stack([x, y]), atol=0.06)
    assert [d.get("fill") for d in dots] == [f"#0000{k:02x}" for k in range(n)]
    rules = [box_of(root, each) for each in (*of_class(root, "base"), *of_class(root, "rule")) if "H" in each.get("d")]
    assert sorted(box[1] for box in rules) == pytest.approx(sorted(at), abs=0.06)
    assert {(box[0], box[2]) for box in rules} == {(ends[0][0], ends[1][0])}
    legible(root)
    assert root.get("aria-label") == "growth & co"


def test_the_chord_joins_the_first_and_the_last_usable_section():
    growth = [1.0, 4.0, 6.0, 4.5, 8.0, 9.0]
    usable = [False, True, True, True, True, False]
    root = growth_plot(growth, usable)
    dots = [(float(d.get("cx")), float(d.get("cy"))) for d in of_class(root, "dot")]
    (chord,) = paths_of(of_class(root, "chord")[0].get("d"))
    np.testing.assert_allclose(chord, [dots[1], dots[4]], atol=0.06)
    assert ["small" in d.get("class") for d in of_class(root, "dot")] == [not u for u in usable]
    sizes = [float(d.get("r")) for d in of_class(root, "dot")]
    assert sizes[0] == sizes[5] < sizes[1]
    # Section 2 rises above the chord, section 3 falls below it; each is filled to the chord and no further.
    (x0, y0), (x1, y1) = dots[1], dots[4]
    on = lambda k: y0 + (y1 - y0) * (dots[k][0] - x0) / (x1 - x0)  # noqa: E731
    (bulge,), (defect,) = (paths_of(of_class(root, kind)[0].get("d")) for kind in ("bulge", "defect"))
    np.testing.assert_allclose(bulge[:4], [dots[1], dots[2], (dots[3][0], on(3)), dots[4]], atol=0.11)
    np.testing.assert_allclose(defect[:4], [dots[1], (dots[2][0], on(2)), dots[3], dots[4]], atol=0.11)
    for polygon in (bulge, defect):
        np.testing.assert_allclose(polygon[4:], [dots[4], dots[1]], atol=0.06)


def test_what_follows_the_chord_is_not_hatched_and_one_section_has_no_chord():
    straight = growth_plot([1.0, 2.0, 3.0, 4.0])
    assert not of_class(straight, "defect")
    barely = growth_plot([1.0, 2.0, 2.97, 4.0])
    assert bool(of_class(barely, "defect")) == (0.03 / 4 * 184 > 0.5)
    assert of_class(growth_plot([1.0, 2.0], [True, True]), "chord")
    alone = growth_plot([1.0, 2.0], [False, True])
    assert not of_class(alone, "chord")
    assert of_class(alone, "curve")
    one = growth_plot([3.0])
    assert not of_class(one, "curve")
    assert len(of_class(one, "dot")) == 1
    nothing = growth_plot([0.0, 0.0])
    assert [value for value, _ in ticks_of(nothing)] == [0, 1]
    assert len(ticks_of(growth_plot([]))) >= 2


# ---- numbers in words


@given(st.floats(1e-9, 1e9), st.sampled_from(["N", "Pa"]), st.sampled_from([1, -1]))
def test_a_prefix_keeps_a_number_between_one_and_a_thousand(value, unit, sign):
    text = prefixed(sign * value, unit)
    assert value_of(text) == pytest.approx(sign * value, rel=0.0051)
    digits = abs(float(text.split("\u202f")[0].replace("−", "-")))
    assert 1 <= digits < 1000 or value < 1e-9 * 1.001 or value > 999e9


@given(st.floats(1e-8, 1e3), st.booleans())
def test_lengths_and_areas_are_read_back(value, metres):
    assert value_of(length(value, metres=metres)) == pytest.approx(value, rel=0.0051)
    assert value_of(area(value, metres=metres)) == pytest.approx(value, rel=0.0051)
    if metres and 1e-4 <= value < 0.999:
        assert length(value, metres=True).endswith("\u202fmm")
    if metres and 1e-8 <= value < 0.99e-2:
        assert area(value, metres=True).endswith("\u202fmm²")


@pytest.mark.parametrize(
    ("text", "written"),
    [
        (lambda: number(999999.0), "999999"),
        (lambda: number(1e6), "1.00e+06"),
        (lambda: number(1e-4), "0.0001"),
        (lambda: number(9e-5), "9.00e−05"),
        (lambda: number(9.996), "10"),
        (lambda: number(0.5, 2), "0.5"),
        (lambda: number(1.25, 2), "1.2"),
        (lambda: number(100.0), "100"),
        (lambda: number(float("inf")), "–"),
        (lambda: prefixed(0.0, "N"), "0 N"),
        (lambda: prefixed(float("nan"), "N"), "– N"),
        (lambda: prefixed(5e12, "N"), "5000 GN"),
        (lambda: prefixed(-2500.0, "N"), "−2.5 kN"),
        (lambda: prefixed(2.5e-3, "m²", power=2), "2500 mm²"),
        (lambda: length(9.9e-5, metres=True), "99 µm"),
        (lambda: length(1e-4, metres=True), "0.1 mm"),
        (lambda: length(-0.002, metres=True), "−2 mm"),
        (lambda: length(-1.0, metres=False), "−1 taxel"),
        (lambda: length(0.999, metres=True), "999 mm"),
        (lambda: area(9.9e-9, metres=True), "9900 µm²"),
        (lambda: area(1e-8, metres=True), "0.01 mm²"),
        (lambda: area(9.99e-3, metres=True), "9990 mm²"),
        (lambda: area(0.01, metres=True), "10000 mm²"),
        (lambda: angle(math.pi / 2), "90°"),
        (lambda: angle(0.0), "0°"),
        (lambda: angle(1.0), "57.3°"),
        (lambda: percent(0.0), "0 %"),
        (lambda: percent(1.0), "100 %"),
        (lambda: percent(0.999), "99.9 %"),
        (lambda: percent(0.001), "0.1 %"),
        (lambda: percent(0.12345), "12.3 %"),
        (lambda: percent(0.0009), "< 0.1 %"),
        (lambda: percent(0.9991), "> 99.9 %"),
        (lambda: reading(5.0, ""), "5"),
        (lambda: reading(5.0, "PA"), "5 Pa"),
        (lambda: reading(5.0, "pascals"), "5 Pa"),
        (lambda: reading(0.005, "metre"), "5 mm"),
        (lambda: reading(0.005, "Metres"), "5 mm"),
        (lambda: reading(5.0, "count"), "5 count"),
        (lambda: sentence("a"), "A."),
        (lambda: sentence("b!"), "B!"),
        (lambda: sentence("ÄB."), "ÄB."),
    ],
)
def test_how_a_quantity_is_written(text, written):
    assert text().replace("\u202f", " ") == written


# ---- a contact's card


def an_answer(frame=LOP, key="sphere", share=0.9, **options):
    answer = answers_of(recording_of([frame], **options), key)[0]
    return replace(answer, surface=surface_of(answer.surface.contact, key, share))


def measured(answer):
    rows = measures(answer)
    assert len({name for name, _ in rows}) == len(rows)
    return dict(rows)


@pytest.mark.parametrize("pitch", [None, (0.003, 0.002)])
@pytest.mark.parametrize("key", ["sphere", "ridge", "square-pillar", "plane", "hexagonal-pillar", "cone-frustum"])
def test_what_is_measured_is_told_in_its_unit(pitch, key):
    options = {} if pitch is None else {"pitch_m": pitch}
    answer = an_answer(LOP + dome((20, 30), (8.0, 15.0), 5.0), key, **options)
    told, surface = measured(answer), answer.surface
    x, y = surface.position
    assert value_of(told["position x"]) == pytest.approx(x, rel=0.006, abs=1e-5)
    assert value_of(told["position y"]) == pytest.approx(y, rel=0.006, abs=1e-5)
    first, _, rest = told["area"].partition(" (")
    assert value_of(first) == pytest.approx(surface.area, rel=0.006)
    if pitch:
        assert value_of(rest.rstrip(")")) == pytest.approx(surface.area / 6e-6, rel=0.006)
        assert told["area"].count("mm²") == 1
    else:
        assert rest == ""
    assert ("orientation, x to y" in told) == (surface.orientation is not None)
    if surface.orientation is not None:
        degrees = float(told["orientation, x to y"].rstrip("°").replace("−", "-"))
        assert degrees == pytest.approx(math.degrees(surface.orientation), abs=0.06)
    assert told["form, section"] == f"{surface.form}, {surface.section}"
    contact = surface.contact
    assert value_of(told["highest taxel θ₁"]) == pytest.approx(contact.peak, rel=0.006)
    assert value_of(told["standard plane δ"]) == pytest.approx(contact.floor, rel=0.006)
    sized = [name for name in told if name.startswith(("diameter", "breadth", "long side", "short side"))]
    if surface.form == "plane":
        assert sized == []
        return
    expected = (
        ["diameter"]
        if surface.section == "circle"
        else ["breadth"]
        if surface.section == "square"
        else ["long side", "short side"]
    )
    top = " of the top" if surface.form in ("pillar", "frustum") else ""
    assert sized == [name + top for name in expected]
    assert list(told)[: len(sized)] == sized
    for name, size, (low, high) in zip(sized, surface.size, answer.size_interval, strict=False):
        value, _, bounds = told[name].partition(" (")
        assert value_of(value) == pytest.approx(size, rel=0.006)
        ends = bounds.rstrip(")").split(" to ")
        unit = value.split("\u202f")[1]
        ends = [end if "\u202f" in end else f"{end}\u202f{unit}" for end in ends]
        assert [value_of(end) for end in ends] == pytest.approx([low, high], rel=0.006)


def test_an_interval_without_ends_is_not_told():
    answer = an_answer(LOP)
    for bounds in ((1.0, math.inf), (math.nan, 2.0)):
        assert _with_interval(1.5, bounds, metres=False) == "1.5\u202ftaxels"
    assert _with_interval(1.5, (1.0, 2.0), metres=False) == "1.5\u202ftaxels (1\u202ftaxel to 2\u202ftaxels)"
    assert _with_interval(0.0015, (0.001, 0.002), metres=True) == "1.5\u202fmm (1 to 2)"
    assert _with_interval(0.0015, None, metres=True) == "1.5\u202fmm"
    assert measured(answer)["diameter"].endswith(")")


def test_a_place_near_nothing_is_nothing():
    """A thousandth of a taxel is beyond what any sensor tells."""
    answer = an_answer(dome((21, 21), (10.0, 10.0)), pitch_m=0.002)
    told = measured(answer)
    assert (told["position x"], told["position y"]) == ("0\u202fm", "0\u202fm")


def test_force_depth_and_radius_are_told_where_they_are_known():
    told = measured(an_answer(LOP, unit="Pa", pitch_m=(0.003, 0.002)))
    contact = an_answer(LOP).surface.contact
    assert value_of(told["force"]) == pytest.approx(LOP[contact.window][contact.mask].sum() * 6e-6, rel=0.02)
    assert not {"depth", "radius of curvature", "tilt"} & set(told)
    # A cap of 2 mm on a height map, of a paraboloid 12 mm wide at its foot: half way up the chord holds too.
    height = dome((40, 40), (19.5, 19.5), 12.0, 0.002)
    answer = an_answer(height, unit="m", pitch_m=0.0005)
    told = measured(answer)
    assert "force" not in told
    depth, _, bounds = told["depth"].partition(" (")
    assert value_of(depth) == pytest.approx(answer.depth_m, rel=0.006)
    low, high = bounds.rstrip(")").split(" to ")
    assert float(low) < 1e3 * answer.depth_m < float(high)
    radius, _, bounds = told["radius of curvature"].partition(" (")
    assert value_of(radius) == pytest.approx(answer.radius_m, rel=0.006)
    assert value_of(radius) == pytest.approx(0.006**2 / (2 * 0.002), rel=0.15)
    low, high = bounds.rstrip(")").split(" to ")
    assert float(low) < 1e3 * answer.radius_m < float(high)


def test_a_leaning_face_tells_its_tilt_and_a_ring_its_hole():
    face = np.zeros((24, 24))
    face[5:19, 5:19] = 0.004 + 0.0001 * np.arange(14)
    told = measured(an_answer(face, "square-pillar", unit="m", pitch_m=0.001))
    assert told["tilt"] == angle(math.atan(0.1))
    assert "holes at half height" not in told
    assert measured(an_answer(ring()))["holes at half height"] == "1"


def test_what_the_pad_hides_is_told():
    answer = an_answer(dome((20, 30), (9.0, 0.0), 7.0))
    assert answer.surface.cut == ("left",)
    told = measured(answer)
    assert told["cut by the pad's border"] == "left"
    assert "diameter, completed" in told
    assert value_of(told["diameter, completed"].split(" (")[0]) == pytest.approx(answer.surface.completed[2], rel=0.006)
    assert "cut by the pad's border" not in measured(an_answer(LOP))


def test_a_card_tells_its_answer():
    answer = an_answer(LOP, share=0.62, pitch_m=(0.003, 0.002), unit="Pa")
    card = draw_contact_card(answer, anchor="c7", place="frame 3", done=("zeroed",))
    surface = answer.surface
    assert (card.anchor, card.name, card.place, card.done) == ("c7", "sphere", "frame 3", ("Zeroed.",))
    assert card.probability == percent(surface.probability)
    assert card.outline == f"{surface.outline}, {percent(surface.outline_probability)}"
    assert card.held == surface.answer_set
    assert value_of(card.theta_top) == pytest.approx(surface.contact.peak, rel=0.006)
    assert value_of(card.theta_floor) == pytest.approx(surface.contact.floor, rel=0.006)
    assert card.has_interval
    stack = stack_sections(surface.contact)
    assert card.colours.split(", ") == list(stack.colours)
    profile = surface.contact.profile
    rows = json.loads(card.levels)
    assert card.count == len(rows) == len(stack)
    for row, i, height in zip(rows, stack.level, stack.height, strict=True):
        assert row[0] == pytest.approx(height, abs=6e-5)
        assert value_of(row[1]) == pytest.approx(profile.threshold[i], rel=0.006)
        assert value_of(row[2]) == pytest.approx(profile.area[i], rel=0.006)
        assert value_of(row[3]) == pytest.approx(profile.perimeter[i], rel=0.006)
        assert row[4:] == [profile.parts[i], profile.holes[i]]
    for growth, title, bulge, defect in zip(
        card.growths,
        ("√area, mm", "Perimeter, mm"),
        (surface.inequality.bulge_sqrt_area, surface.inequality.bulge_perimeter),
        (surface.inequality.defect_sqrt_area, surface.inequality.defect_perimeter),
        strict=True,
    ):
        assert growth.title == title
        assert float(growth.bulge) == pytest.approx(bulge, abs=0.0051)
        assert float(growth.defect) == pytest.approx(defect, abs=0.0051)
        root = drawn(growth.plot)
        values, at = np.array(ticks_of(root)).T
        y = np.array([float(d.get("cy")) for d in of_class(root, "dot")])
        j = np.sqrt(profile.area) if "area" in title else profile.perimeter
        read = (at[0] - y) / (at[0] - at[-1]) * values[-1]
        np.testing.assert_allclose(read, 1e3 * j[stack.level], atol=0.01 * values[-1])
        small = ["small" in d.get("class") for d in of_class(root, "dot")]
        assert small == [bool(profile.area[i] < 4 * 6e-6) for i in stack.level]
        assert f"bulge {growth.bulge}, defect {growth.defect}" in root.get("aria-label")
    assert card.growths[0].title.endswith("mm")
    bare = draw_contact_card(an_answer(LOP), anchor="c1", place="")
    assert [growth.title for growth in bare.growths] == ["√area, taxels", "Perimeter, taxels"]


def test_too_few_sections_for_a_chord_are_told():
    tiny = np.zeros((9, 9))
    tiny[4, 4] = 10.0
    card = draw_contact_card(an_answer(tiny), anchor="c1", place="")
    for growth in card.growths:
        assert growth.bulge is None
        assert growth.defect is None
        assert "too few usable sections for a chord" in drawn(growth.plot).get("aria-label")


@given(st.lists(st.floats(0.0001, 1), min_size=2, max_size=14))
@settings(max_examples=40)
def test_bars_hold_all_probability_the_largest_first(weights):
    from varishold.report.wording import likeliest_bars

    p = sorted(np.array(weights) / sum(weights), reverse=True)
    shown = likeliest_bars([(f"name {k}", float(q)) for k, q in enumerate(p)])
    named = [bar for bar in shown if bar.name != "all others"]
    assert [bar.name for bar in named] == [f"name {k}" for k in range(len(named))]
    assert [bar.share for bar in named] == [pytest.approx(q) for q in p[: len(named)]]
    assert [bar.text for bar in named] == [percent(bar.share) for bar in named]
    assert 1 - sum(bar.share for bar in shown) < 0.0005
    # At least three where there are as many, then those of a hundredth and more, up to six.
    expected = min(6, max(3, sum(q >= 0.01 for q in p)), len(p))
    assert len(named) == expected
    assert len(shown) - len(named) <= 1
    assert bars([("a", 0.25)])[0].text == "25\u202f%"


@pytest.mark.parametrize(("rows", "cols", "pitch"), [(20, 30, None), (20, 30, (0.0037, 0.0023)), (120, 30, None)])
def test_the_scene_holds_the_surface_of_the_window(rows, cols, pitch):
    frame = dome((rows, cols), (rows / 2, cols / 2), 0.45 * max(rows, cols))
    answer = an_answer(frame, **({} if pitch is None else {"pitch_m": pitch}))
    stack = stack_sections(answer.surface.contact)
    scene = json.loads(draw_contact_card(answer, anchor="c1", place="").scene)
    left, top, wide, high = stack.window
    assert scene["window"] == pytest.approx([left, top, wide, high], abs=6e-5)
    assert scene["taxel"] == pytest.approx(stack.step, abs=6e-5)
    r = slice(round(top / stack.step[1]), round((top + high) / stack.step[1]))
    c = slice(round(left / stack.step[0]), round((left + wide) / stack.step[0]))
    every = math.ceil(max(r.stop - r.start, c.stop - c.start) / 44)
    shown = stack.values[r, c][::every, ::every]
    assert (scene["rows"], scene["cols"]) == shown.shape
    assert max(shown.shape) <= 44
    assert scene["cell"] == pytest.approx([every * s for s in stack.step], abs=6e-5)
    values = np.frombuffer(base64.b64decode(scene["values"]), np.uint8).reshape(shown.shape)
    contact = answer.surface.contact
    share = np.clip((shown - contact.floor) / (contact.peak - contact.floor), 0, 1)
    assert np.abs(values / 255 - share).max() <= 0.5 / 255 + 1e-9
    view = view_of(stack)
    told = [scene[key] for key in ("azimuth", "elevation", "scale", "top")]
    assert told == pytest.approx([view.azimuth, view.elevation, view.scale, view.top], abs=6e-5)
    # A page of many contacts is short: no more digits than can be seen.
    card = draw_contact_card(answer, anchor="c1", place="")
    numbers = re.findall(r"-?\d+\.(\d+)", json.dumps({**scene, "values": "", "azimuth": 0, "elevation": 0}))
    numbers += re.findall(r"-?\d+\.(\d+)", json.dumps([row[0] for row in json.loads(card.levels)]))
    assert max(map(len, numbers)) <= 4


def test_what_no_taxel_felt_lies_on_the_ground_of_the_scene():
    field = np.ones((20, 30), bool)
    field[6, 25] = False
    recording = recording_of([LOP], field=field)
    scene = json.loads(draw_contact_card(answers_of(recording)[0], anchor="c1", place="").scene)
    stack = stack_sections(answers_of(recording)[0].surface.contact)
    values = np.frombuffer(base64.b64decode(scene["values"]), np.uint8).reshape(scene["rows"], scene["cols"])
    assert values[6 - round(stack.window[1]), 25 - round(stack.window[0])] == 0


def test_every_cause_of_a_broken_taxel_is_crossed_out():
    valid = np.ones((20, 30), bool)
    valid[1, 1] = False
    repaired, saturated = np.zeros((2, 20, 30), bool)
    repaired[2, 2] = True
    saturated[3, 3] = saturated[8, 21] = True
    answer = an_answer(LOP)
    (contact,) = with_losses([answer.surface.contact], saturated=saturated, repaired=repaired)
    answer = replace(answer, surface=surface_of(contact))
    for told, crosses in ((valid, 2), (None, 1)):
        root = drawn(draw_contact_card(answer, anchor="c1", place="", valid=told).frame)
        assert len(screen_points(root, of_class(root, "dead")[0])) == 2 * crosses
        assert len(screen_points(root, of_class(root, "full")[0])) == 2 * 2


# ---- the page


@pytest.fixture(scope="module")
def three():
    """Three frames on two pads, each of one contact, 0.1 s apart."""
    frames = np.array([dome((20, 30), (8.0, 10.0 + 5 * k), 6.0) for k in range(3)])
    recording = recording_of(frames, name="left", pitch_m=(0.003, 0.002), unit="Pa", sensor="a mat")
    pads = {**recording.pads, "right": recording.pads["left"]}
    recording = type(recording)(pads, time_s=recording.time_s, unit="Pa", sensor="a mat")
    answers = answers_of(recording)
    answers = [
        replace(a, surface=surface_of(a.surface.contact, key))
        for a, key in zip(answers, ("sphere", "cone", "sphere", "plane", "ridge", "cone"), strict=True)
    ]
    return recording, answers


def rows_of(text):
    body = text[text.index("<tbody>") : text.index("</tbody>")] if "<tbody>" in text else ""
    return [
        [re.sub(r"<[^>]*>", "", cell).strip() for cell in re.findall(r"<td[^>]*>(.*?)</td>", row)]
        for row in re.findall(r"<tr>(.*?)</tr>", body)
    ]


def test_the_table_has_a_line_a_contact(three):
    recording, answers = three
    text = render_touch_report(answers, recording=recording)
    rows = rows_of(text)
    assert len(rows) == len(answers) == 6
    for row, answer in zip(rows, answers, strict=True):
        _, name, probability, outline, size, frame, time, pad, contact = row
        surface = answer.surface
        assert name == surface.name
        assert probability == percent(surface.probability)
        assert outline == f"{surface.outline}, {percent(surface.outline_probability)}"
        assert (int(frame), pad, int(contact)) == (answer.frame, answer.pad, answer.contact)
        assert time == f"{answer.time_s:.2f}\u202fs"
        long, short = surface.size
        if surface.form == "plane":
            assert size == "–"
        elif surface.section == "circle":
            assert value_of(size) == pytest.approx(long, rel=0.006)
        else:
            one, two = size.split(" × ")
            assert value_of(two) == pytest.approx(short, rel=0.006)
            assert 1e-3 * float(one) == pytest.approx(long, rel=0.006)
    links = re.findall(r'<a href="#(c\d+)">', text)
    assert links == [f"c{k}" for k in range(1, 7)]
    shares = [float(s) for s in re.findall(r'<td><span class="bar" style="--p: ([\d.]+)"', text)]
    assert shares == [pytest.approx(a.surface.probability, abs=1e-4) for a in answers]
    words = Page(text).words
    assert "6 contacts cone 2 sphere 2 plane ridge" in words
    # Frame, time, pad and number stand at each card.
    for k, card in enumerate(text.split('<article class="card"')[1:]):
        answer = answers[k]
        assert (
            f"frame {answer.frame} · {answer.time_s:.2f}\u202fs · pad {answer.pad} · contact {answer.contact}" in card
        )
    for picture, answer in zip(re.findall(r'<img src="([^"]*)"', text), answers, strict=True):
        np.testing.assert_array_equal(
            picture_of(picture), picture_of(thumbnail(stack_sections(answer.surface.contact)))
        )


def facts_of(text):
    return dict(re.findall(r"<dt>([^<]*)</dt><dd>([^<]*)</dd>", text[: text.index("</header>")]))


def test_the_head_of_the_page_tells_the_recording(three):
    recording, answers = three
    text = render_touch_report(answers, recording=recording)
    assert facts_of(text) == {
        "sensor": "a mat",
        "taxels": "20 × 30 at 3 × 2\u202fmm (left), 20 × 30 at 3 × 2\u202fmm (right)",
        "frames": "3",
        "duration": "0.2\u202fs",
        "unit": "Pa",
    }
    known = [replace(answers[0], sensor=None), *(replace(a, sensor="mat.toml") for a in answers[1:])]
    assert facts_of(render_touch_report(known, recording=recording))["undone as"] == "mat.toml"
    plain = recording_of([LOP], time=False, pitch_m=0.002)
    facts = facts_of(render_touch_report(answers_of(plain), recording=plain))
    assert facts == {"taxels": "20 × 30 at 2\u202fmm", "frames": "1", "unit": "raw"}
    bare = recording_of([LOP])
    assert facts_of(render_touch_report([], recording=bare)) == {"taxels": "20 × 30", "frames": "1", "unit": "raw"}
    many = type(recording)({f"p{k}": recording.pads["left"] for k in range(6)})
    assert facts_of(render_touch_report([], recording=many))["taxels"].endswith("(p3), 2 more pads")
    four = type(recording)({f"p{k}": recording.pads["left"] for k in range(4)})
    assert facts_of(render_touch_report([], recording=four))["taxels"].endswith("(p3)")


def test_a_single_contact_needs_no_table(three):
    recording, answers = three
    assert rows_of(render_touch_report(answers[:1], recording=recording)) == []
    assert "1 contact sphere" in Page(render_touch_report(answers[:1], recording=recording)).words
    alone = recording_of([LOP], time=False)
    text = render_touch_report(answers_of(alone) * 2, recording=alone)
    assert [len(row) for row in rows_of(text)] == [7, 7]
    assert "pad pad" not in text
    assert "frame 0 · contact 0" in text


def notes_of(text):
    found = re.search(r'<aside class="notes" [^>]*>(.*?)</aside>', text, re.S)
    return (
        [] if found is None else [re.sub(r"\s+", " ", note) for note in re.findall(r"<li>(.*?)</li>", found[1], re.S)]
    )


def test_a_reader_is_told_what_to_know_before_believing(three):
    recording, answers = three
    (skin,) = notes_of(render_touch_report(answers, recording=recording))
    assert skin.startswith("The skin is not known")
    assert notes_of(render_touch_report(answers, recording=recording, skin="6 mm of foam")) == ["Skin: 6 mm of foam."]
    assert notes_of(render_touch_report([], recording=recording)) == []
    maps = recording_of([0.001 * LOP], unit="M", pitch_m=0.001)
    assert notes_of(render_touch_report(answers_of(maps), recording=maps)) == []
    raw = recording_of([LOP])
    skin, unit, spacing = notes_of(render_touch_report(answers_of(raw), recording=raw))
    assert unit.startswith("The sensor gives no unit")
    assert spacing.startswith("The spacing of the taxels is not known")


@pytest.mark.parametrize("n", [1, 2, 4, 5, 7])
def test_broken_taxels_are_counted_and_the_first_are_placed(n):
    valid = np.ones((20, 30), bool)
    valid[0, :n] = False
    recording = recording_of([LOP], valid=valid, pitch_m=0.001, unit="Pa")
    (note,) = [n for n in notes_of(render_touch_report([], recording=recording)) if "broken" in n]
    places = ", ".join(f"(0, {k})" for k in range(min(n, 4)))
    more = f" and {n - 4} more" if n > 4 else ""
    start = "1 taxel is" if n == 1 else f"{n} taxels are"
    assert note.startswith(f"{start} marked broken ((row, col) = {places}{more}); filled")
    pads = {"a": recording.pads["pad"], "b": recording.pads["pad"]}
    both = type(recording)(pads, unit="Pa")
    told = [n for n in notes_of(render_touch_report([], recording=both)) if "broken" in n]
    assert ["of pad a" in told[0], "of pad b" in told[1]] == [True, True]


def test_remarks_are_told_up_to_a_dozen():
    for count in (12, 13, 20):
        recording = recording_of([LOP], pitch_m=0.001, unit="Pa", notes=tuple(f"remark {k}" for k in range(count)))
        told = notes_of(render_touch_report([], recording=recording))
        n = len(recording.remarks)
        assert n >= count
        assert told[:12] == [sentence(r) for r in recording.remarks[:12]]
        assert told[12:] == ([f"The recording has {n - 12} remark{'s' * (n > 13)} more."] if n > 12 else [])


def test_of_very_many_contacts_an_even_choice_is_shown():
    (answer,) = answers_of(recording_of([dome((9, 9), (4, 4), 3.0)]))
    recording = recording_of([dome((9, 9), (4, 4), 3.0)])
    for n in (MOST_CARDS, MOST_CARDS + 1, MOST_ROWS + 200):
        text = render_touch_report([replace(answer, frame=k) for k in range(n)], recording=recording)
        rows = rows_of(text)
        frames = [int(row[5]) for row in rows]
        cards = [int(k) - 1 for k in re.findall(r'<article class="card" id="c(\d+)"', text)]
        assert len(cards) == MOST_CARDS
        assert (cards[0], cards[-1]) == (0, n - 1)
        assert max(b - a for a, b in pairwise(cards)) - min(b - a for a, b in pairwise(cards)) <= 1
        assert frames == sorted(set(frames))
        assert (frames[0], frames[-1]) == (0, n - 1)
        assert set(cards) <= set(frames)
        linked = [int(k) - 1 for k in re.findall(r'<a href="#c(\d+)">', text)]
        assert linked == cards
        told = [note for note in notes_of(text) if "contacts were found" in note]
        if n == MOST_CARDS:
            assert told == []
        elif n <= MOST_ROWS:
            assert told == [
                f"{n} contacts were found. The table lists all; {MOST_CARDS} have a card below, "
                "evenly spread over the recording."
            ]
            assert frames == list(range(n))
        else:
            assert MOST_ROWS <= len(frames) < n
            assert told[0].startswith(
                f"{n} contacts were found. The table lists {len(frames)} and {MOST_CARDS} have a card below, both"
            )


def test_a_page_is_titled_after_its_file():
    recording = recording_of([LOP], source="/data/one/press.npz")
    assert "<title>press.npz ·" in render_touch_report([], recording=recording)
    assert "<title>mine ·" in render_touch_report([], recording=recording, title="mine")
    assert "<title>Touch ·" in render_touch_report([], recording=recording_of([LOP]))
