"""Laws of faces, bodies and draws: volumes, breadths, where rays enter, contacts of the wanted size."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from varishold.errors import InputError
from varishold.solids import (
    SOLIDS,
    Box,
    Ellipsoid,
    HalfCylinder,
    HexagonalPrism,
    LBlock,
    Lump,
    Part,
    Pose,
    Solid,
    Sphere,
    Torus,
    TriangularPrism,
    draw_contact,
    ideal_frame,
    pad_points,
    regular_polygon,
)

GRIPPED: list[type[Solid]] = [
    *(
        kind
        for name, kind in SOLIDS.items()
        if name not in ("ridge", "hip", "lying-cylinder", "edge", "wedge", "plane")
    ),
    *(Box, HexagonalPrism, TriangularPrism, HalfCylinder, LBlock, Ellipsoid, Torus),
]
few = settings(max_examples=40)
seeds = st.integers(0, 2**32 - 1)

# Volume under the face of a solid of size 1, made by `of_size` and by `to_grip`; the round ones by their formulas.
_SIN60 = np.sqrt(3) / 2
_SECTION = {
    "cylinder": np.pi / 4,
    "square-pillar": 1.0,
    "rectangular-pillar": 1.8,
    "box": 1.4,
    "hexagonal prism": _SIN60,
    "triangular prism": 1 / np.sqrt(3),
    "half cylinder": np.pi / 8,
    "L-block": 0.75,
}
_VOLUME = {
    "cylinder": np.pi / 4,
    "square pillar": 1.0,
    "rectangular pillar": 1.8,
    "cone": np.pi / 24,
    "pyramid": 1 / 6,
    "frustum of a cone": np.pi / 12 * 0.3 * (1 + 0.45 + 0.45**2),
    "frustum of a pyramid": 0.1 * (1 + 0.45 + 0.45**2),
    "sphere": np.pi / 12,
    "ridge": 1.8 * 0.5 / 2,
    "hip": 0.5 * (0.8 / 2 + 1 / 3),
    "lying cylinder": np.pi / 8 * 4,
    "ellipsoid": np.pi / 12 * 1.5 * 0.8,
    # Under the upper half of the tube: half of its own volume and all that lies below its middle.
    "torus": np.pi**2 * 0.3 * 0.2**2 + np.pi * (0.5**2 - 0.1**2) * 0.2,
}


def face(solid: Solid, half_m: float, n: int = 700) -> tuple[np.ndarray, np.ndarray]:
    """Heights over a square about the origin, and its points; no point on an axis."""
    points = (np.arange(n) + 0.5) / n * 2 * half_m - half_m
    return solid.height(*np.meshgrid(points, points)), points


@pytest.mark.parametrize("kind", [*SOLIDS.values(), Ellipsoid, Torus], ids=lambda kind: kind.__name__)
def test_a_face_stands_over_the_volume_of_its_form(kind: type[Solid]) -> None:
    if kind.name in ("edge", "plane"):
        return
    for size_m in (1.0, 0.03):
        height, points = face(kind.of_size(size_m), 2.3 * size_m, 900)
        cell = (points[1] - points[0]) ** 2
        assert height.sum() * cell == pytest.approx(_VOLUME[kind.name] * size_m**3, rel=0.01)


@pytest.mark.parametrize("kind", GRIPPED, ids=lambda kind: kind.__name__)
def test_what_a_hand_grips_is_as_broad_as_its_size_and_stands_in_the_middle(kind: type[Solid]) -> None:
    solid = kind.to_grip(0.06)
    corners = [
        np.add(part.centre_m, np.multiply(sign, part.half_m))
        for part in solid.body()
        for sign in ((1, 1, 1), (-1, -1, -1))
    ]
    low, high = np.min(corners, axis=0), np.max(corners, axis=0)
    lengths = high - low
    wanted = {"half cylinder": (0.03, 0.06), "box": (0.084, 0.06), "rectangular pillar": (0.108, 0.06)}
    wanted |= {"ellipsoid": (0.09, 0.06)}
    if kind is HexagonalPrism:
        assert lengths[:2] == pytest.approx((0.06, 0.06 / _SIN60))
    elif kind is TriangularPrism:
        assert lengths[:2] == pytest.approx((0.06, 0.06 / _SIN60))
        assert (low[0], high[0]) == pytest.approx((-0.02, 0.04))
    else:
        assert lengths[:2] == pytest.approx(wanted.get(kind.name, (0.06, 0.06)), rel=1e-9)
    if kind not in (TriangularPrism, HalfCylinder):
        assert low[:2] == pytest.approx(-high[:2], abs=1e-12)
    assert low[2] == pytest.approx(0.0, abs=1e-12)
    below = solid.top_m if kind in (Ellipsoid, Sphere) else 0.0
    assert high[2] == pytest.approx(solid.top_m + below, rel=1e-9)
    tall = {
        "cone": 0.12,
        "pyramid": 0.12,
        "sphere": 0.06,
        "ellipsoid": 0.048,
        "torus": 0.024,
        "rectangular pillar": 0.06,
    }
    assert high[2] == pytest.approx(tall.get(kind.name, 0.16), rel=1e-9)


@pytest.mark.parametrize("kind", GRIPPED, ids=lambda kind: kind.__name__)
@pytest.mark.parametrize("grip", [False, True])
def test_a_body_seen_from_above_is_the_face(kind: type[Solid], grip: bool) -> None:
    solid = kind.to_grip(0.06) if grip else kind.of_size(0.06)
    height, points = face(solid, 0.056, 56)
    x, y = np.meshgrid(points, points)
    high = np.column_stack([x.ravel(), y.ravel(), np.full(x.size, 1.0)])
    reach = np.min([part.hits(high, np.array([0.0, 0.0, -1.0])) for part in solid.body()], axis=0)
    seen = np.where(np.isfinite(reach), 1 - reach, 0.0).reshape(x.shape)
    lifted = height + np.where(height > 0, solid.top_m if kind in (Ellipsoid, Sphere) else 0.0, 0.0)
    # Straight pieces stand for round ones: a rim, and a slope by as much as they cut.
    near_m = 3e-3 if kind is Torus else 0.008 * solid.top_m
    assert (np.abs(seen - lifted) <= near_m).mean() > 0.985


def inside(part: Part, points: np.ndarray) -> np.ndarray:
    """How far inside the points are, by the definition of each form: positive inside."""
    p = (points - np.array(part.centre_m)) / np.array(part.half_m)
    if part.kind == "box":
        return 1 - np.abs(p).max(axis=1)
    if part.kind == "cylinder":
        return 1 - np.maximum(np.hypot(p[:, 0], p[:, 1]), np.abs(p[:, 2]))
    return 1 - np.sqrt((p * p).sum(axis=1))


@few
@given(seeds, st.sampled_from(["box", "cylinder", "ellipsoid", "hull"]), st.sampled_from(["any", "along", "across"]))
def test_a_ray_enters_where_the_body_begins(seed: int, kind: str, way: str) -> None:
    rng = np.random.default_rng(seed)
    x, y, z = rng.uniform(0.5, 2.0, 3)
    part = {
        "box": Part.box(x, y, z),
        "cylinder": Part.cylinder(x, z),
        "ellipsoid": Part.ellipsoid(x, y, z),
        "hull": Part.prism(np.array([[x, y], [-x, y], [-x, -y], [x, -y]]) / 2, z),
    }[kind]
    twin = Part.box(x, y, z) if kind == "hull" else part
    direction = rng.normal(size=3)
    if way == "along":
        direction = np.array([0.0, 0.0, rng.choice([-1.0, 1.0])])
    elif way == "across":
        direction[2] = 0.0
    direction /= np.linalg.norm(direction)
    origins = rng.uniform(-1.5, 1.5, (60, 3)) + np.array([0, 0, z / 2]) - 5 * direction
    reach = part.hits(origins, direction)
    hit = np.isfinite(reach)
    at = origins[hit] + reach[hit, None] * direction
    assert (inside(twin, at + 1e-6 * direction) > -1e-5).all()
    assert (np.abs(inside(twin, at)) < 1e-6).all()
    assert (inside(twin, at - 1e-4 * direction) < 1e-9).all()
    along = np.linspace(0, 12, 400)[:, None, None] * direction + origins[~hit]
    assert (inside(twin, along.reshape(-1, 3)) < 0.06).all()
    # From inside, the entry lies behind.
    middle = np.array([[0.0, 0.0, z / 2]])
    assert part.hits(middle, direction)[0] < 0


def test_a_ray_along_a_cylinders_side_meets_its_cap_or_nothing() -> None:
    post = Part.cylinder(2.0, 4.0)
    down = np.array([0.0, 0.0, -1.0])
    origins = np.array([[0.0, 0.0, 9.0], [1.0, 0.0, 9.0], [1.01, 0.0, 9.0]])
    assert post.hits(origins, down).tolist() == [5.0, 5.0, np.inf]
    box = Part.box(2.0, 2.0, 4.0)
    assert box.hits(origins, down).tolist() == [5.0, 5.0, np.inf]


def test_the_corners_of_a_regular_polygon() -> None:
    square = regular_polygon(4, np.sqrt(2), turn_rad=np.pi / 4)
    np.testing.assert_allclose(square, [[1, 1], [-1, 1], [-1, -1], [1, -1]], atol=1e-12)
    tip = Part.prism(square, 3.0, top_scale=0.0)
    assert (tip.half_m, tip.centre_m) == (pytest.approx((1, 1, 1.5)), pytest.approx((0, 0, 1.5)))
    assert len(tip.corners_m) == 5
    assert len(Part.prism(square, 3.0, top_scale=0.5).corners_m) == 8


@pytest.mark.parametrize("number", range(1, 13))
def test_a_lump_stands_in_the_middle_of_its_table(number: int) -> None:
    lump = Lump(0.07, number)
    corners = np.vstack([part.corners_m for part in lump.body()])
    low, high = corners.min(axis=0), corners.max(axis=0)
    assert low[:2] == pytest.approx(-high[:2], abs=1e-9)
    assert lump.top_m == pytest.approx(high[2])
    assert 0.3 < high[2] / 0.07 < 5
    assert 0.3 < (high[0] - low[0]) / 0.07 < 4
    height, _ = face(lump, 0.2, 101)
    assert 0 < height.max() <= lump.top_m + 1e-12
    assert Lump(0.14, number).top_m == pytest.approx(2 * lump.top_m)
    assert Lump.of_size(0.14).breadth_m == 0.14


def test_lumps_differ() -> None:
    forms = {tuple(part.half_m[0] for part in Lump(0.07, number).body()) for number in range(1, 40)}
    assert len(forms) == 39
    assert any(len(Lump(0.07, number).body()) == 2 for number in range(1, 40))


@pytest.mark.parametrize("name", SOLIDS)
def test_a_drawn_contact_has_the_wanted_breadth_depth_and_slope(name: str) -> None:
    rng = np.random.default_rng(8)
    turns = []
    for _ in range(25):
        drawn = draw_contact(
            rng, name, field_m=(40.0, 60.0), size_m=(10.0, 20.0), slope=(0.1, 0.3), aspect=(1.5, 2.5), top=(0.3, 0.6)
        )
        solid, (long_m, short_m) = drawn.solid, drawn.size_m
        turns.append(drawn.pose.yaw_rad)
        assert 0 < drawn.depth_m <= solid.top_m * (1 + 1e-12)
        points = (np.arange(800) + 0.5) / 800 * 80 - 40
        line = np.zeros_like(points)
        cut = solid.top_m - drawn.depth_m
        across = solid.height(line, points) > cut
        along = solid.height(points, line) > cut
        if np.isfinite(short_m):
            assert np.ptp(points[across]) == pytest.approx(short_m, abs=0.25)
        if np.isfinite(long_m) and long_m < 79:
            assert np.ptp(points[along]) == pytest.approx(long_m, abs=0.25)
        if name in ("ridge", "hip", "rectangular-pillar"):
            assert 1.5 <= long_m / short_m <= 2.5
            assert 10 <= long_m <= 20
            assert 0.1 <= drawn.depth_m / short_m <= 0.3
        elif np.isfinite(short_m):
            assert 10 <= short_m <= 20
            assert 0.1 <= drawn.depth_m / short_m <= 0.3
        # A slope goes on below the contact line, by as much again.
        if name in ("cone", "pyramid", "ridge", "hip", "wedge", "cone-frustum", "pyramid-frustum"):
            assert solid.top_m == pytest.approx(2 * drawn.depth_m)
        if "frustum" in name:
            assert 0.3 <= drawn.true_size_m[0] / short_m <= 0.6
        fixed = draw_contact(rng, name, field_m=(40.0, 60.0), size_m=(10.0, 20.0), depth_m=1.5)
        assert fixed.depth_m == 1.5
        if not solid.may_leave_field:
            assert abs(drawn.pose.x_m) <= 30 - short_m / 2
            assert abs(drawn.pose.y_m) <= 20 - short_m / 2
        else:
            assert max(abs(drawn.pose.x_m), abs(drawn.pose.y_m)) <= 10
    assert min(turns) < -0.9
    assert max(turns) > 0.9
    assert max(map(abs, turns)) <= np.pi / 2


def test_a_ball_is_cut_at_the_wanted_breadth_and_never_below_its_middle() -> None:
    rng = np.random.default_rng(2)
    for slope in ((0.1, 0.2), (0.8, 0.9)):
        for _ in range(10):
            drawn = draw_contact(rng, "sphere", field_m=(40, 40), size_m=(10, 20), slope=slope)
            radius = drawn.solid.top_m
            half = np.sqrt(radius**2 - (radius - drawn.depth_m) ** 2)
            assert 2 * half == pytest.approx(drawn.size_m[0])
            assert drawn.depth_m <= radius * (1 + 1e-12)


def test_lying_cylinders_end_in_the_field_or_leave_it_at_both_ends() -> None:
    rng = np.random.default_rng(5)
    lengths = np.array(
        [draw_contact(rng, "lying-cylinder", field_m=(30, 40), size_m=(8, 12)).size_m[0] for _ in range(120)]
    )
    leaves = lengths == 160
    assert 0.2 < leaves.mean() < 0.47
    assert lengths[~leaves].min() >= 1.3 * 8
    assert lengths[~leaves].max() <= 3 * 12


@few
@given(st.integers(1, 5), st.integers(1, 6), st.integers(1, 3), st.floats(0.5, 2), st.floats(0.5, 2))
def test_the_points_of_a_pad(rows: int, cols: int, per_taxel: int, row_pitch: float, col_pitch: float) -> None:
    x, y = pad_points((rows, cols), (row_pitch, col_pitch), per_taxel=per_taxel)
    assert x.shape == y.shape == (rows * per_taxel, cols * per_taxel)
    assert x.mean() == pytest.approx(0, abs=1e-9)
    assert y.mean() == pytest.approx(0, abs=1e-9)
    np.testing.assert_allclose(np.diff(x, axis=1), col_pitch / per_taxel)
    np.testing.assert_allclose(np.diff(y, axis=0), row_pitch / per_taxel)
    assert not np.diff(x, axis=0).any()
    assert not np.diff(y, axis=1).any()


def test_a_pose_shifts_turns_and_tips_a_face() -> None:
    block = Box(6.0, 2.0, 1.0)
    x, y = pad_points((21, 31), (0.5, 0.25))
    plain = block.placed(x, y)
    np.testing.assert_array_equal(plain, ((np.abs(x) <= 3) & (np.abs(y) <= 1)).astype(float))
    moved = block.placed(x, y, Pose(1.0, -2.0))
    np.testing.assert_array_equal(moved, ((np.abs(x - 1) <= 3) & (np.abs(y + 2) <= 1)).astype(float))
    turned = block.placed(x, y, Pose(yaw_rad=np.pi / 6))
    along, across = x * np.cos(np.pi / 6) + y * np.sin(np.pi / 6), y * np.cos(np.pi / 6) - x * np.sin(np.pi / 6)
    np.testing.assert_array_equal(turned > 0, (np.abs(along) <= 3) & (np.abs(across) <= 1))
    tipped = block.placed(x, y, Pose(0.5, 0.0, tip_x=0.1, tip_y=-0.2))
    on = (np.abs(x - 0.5) <= 3) & (np.abs(y) <= 1)
    np.testing.assert_allclose(tipped, np.where(on, 1 + 0.1 * (x - 0.5) - 0.2 * y, 0.0), atol=1e-12)
    only_y = block.placed(x, y, Pose(tip_y=0.1))
    np.testing.assert_allclose(only_y, np.where(plain > 0, 1 + 0.1 * y, 0.0), atol=1e-12)


def test_an_ideal_frame_is_the_mean_height_above_the_standard_plane() -> None:
    block = Box(6.0, 4.0, 3.0)
    whole = ideal_frame(block, (8, 10), 1.0)
    cut = ideal_frame(block, (8, 10), 1.0, depth_m=1.0)
    np.testing.assert_allclose(whole[2:6, 2:8], 3.0)
    np.testing.assert_allclose(cut[2:6, 2:8], 1.0)
    assert whole.sum() == pytest.approx(72)
    assert cut.sum() == pytest.approx(24)
    half = ideal_frame(block, (8, 10), 1.0, pose=Pose(0.5, 0.25))
    assert half[3, 2] == pytest.approx(1.5)
    assert half[2, 4] == pytest.approx(2.25)
    assert half[6, 4] == pytest.approx(0.75)
    for depth in (0.0, -1.0, 3.1, np.nan):
        with pytest.raises(InputError, match="depth_m must lie in"):
            ideal_frame(block, (8, 10), 1.0, depth_m=depth)
    assert ideal_frame(block, (8, 10), (2.0, 1.0)).sum() == pytest.approx(36)


def test_sizes_and_poses_have_their_bounds() -> None:
    for bad in (0.0, -1.0, np.inf, np.nan):
        with pytest.raises(InputError, match="must be positive and finite"):
            Sphere(bad)
    with pytest.raises(InputError, match="at most 1e"):
        Sphere(1e101)
    assert Sphere(1e100).diameter_m == 1e100
    for bad in (np.inf, np.nan, -1e101):
        with pytest.raises(InputError, match="yaw_rad of a pose must be finite"):
            Pose(yaw_rad=bad)
    assert Pose(x_m=-1e100).x_m == -1e100
