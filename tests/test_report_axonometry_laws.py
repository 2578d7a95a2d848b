"""The stacked solid by plain projection: walls face the eye and the light, grid and axis stand where they belong."""

from __future__ import annotations

import cmath
import itertools
import math
import re

import numpy as np
import pytest
from tests.reading_svg import box_of, drawn, of_class, paths_of

from varishold.report import SectionStack, stack_sections
from varishold.report.axonometry import AZIMUTH, ELEVATION, View, _ground, _runs, _slab, _tones, stacked_slices, view_of
from varishold.report.screen import SCREEN_HEIGHT, SCREEN_WIDTH
from varishold.touch import find_contacts

VIEWS = [(-0.55, 0.62), (0.3, 0.4), (1.9, 0.62), (-2.7, 0.2), (3.0, 0.9)]


def a_stack(rows: int = 24, cols: int = 30, pitch: tuple[float, float] | None = None, levels: int = 7) -> SectionStack:
    y, x = np.mgrid[:rows, :cols]
    frame = np.maximum(1 - np.hypot((y - rows / 2) / (rows / 3), (x - cols / 2.3) / (cols / 4)), 0.0)
    return stack_sections(find_contacts(frame, levels, pitch=pitch)[0])


def placed(view: View, x: float, y: float, height: float) -> tuple[float, float]:
    """Turn a point about the middle, tip it away from the eye, put it on the screen: one number at a time."""
    turned = complex(x - view.middle[0], y - view.middle[1]) * cmath.exp(1j * view.azimuth)
    up = view.top * (height - 0.5)
    down = turned.imag * math.sin(view.elevation) - up * math.cos(view.elevation)
    return SCREEN_WIDTH / 2 + view.scale * turned.real, SCREEN_HEIGHT / 2 + view.scale * down


@pytest.mark.parametrize(("azimuth", "elevation"), VIEWS)
def test_points_land_where_a_plain_projection_puts_them(azimuth: float, elevation: float) -> None:
    view = View((3.0, -2.0), azimuth, elevation, 7.0, 5.0)
    rng = np.random.default_rng(0)
    x, y = rng.uniform(-9, 9, (2, 20))
    for height in (0.0, 0.3, 1.0):
        wanted = [placed(view, *point, height) for point in zip(x.tolist(), y.tolist(), strict=True)]
        np.testing.assert_allclose(view.project(x, y, height), wanted)
        sunk = view.project(x, y, height - 0.2)[:, 1] - view.project(x, y, height)[:, 1]
        assert sunk == pytest.approx(view.sink(0.2))
        assert view.sink(0.2) > 0


@pytest.mark.parametrize("pitch", [None, (0.003, 0.002)])
@pytest.mark.parametrize(("rows", "cols"), [(24, 30), (12, 60), (50, 14)])
def test_a_stack_is_drawn_as_large_as_it_may_turn_on_the_screen(
    rows: int, cols: int, pitch: tuple[float, float] | None
) -> None:
    stack = a_stack(rows, cols, pitch)
    view = view_of(stack)
    left, top, wide, high = stack.window
    assert view.middle == pytest.approx((left + wide / 2, top + high / 2))
    assert (view.azimuth, view.elevation) == (AZIMUTH, ELEVATION) == (-0.55, 0.62)
    assert view.top == pytest.approx(0.62 * math.sqrt(wide * high))
    # Turned all the way round it touches a side or an end of its room: 6 units free at the sides, 10 above and below.
    reach = []
    for azimuth in np.linspace(0, 2 * math.pi, 721):
        turned = view_of(stack, azimuth=float(azimuth))
        assert (turned.scale, turned.top) == (view.scale, view.top)
        for x in (left, left + wide):
            for y in (top, top + high):
                reach += [placed(turned, x, y, 0.0), placed(turned, x, y, 1.0)]
    x0, y0 = np.min(reach, axis=0)
    assert min(x0 - 6, y0 - 10) == pytest.approx(0, abs=0.05)
    assert np.add(np.min(reach, axis=0), np.max(reach, axis=0)) == pytest.approx((360, 300), abs=0.05)
    assert view_of(stack, elevation=0.3).elevation == 0.3


@pytest.mark.parametrize(("azimuth", "elevation"), VIEWS)
def test_a_wall_is_as_light_as_it_faces_the_light_and_only_seen_from_its_front(
    azimuth: float, elevation: float
) -> None:
    view = View((0.0, 0.0), azimuth, elevation, 3.0, 4.0)
    rng = np.random.default_rng(1)
    angle = np.sort(rng.uniform(0, 2 * math.pi, 60))
    polygon = np.stack([5 * np.cos(angle), 3 * np.sin(angle)], axis=1)
    tones = _tones(polygon, view)
    for k, tone in enumerate(tones.tolist()):
        (x0, y0), (x1, y1) = polygon[k], polygon[(k + 1) % 60]
        # Outer outlines turn from +x toward +y: what lies outside is on the right.
        out = complex(x1 - x0, y1 - y0) * -1j
        out = out / abs(out) * cmath.exp(1j * azimuth)
        light = min(max(-0.8 * out.real + 0.6 * out.imag, 0.0), 1.0)
        if abs(out.imag) > 1e-9 and abs(4 * light % 1 - 0.5) > 1e-9:
            assert tone == (round(4 * light) if out.imag > 0 else -1)
    assert set(tones.tolist()) <= {-1, 0, 1, 2, 3, 4}
    assert len(set(tones.tolist())) >= 4
    runs = _runs(tones)
    told = [(first + i, tones[first]) for first, last in runs for i in range(last - first + 1)]
    assert told == [(k, tone) for k, tone in enumerate(tones.tolist()) if tone >= 0]
    assert all(len(set(tones[first : last + 1].tolist())) == 1 for first, last in runs)
    joined = [b[0] - a[1] == 1 and tones[a[0]] == tones[b[0]] for a, b in itertools.pairwise(runs)]
    assert not any(joined)


def svg_of(inner: str) -> str:
    return f'<svg viewBox="0 0 360 300"><g transform="scale(0.1)">{inner}</g></svg>'


@pytest.mark.parametrize(("azimuth", "elevation"), VIEWS)
@pytest.mark.parametrize("pitch", [None, (0.003, 0.002)])
@pytest.mark.parametrize(("rows", "cols"), [(24, 30), (9, 11), (70, 52)])
def test_the_ground_is_the_window_with_a_line_between_taxels_and_the_axis_at_its_left_corner(
    rows: int, cols: int, pitch: tuple[float, float] | None, azimuth: float, elevation: float
) -> None:
    stack = a_stack(rows, cols, pitch)
    view = view_of(stack, azimuth=azimuth, elevation=elevation)
    root = drawn(svg_of(_ground(stack, view)))
    left, top, wide, high = stack.window
    corners = [(left, top), (left + wide, top), (left + wide, top + high), (left, top + high)]
    (ground,) = paths_of(of_class(root, "ground")[0].get("d"))
    np.testing.assert_allclose(ground / 10, [placed(view, x, y, 0.0) for x, y in corners], atol=0.051)
    # Lines between taxels, every so many that there are about ten at most.
    x_step, y_step = stack.step
    every = max(1, round(max(wide / x_step, high / y_step) / 10))
    lines = []
    for k in range(1000):
        if left - 1e-9 <= k * x_step <= left + wide + 1e-9 and k % every == 0:
            lines.append([(k * x_step, top), (k * x_step, top + high)])
    for k in range(1000):
        if top - 1e-9 <= k * y_step <= top + high + 1e-9 and k % every == 0:
            lines.append([(left, k * y_step), (left + wide, k * y_step)])
    found = np.array(paths_of(of_class(root, "grid")[0].get("d"))) / 10
    np.testing.assert_allclose(found, [[placed(view, x, y, 0.0) for x, y in line] for line in lines], atol=0.051)
    west = min(corners, key=lambda corner: placed(view, *corner, 0.0)[0])
    foot, head = placed(view, *west, 0.0), placed(view, *west, 1.0)
    (axis,) = paths_of(of_class(root, "axis")[0].get("d"))
    np.testing.assert_allclose(axis / 10, [foot, head], atol=0.051)
    floor, peak = root.iter("text")
    assert (floor.text, peak.text) == ("δ", "θ₁")
    for text, (x, y) in ((floor, foot), (peak, (head[0], head[1] + 4))):
        assert float(text.get("x", 0)) == pytest.approx(x - 6, abs=0.051)
        assert float(text.get("y", 0)) == pytest.approx(y, abs=0.051)
        assert text.get("text-anchor") == "end"
    assert 'transform="scale(10)"' in _ground(stack, view)


@pytest.mark.parametrize(("azimuth", "elevation"), VIEWS)
def test_a_slab_is_its_rim_and_below_it_walls_down_to_the_next(azimuth: float, elevation: float) -> None:
    stack = a_stack()
    view = view_of(stack, azimuth=azimuth, elevation=elevation)
    for i in range(len(stack)):
        below = float(stack.height[i + 1]) if i + 1 < len(stack) else 0.0
        root = drawn(svg_of(_slab(stack, view, i, below)))
        *walls, rim = root.iter("path")
        assert rim.get("class") == "rim"
        assert rim.get("fill") == stack.colours[i]
        height = float(stack.height[i])
        box = box_of(root, rim)
        points = np.array([placed(view, *point, height) for polygon in stack.outlines[i] for point in polygon])
        assert box == pytest.approx([*points.min(axis=0), *points.max(axis=0)], abs=0.06)
        down = view.scale * view.top * (height - below) * math.cos(elevation)
        reach = np.array([box_of(root, wall) for wall in walls])
        # Walls go down from the rim's near side, by the height of the slab, from its left to its right end.
        assert reach[:, 3].max() == pytest.approx(box[3] + down, abs=0.11)
        assert reach[:, 0].min() == pytest.approx(box[0], abs=1.0)
        assert reach[:, 2].max() == pytest.approx(box[2], abs=1.0)
        for wall in walls:
            assert wall.get("fill") == wall.get("stroke")
            for strip in paths_of(wall.get("d")):
                upper = strip[: len(strip) // 2] / 10 if len(strip) % 2 == 0 else None
                if upper is not None:
                    lower = strip[len(strip) // 2 :][::-1] / 10
                    assert (lower - upper)[:, 1] == pytest.approx(down, abs=0.11)
        # Each tone is a share of the rim's colour: .38 where no light falls, .78 where all does, evenly between.
        light = [int(stack.colours[i][k : k + 2], 16) for k in (1, 3, 5)]
        shares = []
        for wall in walls:
            dark = [int(wall.get("fill", "")[k : k + 2], 16) for k in (1, 3, 5)]
            shares.append(sum(dark) / sum(light))
        assert shares == sorted(shares)
        assert all(min(abs(share - (0.38 + 0.1 * k)) for k in range(5)) < 0.006 for share in shares)


@pytest.mark.parametrize("levels", [1, 2, 7])
def test_slabs_lie_one_upon_the_other(levels: int) -> None:
    stack = a_stack(levels=levels)
    picture = str(stacked_slices(stack, label="a & b"))
    root = drawn(picture)
    assert root.get("aria-label") == "a & b"
    order = [int(k) for k in re.findall(r'data-i="(\d+)"', picture)]
    assert order == list(reversed(range(len(stack))))
    view = view_of(stack)
    for i in order:
        below = float(stack.height[i + 1]) if i + 1 < len(stack) else 0.0
        assert _slab(stack, view, i, below) in picture
    assert _ground(stack, view) in picture
    assert picture.index(_ground(stack, view)) < picture.index("data-i")
    assert 'class="turn" transform="scale(0.1)"' in picture
