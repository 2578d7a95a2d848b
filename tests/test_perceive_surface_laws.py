"""The parts of a felt surface beside plain sums: bodies, kernels, what is left out, triangles, beliefs far down."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

pytest.importorskip("scipy", reason="SciPy is not installed; pip install -e '.[skin]'")

from scipy.stats import truncnorm

from varishold.errors import InputError
from varishold.perceive import (
    Belief,
    Evidence,
    ImplicitSurface,
    Library,
    SurfaceContacts,
    SurfaceMesh,
    expected_information,
    surface_points,
)
from varishold.perceive import distance_process as process_module
from varishold.perceive import implicit_surface as surface_module
from varishold.perceive.contour_mesh import contour_mesh, write_stl
from varishold.perceive.distance_process import DistanceProcess, Straying, likeliest_process
from varishold.perceive.likelihood import squared_distances
from varishold.perceive.plain_body import Ball, Bar, plain_bodies

BALL = Ball((0.01, -0.02, 0.05, 0.04), (0.005,) * 4)
BAR = Bar((0.01, -0.02, 0.03, 0.1), (0.005, 0.005, 0.005, 0.03))


def directions(n: int, seed: int = 0) -> np.ndarray:
    out = np.random.default_rng(seed).normal(size=(n, 3))
    return out / np.linalg.norm(out, axis=1, keepdims=True)


def lump(n: int, seed: int = 0, touches: int = 6) -> SurfaceContacts:
    """Points of a ball that is dented, with rough normals; some a touch."""
    out, rng = directions(n, seed), np.random.default_rng(seed + 1)
    radius = 0.04 + 0.004 * np.sin(3 * out[:, :1])
    return SurfaceContacts(
        radius * out + [0.0, 0.0, 0.05],
        out + 0.05 * rng.normal(size=(n, 3)),
        sigma_m=rng.uniform(0.0004, 0.001, n),
        normal_sigma=rng.uniform(0.05, 0.2, n),
        touch=np.arange(n) % touches,
    )


# Plain bodies.


def test_distances_of_bodies_are_those_of_geometry() -> None:
    for out in directions(5):
        for off in (-0.04, -0.01, 0.0, 0.03):
            place = np.array([[0.01, -0.02, 0.05]]) + (0.04 + off) * out
            assert BALL.distance(place) == pytest.approx([off], abs=1e-12)
    # Beside, above, round the rim, and inside near the side and near the top.
    for beside, above, far in (
        (0.02, -0.05, 0.02),
        (-0.01, 0.02, 0.02),
        (0.03, 0.04, 0.05),
        (-0.01, -0.05, -0.01),
        (-0.02, -0.005, -0.005),
        (-0.03, -5.0, -0.03),
    ):
        for turn in (0.0, 1.0, 4.0):
            r = 0.03 + beside
            place = np.array([[0.01 + r * math.cos(turn), -0.02 + r * math.sin(turn), 0.1 + above]])
            assert BAR.distance(place) == pytest.approx([far], abs=1e-12)


def test_slopes_and_changes_of_bodies_are_those_of_geometry() -> None:
    out = directions(7)
    places = np.array([0.01, -0.02, 0.05]) + 0.06 * out
    np.testing.assert_allclose(BALL.slope(places), out.T, atol=1e-7)
    np.testing.assert_allclose(BALL.change(places), 0.005 * np.column_stack([-out, -np.ones(7)]), atol=1e-9)
    turn = np.array([0.3, 2.0, 5.0])
    flat = np.column_stack([np.cos(turn), np.sin(turn)])
    side = np.column_stack([0.01 + 0.05 * flat[:, 0], -0.02 + 0.05 * flat[:, 1], [0.0, 0.05, 0.08]])
    zero, one = np.zeros(3), np.ones(3)
    np.testing.assert_allclose(BAR.slope(side), np.column_stack([flat, zero]).T, atol=1e-7)
    np.testing.assert_allclose(BAR.change(side), 0.005 * np.column_stack([-flat, -one, zero]), atol=1e-9)
    top = np.array([[0.01, -0.01, 0.12], [0.02, -0.02, 0.095]])
    np.testing.assert_allclose(BAR.slope(top), [[0, 0], [0, 0], [1, 1]], atol=1e-7)
    np.testing.assert_allclose(BAR.change(top), [[0, 0, 0, -0.03]] * 2, atol=1e-9)
    # How fast the changes change, by longer steps.
    for body in (BALL, BAR):
        steep = body.slope(side, change=True)
        assert steep.shape == (3, 3, 4)
        for k, h in enumerate(1e-4 * np.eye(3)):
            by_hand = (body.change(side + h) - body.change(side - h)) / 2e-4
            np.testing.assert_allclose(steep[k], by_hand, atol=1e-4)


def test_a_box_holds_its_body() -> None:
    np.testing.assert_allclose(BALL.box(), [[-0.03, -0.06, 0.01], [0.05, 0.02, 0.09]])
    np.testing.assert_allclose(BAR.box(), [[-0.02, -0.05, 0.1], [0.04, 0.01, 0.1]])


def round_by_equations(points: np.ndarray, normals: np.ndarray) -> np.ndarray:
    """Middle and radius with p = c + r n, all equations at once."""
    d = points.shape[1]
    rows = np.vstack([np.column_stack([np.eye(d), n]) for n in normals])
    return np.linalg.lstsq(rows, points.ravel(), rcond=None)[0]


def test_bodies_are_fitted_by_least_squares() -> None:
    rng = np.random.default_rng(1)
    normals = directions(12)
    points = 0.03 * normals + [0.1, 0.2, 0.3] + 0.003 * rng.normal(size=(12, 3))
    ball = Ball.fitted(points, normals)
    np.testing.assert_allclose(ball.numbers_m, round_by_equations(points, normals))
    assert ball.sigma_m == (0.005,) * 4
    # A hollow is no body: the thinnest ball is.
    hollow = Ball.fitted(-points, normals)
    assert hollow.numbers_m[3] == 0.002
    np.testing.assert_allclose(hollow.numbers_m[:3], -points.mean(axis=0) - 0.002 * normals.mean(axis=0))


def test_a_body_whose_normals_are_alike_is_as_broad_as_what_a_hand_holds() -> None:
    normals = directions(12)
    points = 0.05 * normals + [0.1, 0.2, 0.3]
    one, other = normals[0], np.cross(normals[0], [0.0, 0.0, 1.0])
    other /= np.linalg.norm(other)
    alike = Ball.fitted(points, np.tile(one, (12, 1)))
    np.testing.assert_allclose(alike.numbers_m, [*(points.mean(axis=0) - 0.03 * one), 0.03])
    # Normals that turn by less than a tenth, their mean square, tell as much of the radius as they turn.
    for turned, radius in ((0.04, 0.038), (0.08, 0.046), (0.1, 0.05), (0.3, 0.05)):
        few = np.sqrt(1 - turned) * one + np.outer([1.0, -1.0] * 6, np.sqrt(turned) * other)
        assert Ball.fitted(0.05 * few, few).numbers_m[3] == pytest.approx(radius)


def leaning(up: list[float]) -> np.ndarray:
    turn = np.arange(len(up)) * 1.3
    flat = np.sqrt(1 - np.square(up))
    return np.column_stack([flat * np.cos(turn), flat * np.sin(turn), up])


def test_a_bar_is_fitted_to_its_sides_and_topped_by_what_looks_up() -> None:
    rng = np.random.default_rng(2)
    # Flat of the first three is more than .7, and of none after them; up is more than .7 from the last but three.
    normals = leaning([0.0, 0.3, -0.71, -0.72, 0.72, 0.75, 0.99])
    points = 0.03 * normals + 0.003 * rng.normal(size=(7, 3)) + [0.1, 0.0, 0.2]
    bar = Bar.fitted(points, normals)
    np.testing.assert_allclose(bar.numbers_m[:3], round_by_equations(points[:3, :2], normals[:3, :2]))
    assert bar.numbers_m[3] == np.median(points[4:, 2])
    assert bar.sigma_m == (0.005,) * 4
    # Two sides are too few.
    few = Bar.fitted(points[1:], normals[1:])
    np.testing.assert_allclose(few.numbers_m[:3], round_by_equations(points[1:, :2], normals[1:, :2]))
    blind = Bar.fitted(points[:4], normals[:4])
    assert blind.numbers_m[3] == points[:4, 2].max() + 0.005
    assert blind.sigma_m == (0.005, 0.005, 0.005, 0.03)
    just = leaning([0.0, 0.1, 0.2, 0.69])
    assert Bar.fitted(points[:4], just).sigma_m[3] == 0.03
    exact = np.array([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.7, 0.0, 0.7]])
    at = Bar.fitted(points[:4], exact)
    assert at.sigma_m[3] == 0.03
    np.testing.assert_allclose(at.numbers_m[:3], round_by_equations(points[:3, :2], exact[:3, :2]))


def test_a_ball_is_tried_for_what_stands_when_its_top_was_touched() -> None:
    points, side = directions(5), leaning([0.0, 0.1, 0.2, 0.3, 0.7])
    top = leaning([0.0, 0.1, 0.2, 0.3, 0.71])
    for normals, stands, kinds in (
        (side, False, [Ball]),
        (top, False, [Ball]),
        (side, True, [Bar]),
        (top, True, [Ball, Bar]),
    ):
        assert [type(body) for body in plain_bodies(points, normals, stands=stands)] == kinds


# Contacts.


def test_contacts_are_taken_up_to_their_bounds() -> None:
    out = directions(1000)
    few = SurfaceContacts(out[:4], 3 * out[:4])
    np.testing.assert_allclose(few.normal, out[:4])
    assert np.asarray(few.sigma_m).tolist() == [0.0005] * 4
    assert np.asarray(few.normal_sigma).tolist() == [0.1] * 4
    assert np.asarray(few.touch).tolist() == [0, 1, 2, 3]
    assert np.asarray(few.free_m).shape == (0, 3)
    assert len(SurfaceContacts(out, out).point_m) == 1000
    assert len(np.asarray(SurfaceContacts(out, out, free_m=np.zeros((2000, 3))).free_m)) == 2000
    far = np.array([[2.0, -2.0, 2.0], [0, 0, 0], [0, 0, 0], [0, 0, 0]])
    assert SurfaceContacts(far, 50 * out[:4], free_m=far).point_m.max() == 2
    each = SurfaceContacts(out[:4], out[:4], [1.0, 2.0, 3.0, 4.0], [0.1, 0.2, 0.3, 0.4], np.array([5, 5, 7, 8], "u1"))
    assert np.asarray(each.sigma_m).tolist() == [1.0, 2.0, 3.0, 4.0]
    assert np.asarray(each.normal_sigma).tolist() == [0.1, 0.2, 0.3, 0.4]
    assert np.asarray(each.touch).tolist() == [5, 5, 7, 8]
    short = np.vstack([out[:3], [[2e-9, 0, 0]]])
    np.testing.assert_allclose(SurfaceContacts(out[:4], short).normal[3], [1, 0, 0])


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"point_m": [[0.0, 0, 0], [0, -2.001, 0], [0, 0, 3], [0, 0, 0]]}, "point_m of row 1 is farther than 2 m"),
        ({"free_m": [[0.0, 0, 0], [0, 0, 2.001]]}, "free_m of row 1 is farther than 2 m"),
        ({"point_m": [[0.0, 0, 0], [0, 0, 0], [0, math.inf, 0], [0, 0, math.nan]]}, r"\[0.0, inf, 0.0\] in row 2"),
        ({"normal": [[1.0, 0, 0], [1, 0, 0], [1e-10, 0, 0], [1, 0, 0]]}, "normal of contact point 2 has no length"),
        ({"sigma_m": [1.0, 2.0, -3.0, 4.0]}, "sigma_m must be positive and finite, got -3.0"),
        ({"normal_sigma": [1.0, 2.0, 3.0, math.inf]}, "normal_sigma must be positive and finite"),
        ({"normal_sigma": 0.0}, "normal_sigma must be positive and finite, got 0.0"),
        ({"touch": [1, 2, 3]}, r"touch of 4 contact points must be 4 whole numbers, got int64 of shape \(3,\)"),
        ({"point_m": [[0.0, 0, 0], [0.0]]}, "point_m must be numbers in an even array"),
        ({"point_m": np.zeros(3)}, r"point_m must have shape \(n, 3\), got \(3,\)"),
        ({"sigma_m": "thick"}, "sigma_m must be numbers in an even array"),
    ],
)
def test_contacts_beyond_their_bounds_are_refused(change: dict[str, Any], said: str) -> None:
    good: dict[str, Any] = {"point_m": directions(4), "normal": directions(4)}
    with pytest.raises(InputError, match=said):
        SurfaceContacts(**(good | change))


# The process, beside one whose slopes are differences of its kernel.


class PlainProcess:
    """The same process: every slope is a difference of values a little apart."""

    step_m = 1e-4

    def __init__(self, contacts: SurfaceContacts, body: Any, shape: Straying, free: np.ndarray) -> None:
        self.body, self.shape = body, shape
        points = contacts.point_m
        both = np.vstack([points, free])
        h = self.step_m
        # Each observation is a sum of values: (weights, places).
        self.told = [((1.0,), (p,)) for p in both]
        self.told += [((0.5 / h, -0.5 / h), (p + h * way, p - h * way)) for way in np.eye(3) for p in points]
        self.y = np.concatenate(
            [
                -body.distance(points),
                0.004 - body.distance(free),
                (contacts.normal.T - body.slope(points)).ravel(),
            ]
        )
        sigmas = [
            np.asarray(contacts.sigma_m),
            np.full(len(free), 0.0005),
            np.tile(np.asarray(contacts.normal_sigma), 3),
        ]
        noise = np.concatenate(sigmas)
        self.k = self.between(self.told, self.told) + np.diag(noise**2)

    def prior(self, one: np.ndarray, other: np.ndarray) -> np.ndarray:
        apart = (one[:, None] - other) / [1.0, 1.0, self.shape.upright]
        r = math.sqrt(5) * np.linalg.norm(apart, axis=-1) / self.shape.length_m
        strays = self.shape.amplitude_m**2 * (1 + r + r**2 / 3) * np.exp(-r)
        return strays + self.body.change(one) @ self.body.change(other).T

    def between(self, some: list[Any], others: list[Any]) -> np.ndarray:
        one, a = self.sums(some)
        other, b = self.sums(others)
        return a @ self.prior(one, other) @ b.T

    @staticmethod
    def sums(told: list[Any]) -> tuple[np.ndarray, np.ndarray]:
        places = np.array([p for _, at in told for p in at])
        weights = np.zeros((len(told), len(places)))
        column = 0
        for row, (by, _) in enumerate(told):
            weights[row, column : column + len(by)] = by
            column += len(by)
        return places, weights

    def tells(self, places: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        here = [((1.0,), (p,)) for p in places]
        across = self.between(here, self.told)
        mean = self.body.distance(places) + across @ np.linalg.solve(self.k, self.y)
        return mean, self.prior(places, places) - across @ np.linalg.solve(self.k, across.T)

    @property
    def evidence(self) -> float:
        return float(-0.5 * self.y @ np.linalg.solve(self.k, self.y) - 0.5 * np.linalg.slogdet(self.k)[1])


FREE = np.array([[0.0, 0.0, 0.088], [0.041, 0.0, 0.05]])


@pytest.mark.parametrize("body", [Ball((0.0, 0.0, 0.05, 0.038), (0.005,) * 4), BAR])
@pytest.mark.parametrize("shape", [Straying(0.03, 0.006, 1.0), Straying(0.05, 0.003, 3.0)])
@pytest.mark.parametrize("free", [FREE, FREE[:0]])
def test_the_process_is_one_whose_slopes_are_differences(body: Any, shape: Straying, free: np.ndarray) -> None:
    contacts = lump(7)
    ours = DistanceProcess(contacts, np.arange(7), body, shape, free if len(free) else None)
    plain = PlainProcess(contacts, body, shape, free)
    places = np.vstack([0.045 * directions(5, 3) + [0.0, 0.0, 0.05], contacts.point_m[:2], [[0.0, 0.0, 0.05]]])
    mean, together = plain.tells(places)
    np.testing.assert_allclose(ours.mean(places), mean, rtol=1e-3, atol=5e-6)
    np.testing.assert_allclose(ours.sigma(places), np.sqrt(np.diag(together)), rtol=5e-3, atol=1e-6)
    np.testing.assert_allclose(ours.covariance(places, places[:3]), together[:, :3], rtol=5e-3, atol=2e-9)
    assert ours.evidence == pytest.approx(plain.evidence, abs=0.05)


def test_places_are_looked_at_in_blocks_that_nobody_sees(monkeypatch: pytest.MonkeyPatch) -> None:
    ours = DistanceProcess(lump(6), np.arange(6), BALL, Straying(0.03, 0.006, 1.0))
    places = 0.05 * directions(9)
    mean, sigma = ours.mean(places), ours.sigma(places)
    monkeypatch.setattr(surface_points, "_BLOCK", 4)
    np.testing.assert_allclose(ours.mean(places), mean)
    np.testing.assert_allclose(ours.sigma(places), sigma)
    assert ours.mean(places[:0]).shape == ours.sigma(places[:0]).shape == (0,)


@pytest.mark.parametrize("touches", [4, 6])
def test_what_is_left_out_is_really_left_out(touches: int) -> None:
    contacts, shape = lump(12, touches=touches), Straying(0.03, 0.006, 1.0)
    some = np.array([11, 0, 1, 2, 3, 4, 5, 6, 7, 9])
    odd = DistanceProcess(contacts, some, BALL, shape).odd(contacts, some)
    touch = np.asarray(contacts.touch)
    for k, point in enumerate(some):
        others = some[touch[some] != touch[point]]
        without = DistanceProcess(contacts, others, BALL, shape)
        at = contacts.point_m[[point]]
        sigma = math.hypot(float(without.sigma(at)[0]), float(np.asarray(contacts.sigma_m)[point]))
        assert odd[k] == pytest.approx(abs(float(without.mean(at)[0])) / sigma, rel=1e-6)
    few = replace(contacts, touch=np.arange(12) % 3)
    assert DistanceProcess(few, some, BALL, shape).odd(few, some).tolist() == [0.0] * 10


@pytest.mark.parametrize("stands", [False, True])
@pytest.mark.parametrize("seed", [0, 3])
def test_the_likeliest_of_all_that_are_tried_is_chosen(stands: bool, seed: int) -> None:
    contacts, some = lump(14, seed), np.arange(2, 14)
    bodies = plain_bodies(contacts.point_m[some], contacts.normal[some], stands=stands)
    tried = [
        DistanceProcess(contacts, some, body, Straying(length, amplitude, upright))
        for body in bodies
        for length in (0.02, 0.035, 0.06, 0.1)
        for amplitude in (0.002, 0.004, 0.008, 0.016)
        for upright in ((1.0, 3.0) if stands else (1.0,))
    ]
    best = max(tried, key=lambda each: each.evidence)
    found = likeliest_process(contacts, some, stands=stands)
    assert (found.body, found.shape) == (best.body, best.shape)
    assert found.evidence == pytest.approx(best.evidence)


def test_the_choice_is_made_on_points_far_apart(monkeypatch: pytest.MonkeyPatch) -> None:
    points = directions(130) * [1.0, 2.0, 3.0]
    assert process_module._spread_out(points, 130).tolist() == list(range(130))
    first = max(range(130), key=lambda k: math.dist(points[k], points.mean(axis=0)))
    chosen = [first]
    while len(chosen) < 20:
        chosen.append(max(range(130), key=lambda k: min(math.dist(points[k], points[j]) for j in chosen)))
    assert process_module._spread_out(points, 20).tolist() == chosen
    made: list[tuple[Any, ...]] = []

    class Noted:
        def __init__(self, contacts: Any, some: np.ndarray, body: Any, shape: Straying) -> None:
            self.body, self.shape, self.evidence = body, shape, -abs(shape.length_m - 0.06) - shape.amplitude_m
            made.append((len(some), type(body), shape))

    monkeypatch.setattr(process_module, "DistanceProcess", Noted)
    contacts = lump(130)
    for stands, bodies, uprights in ((False, (Ball,), (1.0,)), (True, (Ball, Bar), (1.0, 3.0))):
        made.clear()
        likeliest_process(contacts, np.arange(130), stands=stands)
        tried = {
            (120, body, Straying(length, amplitude, upright))
            for body in bodies
            for length in (0.02, 0.035, 0.06, 0.1)
            for amplitude in (0.002, 0.004, 0.008, 0.016)
            for upright in uprights
        }
        assert set(made[:-1]) == tried
        assert len(made) == len(tried) + 1
        assert made[-1] == (130, Ball, Straying(0.06, 0.002, 1.0))


# The surface of it.


def test_the_band_and_the_floor_come_from_what_was_left_out() -> None:
    contacts = lump(24)
    surface = ImplicitSurface(contacts)
    made = likeliest_process(contacts, np.arange(24), stands=False)
    odd = made.odd(contacts, np.arange(24))
    assert surface.kept.tolist() == np.flatnonzero(odd < 5).tolist()
    if len(surface.kept) < 24:
        made = likeliest_process(contacts, surface.kept, stands=False)
        odd = made.odd(contacts, surface.kept)
    assert surface.factor == pytest.approx(1.5 * min(4.0, max(1.0, np.quantile(odd, 0.9) / 1.645)))
    assert surface.floor_m == np.median(np.asarray(contacts.sigma_m))
    places = 0.05 * directions(6) + [0.0, 0.0, 0.05]
    mean, sigma = surface.distance(places)
    expected, wide = bound_to(surface, made, places)
    np.testing.assert_allclose(mean, expected, atol=1e-9)
    np.testing.assert_allclose(sigma, wide, rtol=1e-5)
    np.testing.assert_allclose(
        surface.covariance(places, places[:2]), surface.factor**2 * made.covariance(places, places[:2])
    )


def test_the_surface_is_looked_for_a_little_beyond_what_was_touched() -> None:
    contacts = lump(12)
    hanging = ImplicitSurface(contacts)
    points = np.vstack([contacts.point_m, hanging.body.box()])
    low, high = points.min(axis=0), points.max(axis=0)
    margin = 0.15 * (high - low).max()
    np.testing.assert_allclose(hanging.bounds_m, [low - margin, high + margin])
    standing = ImplicitSurface(contacts, table_m=0.002)
    points = np.vstack([contacts.point_m, standing.body.box()])
    low, high = points.min(axis=0), points.max(axis=0)
    low[2] = 0.002
    margin = 0.15 * (high - low).max()
    np.testing.assert_allclose(standing.bounds_m, [low - margin, high + margin])
    with pytest.raises(InputError, match="table_m must lie below"):
        ImplicitSurface(contacts, table_m=float(contacts.point_m[:, 2].max()))
    # The table's face is known; a little above it, it is not.
    heights = np.array([[0.0, 0.0, z] for z in (0.002, 0.0020999, 0.0021001, 0.04)])
    mesh = SurfaceMesh(heights, np.zeros((0, 3), int), np.array([4.0, 3.0, 2.0, 1.0]))
    place, sigma = standing.least_known(mesh)
    assert (place[2], sigma) == (0.0021001, 2.0)
    assert hanging.least_known(mesh)[1] == 4.0
    cut = ImplicitSurface(contacts, table_m=0.04).mesh(steps=8)
    assert cut.vertices_m[:, 2].min() == pytest.approx(0.04, abs=1e-3)
    mesh = standing.mesh(steps=8)
    assert standing.least_known()[1] == pytest.approx(standing.least_known(standing.mesh(steps=30))[1])
    np.testing.assert_allclose(mesh.sigma_m, standing.distance(mesh.vertices_m)[1])


class Fake:
    """A process that says what it is told to: the distance from a ball about the origin."""

    body, shape = Ball((0.0, 0.0, 0.0, 0.04), (0.005,) * 4), Straying(0.03, 0.006, 1.0)

    def __init__(self, odd: list[float], radius_m: float = 0.04) -> None:
        self._odd, self._radius_m = np.array(odd), radius_m

    def odd(self, contacts: Any, some: np.ndarray) -> np.ndarray:
        return self._odd[some]

    def mean(self, places: np.ndarray) -> np.ndarray:
        return np.linalg.norm(places, axis=1) - self._radius_m

    def sigma(self, places: np.ndarray) -> np.ndarray:
        return np.full(len(places), 0.003)

    def sigma_before(self, places: np.ndarray) -> np.ndarray:
        return np.full(len(places), 0.006)


def bound_to(surface: ImplicitSurface, process: Any, places: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """What a surface says whose process is this one, worked out place by place."""
    points = surface.contacts.point_m[surface.kept]
    normals = surface.contacts.normal[surface.kept]
    one_sided = max(2 * np.linalg.norm(normals.mean(axis=0)) - 1, 0)
    slack = np.abs(process.mean(points))
    slack += 1.645 * np.hypot(surface.factor * process.sigma(points), surface.floor_m)
    told = []
    for place, mean, sigma, before in zip(
        places, process.mean(places), process.sigma(places), process.sigma_before(places), strict=True
    ):
        apart = np.linalg.norm(points - place, axis=1)
        most = (apart + slack).min()
        turned = max(apart.min() - 0.025, 0.0) * sigma / before
        deep = max(np.average(((points - place) * normals).sum(axis=1), weights=np.maximum(apart, 1e-6) ** -8.0), 0.0)
        wide = math.hypot(surface.factor * sigma, 1.5 * max(turned, one_sided * deep))
        middle = min(max(mean, -most), most)
        cut = truncnorm((-most - middle) / wide, (most - middle) / wide, loc=middle, scale=wide)
        told.append((cut.mean(), math.hypot(cut.std(), surface.floor_m)))
    means, sigmas = np.array(told).T
    return means, sigmas


@pytest.mark.parametrize(
    ("odd", "kept", "factor"),
    [
        ([0.0] * 6, [0, 1, 2, 3, 4, 5], 1.0),
        ([4.99, 0.0, 5.0, 0.0, 9.0, 1.0], [0, 1, 3, 5], float(np.quantile([4.99, 0, 0, 1], 0.9)) / 1.645),
        ([3.29] * 6, [0, 1, 2, 3, 4, 5], 2.0),
        # Where fewer than four would be left, all of them count.
        ([9.0, 9.0, 9.0, 0.0, 0.0, 0.0], [0, 1, 2, 3, 4, 5], 4.0),
    ],
)
def test_points_that_others_belie_are_left_out(
    monkeypatch: pytest.MonkeyPatch, odd: list[float], kept: list[int], factor: float
) -> None:
    asked: list[Any] = []

    def likeliest(contacts: Any, some: np.ndarray, *, stands: bool) -> Fake:
        asked.append((some.tolist(), stands))
        return Fake(odd)

    monkeypatch.setattr(surface_module, "likeliest_process", likeliest)
    contacts = SurfaceContacts(0.04 * directions(6), directions(6), sigma_m=[0.001, 0.001, 0.002, 0.004, 0.005, 0.005])
    for table in (None, -0.05):
        asked.clear()
        surface = ImplicitSurface(contacts, table_m=table)
        assert surface.kept.tolist() == kept
        every = [(list(range(6)), table is not None)]
        assert asked == every + [(kept, table is not None)] * (len(kept) < 6)
        assert surface.factor == pytest.approx(1.5 * factor)
        assert surface.floor_m == 0.003
        place = np.array([[0.0, 0.0, 0.05]])
        for told, expected in zip(surface.distance(place), bound_to(surface, Fake(odd), place), strict=True):
            np.testing.assert_allclose(told, expected, rtol=1e-5)


def test_free_places_that_the_surface_holds_are_told_to_it_twice_at_most(monkeypatch: pytest.MonkeyPatch) -> None:
    free = np.array([[0.0, 0.0, z] for z in (0.01, 0.02, 0.03, 0.05)])
    contacts = SurfaceContacts(0.04 * directions(6), directions(6), free_m=free)
    monkeypatch.setattr(surface_module, "likeliest_process", lambda *_, **__: Fake([0.0] * 6))
    for radii, told in (
        ((0.005, 0.0), [[0.01, 0.02, 0.03]]),
        ((0.025, 0.005, 0.0), [[0.01, 0.02, 0.03], [0.01, 0.02]]),
        ((0.025, 0.025, 0.025), [[0.01, 0.02, 0.03], [0.01, 0.02]]),
    ):
        given: list[Any] = []
        left = list(radii)

        def again(
            c: Any, some: Any, body: Any, shape: Any, taken: Any, given: list[Any] = given, left: list[float] = left
        ) -> Fake:
            assert (c, some.tolist(), body, shape) == (contacts, list(range(6)), Fake.body, Fake.shape)
            given.append(taken[:, 2].tolist())
            return Fake([0.0] * 6, left.pop(0))

        monkeypatch.setattr(surface_module, "DistanceProcess", again)
        surface = ImplicitSurface(contacts)
        assert given == told
        place, last = np.array([[0.0, 0.0, 0.05]]), Fake([0.0] * 6, radii[len(told) - 1])
        np.testing.assert_allclose(surface.distance(place)[0], bound_to(surface, last, place)[0], rtol=1e-5)


@pytest.mark.parametrize("table", [None, -0.02])
def test_the_mesh_is_that_of_a_grid_with_so_many_steps(monkeypatch: pytest.MonkeyPatch, table: float | None) -> None:
    monkeypatch.setattr(surface_module, "likeliest_process", lambda *_, **__: Fake([0.0] * 6))
    contacts = SurfaceContacts([[0.03, 0, 0], [-0.04, 0, 0], [0, 0.05, 0], [0, 0, 0.01]] * 2, [[0.0, 0, 1]] * 8)
    monkeypatch.setattr(surface_module, "likeliest_process", lambda *_, **__: Fake([0.0] * 8))
    surface = ImplicitSurface(contacts, table_m=table)
    low, high = surface.bounds_m
    for steps, mesh in ((8, surface.mesh(steps=8)), (30, surface.mesh())):
        pitch = float(max(high - low)) / steps
        ways = [a + pitch * np.arange(math.ceil((b - a) / pitch) + 1) for a, b in zip(low, high, strict=True)]
        places = np.stack(np.meshgrid(*ways, indexing="ij"), axis=-1)
        level = np.linalg.norm(places, axis=-1) - 0.04
        if table is not None:
            level = np.maximum(level, table - places[..., 2])
        vertices, faces = contour_mesh(level, low, pitch)
        np.testing.assert_allclose(mesh.vertices_m, vertices, atol=1e-12)
        np.testing.assert_array_equal(mesh.faces, faces)
        np.testing.assert_allclose(mesh.sigma_m, bound_to(surface, Fake([0.0] * 8), mesh.vertices_m)[1], rtol=1e-5)


# Triangles.


def grid(n: int, pitch: float) -> np.ndarray:
    return pitch * (np.stack(np.meshgrid(*[np.arange(n)] * 3, indexing="ij"), axis=-1) - (n - 1) / 2)


def test_a_ball_of_triangles_has_its_volume_and_area() -> None:
    pitch, radius = 0.005, 0.04
    level = np.linalg.norm(grid(23, pitch), axis=-1) - radius
    first = np.array([1.0, 2.0, 3.0]) - 11 * pitch
    mesh = SurfaceMesh(*contour_mesh(level, first, pitch), np.zeros(0))
    off = np.linalg.norm(mesh.vertices_m - [1.0, 2.0, 3.0], axis=1) - radius
    # A chord as long as a cube's diagonal is so far off the ball.
    assert np.abs(off).max() < 3 * pitch**2 / (8 * radius)
    assert mesh.volume_m3 == pytest.approx(4 / 3 * math.pi * radius**3, rel=0.02)
    assert mesh.vertex_areas_m2.sum() == pytest.approx(4 * math.pi * radius**2, rel=0.02)
    np.testing.assert_allclose(
        mesh.vertex_normals, (mesh.vertices_m - [1.0, 2.0, 3.0]) / (radius + off)[:, None], atol=0.35
    )
    np.testing.assert_allclose(mesh.face_normals.sum(axis=0), 0, atol=1e-12)
    assert len(np.unique(mesh.faces)) == len(mesh.vertices_m)


@pytest.mark.parametrize("way", [(1.0, 0.0, 0.0), (0.3, -0.5, 0.8), (-0.6, 0.7, 0.2)])
def test_a_slanted_plane_stays_plane(way: tuple[float, float, float]) -> None:
    pitch = 0.01
    places = grid(11, pitch)
    level = places @ np.array(way) - 0.0037
    vertices, faces = contour_mesh(level, places[0, 0, 0], pitch)
    inner = (np.abs(vertices) < 3.9 * pitch).all(axis=1)
    assert inner.sum() > 20
    np.testing.assert_allclose(vertices[inner] @ np.array(way), 0.0037, atol=0.012 * pitch)
    flat = inner[faces].all(axis=1)
    normals = SurfaceMesh(vertices, faces, np.zeros(0)).face_normals[flat]
    steep = normals @ np.array(way) / np.linalg.norm(normals, axis=1)
    # Narrow triangles about a corner may lie askew; none looks inward.
    assert (steep > 0).all()
    assert np.median(steep) == pytest.approx(np.linalg.norm(way))


def test_the_border_is_outside_and_corners_are_passed_by_a_little() -> None:
    pitch, first = 0.01, np.array([1.0, 2.0, 3.0])
    vertices, _ = contour_mesh(np.full((5, 6, 7), -pitch), first, pitch)
    np.testing.assert_allclose(vertices.min(axis=0), first + 0.5 * pitch)
    np.testing.assert_allclose(vertices.max(axis=0), first + pitch * (np.array([4, 5, 6]) - 0.5))
    vertices, _ = contour_mesh(np.full((5, 5, 5), -1e-9), first, pitch)
    np.testing.assert_allclose(vertices.min(axis=0), first + 0.99 * pitch)
    level = np.full((5, 5, 5), -3 * pitch)
    level[0] = 9 * pitch
    level[-1] = 1e-9
    vertices, _ = contour_mesh(level, first, pitch)
    np.testing.assert_allclose(vertices[:, 0].min(), first[0] + 0.75 * pitch)
    np.testing.assert_allclose(vertices[:, 0].max(), first[0] + 3.75 * pitch)
    # Nothing on the border is changed in the caller's field.
    assert level[-1].max() == 1e-9
    touching = np.ones((5, 5, 5))
    touching[2, 2, 2] = 0.0
    with pytest.raises(InputError, match="nowhere below zero"):
        contour_mesh(touching, first, pitch)
    outside = np.full((5, 5, 5), 1.0)
    outside[0, 2, 2] = -1.0
    with pytest.raises(InputError, match="nowhere below zero"):
        contour_mesh(outside, first, pitch)


def test_a_corner_of_a_cube_measures_what_it_should() -> None:
    vertices = np.array([[0.0, 0, 0], [2, 0, 0], [0, 2, 0], [0, 0, 2], [9, 9, 9]])
    mesh = SurfaceMesh(vertices, np.array([[0, 2, 1], [0, 3, 2], [0, 1, 3], [1, 2, 3]]), np.zeros(5))
    assert mesh.volume_m3 == pytest.approx(8 / 6)
    np.testing.assert_allclose(mesh.face_normals, [[0, 0, -4], [-4, 0, 0], [0, -4, 0], [4, 4, 4]])
    slant = math.sqrt(48) / 2
    np.testing.assert_allclose(mesh.vertex_areas_m2, [2, *[(4 + slant) / 3] * 3, 0])
    third = 1 / math.sqrt(3)
    np.testing.assert_allclose(
        mesh.vertex_normals, [[-third] * 3, [1, 0, 0], [0, 1, 0], [0, 0, 1], [0, 0, 0]], atol=1e-12
    )


def test_a_file_holds_normals_corners_and_an_empty_rest(tmp_path: Path) -> None:
    vertices = np.array([[0.0, 0, 0], [2, 0, 0], [0, 2, 0], [0, 0, 2]])
    # The last triangle is nothing: it has no normal.
    mesh = SurfaceMesh(vertices, np.array([[0, 2, 1], [1, 2, 3], [0, 1, 1]]), np.zeros(4))
    write_stl(tmp_path / "corner.stl", mesh)
    data = (tmp_path / "corner.stl").read_bytes()
    assert data[:80] == b"varishold surface, metres".ljust(80)
    assert data[80:84] == b"\x03\x00\x00\x00"
    rows = np.frombuffer(data[84:], np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("more", "<u2")]))
    np.testing.assert_allclose(rows["normal"], [[0, 0, -1], [3**-0.5] * 3, [0, 0, 0]], atol=1e-6)
    np.testing.assert_array_equal(rows["corners"], vertices[mesh.faces])
    assert rows["more"].tolist() == [0, 0, 0]


# Beliefs.


def small_library() -> Library:
    rng = np.random.default_rng(4)
    sizes = {name: rng.uniform(0.05, 0.1, 12).tolist() for name in ("ball", "box")}

    def example(at: float, size: float) -> list[Evidence]:
        x, y = rng.normal(at, 0.5, 2)
        return [Evidence("grip", {"form.x": x, "form.y": y, "size.circle": math.log(size) + rng.normal(0, 0.04)})]

    return Library.from_examples(
        {name: [example(at, size) for size in sizes[name]] for name, at in (("ball", 0.0), ("box", 1.0))},
        sizes_m=sizes,
    )


@pytest.mark.parametrize("far", [-1e5, -900.0, 900.0, 1e5])
def test_how_likely_all_was_together_says_nothing_of_the_shares(far: float) -> None:
    library = small_library()
    belief = Belief.before(library).after(
        Evidence("grip", {"form.x": 0.3, "form.y": 0.4, "size.circle": math.log(0.07)})
    )
    moved = replace(belief, log_weight=belief.log_weight + far)
    np.testing.assert_allclose(moved.particles, belief.particles, rtol=1e-6)
    assert moved.probability == pytest.approx(belief.probability, rel=1e-6)
    assert moved.size("ball") == pytest.approx(belief.size("ball"))
    assert moved.particles.sum() == pytest.approx(1.0)
    sized = replace(belief, size_table=belief.size_table + far)
    np.testing.assert_allclose(sized.particles, belief.particles, rtol=1e-6)


def entropy(p: np.ndarray) -> float:
    return -sum(x * math.log(x) for x in p if x > 0)


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("fails", [False, True])
def test_expected_information_is_that_of_plain_sums(seed: int, fails: bool) -> None:
    rng = np.random.default_rng(seed)
    n, names = 21, 3
    owner = np.arange(n) % names
    white = (rng.normal(size=(n, 2)) + owner[:, None]).astype(np.float32)
    failed, made = np.zeros(n, bool), np.ones(n, bool)
    failed[:5], made[:5] = fails, not fails
    chance = np.where(failed, 0.9, 0.1) if fails else np.zeros(n)

    def kernel(squares: np.ndarray, known: int) -> np.ndarray:
        assert known == 2
        return -2 * squares - 800

    model = SimpleNamespace(
        failed=failed, made=made, white=white, kernel=kernel, log_success=lambda _, *, failed: np.log(chance)
    )
    particles = rng.dirichlet(np.full(n, 0.8))
    library = SimpleNamespace(touches={"grip": model}, owner=owner, kind=owner, objects=("a", "b", "c"))
    belief: Any = SimpleNamespace(library=_Sized(library, n), particles=particles, here={})

    of_name = [particles[owner == k].sum() for k in range(names)]
    lost = [float((particles * chance)[owner == k].sum()) for k in range(names)]
    stands = np.where(made, particles * (1 - chance), 0.0)
    for k in range(names):
        stands[owner == k] *= (of_name[k] - lost[k]) / stands[owner == k].sum()
    share = stands / stands.sum()
    order = [k for k in np.argsort(-share, kind="stable") if share[k] > 0]
    ends = np.cumsum(share[order])
    left = 0.0
    for outcome in range(48):
        at = next(k for k, end in zip(order, ends, strict=True) if end >= (outcome + 0.5) / 48)
        felt = np.exp(-2 * ((white - white[at]) ** 2).sum(axis=1))
        felt[at] = 0.0
        after = np.zeros(names)
        for k in range(names):
            others = [j for j in range(n) if owner[j] == k and j != at]
            mass = share[others].sum()
            after[k] = share[owner == k].sum() * (share[others] * felt[others]).sum() / mass if mass > 0 else 0.0
        left += entropy(after / after.sum()) / 48
    p_failed = sum(lost)
    left = (1 - p_failed) * left + (p_failed * entropy(np.array(lost) / p_failed) if fails else 0.0)
    expected = max(0.0, entropy(np.array(of_name)) - left)
    assert expected_information(belief, "grip") == pytest.approx(expected, rel=1e-4, abs=1e-6)
    assert squared_distances(white[:1], white[1:2])[0, 0] == pytest.approx(((white[0] - white[1]) ** 2).sum(), rel=1e-5)


class _Sized:
    """A library that has a length."""

    def __init__(self, of: Any, n: int) -> None:
        self._of, self._n = of, n

    def __len__(self) -> int:
        return self._n

    def __getattr__(self, name: str) -> Any:
        return getattr(self._of, name)
