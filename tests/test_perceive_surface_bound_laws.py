"""What a surface says far from all that was touched: a signed distance changes by no more than one goes."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

pytest.importorskip("scipy", reason="SciPy is not installed; pip install -e '.[skin]'")

from scipy.stats import truncnorm

from varishold.perceive import ImplicitSurface, SurfaceContacts
from varishold.perceive.distance_bound import DistanceBound, cut_off, depth_behind

BAND = 1.645


def some_faces(
    seed: int, faces: tuple[int, ...], n: int = 45, broad_m: float = 0.06, high_m: float = 0.09
) -> SurfaceContacts:
    """Touch a block from its middle on: its face toward +x (0), and the halves toward +x of those toward +-y (1, 2)."""
    rng = np.random.default_rng(seed)
    face, deep = rng.choice(faces, n), rng.uniform(0.0, broad_m / 2, n)
    side = np.where(face == 1, 1.0, -1.0) * broad_m / 2
    points = np.stack(
        [
            np.where(face == 0, broad_m / 2, deep),
            np.where(face == 0, rng.uniform(-broad_m / 2, broad_m / 2, n), side),
            rng.uniform(0.01, high_m - 0.01, n),
        ],
        axis=1,
    )
    normals = np.array([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, -1.0, 0.0]])[face]
    return SurfaceContacts(
        points + 0.0005 * rng.normal(size=(n, 3)), normals + 0.05 * rng.normal(size=(n, 3)), touch=np.arange(n) // 4
    )


def far_and_near(seed: int, n: int = 400) -> np.ndarray:
    return np.random.default_rng(seed).uniform([-0.25, -0.15, 0.0], [0.1, 0.15, 0.15], (n, 3))


# Normals that are cut off.


@given(st.floats(-0.3, 0.3), st.floats(1e-3, 0.2), st.floats(1e-3, 0.3))
def test_a_normal_that_is_cut_off_has_the_moments_of_one(mean: float, sigma: float, most: float) -> None:
    inside = float(np.clip(mean, -most, most))
    there = truncnorm((-most - inside) / sigma, (most - inside) / sigma, loc=inside, scale=sigma)
    got, deviation = cut_off(np.array([mean]), np.array([sigma]), np.array([most]))
    assert got[0] == pytest.approx(there.mean(), abs=1e-6)
    assert deviation[0] == pytest.approx(there.std(), abs=1e-6)


@given(st.floats(-0.3, 0.3), st.floats(1e-6, 10.0), st.floats(1e-6, 0.3))
def test_a_cut_keeps_the_sign_and_never_widens(mean: float, sigma: float, most: float) -> None:
    (got,), (deviation,) = cut_off(np.array([mean]), np.array([sigma]), np.array([most]))
    assert abs(got) <= min(abs(mean), most) + 1e-12
    assert got * mean >= -1e-12
    assert 0 <= deviation <= min(sigma, most / np.sqrt(3)) * (1 + 1e-6)


def test_a_narrow_normal_stays_and_a_wide_one_lies_evenly() -> None:
    means, most = np.array([0.01, 0.01]), np.array([0.05, 0.05])
    got, deviation = cut_off(means, np.array([0.001, 1e3]), most)
    np.testing.assert_allclose(got, [0.01, 0.0], atol=1e-5)
    np.testing.assert_allclose(deviation, [0.001, 0.05 / np.sqrt(3)], rtol=1e-3)


def test_the_bound_is_the_least_over_all_points() -> None:
    rng = np.random.default_rng(1)
    # More places than are looked at at once.
    points, slack, places = rng.normal(size=(9, 3)), rng.uniform(0, 0.5, 9), rng.normal(size=(2101, 3))
    apart = np.linalg.norm(places[:, None] - points, axis=2)
    away, most = DistanceBound(points, slack).at(places)
    np.testing.assert_allclose(away, apart.min(axis=1))
    np.testing.assert_allclose(most, (apart + slack).min(axis=1))
    assert all(len(each) == 0 for each in DistanceBound(points, slack).at(np.zeros((0, 3))))


@given(st.integers(0, 2**32 - 1), st.floats(-0.1, 0.1))
def test_a_place_behind_a_flat_face_is_as_deep_as_it_is_away_from_it(seed: int, deep: float) -> None:
    rng = np.random.default_rng(seed)
    points = rng.uniform(-0.05, 0.05, (8, 3)) * [0.0, 1.0, 1.0]
    places = rng.uniform(-0.2, 0.2, (5, 3)) * [0.0, 1.0, 1.0] - [deep, 0.0, 0.0]
    got = depth_behind(places, points, np.tile([1.0, 0.0, 0.0], (8, 1)))
    np.testing.assert_allclose(got, max(deep, 0.0), atol=1e-12)


def test_the_nearest_face_tells_how_deep_a_place_is_and_does_so_evenly() -> None:
    points, normals = np.array([[0.0, 0.0, 0.0], [-0.04, 0.04, 0.0]]), np.array([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
    near_one, near_other = depth_behind(np.array([[-0.01, 0.0, 0.0], [-0.04, 0.03, 0.0]]), points, normals)
    assert (near_one, near_other) == (pytest.approx(0.01, rel=1e-3), pytest.approx(0.01, rel=1e-3))
    assert depth_behind(points, points, normals) == pytest.approx([0.0, 0.0], abs=1e-9)
    # More places than are looked at at once, a tenth of a millimetre apart: from one face to the other without a jump.
    line = np.linspace([-0.2, 0.0, 0.0], [0.01, 0.0, 0.0], 2101)
    assert np.abs(np.diff(depth_behind(line, points, normals))).max() < 0.0005
    assert depth_behind(np.zeros((0, 3)), points, normals).shape == (0,)


# Surfaces.


def block_face(seed: int, faces: int, broad_m: float, deep_m: float) -> tuple[SurfaceContacts, np.ndarray]:
    """Touch a block's face toward +x (1), that toward +y too (2); and points of its sides that nobody touched."""
    rng = np.random.default_rng(seed)
    half = np.array([deep_m, broad_m, broad_m]) / 2
    felt, hidden = [], []
    for axis, way, n in ((0, 1, 24), (1, 1, 24 * (faces - 1)), (0, -1, 60), (1, -1, 60)):
        places = rng.uniform(-0.9, 0.9, (n, 3)) * half
        places[:, axis] = way * half[axis]
        (felt if way > 0 else hidden).append((places, way * np.tile(np.eye(3)[axis], (n, 1))))
    points, normals = (np.vstack(each) for each in zip(*felt, strict=True))
    contacts = SurfaceContacts(
        points + 0.0005 * rng.normal(size=points.shape),
        normals + 0.1 * rng.normal(size=points.shape),
        touch=np.arange(len(points)) // 4,
    )
    return contacts, np.vstack([places for places, _ in hidden])


@pytest.mark.parametrize("faces", [1, 2])
@pytest.mark.parametrize(("broad", "deep"), [(0.02, 0.02), (0.06, 0.02), (0.06, 0.06), (0.04, 0.16), (0.12, 0.12)])
@pytest.mark.parametrize("table", [True, False])
def test_behind_the_only_faces_that_were_touched_a_block_may_end_anywhere(
    faces: int, broad: float, deep: float, table: bool
) -> None:
    held, wide = [], []
    for seed in range(2):
        contacts, hidden = block_face(seed, faces, broad, deep)
        surface = ImplicitSurface(contacts, table_m=-broad / 2 if table else None)
        mean, sigma = surface.distance(hidden)
        held.append(np.mean(np.abs(mean) <= BAND * sigma))
        away = np.linalg.norm(hidden[:, None] - contacts.point_m, axis=2).min(axis=1)
        wide.append((sigma / (away + 0.005)).max())
    assert np.mean(held) >= 0.85
    # And yet no wider than what lies open.
    assert max(wide) < 0.9


def test_of_one_flat_face_the_surface_is_as_thick_as_what_a_hand_holds_and_unsure_of_it() -> None:
    contacts, _ = block_face(3, 1, 0.06, 0.06)
    mesh = ImplicitSurface(contacts).mesh()
    back = mesh.vertices_m[:, 0] < mesh.vertices_m[:, 0].min() + 0.01
    assert 0.04 < np.ptp(mesh.vertices_m[:, 0]) < 0.09
    assert mesh.sigma_m[back].min() > 0.015


@pytest.mark.parametrize("table", [0.0, None])
@pytest.mark.parametrize("faces", [(0, 1, 2), (0, 1), (0,), (1, 2)])
def test_no_distance_is_more_than_the_way_to_what_was_touched(faces: tuple[int, ...], table: float | None) -> None:
    surface = ImplicitSurface(some_faces(1, faces), table_m=table)
    points, places = surface.contacts.point_m[surface.kept], far_and_near(2)
    # A point that was touched lies on the surface as far as the process knows.
    process = surface._process
    known = np.hypot(np.sqrt(np.diag(surface.covariance(points, points))), surface.floor_m)
    slack = np.abs(process.mean(points)) + BAND * known
    most = (np.linalg.norm(places[:, None] - points, axis=2) + slack).min(axis=1)
    mean, sigma = surface.distance(places)
    assert (np.abs(mean) <= most + 1e-9).all()
    assert (sigma <= np.hypot(most / np.sqrt(3), surface.floor_m) + 1e-9).all()
    # Which is well.
    assert slack.max() < 0.02


@pytest.mark.parametrize("seed", range(3))
def test_a_distance_hardly_changes_by_more_than_one_goes(seed: int) -> None:
    surface = ImplicitSurface(some_faces(seed, (0, 1, 2)), table_m=0.0)
    places, rng = far_and_near(seed, 2000), np.random.default_rng(seed)
    step = rng.normal(size=places.shape)
    step *= 0.002 / np.linalg.norm(step, axis=1, keepdims=True)
    change = np.abs(surface.distance(places + step)[0] - surface.distance(places)[0])
    assert np.quantile(change, 0.99) <= 1.05 * 0.002


@pytest.mark.parametrize("deep", [0.06, 0.08, 0.1, 0.14])
def test_of_a_side_that_nobody_touched_little_is_claimed(deep: float) -> None:
    # How far a block goes on behind its touched half, nobody can know.
    held = []
    for seed in range(4):
        surface = ImplicitSurface(some_faces(seed, (0, 1, 2)), table_m=0.0)
        rng = np.random.default_rng(100 + seed)
        back = np.column_stack([np.full(60, 0.03 - deep), rng.uniform(-0.03, 0.03, 60), rng.uniform(0.01, 0.08, 60)])
        mean, sigma = surface.distance(back)
        held.append(np.mean(np.abs(mean) <= BAND * sigma))
    assert np.mean(held) >= 0.88


def test_of_a_ball_that_was_touched_on_one_half_the_other_one_is_held() -> None:
    held = []
    for seed in range(4):
        rng = np.random.default_rng(seed)
        out = rng.normal(size=(160, 3))
        out /= np.linalg.norm(out, axis=1, keepdims=True)
        near = out[out[:, 0] > 0][:50]
        points = 0.04 * near + 0.0005 * rng.normal(size=near.shape)
        surface = ImplicitSurface(
            SurfaceContacts(points, near + 0.05 * rng.normal(size=near.shape), touch=np.arange(50) // 5)
        )
        mean, sigma = surface.distance(0.04 * out[out[:, 0] < 0])
        held.append(np.mean(np.abs(mean) <= BAND * sigma))
        # What the rest tells is not thrown away: a ball stays a ball.
        assert sigma.mean() < 0.01
    assert np.mean(held) >= 0.88


def test_where_it_was_touched_the_surface_and_its_band_are_those_of_the_process() -> None:
    surface = ImplicitSurface(some_faces(3, (0, 1, 2)), table_m=0.0)
    rng = np.random.default_rng(4)
    places = np.column_stack([np.full(50, 0.03), rng.uniform(-0.02, 0.02, 50), rng.uniform(0.02, 0.07, 50)])
    mean, sigma = surface.distance(places)
    told = np.hypot(np.sqrt(np.diag(surface.covariance(places, places))), surface.floor_m)
    np.testing.assert_allclose(sigma, told, rtol=0.1)
    np.testing.assert_allclose(mean, surface._process.mean(places), atol=0.0002)


def test_the_bound_moves_no_part_of_the_surface() -> None:
    surface = ImplicitSurface(some_faces(5, (0, 1, 2)), table_m=0.0)
    places = far_and_near(6)
    mean, told = surface.distance(places)[0], surface._process.mean(places)
    assert (np.sign(mean) == np.sign(told)).all()
    assert (np.abs(mean) <= np.abs(told) + 1e-12).all()
    # It does something: the process says of some places more than can be.
    away = np.linalg.norm(places[:, None] - surface.contacts.point_m, axis=2).min(axis=1)
    assert (np.abs(told) > 0.75 * away).any()
    assert np.abs(mean - told).max() > 0.02
