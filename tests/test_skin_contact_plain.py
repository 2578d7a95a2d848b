"""Contact beside plain linear algebra: dense matrices, non-negative least squares, sampled faces, known force laws."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.optimize import nnls

from varishold.errors import InputError, NotConvergedError
from varishold.skin import Skin, press
from varishold.skin import contact as contacts
from varishold.skin import pressing as presses
from varishold.skin.contact import Contact, contact_box, solve_contact
from varishold.skin.face import Face, face_of_map, face_of_solid
from varishold.skin.media import Cells, Medium, medium_of
from varishold.skin.nonnegative import solve_nonnegative
from varishold.solids import Cone, Cylinder, Plane, Pose, Solid, Sphere, SquarePillar, Torus

Floats = NDArray[np.float64]

SKINS = {
    "layer": Skin("layer", 6e-3, 0.45),
    "incompressible": Skin("layer", 1.5e-3, 0.5),
    "half-space": Skin("half-space"),
    "winkler": Skin("winkler", 6e-3, 0.3),
}


def _matrix(medium: Medium, cells: Cells) -> Floats:
    kernel = medium.influence(cells)
    i, j = (each.ravel() for each in np.indices((cells.rows, cells.cols)))
    out: Floats = kernel[np.abs(np.subtract.outer(i, i)), np.abs(np.subtract.outer(j, j))]
    return out


def _spring(kind: str, loaded: Floats, own: float) -> Floats:
    part = np.where((loaded > 0) & (loaded < 1), loaded, 1.0)
    return own * (1 / part - 1 if kind == "winkler" else 1 / np.sqrt(part) - 1)


def _plainly(face: Face, skin: Skin, cells: Cells, depth: float) -> tuple[Floats, Floats, Floats]:
    """Pressure, displacement and gap: the minimum over p >= 0 of p'(G + S)p / 2 - p'w as least squares."""
    matrix = _matrix(medium_of(skin), cells)
    spring = _spring(skin.kind, face.loaded.ravel(), matrix[0, 0])
    wanted = np.where(np.isfinite(face.below_top_m), depth - face.below_top_m, -100 * depth).ravel()
    wanted = np.maximum(wanted, -100 * depth)
    root = np.linalg.cholesky(matrix + np.diag(spring))
    pressure = nnls(root.T, np.linalg.solve(root, wanted))[0]
    displacement = matrix @ pressure
    gap = np.where(wanted > -100 * depth, displacement + spring * pressure - wanted, np.inf)
    shape = (cells.rows, cells.cols)
    return pressure.reshape(shape), displacement.reshape(shape), gap.reshape(shape)


@pytest.mark.parametrize("name", SKINS)
@pytest.mark.parametrize(
    "solid", [Sphere(16e-3), Cylinder(7e-3, 4e-3), Cone(9e-3, 3e-3), Torus(8e-3, 2e-3), Plane(4e-3)]
)
def test_a_contact_is_the_least_energy_of_a_dense_matrix(solid: Solid, name: str) -> None:
    skin, cells, depth = SKINS[name], Cells(18, 15, 0.7e-3, 0.8e-3), 0.6e-3
    face = face_of_solid(solid, cells, Pose(0.3e-3, -0.4e-3, 0.2), depth)
    pressure, displacement, gap = _plainly(face, skin, cells, depth)
    made = solve_contact(face, skin, cells, depth, 1e-8, 2000)
    np.testing.assert_allclose(made.pressure, pressure, atol=1e-5 * pressure.max())
    np.testing.assert_allclose(made.displacement_m, displacement, atol=1e-6 * depth)
    np.testing.assert_allclose(made.gap_m, gap, atol=1e-6 * depth)
    # What it says of itself is so.
    open_ = (made.pressure > 0) | (made.gap_m < 0)
    assert made.rms_gap == pytest.approx(np.sqrt(np.mean(made.gap_m[open_] ** 2)) / depth, rel=1e-6)
    assert made.rms_gap <= 1e-8
    # Begun from another contact it ends in the same.
    start = np.roll(made.pressure, 3, axis=1)
    again = solve_contact(face, skin, cells, depth, 1e-8, 2000, start)
    np.testing.assert_allclose(again.pressure, pressure, atol=1e-5 * pressure.max())
    # Single precision is near, and counts its steps.
    rough = solve_contact(face, skin, cells, depth, 1e-4, 2000)
    np.testing.assert_allclose(rough.pressure, pressure, atol=0.02 * pressure.max())
    assert rough.rms_gap <= 1e-4
    assert 0 < rough.iterations <= made.iterations
    assert rough.pressure.dtype == rough.displacement_m.dtype == np.float64


@pytest.mark.parametrize("above_m", [1e-6, 20e-6])
def test_a_skin_that_bulges_meets_a_brim_above_it(above_m: float) -> None:
    """What is not to be pressed touches all the same, where the skin is driven up beside the pin."""
    skin, cells, depth = SKINS["incompressible"], Cells(26, 24, 0.5e-3, 0.5e-3), 0.5e-3
    y, x = np.mgrid[:26, :24]
    height = np.where(np.hypot(y - 12.5, x - 11.5) < 4, depth + above_m, 0.0)
    face = face_of_map(height, cells)
    pressure, _, gap = _plainly(face, skin, cells, depth)
    assert (pressure[height == 0] > 0).any()
    made = solve_contact(face, skin, cells, depth, 1e-7, 3000)
    np.testing.assert_allclose(made.pressure, pressure, atol=1e-4 * pressure.max())
    np.testing.assert_allclose(made.gap_m, gap, atol=1e-5 * depth)
    assert made.rms_gap <= 1e-7


def test_what_lies_nowhere_near_is_told() -> None:
    cells = Cells(8, 8, 1e-3, 1e-3)
    far = Face(np.full((8, 8), 2e-3), np.ones((8, 8)), 5e-3)
    with pytest.raises(InputError, match=r"nothing touches at a depth of 0\.001 m"):
        solve_contact(far, SKINS["layer"], cells, 1e-3, 1e-5, 100)


@pytest.mark.parametrize("name", SKINS)
def test_a_coarser_grid_saves_steps_and_changes_nothing(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    cells, depth = Cells(64, 48, 0.25e-3, 0.3e-3), 0.5e-3
    with_it, without = 0, 0
    for solid in (Sphere(30e-3), SquarePillar(9e-3, 4e-3), Cone(12e-3, 1e-3)):
        face = face_of_solid(solid, cells, Pose(0.1e-3, 0.0, 0.3), depth)
        monkeypatch.setattr(contacts, "_SMALLEST_COARSE", 24)
        quick = solve_contact(face, SKINS[name], cells, depth, 1e-6, 400)
        monkeypatch.setattr(contacts, "_SMALLEST_COARSE", 10**9)
        slow = solve_contact(face, SKINS[name], cells, depth, 1e-6, 400)
        np.testing.assert_allclose(quick.pressure, slow.pressure, atol=2e-3 * slow.pressure.max())
        with_it, without = with_it + quick.iterations, without + slow.iterations
    assert with_it <= {"layer": 18, "incompressible": 22, "half-space": 22, "winkler": 3}[name]
    assert with_it < without or name == "winkler"


@given(st.integers(3, 40), st.integers(3, 40), st.data())
@settings(max_examples=60)
def test_a_box_holds_all_marks_with_a_cell_to_spare(rows: int, cols: int, data: st.DataObject) -> None:
    inside = np.zeros((rows, cols), dtype=bool)
    for _ in range(data.draw(st.integers(1, 3))):
        inside[data.draw(st.integers(0, rows - 1)), data.draw(st.integers(0, cols - 1))] = True
    for part, length, marks in zip(contact_box(inside), (rows, cols), np.nonzero(inside), strict=True):
        low, high = max(int(marks.min()) - 1, 0), min(int(marks.max()) + 2, length)
        assert 0 <= part.start <= low
        assert high <= part.stop <= length
        # As small as steps of eight cells allow, and begun where the marks begin unless the field ends.
        assert part.stop - part.start == min(8 * math.ceil((high - low) / 8), length)
        assert part.start == low or part.stop == length


# The solver


def _quadratic(seed: int, n: int, values: Floats) -> tuple[Floats, Floats]:
    rng = np.random.default_rng(seed)
    turn = np.linalg.qr(rng.normal(size=(n, n)))[0]
    return (turn * values) @ turn.T, rng.normal(size=n)


@settings(max_examples=20)
@given(st.integers(0, 2**31))
def test_a_minimum_is_that_of_non_negative_least_squares(seed: int) -> None:
    matrix, b = _quadratic(seed, 14, np.geomspace(0.2, 8, 14))
    root = np.linalg.cholesky(matrix)
    told = nnls(root.T, np.linalg.solve(root, b))[0]
    made = solve_nonnegative(
        lambda x: matrix @ x, lambda r: r / np.diag(matrix), b, np.ones(14), tolerance=1e-10, max_iterations=2000
    )
    np.testing.assert_allclose(made.x, told, atol=1e-8)
    np.testing.assert_allclose(made.gradient, matrix @ made.x - b, atol=1e-9)
    free = (made.x > 0) | (made.gradient < 0)
    assert made.rms == pytest.approx(np.sqrt(np.mean(made.gradient[free] ** 2)), rel=1e-3, abs=1e-14)
    # Where it starts on the answer it takes no step.
    again = solve_nonnegative(
        lambda x: matrix @ x, lambda r: r, b, made.x, tolerance=2 * made.rms + 1e-12, max_iterations=5
    )
    assert (again.iterations, again.converged) == (0, True)


@settings(max_examples=20)
@given(st.integers(0, 2**31), st.integers(1, 6))
def test_conjugate_gradients_end_after_a_step_for_each_value(seed: int, different: int) -> None:
    """A matrix with so many different eigenvalues, and an answer that nowhere is cut at zero."""
    matrix, _ = _quadratic(seed, 12, np.resize(np.geomspace(1, 20, different), 12))
    answer = np.random.default_rng(seed).uniform(50, 51, 12)
    b = matrix @ answer
    start = answer + np.random.default_rng(seed + 1).uniform(-1, 1, 12)
    made = solve_nonnegative(lambda x: matrix @ x, lambda r: r, b, start, tolerance=1e-8, max_iterations=50)
    assert made.iterations <= different
    np.testing.assert_allclose(made.x, answer, rtol=1e-8)
    # With its own inverse before it one step is enough; with one that leads astray it still gets there.
    inverse = np.linalg.inv(matrix)
    once = solve_nonnegative(lambda x: matrix @ x, lambda r: inverse @ r, b, start, tolerance=1e-8, max_iterations=50)
    assert once.iterations <= 1
    astray = solve_nonnegative(lambda x: matrix @ x, lambda r: -r, b, start, tolerance=1e-8, max_iterations=50)
    assert astray.converged


# Faces


@pytest.mark.parametrize("pose", [Pose(), Pose(0.2e-3, -0.3e-3, 0.4), Pose(0.5e-3, 0.0, 0.0, 0.05, -0.02)])
def test_a_smooth_face_is_the_mean_over_each_cell(pose: Pose) -> None:
    cells, solid, n = Cells(10, 12, 0.5e-3, 0.4e-3), Sphere(40e-3), 20
    face = face_of_solid(solid, cells, pose, 2e-3)
    y = ((np.arange(10 * n) + 0.5) / n - 5)[:, None] * 0.5e-3
    x = ((np.arange(12 * n) + 0.5) / n - 6)[None, :] * 0.4e-3
    mean = solid.placed(x, y, pose).reshape(10, n, 12, n).mean(axis=(1, 3))
    np.testing.assert_allclose(face.below_top_m, face.top_m - mean, atol=2e-8)
    assert (face.loaded == 1).all()


def _cells_by_hand(solid: Solid, cells: Cells, pose: Pose, depth: float) -> tuple[Floats, Floats]:
    """Loaded share and mean height of each cell that a wall crosses, nan elsewhere."""
    share, mean = np.full((2, cells.rows, cells.cols), np.nan)
    for i in range(cells.rows):
        for j in range(cells.cols):

            def at(u: float, v: float, i: int = i, j: int = j) -> float:
                y, x = (i + u - cells.rows / 2) * cells.row_m, (j + v - cells.cols / 2) * cells.col_m
                return float(solid.placed(np.array([x]), np.array([y]), pose)[0])

            seen = [at(u, v) for u, v in ((0, 0), (0, 1), (1, 0), (1, 1), (0.5, 0.5))]
            if max(seen) - min(seen) > depth / 2:
                fine = np.array([at((2 * k + 1) / 12, (2 * m + 1) / 12) for k in range(6) for m in range(6)])
                upper = fine[(fine > 0) & (fine >= fine.max() - depth / 2)]
                share[i, j] = len(upper) / 36
                mean[i, j] = upper.mean() if len(upper) else 0.0
    return share, mean


@pytest.mark.parametrize("solid", [Cylinder(5e-3, 3e-3), SquarePillar(4e-3, 1e-3), Cone(5e-3, 4e-3), Torus(4e-3, 2e-3)])
def test_a_cell_that_a_wall_crosses_counts_its_upper_part(solid: Solid) -> None:
    cells, depth = Cells(13, 16, 0.5e-3, 0.45e-3), min(1e-3, 0.9 * solid.top_m)
    for pose in (Pose(), Pose(0.1e-3, 0.2e-3, 0.3)):
        face = face_of_solid(solid, cells, pose, depth)
        share, mean = _cells_by_hand(solid, cells, pose, depth)
        high = np.isfinite(share) & (mean > face.top_m - depth)
        assert high.sum() > 3
        np.testing.assert_allclose(face.loaded[high], share[high])
        np.testing.assert_allclose(face.below_top_m[high], face.top_m - mean[high], atol=1e-12)
        assert np.isinf(face.below_top_m[face.loaded == 0]).all()
        assert np.isfinite(face.below_top_m[face.loaded > 0]).all()
        whole = np.isnan(share)
        assert np.isin(face.loaded[whole], (0.0, 1.0)).all()
    assert solid.top_m == pytest.approx(face_of_solid(solid, cells, Pose(), depth).top_m, rel=0.05)


def test_a_slope_of_half_the_depth_in_a_cell_is_no_wall() -> None:
    cells = Cells(9, 9, 1e-3, 1e-3)
    for depth, wall in ((2e-3, False), (1.9e-3, True)):
        face = face_of_solid(Cylinder(5e-3, 1e-3), cells, Pose(), depth)
        assert ((face.loaded > 0) & (face.loaded < 1)).any() == wall


def test_what_lies_two_depths_down_is_sampled_no_finer() -> None:
    """Steep flanks that the press never reaches count as they are met in the middle."""
    cells = Cells(16, 16, 0.5e-3, 0.5e-3)
    face = face_of_solid(Cone(7e-3, 7e-3), cells, Pose(), 0.4e-3)
    down = face.below_top_m > 3 * 0.4e-3
    assert np.isin(face.loaded[down & np.isfinite(face.below_top_m)], (0.0, 1.0)).all()
    assert (face.loaded[~down] > 0).all()


def test_the_highest_point_counts_though_it_lies_between_samples() -> None:
    cells, cone = Cells(8, 8, 1e-3, 1e-3), Cone(6e-3, 3e-3)
    assert face_of_solid(cone, cells, Pose(0.3e-3, 0.2e-3), 1e-3).top_m == pytest.approx(3e-3, rel=1e-12)
    assert face_of_solid(cone, cells, Pose(4e-3, 0.25e-3), 1e-3).top_m == pytest.approx(3e-3, rel=1e-12)
    assert face_of_solid(cone, cells, Pose(0.25e-3, 4e-3), 1e-3).top_m == pytest.approx(3e-3, rel=1e-12)
    for beyond in (Pose(4.5e-3, 0.25e-3), Pose(0.25e-3, -4.5e-3)):
        assert face_of_solid(cone, cells, beyond, 1e-3).top_m < 3e-3 - 0.4e-3
    with pytest.raises(
        InputError, match=r"the cone at \(0\.0001, 0\.02\) m lies outside the field of 0\.008 x 0\.008 m"
    ):
        face_of_solid(Cone(6e-3, 3e-3), cells, Pose(0.1e-3, 20e-3), 1e-3)


@pytest.mark.parametrize("shape", [(2, 2), (2, 5), (7, 3), (20, 31)])
def test_a_height_map_is_linear_between_its_points(shape: tuple[int, int]) -> None:
    cells, given_ = Cells(9, 14, 1e-3, 2e-3), np.random.default_rng(shape[0]).random(shape)
    at = [((np.arange(n) + 0.5) / n) * m - 0.5 for n, m in zip((9, 14), shape, strict=True)]
    along = np.array([np.interp(at[1], np.arange(shape[1]), row) for row in given_])
    told = np.array([np.interp(at[0], np.arange(shape[0]), column) for column in along.T]).T
    face = face_of_map(given_, cells)
    assert face.top_m == pytest.approx(told.max())
    np.testing.assert_allclose(face.below_top_m, told.max() - told, atol=1e-12)
    assert face.loaded.shape == (9, 14)
    assert (face.loaded == 1).all()


# Presses


def test_a_press_says_where_and_how_hard() -> None:
    skin = Skin("layer", 6e-3, 0.45, youngs_modulus_pa=2e5)
    cylinder = Cylinder(6e-3, 1e-3)
    # As deep as the solid is high, and a rounding error more, but no more.
    made = press(cylinder, skin, depth=1e-3 * (1 + 5e-13), shape=(8, 10), pitch_m=(1.5e-3, 1e-3), per_taxel=3)
    with pytest.raises(InputError, match=r"depth must not exceed the solid's height, 0\.001 m"):
        press(cylinder, skin, depth=1e-3 * (1 + 1e-9), shape=(8, 10), pitch_m=1e-3)
    assert (made.shape, made.pitch_m) == ((8, 10), (1.5e-3, 1e-3))
    np.testing.assert_allclose(made.y_m, (np.arange(24) - 11.5) * 0.5e-3)
    np.testing.assert_allclose(made.x_m, (np.arange(30) - 14.5) * 1e-3 / 3)
    assert made.force_n == pytest.approx(made.pressure.sum() * 0.5e-3 * 1e-3 / 3)
    np.testing.assert_array_equal(made.contact, made.pressure > 0)
    r = np.hypot(made.x_m[None, :], made.y_m[:, None])
    assert np.isinf(made.gap_m[r > 3.6e-3]).all()
    assert np.abs(made.gap_m[r < 2.4e-3]).max() < 1e-6
    assert np.abs(made.displacement_m[r < 2.4e-3] - 1e-3).max() < 1e-6
    free = press(cylinder, Skin("layer", 6e-3, 0.45), depth=1e-3, shape=(8, 10), pitch_m=(1.5e-3, 1e-3), per_taxel=3)
    modulus = 2e5 / (1 - 0.45**2)
    np.testing.assert_allclose(made.pressure, free.pressure * modulus, rtol=1e-3)
    assert made.force_n == pytest.approx(free.force_n * modulus, rel=1e-3)


class _Laws:
    """Stands for the solver: a force that grows as a power of the depth."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch, force: Any) -> None:
        self.depths: list[float] = []
        self.starts: list[Any] = []

        def solved(
            face: Any, skin: Any, cells: Cells, depth: float, tol: float, most: int, start: Any = None
        ) -> Contact:
            self.depths.append(depth)
            self.starts.append(start)
            pressure = np.full((cells.rows, cells.cols), force(depth) / (cells.rows * cells.cols))
            return Contact(pressure / (cells.row_m * cells.col_m), pressure, pressure, 0.0, 1)

        monkeypatch.setattr(presses, "solve_contact", solved)


E1 = Skin("half-space", poisson=0.0, youngs_modulus_pa=1.0)


@pytest.mark.parametrize("power", [0.5, 1.0, 1.5, 2.0, 3.0, 4.0])
@pytest.mark.parametrize("force", [1e-3, 1.0, 300.0])
def test_a_force_that_is_a_power_of_the_depth_is_found_at_once(
    power: float, force: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A first trial, one for the power, and what no step by more than a factor of 20 down or 4.5 up can save."""
    laws = _Laws(monkeypatch, lambda depth: (1000 * depth) ** power)
    made = press(np.eye(6) * 1e-3, E1, force=force, shape=(10, 10), pitch_m=2e-3, per_taxel=2, tolerance=1e-6)
    assert made.depth_m == pytest.approx(1e-3 * force ** (1 / power), rel=1e-4)
    assert laws.depths[0] == pytest.approx(0.1 * 20e-3 / 10)
    assert laws.depths[-1] == made.depth_m
    assert laws.starts[0] is None
    assert all(start is not None for start in laws.starts[1:])
    steps = np.diff(np.log(laws.depths))
    assert (steps <= 1.5 + 1e-9).all()
    assert (steps >= -3.0 - 1e-9).all()
    away = np.log(made.depth_m / laws.depths[0])
    jumps = math.ceil(away / 1.5) if away > 0 else math.ceil(-away / 3)
    assert len(laws.depths) <= max(jumps, 1) + 2
    # The first step takes the force for that of a sphere.
    first = (math.log(force) - power * math.log(1000 * laws.depths[0])) / 1.5
    assert steps[0] == pytest.approx(min(max(first, -3.0), 1.5))


def test_a_force_that_jumps_is_closed_in_upon_and_told(monkeypatch: pytest.MonkeyPatch) -> None:
    laws = _Laws(monkeypatch, lambda depth: 0.5 if depth < 3e-3 else 2.0)
    with pytest.raises(NotConvergedError, match=r"no depth found for the force within 40 trials; last 0\.003"):
        press(np.eye(6) * 1e-3, E1, force=1.0, shape=(10, 10), pitch_m=2e-3, per_taxel=2)
    assert len(laws.depths) == 40
    # Every trial lies between the nearest on both sides of the jump.
    for k, depth in enumerate(laws.depths[6:], start=6):
        below = max(d for d in laws.depths[:k] if d < 3e-3)
        above = min(d for d in laws.depths[:k] if d >= 3e-3)
        assert below <= depth <= above


def test_a_force_s_tolerance_is_ten_times_the_solver_s(monkeypatch: pytest.MonkeyPatch) -> None:
    for off, trials in ((9e-4, 1), (11e-4, 2)):
        laws = _Laws(monkeypatch, lambda depth, off=off: (1 + off) * (depth / 2e-4) ** 1.5)
        press(np.eye(6) * 1e-3, E1, force=1.0, shape=(10, 10), pitch_m=2e-3, per_taxel=2, tolerance=1e-4)
        assert len(laws.depths) == trials


def test_a_low_solid_s_trials_go_no_deeper_than_it_is_high(monkeypatch: pytest.MonkeyPatch) -> None:
    laws = _Laws(monkeypatch, lambda depth: 1e3 * depth)
    made = press(Cylinder(4e-3, 0.5e-3), E1, force=0.5, shape=(10, 10), pitch_m=2e-3, per_taxel=2)
    assert laws.depths[0] == pytest.approx(0.05e-3)
    assert made.depth_m == pytest.approx(0.5e-3)
    assert max(laws.depths) <= 0.5e-3
    with pytest.raises(InputError, match=r"the whole solid, 0\.0005 m high, is pressed in at 0\.5 N"):
        press(Cylinder(4e-3, 0.5e-3), E1, force=0.51, shape=(10, 10), pitch_m=2e-3, per_taxel=2)
