"""Laws of convex parts: their lengths, how far they reach, and to the last digit where straight rays enter them."""

from __future__ import annotations

import numpy as np
import pytest

from varishold.solids import Part, regular_polygon

DOWN = np.array([0.0, 0.0, -1.0])
EAST = np.array([1.0, 0.0, 0.0])
SLANTED = np.array([0.6, 0.0, -0.8])
SQUARE = np.array([[1.0, 1.0], [-1.0, 1.0], [-1.0, -1.0], [1.0, -1.0]])
# Each 2 m broad and 4 m high.
POST, BLOCK, HULL = Part.cylinder(2.0, 4.0), Part.box(2.0, 2.0, 4.0), Part.prism(SQUARE, 4.0)
BALL = Part.ellipsoid(2.0, 2.0, 2.0)


def entry(part: Part, start: tuple[float, float, float], way: np.ndarray) -> float:
    return float(part.hits(np.array([start]), way)[0])


def test_what_stands_on_the_base_plane_has_its_lengths_about_its_middle() -> None:
    assert Part.box(1.0, 2.0, 5.0) == Part("box", (0.5, 1.0, 2.5), (0.0, 0.0, 2.5))
    assert Part.cylinder(3.0, 5.0) == Part("cylinder", (1.5, 1.5, 2.5), (0.0, 0.0, 2.5))
    assert Part.ellipsoid(1.0, 2.0, 5.0) == Part("ellipsoid", (0.5, 1.0, 2.5), (0.0, 0.0, 2.5))


def test_a_hull_keeps_its_corners_and_knows_its_box() -> None:
    corners = ((1.0, 10.0, 100.0), (2.0, 13.0, 105.0), (4.0, 11.0, 101.0), (3.0, 12.0, 109.0))
    hull = Part.hull(np.array(corners))
    assert hull == Part("hull", (1.5, 1.5, 4.5), (2.5, 11.5, 104.5), corners)


def test_a_prism_is_its_polygon_below_and_its_scaled_copy_on_top() -> None:
    low = tuple((x, y, 0.0) for x, y in SQUARE.tolist())
    assert HULL.corners_m == low + tuple((x, y, 4.0) for x, y in SQUARE.tolist())
    half = Part.prism(SQUARE, 3.0, top_scale=0.5)
    assert half.corners_m == low + tuple((x / 2, y / 2, 3.0) for x, y in SQUARE.tolist())
    wide = Part.prism(SQUARE, 3.0, top_scale=1.5)
    assert wide.half_m == (1.5, 1.5, 1.5)
    assert Part.prism(SQUARE, 3.0, top_scale=0.0).corners_m == (*low, (0.0, 0.0, 3.0))


def test_the_first_corner_of_a_polygon_lies_at_its_turn_and_the_others_follow_anticlockwise() -> None:
    np.testing.assert_allclose(regular_polygon(4, 2.0), [[2, 0], [0, 2], [-2, 0], [0, -2]], atol=1e-12)
    turned = regular_polygon(3, 2.0, turn_rad=np.pi / 2)
    np.testing.assert_allclose(turned, [[0, 2], [-np.sqrt(3), -1], [np.sqrt(3), -1]], atol=1e-12)


@pytest.mark.parametrize(
    ("part", "east", "slanting", "back"),
    [
        (Part("box", (1.0, 2.0, 5.0), (10.0, 20.0, 5.0)), 11.0, 22 + 2.2, -22 + 2.2),
        (Part("cylinder", (1.0, 1.0, 5.0), (10.0, 20.0, 5.0)), 11.0, 22 + 1.0, -22 + 1.0),
        (Part("ellipsoid", (1.0, 2.0, 5.0), (10.0, 20.0, 5.0)), 11.0, 22 + np.sqrt(2.92), -22 + np.sqrt(2.92)),
        (Part.hull(np.array([[9.0, 18, 0], [11, 18, 0], [11, 22, 0], [10, 20, 50]])), 11.0, 24.2, -19.8),
    ],
    ids=lambda value: getattr(value, "kind", ""),
)
def test_a_part_reaches_as_far_as_its_farthest_point_that_way(
    part: Part, east: float, slanting: float, back: float
) -> None:
    assert part.reach(np.array([1.0, 0.0])) == pytest.approx(east)
    # Towards (0.6, 0.8) the middle lies at 22.
    assert part.reach(np.array([0.6, 0.8])) == pytest.approx(slanting)
    assert part.reach(np.array([-0.6, -0.8])) == pytest.approx(back)


def test_what_is_round_reaches_equally_far_every_way_to_the_last_bit() -> None:
    for turn in np.linspace(0, 6, 50):
        assert POST.reach(np.array([np.cos(turn), np.sin(turn)])) == 1.0


@pytest.mark.parametrize("part", [POST, BLOCK, HULL], ids=lambda part: part.kind)
def test_a_ray_meets_the_first_face_on_its_way(part: Part) -> None:
    assert entry(part, (0.0, 0.0, 9.0), DOWN) == pytest.approx(5.0)
    assert entry(part, (0.5, 0.5, -9.0), -DOWN) == pytest.approx(9.0)
    assert entry(part, (-9.0, 0.0, 3.0), EAST) == pytest.approx(8.0)
    assert entry(part, (9.0, 0.0, 3.0), -EAST) == pytest.approx(8.0)
    # Through the top at x = -0.25, and through the side at z = 2.
    assert entry(part, (-3.25, 0.0, 8.0), SLANTED) == pytest.approx(5.0)
    assert entry(part, (-4.0, 0.0, 6.0), SLANTED) == pytest.approx(5.0)
    # A ray that begins inside, or beyond, entered before.
    assert entry(part, (0.0, 0.0, 1.0), DOWN) == pytest.approx(-3.0)
    assert entry(part, (0.0, 0.0, -1.0), DOWN) == pytest.approx(-5.0)
    assert entry(part, (0.25, 0.0, 2.0), EAST) == pytest.approx(-1.25)


@pytest.mark.parametrize("part", [POST, BLOCK, HULL], ids=lambda part: part.kind)
def test_a_ray_that_crosses_the_planes_but_not_the_part_misses(part: Part) -> None:
    # It comes to the top's level beside the top, and to the side's place below the base or above the top.
    assert entry(part, (-1.5, 0.0, 8.0), SLANTED) == np.inf
    assert entry(part, (-4.0, 0.0, 2.0), SLANTED) == np.inf
    assert entry(part, (-1.75, 0.0, 8.0), SLANTED) == np.inf
    assert entry(part, (-9.0, 0.0, 4.001), EAST) == np.inf
    assert entry(part, (-9.0, 0.0, -0.001), EAST) == np.inf
    assert entry(part, (-9.0, 1.001, 2.0), EAST) == np.inf
    assert entry(part, (1.001, 0.0, 9.0), DOWN) == np.inf
    assert entry(part, (0.0, -1.001, 9.0), DOWN) == np.inf


@pytest.mark.parametrize("part", [POST, BLOCK], ids=lambda part: part.kind)
def test_a_ray_along_a_face_meets_its_border(part: Part) -> None:
    assert entry(part, (-9.0, 0.0, 4.0), EAST) == pytest.approx(8.0)
    assert entry(part, (-9.0, 0.0, 0.0), EAST) == pytest.approx(8.0)
    assert entry(part, (0.0, 1.0, 9.0), DOWN) == pytest.approx(5.0)


def test_a_ray_through_one_edge_of_a_box_touches_it() -> None:
    way = np.array([1.0, -1.0, 0.0]) / np.sqrt(2)
    assert entry(BLOCK, (0.0, 2.0, 1.0), way) == pytest.approx(np.sqrt(2))
    assert entry(BLOCK, (0.0, 2.0 + 1e-9, 1.0), way) == np.inf


def test_a_ray_that_hardly_leans_counts_as_level_with_a_side() -> None:
    for lean in (1e-12, -1e-12):
        way = np.array([lean, 0.0, -1.0])
        assert entry(BLOCK, (0.5, 0.0, 9.0), way) == pytest.approx(5.0)
        assert entry(BLOCK, (-2.0, 0.0, 9.0), way) == np.inf
        assert entry(BLOCK, (2.0, 0.0, 9.0), way) == np.inf


def test_a_ray_that_grazes_what_is_round_touches_it_in_one_point() -> None:
    assert entry(BALL, (1.0, 0.0, 6.0), DOWN) == 5.0
    assert entry(BALL, (1.001, 0.0, 6.0), DOWN) == np.inf
    assert entry(POST, (-5.0, 1.0, 2.0), EAST) == 5.0


def test_an_ellipsoid_is_met_where_its_equation_says() -> None:
    egg = Part.ellipsoid(2.0, 4.0, 6.0)
    assert entry(egg, (0.6, 0.0, 9.0), DOWN) == pytest.approx(9 - 3 - 3 * 0.8)
    assert entry(egg, (0.0, 1.2, 9.0), DOWN) == pytest.approx(9 - 3 - 3 * 0.8)
    assert entry(egg, (-7.0, 1.2, 3.0), EAST) == pytest.approx(7 - 0.8)
    assert entry(egg, (0.0, -7.0, 3.0), np.array([0.0, 1.0, 0.0])) == pytest.approx(7 - 2.0)
    assert entry(egg, (0.0, 0.0, 1.0), DOWN) == pytest.approx(-5.0)


def test_parts_off_the_middle_line_are_met_where_they_stand() -> None:
    for kind in ("box", "cylinder", "ellipsoid"):
        part = Part(kind, (1.0, 1.0, 2.0), (10.0, -20.0, 30.0))
        assert entry(part, (10.0, -20.0, 40.0), DOWN) == pytest.approx(8.0)
        assert entry(part, (0.0, -20.0, 30.0), EAST) == pytest.approx(9.0)
        assert entry(part, (10.0, 20.0, 40.0), DOWN) == np.inf
