"""Laws of faces and bodies point by point: lengths by size, heights on both sides of every border, corners."""

from __future__ import annotations

from dataclasses import astuple

import numpy as np
import pytest
from scipy.spatial import ConvexHull

from varishold.errors import InputError
from varishold.solids import (
    SOLIDS,
    Box,
    Cone,
    ConeFrustum,
    Cylinder,
    Edge,
    Ellipsoid,
    HalfCylinder,
    HexagonalPrism,
    Hip,
    LBlock,
    Lump,
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
    Torus,
    TriangularPrism,
    Wedge,
    ideal_frame,
    pad_points,
    solid_of_size,
)

# The fields of a solid of size 2, as it is usual and as a hand grips it.
_FIELDS: list[tuple[type[Solid], tuple[float, ...], tuple[float, ...]]] = [
    (Box, (2.8, 2, 0.16), (2.8, 2, 0.16)),
    (Cone, (2, 1), (2, 4)),
    (ConeFrustum, (2, 0.9, 0.6), (2, 1.2, 0.16)),
    (Cylinder, (2, 2), (2, 0.16)),
    (Edge, (2,), (2,)),
    (Ellipsoid, (3, 2, 1.6), (3, 2, 1.6)),
    (HalfCylinder, (2, 0.16), (2, 0.16)),
    (HexagonalPrism, (2, 0.16), (2, 0.16)),
    (Hip, (3.6, 2, 1), (3.6, 2, 1)),
    (LBlock, (2, 0.16), (2, 0.16)),
    (Lump, (2, 1), (2, 1)),
    (LyingCylinder, (2, 8), (2, 8)),
    (Plane, (2,), (2,)),
    (Pyramid, (2, 1), (2, 4)),
    (PyramidFrustum, (2, 0.9, 0.6), (2, 1.2, 0.16)),
    (RectangularPillar, (3.6, 2, 2), (3.6, 2, 2)),
    (Ridge, (3.6, 2, 1), (3.6, 2, 1)),
    (Sphere, (2,), (2,)),
    (SquarePillar, (2, 2), (2, 0.16)),
    (Torus, (2, 0.8), (2, 0.8)),
    (TriangularPrism, (2, 0.16), (2, 0.16)),
    (Wedge, (2, 1), (2, 1)),
]


@pytest.mark.parametrize(("kind", "usual", "gripped"), _FIELDS, ids=lambda value: getattr(value, "__name__", ""))
def test_a_size_gives_every_length(kind: type[Solid], usual: tuple[float, ...], gripped: tuple[float, ...]) -> None:
    assert astuple(kind.of_size(2.0)) == pytest.approx(usual)
    assert astuple(kind.to_grip(2.0)) == pytest.approx(gripped)


# Points of the solid's own axes and the height there. Borders belong to the face.
_R3 = np.sqrt(3)
_POINTS: list[tuple[Solid, list[tuple[float, float, float]]]] = [
    (Cylinder(10, 7), [(3, 4, 7), (-3, -4, 7), (5, 0, 7), (0, -5, 7), (5.01, 0, 0), (3, 4.01, 0), (4, 4, 0)]),
    (SquarePillar(10, 7), [(5, 5, 7), (-5, 5, 7), (5.01, 0, 0), (0, -5.01, 0), (-5.01, -5, 0)]),
    (RectangularPillar(10, 6, 7), [(5, 3, 7), (-5, -3, 7), (5.01, 0, 0), (-5.01, 0, 0), (0, 3.01, 0), (0, -3.01, 0)]),
    (Cone(10, 8), [(0, 0, 8), (5, 0, 0), (3, 0, 3.2), (0, -3, 3.2), (1.5, 2, 4), (-6, 0, 0)]),
    (Pyramid(10, 8), [(0, 0, 8), (5, 5, 0), (3, 0, 3.2), (0, -3, 3.2), (2.5, 2, 4), (-6, 0, 0)]),
    (ConeFrustum(10, 4, 6), [(0, 0, 6), (2, 0, 6), (1.2, 1.6, 6), (3.5, 0, 3), (2.1, -2.8, 3), (5, 0, 0), (4, 4, 0)]),
    (PyramidFrustum(10, 4, 6), [(0, 0, 6), (2, -2, 6), (3.5, 0, 3), (3.5, -3.5, 3), (0, 4, 2), (5, 5, 0), (6, 0, 0)]),
    (Sphere(10), [(0, 0, 5), (3, 0, 4), (0, -3, 4), (0, 4, 3), (5, 0, 0), (4, 4, 0)]),
    (Ellipsoid(10, 20, 6), [(0, 0, 3), (3, 0, 2.4), (0, -6, 2.4), (0, 8, 1.8), (4, 0, 1.8), (5, 0, 0), (5, 5, 0)]),
    (Ridge(10, 6, 4), [(5, 0, 4), (-5, 1.5, 2), (0, -1.5, 2), (5.01, 0, 0), (-5.01, 0, 0), (0, 3, 0), (0, -4, 0)]),
    (Hip(10, 6, 4), [(0, 0, 4), (2, 0, 4), (-2, 0, 4), (3.5, 0, 2), (-3.5, 0, 2), (0, -1.5, 2), (5, 0, 0), (4, 3, 0)]),
    (LyingCylinder(10, 8), [(4, 0, 5), (-4, 3, 4), (0, -4, 3), (4.01, 0, 0), (-4.01, 0, 0), (0, 5, 0), (0, -6, 0)]),
    (Edge(3), [(0, 0, 3), (0, 9, 3), (-9, -9, 3), (0.01, 0, 0), (0.5, 5, 0), (1, 0, 0), (9, -9, 0)]),
    (Wedge(6, 4), [(0, 0, 4), (99, 0, 4), (-99, 1.5, 2), (7, -1.5, 2), (0, 3, 0), (5, -4, 0)]),
    (Plane(3), [(0, 0, 3), (1e6, -1e6, 3)]),
    (HalfCylinder(8, 7), [(-2, 0, 7), (2, 0, 7), (-2, 4, 7), (-2, -4, 7), (-2.01, 0, 0), (2.01, 0, 0), (0.4, 3.3, 0)]),
    (LBlock(8, 7), [(4, -4, 7), (-4, 4, 7), (0, 4, 7), (4, 0, 7), (0.01, 0.01, 0), (3, 3, 0), (-4.01, 0, 0)]),
    (Torus(10, 2), [(4, 0, 2), (0, -4, 2), (5, 0, 1), (3, 0, 1), (4.6, 0, 1.8), (0, 3.2, 1.6), (2.9, 0, 0), (0, 0, 0)]),
    (Torus(10, 2), [(5.01, 0, 0), (-4.8, 0, 1.6)]),
    (HexagonalPrism(6, 7), [(2.999, 0, 7), (3.001, 0, 0), (-2.999, 0, 7), (-3.001, 0, 0), (0, 3.46, 7), (0, 3.47, 0)]),
    (
        TriangularPrism(6, 7),
        [(-1.999, 3.46, 7), (-2.001, 0, 0), (3.999, 0, 7), (4.001, 0, 0), (1, -1.73, 7), (1, 1.74, 0)],
    ),
]


@pytest.mark.parametrize(("solid", "points"), _POINTS, ids=lambda value: getattr(value, "name", ""))
def test_a_face_is_as_high_as_its_form_says(solid: Solid, points: list[tuple[float, float, float]]) -> None:
    x, y, height = np.array(points, dtype=float).T
    np.testing.assert_allclose(solid.height(x, y), height, atol=1e-9)
    # A whole grid at once, and rows against columns.
    grid = solid.height(x[:, None] + 0 * y, y + 0 * x[:, None])
    assert grid.shape == (len(points), len(points))
    np.testing.assert_array_equal(np.diag(grid), solid.height(x, y))
    if not isinstance(solid, LyingCylinder | Wedge | Plane | Edge | Ellipsoid | Sphere | Torus):
        assert solid.top_m == astuple(solid)[-1]


def test_the_top_of_what_is_round_above() -> None:
    assert [Sphere(6.0).top_m, Ellipsoid(9.0, 8.0, 6.0).top_m, LyingCylinder(6.0, 9.0).top_m] == [3.0, 3.0, 3.0]
    assert Torus(10.0, 6.0).top_m == 6.0


def test_an_edge_and_a_wedge_and_a_plane_take_points_that_broadcast() -> None:
    x, y = np.zeros((3, 1)), np.zeros((1, 4))
    for solid in (Edge(1.0), Wedge(1.0, 1.0), Plane(1.0)):
        np.testing.assert_array_equal(solid.height(x, y), np.ones((3, 4)))


def test_a_prism_has_its_breadth_from_a_side_to_what_lies_opposite() -> None:
    assert HexagonalPrism(6.0, 1.0).side_distance_m == pytest.approx(3.0)
    assert TriangularPrism(6.0, 1.0).side_distance_m == pytest.approx(2.0)
    (three,) = TriangularPrism(6.0, 5.0).body()
    wanted = [[4, 0, 0], [-2, 2 * _R3, 0], [-2, -2 * _R3, 0]]
    corners = np.array(three.corners_m)
    for corner in wanted:
        assert np.abs(corners - corner).max(axis=1).min() < 1e-9
        assert np.abs(corners - np.add(corner, [0, 0, 5])).max(axis=1).min() < 1e-9
    assert len(corners) == 6
    (six,) = HexagonalPrism(6.0, 5.0).body()
    assert len(six.corners_m) == 12
    np.testing.assert_allclose(np.hypot(*np.array(six.corners_m)[:, :2].T), 2 * _R3)


def volume_m3(solid: Solid) -> float:
    return float(sum(ConvexHull(np.array(part.corners_m)).volume for part in solid.body()))


def test_bodies_with_corners_have_the_volume_of_their_form() -> None:
    # A regular polygon of 48 sides in a circle, and 24 of a half circle.
    disc = 48 / 2 * np.sin(2 * np.pi / 48)
    assert volume_m3(Cone(2.0, 3.0)) == pytest.approx(disc)
    assert volume_m3(Pyramid(2.0, 3.0)) == pytest.approx(4)
    assert volume_m3(ConeFrustum(4.0, 2.0, 3.0)) == pytest.approx(disc * (4 + 2 + 1))
    assert volume_m3(PyramidFrustum(4.0, 2.0, 3.0)) == pytest.approx(16 + 8 + 4)
    assert volume_m3(HalfCylinder(2.0, 3.0)) == pytest.approx(3 * 24 / 2 * np.sin(np.pi / 24))
    assert volume_m3(TriangularPrism(6.0, 5.0)) == pytest.approx(5 * 12 * _R3)
    assert volume_m3(HexagonalPrism(6.0, 5.0)) == pytest.approx(5 * 18 * _R3)


def test_the_body_of_a_frustum_stands_on_its_base_with_a_flat_side_to_each_axis() -> None:
    (part,) = PyramidFrustum(4.0, 2.0, 3.0).body()
    np.testing.assert_allclose(np.abs(np.array(part.corners_m)[:, :2]), [[2, 2]] * 4 + [[1, 1]] * 4)
    (part,) = ConeFrustum(4.0, 2.0, 3.0).body()
    radius = np.hypot(*np.array(part.corners_m)[:, :2].T)
    np.testing.assert_allclose(radius, [2] * 48 + [1] * 48)
    assert [part.half_m[2], part.centre_m[2]] == [1.5, 1.5]
    (half,) = HalfCylinder(2.0, 3.0).body()
    assert len(half.corners_m) == 50
    np.testing.assert_allclose(np.hypot(*(np.array(half.corners_m)[:, :2] + [0.5, 0]).T), 1.0)


def test_a_ring_is_24_pieces_whose_corners_lie_on_it_and_which_meet() -> None:
    ring = Torus(10.0, 2.0)
    pieces = [np.array(part.corners_m) for part in ring.body()]
    assert len(pieces) == 24
    for k, piece in enumerate(pieces):
        assert piece.shape == (24, 3)
        off = np.hypot(piece[:, 0], piece[:, 1]) - 4
        np.testing.assert_allclose(np.hypot(off, piece[:, 2] - 1), 1.0)
        np.testing.assert_allclose(pieces[k - 1][12:], piece[:12], atol=1e-12)
        turn = np.unwrap(np.arctan2(piece[[0, 12], 1], piece[[0, 12], 0]))
        assert np.diff(turn) == pytest.approx(2 * np.pi / 24)
        around = np.unwrap(np.arctan2(piece[:12, 2] - 1, off[:12]))
        np.testing.assert_allclose(np.diff(around), 2 * np.pi / 12)
        assert [piece[:, 2].min(), piece[:, 2].max()] == pytest.approx([0, 2])
    # The first lies at the turn 0.
    assert pieces[0][0] == pytest.approx([5, 0, 1])


def test_an_l_block_is_a_half_and_a_quarter() -> None:
    long, short = LBlock(8.0, 6.0).body()
    assert (long.half_m, long.centre_m) == ((4, 2, 3), (0, -2, 3))
    assert (short.half_m, short.centre_m) == ((2, 2, 3), (-2, 2, 3))


def test_bodies_that_need_no_corners() -> None:
    for solid, kind, half in (
        (Cylinder(2.0, 6.0), "cylinder", (1, 1, 3)),
        (SquarePillar(2.0, 6.0), "box", (1, 1, 3)),
        (RectangularPillar(4.0, 2.0, 6.0), "box", (2, 1, 3)),
        (Box(4.0, 2.0, 6.0), "box", (2, 1, 3)),
        (Sphere(6.0), "ellipsoid", (3, 3, 3)),
        (Ellipsoid(4.0, 2.0, 6.0), "ellipsoid", (2, 1, 3)),
    ):
        (part,) = solid.body()
        assert (part.kind, part.half_m, part.centre_m) == (kind, half, (0, 0, 3))


def test_every_length_of_a_solid_is_positive_and_bounded() -> None:
    for bad in (0.0, -1.0, np.inf, np.nan):
        with pytest.raises(InputError, match=r"^height_m of a hip must be positive and finite, got "):
            Hip(1.0, 1.0, bad)
    with pytest.raises(InputError, match=r"^breadth_m of a hip must be at most 1e\+100, got 1\.01e\+100$"):
        Hip(1.0, 1.01e100, 1.0)
    assert astuple(Hip(1e100, 1e-300, 1e100)) == (1e100, 1e-300, 1e100)


def test_a_size_is_positive_and_finite() -> None:
    for bad in (0.0, -1.0, np.inf, np.nan):
        with pytest.raises(InputError, match=r"^the size of a cone must be positive and finite, got "):
            solid_of_size("cone", bad)
    assert {name: type(solid_of_size(name, 1e-3)) for name in SOLIDS} == SOLIDS


def test_the_points_of_a_taxel_lie_evenly_about_its_middle() -> None:
    x, y = pad_points((2, 3), 2.0)
    np.testing.assert_allclose(x, [[-2, 0, 2]] * 2)
    np.testing.assert_allclose(y, [[-1] * 3, [1] * 3])
    x, y = pad_points((1, 2), (4.0, 2.0), per_taxel=2)
    np.testing.assert_allclose(x, [[-1.5, -0.5, 0.5, 1.5]] * 2)
    np.testing.assert_allclose(y, [[-1] * 4, [1] * 4])


def test_a_frame_is_the_mean_of_eight_by_eight_points_a_taxel() -> None:
    ball = Sphere(6.0)
    x, y = pad_points((6, 5), (1.0, 1.5), per_taxel=8)
    above = np.maximum(ball.height(x - 0.3, y + 0.2) - 1.0, 0.0)
    wanted = [[above[8 * i : 8 * i + 8, 8 * k : 8 * k + 8].mean() for k in range(5)] for i in range(6)]
    frame = ideal_frame(ball, (6, 5), (1.0, 1.5), depth_m=2.0, pose=Pose(0.3, -0.2))
    np.testing.assert_allclose(frame, wanted, rtol=1e-12)
    once = ideal_frame(ball, (6, 5), (1.0, 1.5), depth_m=2.0, per_taxel=1)
    np.testing.assert_allclose(once, np.maximum(ball.height(*pad_points((6, 5), (1.0, 1.5))) - 1.0, 0.0))


def test_a_frame_is_at_most_as_deep_as_its_solid() -> None:
    block = Box(6.0, 4.0, 3.0)
    # A depth that a sum has rounded up is the whole height.
    np.testing.assert_allclose(ideal_frame(block, (8, 10), 1.0, depth_m=3.0 * (1 + 5e-13)).sum(), 72)
    assert ideal_frame(block, (8, 10), 1.0, depth_m=1e-9).max() > 0
    for depth in (0.0, 3.0 * (1 + 1e-9), -1.0):
        with pytest.raises(InputError, match=r"^depth_m must lie in \(0, 3\], the height of the box, got "):
            ideal_frame(block, (8, 10), 1.0, depth_m=depth)


# Of lumps of breadth 1: length, height, corners, volume and level middle of each part.
# A lump is told by its number alone.
_LUMPS = {
    1: (1.136307, 2.75025, [(48, 2.258856, 0.0, 0.0)]),
    2: (1.61011, 0.736192, [(14, 0.428032, 0.0, 0.0)]),
    3: (1.070886, 1.61714, [(14, 0.57687, 0.0, 0.0)]),
    4: (1.250289, 1.868688, [(48, 1.38337, -0.134255, 0.0), (14, 0.455842, 0.281781, -0.155274)]),
    8: (0.739564, 1.697053, [(48, 0.946614, 0.0, 0.0), (8, 0.09801, 0.118533, -0.28694)]),
    9: (1.29138, 1.517833, [(48, 1.267289, 0.0, 0.0)]),
    11: (1.713865, 3.49287, [(6, 1.109178, 0.0, 0.0)]),
    14: (1.03162, 1.983516, [(14, 1.359497, 0.0, 0.0)]),
    21: (0.679186, 1.285346, [(48, 0.374327, 0.0, 0.0)]),
    23: (0.975611, 2.302373, [(12, 1.372305, 0.0, 0.0)]),
}


@pytest.mark.parametrize("number", _LUMPS)
def test_a_number_names_the_same_lump_for_ever(number: int) -> None:
    length, height, parts = _LUMPS[number]
    lump = Lump(1.0, number)
    corners = [np.array(part.corners_m) for part in lump.body()]
    assert np.ptp(np.vstack(corners), axis=0) == pytest.approx([length, 1.0, height], abs=1e-6)
    found = [
        (len(each), ConvexHull(each).volume, *part.centre_m[:2])
        for each, part in zip(corners, lump.body(), strict=True)
    ]
    np.testing.assert_allclose(found, parts, atol=1e-6)
    assert lump.top_m == pytest.approx(height, abs=1e-6)
    assert Lump(1.0) == Lump(1.0, 1)
