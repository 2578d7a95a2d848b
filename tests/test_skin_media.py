"""Laws of the media and of what solves on them: known transforms, sums of single loads, the conditions of a minimum."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from varishold.skin.influence import influence_of
from varishold.skin.inhibition import edge_map, lateral_inhibition
from varishold.skin.media.half_space import HalfSpace
from varishold.skin.media.layer import Layer
from varishold.skin.media.medium import Cells, wave_numbers
from varishold.skin.media.winkler import Winkler
from varishold.skin.nonnegative import solve_nonnegative
from varishold.skin.taxels import Taxels

few = settings(max_examples=15)
seeds = st.integers(0, 2**32 - 1)


def test_a_half_space_sinks_as_boussinesq_and_love_say() -> None:
    cells = Cells(30, 40, 2e-3, 1e-3)
    kernel = HalfSpace().influence(cells)
    y, x = np.mgrid[:30, :40] * np.array([2e-3, 1e-3])[:, None, None]
    far = np.hypot(x, y) > 12e-3
    np.testing.assert_allclose(kernel[far], 2e-6 / (np.pi * np.hypot(x, y)[far]), rtol=5e-3)
    # The middle of a square of side a under an even load: (4 / pi) ln(1 + sqrt 2) a.
    square = HalfSpace().influence(Cells(3, 3, 1e-3, 1e-3))[0, 0]
    assert square == pytest.approx(4 / np.pi * np.log(1 + np.sqrt(2)) * 1e-3)
    assert HalfSpace().compliance(np.array([4.0])) == pytest.approx(0.5)
    assert HalfSpace().transfer(np.array([3.0]), 0.5) == pytest.approx(2.5 * np.exp(-1.5))
    assert HalfSpace().reach_m == np.inf


@pytest.mark.parametrize("poisson", [-0.5, 0.0, 0.3, 0.45, 0.5])
def test_a_layer_yields_as_springs_to_long_waves_and_as_a_half_space_to_short_ones(poisson: float) -> None:
    layer = Layer(2e-3, poisson)
    short = np.array([5e4, 2e5])
    np.testing.assert_allclose(layer.compliance(short), 2 / short, rtol=1e-9)
    springs = Winkler(2e-3, poisson).compliance(np.zeros(1))[0] if poisson < 0.5 else 0.0
    assert layer.compliance(np.array([1e-6]))[0] == pytest.approx(springs, abs=1e-12)
    assert springs == pytest.approx(2e-3 * (1 - 2 * poisson) / (1 - poisson) ** 2)
    # Its parts meet without a step.
    for seam in (1e-3, 18.0):
        a, b = layer.compliance(np.array([seam * (1 - 1e-9), seam * (1 + 1e-9)]) / 2e-3)
        assert a == pytest.approx(b, rel=1e-5)
        c, d = layer.transfer(np.array([seam * (1 - 1e-9), seam * (1 + 1e-9)]) / 2e-3, 0.7e-3)
        assert c == pytest.approx(d, rel=1e-5)
    k = np.geomspace(1, 1e5, 50)
    np.testing.assert_allclose(layer.transfer(k, 0.0), 1.0, rtol=1e-9)
    assert layer.reach_m == pytest.approx(0.04)


def test_springs_yield_each_for_itself() -> None:
    springs = Winkler(1e-3, 0.3)
    kernel = springs.influence(Cells(4, 5, 1e-3, 1e-3))
    assert np.count_nonzero(kernel) == 1
    assert kernel[0, 0] == springs.compliance(np.ones(1))[0]
    assert springs.reach_m == 0
    np.testing.assert_array_equal(springs.transfer(np.array([0.0, 9.0]), 0.5e-3), 1.0)
    np.testing.assert_allclose(springs.partial_cell(np.array([1.0, 0.5]), 2.0), [0.0, 2.0])
    np.testing.assert_allclose(HalfSpace().partial_cell(np.array([1.0, 0.25]), 2.0), [0.0, 2.0])
    np.testing.assert_allclose(Layer(1e-3, 0.4).partial_cell(np.array([0.25]), 2.0), [2.0])


@pytest.mark.parametrize("medium", [HalfSpace(), Layer(6e-3, 0.45), Layer(1e-3, 0.3), Winkler(2e-3, 0.3)])
def test_a_displacement_is_the_sum_of_what_each_cell_does(medium: object) -> None:
    cells = Cells(12, 9, 1e-3, 1.5e-3)
    influence = influence_of(medium, cells, 12, 9)  # type: ignore[arg-type]
    kernel = medium.influence(cells)  # type: ignore[attr-defined]
    pressure = np.random.default_rng(0).random((12, 9))
    i, j = np.indices((12, 9))
    wanted = sum(pressure[r, c] * kernel[np.abs(i - r), np.abs(j - c)] for r in range(12) for c in range(9))
    np.testing.assert_allclose(influence.displacement(pressure), wanted, rtol=1e-9, atol=1e-12)
    both = influence.displacement(np.stack([pressure, 2 * pressure]))
    np.testing.assert_allclose(both[1], 2 * wanted, rtol=1e-9, atol=1e-12)
    assert influence.own == kernel[0, 0]
    single = influence_of(medium, cells, 12, 9, single=True)  # type: ignore[arg-type]
    assert single.displacement(pressure.astype(np.float32)).dtype == np.float32


def test_waves_of_a_grid() -> None:
    ky, kx = wave_numbers(4, 6, 0.5, 0.25)
    np.testing.assert_allclose(ky, 2 * np.pi * np.array([0, 0.5, -1.0, -0.5]))
    np.testing.assert_allclose(kx, 2 * np.pi * np.array([0, 1, 2, 3]) / 1.5)


@few
@given(seeds)
def test_a_minimum_over_what_is_not_negative_meets_its_conditions(seed: int) -> None:
    rng = np.random.default_rng(seed)
    root = rng.normal(size=(12, 12))
    matrix, b = root @ root.T + 0.5 * np.eye(12), rng.normal(size=12)

    def apply(x: np.ndarray) -> np.ndarray:
        return matrix @ x

    found = solve_nonnegative(apply, lambda r: r / np.diag(matrix), b, np.ones(12), tolerance=1e-9, max_iterations=3000)
    assert found.converged
    assert (found.x >= 0).all()
    np.testing.assert_allclose(found.gradient, apply(found.x) - b, atol=1e-6)
    assert (found.gradient > -1e-6).all()
    np.testing.assert_allclose(found.gradient[found.x > 0], 0, atol=1e-6)
    assert found.rms <= 1e-9
    short = solve_nonnegative(apply, lambda r: r, b, np.ones(12), tolerance=0.0, max_iterations=2)
    assert (short.converged, short.iterations) == (False, 2)


@pytest.mark.parametrize("depth_m", [0.5e-3, 1e-3, 3e-3])
def test_inhibition_keeps_even_loads_and_has_the_curvature_of_its_depth(depth_m: float) -> None:
    pitch = (1e-3, 1.3e-3)
    assert lateral_inhibition(np.full((9, 9), 3.0), pitch_m=pitch, depth_m=depth_m) == pytest.approx(3.0)
    y, x = np.mgrid[-30:31, -30:31] * np.array([1e-3, 1.3e-3])[:, None, None]
    bowl = 1e6 * (x**2 + 2 * y**2)
    # w (G_c - G_s) of a parabola is - d^2 / 2 times its Laplacian, whatever the two widths are.
    for centre_m, surround_m in ((1.5e-3, 2.5e-3), (2e-3, 4e-3)):
        edges = edge_map(bowl, pitch_m=pitch, depth_m=depth_m, centre_m=centre_m, surround_m=surround_m)
        assert edges[30, 30] == pytest.approx(-(depth_m**2) / 2 * 1e6 * 6, rel=0.02)
        both = lateral_inhibition(bowl, pitch_m=pitch, depth_m=depth_m, centre_m=centre_m, surround_m=surround_m)
        assert (both - edges)[30, 30] == pytest.approx(1e6 * 3 * centre_m**2, rel=0.02)
    usual = edge_map(bowl, pitch_m=pitch, depth_m=depth_m)
    centre_m = max(0.65e-3, 0.3 * depth_m)
    named = edge_map(bowl, pitch_m=pitch, depth_m=depth_m, centre_m=centre_m, surround_m=1.6 * centre_m)
    np.testing.assert_allclose(usual, named)


@few
@given(seeds)
def test_taxels_depart_as_they_are_told_to(seed: int) -> None:
    rng = np.random.default_rng(seed)
    stress = rng.random((2, 20, 20)) + 0.5
    np.testing.assert_array_equal(Taxels().read(stress, seed=seed), stress)
    gains = Taxels(gain_spread=0.1).read(stress, seed=seed) / stress
    np.testing.assert_allclose(gains[0], gains[1])
    assert np.std(gains[0]) == pytest.approx(0.1, rel=0.2)
    assert np.mean(gains[0]) == pytest.approx(1.0, abs=0.03)
    noise = Taxels(noise=0.05).read(stress, seed=seed) - stress
    for k in range(2):
        assert noise[k].std() == pytest.approx(0.05 * stress[k].max(), rel=0.2)
    spot = np.zeros((7, 7))
    spot[3, 3] = 1.0
    leak = Taxels(crosstalk=0.1).read(spot)
    assert (leak[3, 3], leak[2, 3], leak[4, 3], leak[3, 2], leak[3, 4], leak[2, 2]) == pytest.approx(
        (0.6, 0.1, 0.1, 0.1, 0.1, 0.0)
    )
    dull = Taxels(dead=0.1, stuck=0.2).read(stress, seed=seed)
    assert np.count_nonzero((dull == 0).all(axis=0)) == 40
    assert np.count_nonzero((dull[0] == dull[1]) & (dull[0] != 0)) == 80
    cut = Taxels(full_scale=1.0).read(stress)
    np.testing.assert_allclose(cut, np.minimum(stress, 1.0))
    steps = Taxels(bits=3, full_scale=1.4).read(stress) / 0.2
    np.testing.assert_allclose(steps, np.round(steps), atol=1e-9)
    assert np.abs(0.2 * steps - np.minimum(stress, 1.4)).max() <= 0.1 + 1e-9
    own = Taxels(bits=8).read(stress)
    assert np.abs(own - stress).max() <= stress.max() / 255 / 2 + 1e-9


def test_a_loop_is_widest_at_half_the_highest_stress_on_the_way_down() -> None:
    press = np.array([0.0, 0.5, 1.0, 0.75, 0.5, 0.25, 0.0])[:, None, None] * np.full((1, 2, 2), 8.0)
    read = Taxels(hysteresis=0.1).read(press)[:, 0, 0]
    np.testing.assert_allclose(read, [0, 4, 8, 6 + 0.6, 4 + 0.8, 2 + 0.6, 0])
