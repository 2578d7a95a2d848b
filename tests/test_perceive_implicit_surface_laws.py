"""A surface from points, normals and free places: what must hold whatever was touched."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

pytest.importorskip("scipy", reason="SciPy is not installed; pip install -e '.[skin]'")

from varishold.errors import InputError
from varishold.perceive import ImplicitSurface, SurfaceContacts, SurfaceMesh, write_stl
from varishold.perceive.contour_mesh import contour_mesh
from varishold.perceive.plain_body import Ball, Bar, plain_bodies
from varishold.perceive.surface_points import MOST

RADIUS_M, NOISE_M = 0.04, 0.0005


def ball(seed: int = 1, n: int = 60) -> SurfaceContacts:
    """Noisy points all over a ball, six a touch."""
    rng = np.random.default_rng(seed)
    out = rng.normal(size=(n, 3))
    out /= np.linalg.norm(out, axis=1, keepdims=True)
    points = RADIUS_M * out + NOISE_M * rng.normal(size=(n, 1)) * out
    return SurfaceContacts(points, out + 0.05 * rng.normal(size=(n, 3)), touch=np.arange(n) // 6)


def edges(mesh: SurfaceMesh) -> np.ndarray:
    """Every edge of every triangle, in its direction."""
    return np.concatenate([mesh.faces[:, [k, (k + 1) % 3]] for k in range(3)])


def closed(mesh: SurfaceMesh) -> bool:
    """Whether every edge belongs to two triangles, which run along it in opposite directions."""
    there = {tuple(edge) for edge in edges(mesh).tolist()}
    return len(there) == len(edges(mesh)) and all((b, a) in there for a, b in there)


def euler_number(mesh: SurfaceMesh) -> int:
    return len(mesh.vertices_m) - len(edges(mesh)) // 2 + len(mesh.faces)


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_noisy_points_of_a_ball_give_the_ball_back(seed: int) -> None:
    surface = ImplicitSurface(ball(seed))
    mesh = surface.mesh()
    off = np.linalg.norm(mesh.vertices_m, axis=1) - RADIUS_M
    assert np.abs(off).mean() < NOISE_M
    assert np.abs(off).max() < 4 * NOISE_M
    assert mesh.volume_m3 == pytest.approx(4 / 3 * np.pi * RADIUS_M**3, rel=0.05)
    inside, outside = surface.distance([[0.0, 0.0, 0.0], [0.0, 0.0, 2 * RADIUS_M]])[0]
    assert inside == pytest.approx(-RADIUS_M, rel=0.1)
    assert outside == pytest.approx(RADIUS_M, rel=0.1)


def test_a_closed_mesh_has_each_edge_twice_and_looks_outward() -> None:
    mesh = ImplicitSurface(ball()).mesh(steps=20)
    assert closed(mesh)
    assert euler_number(mesh) == 2
    middles = mesh.vertices_m[mesh.faces].mean(axis=1)
    assert ((mesh.face_normals * middles).sum(axis=1) > 0).all()
    assert ((mesh.vertex_normals * mesh.vertices_m).sum(axis=1) > 0).all()
    assert mesh.vertex_areas_m2.sum() == pytest.approx(np.linalg.norm(mesh.face_normals, axis=1).sum() / 2)


@settings(max_examples=15)
@given(st.integers(0, 2**32 - 1), st.tuples(*[st.integers(4, 9)] * 3))
def test_any_field_gives_a_closed_mesh(seed: int, shape: tuple[int, int, int]) -> None:
    level = np.random.default_rng(seed).normal(size=shape)
    level[1, 1, 1] = -1.0
    vertices, faces = contour_mesh(level, np.zeros(3), 0.01)
    mesh = SurfaceMesh(vertices, faces, np.zeros(len(vertices)))
    assert closed(mesh)
    assert mesh.volume_m3 > 0
    assert vertices.min() >= 0
    assert (vertices <= 0.01 * (np.array(shape) - 1)).all()


def test_a_ring_has_one_hole() -> None:
    x, y, z = np.mgrid[-15:16, -15:16, -8:9] * 0.1
    mesh = SurfaceMesh(*contour_mesh(np.hypot(np.hypot(x, y) - 1.0, z) - 0.4, np.zeros(3), 0.1), np.zeros(0))
    assert closed(mesh)
    assert euler_number(mesh) == 0


def test_only_the_largest_piece_is_the_surface() -> None:
    x, y, z = np.mgrid[-10:11, -10:11, -10:31] * 0.1
    level = np.minimum(np.sqrt(x**2 + y**2 + z**2) - 0.7, np.sqrt(x**2 + y**2 + (z - 2.3) ** 2) - 0.4)
    vertices, _ = contour_mesh(level, np.array([-1.0, -1.0, -1.0]), 0.1)
    assert vertices[:, 2].max() < 1.0
    with pytest.raises(InputError, match="nowhere below zero"):
        contour_mesh(np.ones((5, 5, 5)), np.zeros(3), 0.1)


def test_what_was_not_touched_is_known_least() -> None:
    every = ball(n=120)
    low = every.point_m[:, 2] < 0.3 * RADIUS_M
    surface = ImplicitSurface(
        SurfaceContacts(every.point_m[low], every.normal[low], touch=np.asarray(every.touch)[low])
    )
    place, sigma = surface.least_known()
    assert place[2] > 0.8 * RADIUS_M
    away = np.linspace(0.3, 1.0, 5)[:, None] * [0.0, 0.0, RADIUS_M]
    side = np.sqrt(np.maximum(RADIUS_M**2 - away[:, 2:] ** 2, 0)) * [1.0, 0.0, 0.0]
    assert (np.diff(surface.distance(away + side)[1]) > 0).all()
    assert surface.distance([place])[1][0] == pytest.approx(sigma)


def test_a_touch_makes_its_place_better_known() -> None:
    some = ball(n=30)
    before = ImplicitSurface(some)
    place, sigma = before.least_known()
    out = place / np.linalg.norm(place)
    after = ImplicitSurface(
        SurfaceContacts(
            np.vstack([some.point_m, RADIUS_M * out]),
            np.vstack([some.normal, out]),
            touch=[*np.asarray(some.touch), 99],
        )
    )
    assert after.distance([place])[1][0] < sigma


def test_moved_points_give_the_moved_surface() -> None:
    some = ball()
    turn, rise = 0.7, np.array([0.3, -0.2, 0.1])
    axes = np.array([[np.cos(turn), -np.sin(turn), 0], [np.sin(turn), np.cos(turn), 0], [0, 0, 1]])
    moved = SurfaceContacts(some.point_m @ axes.T + rise, some.normal @ axes.T, touch=some.touch)
    places = np.random.default_rng(5).uniform(-0.06, 0.06, (40, 3))
    one, other = ImplicitSurface(some), ImplicitSurface(moved)
    for here, there in zip(one.distance(places), other.distance(places @ axes.T + rise), strict=True):
        np.testing.assert_allclose(here, there, atol=1e-7)


def test_the_order_of_points_says_nothing() -> None:
    some, order = ball(), np.random.default_rng(3).permutation(60)
    mixed = SurfaceContacts(some.point_m[order], some.normal[order], touch=np.asarray(some.touch)[order])
    places = np.random.default_rng(5).uniform(-0.06, 0.06, (40, 3))
    one, other = ImplicitSurface(some), ImplicitSurface(mixed)
    for here, there in zip(one.distance(places), other.distance(places), strict=True):
        np.testing.assert_allclose(here, there, atol=1e-9)


def test_the_band_holds_what_it_says() -> None:
    held = []
    for seed in range(6):
        surface = ImplicitSurface(ball(seed, n=36))
        out = np.random.default_rng(100 + seed).normal(size=(200, 3))
        distance, sigma = surface.distance(RADIUS_M * out / np.linalg.norm(out, axis=1, keepdims=True))
        held.append(np.mean(np.abs(distance) <= 1.645 * sigma))
    assert np.mean(held) > 0.85


def test_covariance_with_itself_is_the_variance() -> None:
    surface = ImplicitSurface(ball())
    places = np.random.default_rng(2).uniform(-0.05, 0.05, (40, 3))
    together = surface.covariance(places, places)
    np.testing.assert_allclose(together, together.T, atol=1e-12)
    mean, sigma = surface.distance(places)
    own = np.hypot(np.sqrt(np.diag(together)), surface.floor_m)
    # That of the distance itself is cut at the bound, and more where all points are far: elsewhere it is the same.
    away = np.linalg.norm(places[:, None] - surface.contacts.point_m, axis=2).min(axis=1)
    near = away < 0.025
    free = near & (away - np.abs(mean) > 4 * own)
    assert free.sum() >= 15
    np.testing.assert_allclose(own[free], sigma[free], rtol=1e-3, atol=1e-7)
    assert (sigma[near] <= own[near] * (1 + 1e-4)).all()


def test_a_point_that_all_others_belie_does_not_count() -> None:
    some = ball()
    points = some.point_m.copy()
    points[7] *= 0.4
    surface = ImplicitSurface(SurfaceContacts(points, some.normal, touch=some.touch))
    assert 7 not in surface.kept
    assert len(surface.kept) >= 55
    off = np.linalg.norm(surface.mesh(steps=20).vertices_m, axis=1) - RADIUS_M
    assert np.abs(off).mean() < 2 * NOISE_M


def test_a_free_place_is_outside() -> None:
    every = ball(n=120)
    low = every.point_m[:, 2] < 0.2 * RADIUS_M
    points, normals = every.point_m[low], every.normal[low]
    free = np.array([[0.0, 0.0, 0.9 * RADIUS_M]])
    assert ImplicitSurface(SurfaceContacts(points, normals)).distance(free)[0][0] < 0
    assert ImplicitSurface(SurfaceContacts(points, normals, free_m=free)).distance(free)[0][0] > 0


def bar_points() -> tuple[np.ndarray, np.ndarray]:
    turn, height = (part.ravel() for part in np.meshgrid(np.arange(8) * np.pi / 4, [0.02, 0.05, 0.08, 0.11]))
    normals = np.column_stack([np.cos(turn), np.sin(turn), 0 * turn])
    return 0.03 * normals + height[:, None] * [0.0, 0.0, 1.0], normals


def test_the_top_of_what_stands_is_unknown_until_it_is_touched() -> None:
    points, normals = bar_points()
    blind = ImplicitSurface(SurfaceContacts(points, normals), table_m=0.0)
    (_, _, z), sigma = blind.least_known()
    assert z > 0.1
    assert sigma > 0.01
    up = np.array([0.0, 0.0, 1.0])
    touched = ImplicitSurface(SurfaceContacts(np.vstack([points, 0.14 * up]), np.vstack([normals, up])), table_m=0.0)
    mesh = touched.mesh()
    assert closed(mesh)
    assert touched.least_known(mesh)[1] < 0.5 * sigma
    assert mesh.vertices_m[:, 2].max() == pytest.approx(0.14, abs=0.003)
    assert mesh.vertices_m[:, 2].min() == pytest.approx(0.0, abs=1e-4)
    assert mesh.volume_m3 == pytest.approx(np.pi * 0.03**2 * 0.14, rel=0.08)


def test_plain_bodies_are_found_in_their_own_points() -> None:
    points, normals = bar_points()
    (bar,) = plain_bodies(points, normals, stands=True)
    assert isinstance(bar, Bar)
    np.testing.assert_allclose(bar.numbers_m[:3], [0.0, 0.0, 0.03], atol=1e-12)
    places = np.array([[0.0, 0.0, 0.0], [0.05, 0.0, 0.05], [0.0, 0.0, bar.numbers_m[3] + 0.01]])
    np.testing.assert_allclose(bar.distance(places), [-0.03, 0.02, 0.01], atol=1e-12)
    (round_,) = plain_bodies(points / 0.03 * 0.02, normals, stands=False)
    assert isinstance(round_, Ball)
    some = ball(n=200)
    (round_,) = plain_bodies(some.point_m, some.normal, stands=False)
    np.testing.assert_allclose(round_.numbers_m, [0, 0, 0, RADIUS_M], atol=0.002)
    np.testing.assert_allclose(round_.slope(some.point_m).T, some.point_m / RADIUS_M, atol=0.1)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"point_m": np.zeros((3, 3)), "normal": np.ones((3, 3))}, "needs 4 to 1000 contact points, got 3"),
        ({"point_m": np.zeros((MOST + 1, 3))}, f"needs 4 to 1000 contact points, got {MOST + 1}"),
        ({"point_m": [[0.0, 0.0, np.nan]] * 5}, "point_m must be finite, got .* in row 0"),
        ({"point_m": np.zeros((5, 2))}, r"point_m must have shape \(n, 3\), got \(5, 2\)"),
        ({"point_m": [["a", "b", "c"]] * 5}, "point_m must be numbers"),
        ({"point_m": np.full((5, 3), 40.0)}, "point_m of row 0 is farther than 2 m from the origin; give metres"),
        ({"normal": np.zeros((5, 3))}, "normal of contact point 0 has no length; leave it out"),
        ({"normal": np.ones((4, 3))}, r"normal of 5 contact points must have shape \(5, 3\), got \(4, 3\)"),
        ({"normal": [[np.inf, 0.0, 0.0]] * 5}, "normal must be finite"),
        ({"sigma_m": 0.0}, "sigma_m must be positive and finite, got 0.0"),
        ({"sigma_m": [1.0, 2.0]}, r"sigma_m must be a number or 5 of them, got shape \(2,\)"),
        ({"normal_sigma": np.nan}, "normal_sigma must be positive and finite"),
        ({"touch": [0.5] * 5}, "touch of 5 contact points must be 5 whole numbers"),
        ({"free_m": [[0.0, np.nan, 0.0]]}, "free_m must be finite"),
        ({"free_m": np.zeros((2001, 3))}, "takes up to 2000 free places, got 2001"),
    ],
)
def test_bad_contacts_are_refused_in_one_line(change: dict, said: str) -> None:
    good = {"point_m": ball().point_m[:5], "normal": ball().normal[:5]}
    with pytest.raises(InputError, match=said) as refused:
        SurfaceContacts(**(good | change))
    assert "\n" not in str(refused.value)


def test_a_bad_table_grid_or_place_is_refused() -> None:
    some = ball(n=12)
    for table in (np.nan, 0.5):
        with pytest.raises(InputError, match="table_m must lie below"):
            ImplicitSurface(some, table_m=table)
    surface = ImplicitSurface(some)
    for steps in (7, 121):
        with pytest.raises(InputError, match=r"steps of a surface's grid must lie in 8 \.\. 120"):
            surface.mesh(steps=steps)
    with pytest.raises(InputError, match="places_m must be finite"):
        surface.distance([[0.0, 0.0, np.inf]])


def test_a_file_holds_every_triangle(tmp_path) -> None:
    mesh = ImplicitSurface(ball(n=20)).mesh(steps=10)
    write_stl(tmp_path / "ball.stl", mesh)
    data = (tmp_path / "ball.stl").read_bytes()
    assert data.startswith(b"varishold surface, metres")
    assert int.from_bytes(data[80:84], "little") == len(mesh.faces)
    assert len(data) == 84 + 50 * len(mesh.faces)
    rows = np.frombuffer(data[84:], np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("more", "<u2")]))
    np.testing.assert_allclose(rows["corners"], mesh.vertices_m[mesh.faces], atol=1e-8)
    np.testing.assert_allclose(np.linalg.norm(rows["normal"], axis=1), 1, atol=1e-5)
    with pytest.raises(InputError, match="cannot write here"):
        write_stl(tmp_path / "no" / "ball.stl", mesh)
