"""The drawings of the report: pure functions from a contact's sections to colours, paths and pictures."""

from __future__ import annotations

import base64
import math
import re

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tests.reading_svg import area_of

from varishold.report import stack_sections
from varishold.report.axonometry import stacked_slices, view_of
from varishold.report.chord_plot import chord_plot
from varishold.report.colours import css, darker, palette, shade
from varishold.report.outline_path import path_data, thinned
from varishold.report.outline_plot import outline_plot
from varishold.report.picture import png_data_uri
from varishold.report.quantities import area, length, number, percent, prefixed, reading
from varishold.report.screen import SCREEN_HEIGHT, SCREEN_WIDTH, fit, scale_bar
from varishold.report.section_stack import MOST_LEVELS
from varishold.touch import find_contacts


def annulus(shape=(26, 30), middle=(12.0, 14.0), radius=7.0, width=3.0):
    y, x = np.mgrid[: shape[0], : shape[1]]
    return np.maximum(1 - ((np.hypot(y - middle[0], x - middle[1]) - radius) / width) ** 2, 0.0)


def bump(shape=(26, 30), middle=(12.0, 14.0), radius=8.0):
    y, x = np.mgrid[: shape[0], : shape[1]]
    return np.maximum(1 - np.hypot(y - middle[0], x - middle[1]) / radius, 0.0)


def relative_luminance(colours):
    c = colours / 255.0
    linear = np.where(c <= 0.04045, c / 12.92, ((c + 0.055) / 1.055) ** 2.4)
    return linear @ [0.2126, 0.7152, 0.0722]


def read_path(d, scale):
    """Read what `path_data` writes."""
    polygons = []
    for part in d.split("M")[1:]:
        n = [int(k) for k in re.findall(r"-?\d+", part)]
        polygons.append(np.cumsum(np.array(n).reshape(-1, 2), axis=0) / scale)
    return polygons


def distance_to(points, polygon):
    """Distance of points from a closed outline."""
    start, stop = polygon, np.roll(polygon, -1, axis=0)
    side = stop - start
    off = points[:, None] - start
    along = np.clip((off * side).sum(-1) / np.maximum((side**2).sum(-1), 1e-300), 0, 1)
    return np.linalg.norm(off - along[..., None] * side, axis=-1).min(axis=1)


def test_the_colour_scale_grows_lighter_all_the_way():
    luminance = relative_luminance(shade(np.linspace(0, 1, 200)))
    assert np.all(np.diff(luminance) > 0)
    assert luminance[0] < 0.01
    assert luminance[-1] > 0.8


def test_equal_steps_look_equal():
    """Lightness L* grows by nearly the same amount over every tenth of the scale."""
    y = relative_luminance(shade(np.linspace(0, 1, 11)))
    lightness = 116 * np.cbrt(np.maximum(y, 0.0089)) - 16
    steps = np.diff(lightness[1:])
    assert steps.max() < 1.5 * steps.min()


def test_palettes_are_the_scale():
    assert palette(3) == b"".join(bytes.fromhex(css(t)[1:]) for t in (0, 0.5, 1))
    assert darker(css(1.0), 0.0) == "#000000"


@given(seed=st.integers(0, 1000), rows=st.integers(1, 9), cols=st.integers(1, 9))
@settings(max_examples=20)
def test_pictures_hold_their_colours(seed, rows, cols):
    index = np.random.default_rng(seed).integers(0, 17, (rows, cols))
    colours = np.frombuffer(palette(16), np.uint8).reshape(-1, 3)
    uri = png_data_uri(np.where(index < 16, index / 15, np.nan), 16)
    png = np.frombuffer(base64.b64decode(uri.removeprefix("data:image/png;base64,")), np.uint8)
    drawn = cv2.imdecode(png, cv2.IMREAD_UNCHANGED)
    assert np.array_equal(drawn[..., 3] == 255, index < 16)
    assert np.array_equal(drawn[..., 2::-1][index < 16], colours[index[index < 16]])


@given(seed=st.integers(0, 10_000), n=st.integers(3, 200), roughness=st.floats(0, 0.5), tolerance=st.floats(1e-3, 0.3))
@settings(max_examples=60)
def test_thinning_moves_no_vertex_by_more_than_the_tolerance(seed, n, roughness, tolerance):
    rng = np.random.default_rng(seed)
    angle = np.linspace(0, 2 * math.pi, n, endpoint=False)
    radius = 5 * (1 + roughness * rng.uniform(-1, 1, n))
    polygon = np.stack([radius * np.cos(angle), radius * np.sin(angle)], axis=-1)
    thin = thinned(polygon, tolerance)
    assert len(thin) <= n
    assert distance_to(polygon, thin).max() <= tolerance * (1 + 1e-9)
    assert {tuple(p) for p in thin} <= {tuple(p) for p in polygon}


def test_thinning_leaves_out_what_lies_on_straight_sides():
    side = np.linspace(0, 1, 33)[:-1]
    zero, one = np.zeros(32), np.ones(32)
    square = np.stack(
        [np.concatenate([side, one, 1 - side, zero]), np.concatenate([zero, side, one, 1 - side])], axis=-1
    )
    thin = thinned(square, 1e-6)
    assert len(thin) < 20
    assert area_of(thin) == pytest.approx(1.0)
    # What lies on a straight side exactly goes however little an outline may move.
    assert len(thinned(64 * square, 0.0)) == len(thin)


@given(seed=st.integers(0, 10_000), n=st.integers(3, 40), parts=st.integers(1, 3))
@settings(max_examples=40)
def test_paths_round_but_do_not_drift(seed, n, parts):
    rng = np.random.default_rng(seed)
    polygons = [rng.uniform(-40, 40, (n, 2)) for _ in range(parts)]
    read = read_path(path_data(polygons, scale=50), 50)
    assert len(read) == parts
    for polygon, back in zip(polygons, read, strict=True):
        assert np.abs(back - polygon).max() <= 0.5 / 50 + 1e-9


def test_paths_leave_out_what_has_no_area():
    assert path_data([np.zeros((5, 2)), np.zeros((2, 2))]) == ""


@pytest.mark.parametrize("frame", [bump(), annulus(), bump(middle=(0.0, 29.0))], ids=["bump", "annulus", "corner"])
@pytest.mark.parametrize("pitch", [None, 0.002, (0.003, 0.002)])
def test_outlines_enclose_the_areas_of_the_profile(frame, pitch):
    """The outer outlines less the holes make the area, so that they are turned the right way."""
    contact = find_contacts(frame, 12, pitch=pitch)[0]
    stack = stack_sections(contact)
    unit = min(contact.spacing)
    for i, level in enumerate(stack.level):
        drawn = sum(area_of(polygon) for polygon in stack.outlines[i]) * unit**2
        whole = float(contact.profile.area[level])
        slack = float(contact.profile.perimeter[level] + 4 * unit) * unit * max(stack.window[2:]) / 500
        assert drawn == pytest.approx(whole, abs=slack + 1e-12)


@given(seed=st.integers(0, 100_000), rows=st.integers(2, 12), cols=st.integers(2, 12), smooth=st.booleans())
@settings(max_examples=60)
def test_sections_that_leave_the_field_are_closed_along_its_border(seed, rows, cols, smooth):
    frame = np.random.default_rng(seed).uniform(0.2, 1.0, (rows, cols))
    if smooth:
        frame = cv2.GaussianBlur(frame, (5, 5), 2.0)
    for contact in find_contacts(frame, 6):
        for i in range(6):
            (polygons,) = contact.filled([float(contact.profile.threshold[i])]).by_level()
            enclosed = sum(area_of(polygon) for polygon in polygons)
            assert enclosed == pytest.approx(contact.profile.area[i], abs=1e-6)


def test_outlines_lie_in_the_frame_and_the_window():
    stack = stack_sections(find_contacts(annulus(), pitch=(0.002, 0.003))[0])
    left, top, wide, high = stack.window
    for outlines in stack.outlines:
        for polygon in outlines:
            x, y = polygon.T
            assert left <= x.min() <= x.max() <= left + wide
            assert top <= y.min() <= y.max() <= top + high
    assert left >= 0
    assert left + wide <= stack.size[0]


def test_fine_profiles_are_drawn_at_some_of_their_levels():
    stack = stack_sections(find_contacts(bump(), 200)[0])
    assert len(stack) == MOST_LEVELS
    assert stack.level[0] <= 20
    assert stack.level[-1] == 199
    assert np.all(np.diff(stack.height) < 0)


def test_broken_floors_do_not_break_the_scale():
    contact = find_contacts(bump(), 8, floor=0.0)[0]
    place = stack_sections(contact).place(np.array([-1.0, 0.0, 0.5, 1.0]))
    assert np.all((place >= 0) & (place <= 1))
    assert np.all(np.diff(place) >= 0)


@given(azimuth=st.floats(-10, 10), elevation=st.floats(0.15, 0.62), wide=st.integers(8, 60), high=st.integers(8, 60))
@settings(max_examples=40)
def test_the_stack_stays_on_the_screen_however_it_is_turned(azimuth, elevation, wide, high):
    stack = stack_sections(find_contacts(np.ones((high, wide)) - 0.001 * np.arange(wide), 4)[0])
    view = view_of(stack, azimuth=azimuth, elevation=elevation)
    left, top, width, height = stack.window
    x, y = np.array([0, 1, 0, 1]) * width + left, np.array([0, 0, 1, 1]) * height + top
    for level in (0.0, 1.0):
        at = view.project(x, y, level)
        assert at.min() >= 0
        assert at[:, 0].max() <= SCREEN_WIDTH
        assert at[:, 1].max() <= SCREEN_HEIGHT


def test_every_slice_is_drawn_from_the_lowest_up():
    stack = stack_sections(find_contacts(bump(), 9)[0])
    for drawing in (stacked_slices(stack, label="stack"), outline_plot(stack, unit_m=None, label="outlines")):
        assert re.findall(r'data-i="(\d+)"', drawing) == [str(i) for i in range(len(stack) - 1, -1, -1)]


def growth_of(values):
    stack = stack_sections(find_contacts(bump(), len(values))[0])
    usable = np.ones(len(stack), bool)
    return chord_plot(stack, np.asarray(values, float), usable, label="growth", tick=number, theta=number)


def test_a_defect_is_hatched_and_a_bulge_is_filled():
    depth = np.linspace(0.05, 1, 10)
    assert 'class="defect"' not in growth_of(np.sqrt(depth))
    assert 'class="defect"' in growth_of(depth**2)
    assert 'class="bulge"' in growth_of(np.sqrt(depth))


@pytest.mark.parametrize("most", [1e-6, 0.3, 0.99, 1.0, 7.0, 12.4, 1e5])
def test_axes_have_a_few_round_ticks(most):
    drawing = growth_of(most * np.linspace(0.1, 1, 10))
    assert 3 <= drawing.count('class="rule"') + 1 <= 6


@given(st.floats(1e-5, 1.0), st.floats(1.0, 100.0))
def test_the_scale_bar_fits(unit_m, size):
    place = fit((0.0, 0.0, size, size))
    wide = float(re.search(r"v4h([\d.]+)v-4", scale_bar(place, unit_m))[1])
    assert 0.3 * SCREEN_WIDTH / 2.5 - 1 <= wide <= 0.3 * SCREEN_WIDTH + 1


@given(st.floats(-1e12, 1e12).filter(lambda v: v == 0 or abs(v) > 1e-12))
def test_numbers_keep_three_digits(value):
    read = float(number(value).replace("−", "-"))
    assert read == pytest.approx(value, rel=0.0051)


@given(st.floats(0, 1, exclude_min=True, exclude_max=True))
def test_what_is_not_certain_is_never_called_so(share):
    assert percent(share) not in ("0\u202f%", "100\u202f%")


@pytest.mark.parametrize(
    ("text", "written"),
    [
        (length(0.0, metres=True), "0 m"),
        (length(1.0, metres=False), "1 taxel"),
        (length(3.2e-5, metres=True), "32 µm"),
        (area(2.5e-9, metres=True), "2500 µm²"),
        (area(2.0, metres=True), "2 m²"),
        (prefixed(0.999, "N"), "999 mN"),
        (prefixed(0.9996, "N"), "1 N"),
        (prefixed(1e-15, "N"), "1.00e−06 nN"),
        (reading(0.0012, "m"), "1.2 mm"),
        (reading(3.456, "kPa"), "3.46 kPa"),
        (reading(float("nan"), "raw"), "–"),
    ],
)
def test_quantities(text, written):
    assert text.replace("\u202f", " ") == written
