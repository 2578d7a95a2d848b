"""Laws of the forward model on a window: both solvers agree, gradients are differences, influence is a matrix."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from varishold.errors import InputError, NotConvergedError
from varishold.skin import Skin, press
from varishold.skin import pressing as presses
from varishold.skin.influence import influence_of
from varishold.skin.media import medium_of
from varishold.skin.media.medium import Cells
from varishold.skin.pressing import contact_cells
from varishold.skin.synthesis import CoarseFace, Synthesis
from varishold.solids import Cylinder, Sphere

few = settings(max_examples=8)
SKINS = {
    "layer": Skin("layer", 6e-3, 0.45, 1e-3),
    "half-space": Skin("half-space", sensing_depth_m=1e-3),
    "winkler": Skin("winkler", 6e-3, 0.3, 1e-3),
}


def cap(synthesis: Synthesis, x_m: float, depth: float, blunt_m2: float = 8e-6) -> CoarseFace:
    """A ball's face by its place along x and its depth, about 1."""
    x, y = synthesis.points_m
    wanted = depth - ((x - x_m) ** 2 + y**2) / blunt_m2
    slopes = np.array([2 * (x - x_m) / blunt_m2, np.ones_like(x)])
    return CoarseFace(wanted, np.ones_like(x), slopes, np.zeros((2, x.size)))


def slab(synthesis: Synthesis, half_m: float, depth: float = 1.0) -> CoarseFace:
    """A flat face with walls at x = -half and half, by its half breadth."""
    x, _ = synthesis.points_m
    side = synthesis.cells.col_m
    covered = np.clip((half_m - np.abs(x)) / side + 0.5, 0.0, 1.0)
    crossed = (covered > 0) & (covered < 1)
    return CoarseFace(np.where(covered > 0, depth, -1.0), covered, np.zeros((1, x.size)), (crossed / side)[None])


@pytest.fixture(scope="module", params=SKINS)
def synthesis(request: pytest.FixtureRequest) -> Synthesis:
    return Synthesis(SKINS[request.param], 8, 10, (1e-3, 1.2e-3), 2)


def test_cells_stand_about_the_middle_of_the_window(synthesis: Synthesis) -> None:
    x, y = (each.reshape(16, 20) for each in synthesis.points_m)
    np.testing.assert_allclose(x[0], (np.arange(20) - 9.5) * 0.6e-3)
    np.testing.assert_allclose(y[:, 0], (np.arange(16) - 7.5) * 0.5e-3)


def test_both_solvers_find_the_same_pressure(synthesis: Synthesis) -> None:
    for face in (cap(synthesis, 3e-4, 1.0), slab(synthesis, 2.2e-3)):
        made = synthesis.frame(face)
        fine = synthesis.pressure(face)
        top = made.pressure.max()
        np.testing.assert_allclose(fine, made.pressure, atol=0.02 * top)
        np.testing.assert_allclose(synthesis.pressure(face, start=fine), fine, atol=0.02 * top)
        np.testing.assert_allclose(synthesis.sensed(made.pressure), made.frame, atol=1e-5 * made.frame.max())
        # Nothing pulls, and what carries load is in contact.
        assert made.pressure.min() >= 0
        np.testing.assert_array_equal(made.active, made.pressure > 0)
        assert not made.active[face.covered == 0].any()
        # Where the search begins does not matter.
        other = synthesis.frame(face, start=made.active)
        np.testing.assert_allclose(other.frame, made.frame, atol=1e-4 * made.frame.max())
        nowhere = synthesis.frame(face, start=np.zeros_like(made.active))
        np.testing.assert_allclose(nowhere.frame, made.frame, atol=1e-4 * made.frame.max())


@pytest.mark.parametrize("name", SKINS)
def test_gradients_are_differences(name: str) -> None:
    synthesis = Synthesis(SKINS[name], 8, 10, (1e-3, 1.2e-3), 2)
    made = synthesis.frame(cap(synthesis, 2e-4, 1.2))
    for k, step in ((0, 2e-5), (1, 2e-2)):
        ends = [
            synthesis.frame(cap(synthesis, 2e-4 + sign * step * (k == 0), 1.2 + sign * step * (k == 1))).frame
            for sign in (1, -1)
        ]
        slope = (ends[0] - ends[1]) / (2 * step)
        np.testing.assert_allclose(made.gradient[k], slope, atol=0.15 * np.abs(slope).max())
    broad = synthesis.frame(slab(synthesis, 2.3e-3))
    assert broad.gradient.shape == (1, 8, 10)
    ends = [synthesis.frame(slab(synthesis, 2.3e-3 + d)).frame for d in (2e-5, -2e-5)]
    slope = (ends[0] - ends[1]) / 4e-5
    np.testing.assert_allclose(broad.gradient[0], slope, atol=0.1 * np.abs(slope).max())


def test_springs_press_as_deep_as_they_are_wanted() -> None:
    synthesis = Synthesis(SKINS["winkler"], 6, 6, (1e-3, 1e-3), 1)
    face = cap(synthesis, 0.0, 0.9)
    made = synthesis.frame(face)
    ratio = made.pressure[made.active] / face.wanted[made.active]
    np.testing.assert_allclose(ratio, ratio[0], rtol=1e-4)
    np.testing.assert_array_equal(made.active, face.wanted > 0)


def test_a_face_that_has_left_is_told(synthesis: Synthesis) -> None:
    with pytest.raises(NotConvergedError, match="nothing touches: the fitted face has left the contact"):
        synthesis.frame(cap(synthesis, 0.0, -0.5))


# Influence


@few
@given(st.integers(0, 2**32 - 1), st.sampled_from(sorted(SKINS)))
def test_displacement_is_the_sum_over_all_cells(seed: int, name: str) -> None:
    rng = np.random.default_rng(seed)
    medium = medium_of(SKINS[name])
    cells = Cells(5, 7, 1e-3, 0.8e-3)
    kernel = medium.influence(cells)
    influence = influence_of(medium, cells, 5, 7)
    pressure = rng.random((5, 7))
    expected = np.zeros((5, 7))
    for r in range(5):
        for c in range(7):
            for i in range(5):
                for j in range(7):
                    expected[r, c] += kernel[abs(r - i), abs(c - j)] * pressure[i, j]
    np.testing.assert_allclose(influence.displacement(pressure), expected, rtol=1e-9)
    single = influence_of(medium, cells, 5, 7, single=True)
    assert single.displacement(pressure.astype(np.float32)).dtype == np.float32
    np.testing.assert_allclose(single.displacement(pressure.astype(np.float32)), expected, rtol=1e-4)
    # The inverse is near enough to help a solver.
    back = influence.inverse(influence.displacement(pressure))
    assert np.corrcoef(back.ravel(), pressure.ravel())[0, 1] > 0.6


# Presses


def test_a_pad_has_about_a_hundred_and_twenty_eight_cells_along_its_longer_side() -> None:
    for shape, per_taxel in (((16, 8), 8), ((8, 16), 8), ((64, 3), 2), ((128, 1), 1), ((300, 2), 1), ((100, 1), 1)):
        cells, spacing = contact_cells(shape, 2e-3, None)
        assert (cells.rows, cells.cols) == (shape[0] * per_taxel, shape[1] * per_taxel)
        assert (cells.row_m, cells.col_m) == pytest.approx((2e-3 / per_taxel,) * 2)
        assert spacing == (2e-3, 2e-3)
    cells, _ = contact_cells((3, 4), (2e-3, 3e-3), 1)
    assert (cells.rows, cells.cols, cells.row_m, cells.col_m) == (3, 4, 2e-3, 3e-3)
    for wrong in ((0, 4), (4, 0), (-1, 4)):
        with pytest.raises(InputError, match="two whole numbers from 1"):
            contact_cells(wrong, 1e-3, None)
    with pytest.raises(InputError, match="per_taxel must be a whole number from 1, got 0"):
        contact_cells((4, 4), 1e-3, 0)


@pytest.mark.parametrize("solid", [Sphere(0.02), Cylinder(0.008, 0.004)])
@pytest.mark.parametrize("force", [0.01, 1.0, 8.0])
def test_a_force_is_found_in_few_presses_and_is_that_of_its_depth(
    monkeypatch: pytest.MonkeyPatch, solid: Any, force: float
) -> None:
    solved, depths = presses.solve_contact, []

    def counted(face: Any, skin: Any, cells: Any, depth: float, *more: Any) -> Any:
        depths.append(depth)
        return solved(face, skin, cells, depth, *more)

    monkeypatch.setattr(presses, "solve_contact", counted)
    skin = Skin("layer", 6e-3, 0.45, 1e-3, youngs_modulus_pa=2e5)
    how: dict[str, Any] = {"shape": (12, 12), "pitch_m": 1.5e-3, "per_taxel": 2}
    made = press(solid, skin, force=force, **how)
    assert made.force_n == pytest.approx(force, rel=0.02)
    assert made.depth_m == depths[-1]
    assert len(depths) <= 7
    again = press(solid, skin, depth=made.depth_m, **how)
    assert again.force_n == pytest.approx(made.force_n, rel=0.01)
