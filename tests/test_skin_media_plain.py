"""Media and transmission beside plain arithmetic: the equations of elasticity, known integrals, sums and matrices."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.fft import next_fast_len
from scipy.integrate import quad
from scipy.linalg import expm
from scipy.special import j0, ndtr

from varishold.errors import InputError
from varishold.skin import Skin
from varishold.skin.influence import Influence, influence_of
from varishold.skin.media import Cells, HalfSpace, Layer, Winkler, cell_symbol, medium_of
from varishold.skin.transmission import Transmission, transmission_of

Floats = NDArray[np.float64]


def _elasticity(k: float, h: float, poisson: float, depth: float) -> tuple[float, float]:
    """Surface displacement and stress at a depth under a unit pressure wave, by Hooke's law and equilibrium.

    The state (along, down, shear, normal) is integrated over the depth, for a contact modulus of 1 (E = 1 - nu^2).
    """
    shear = (1 - poisson) / 2
    ratio = poisson / (1 - poisson)
    oedometer = (1 - 2 * poisson) / (2 * shear * (1 - poisson))
    slope = np.array(
        [
            [0.0, k, 1 / shear, 0.0],
            [-ratio * k, 0.0, 0.0, oedometer],
            [k * k, 0.0, 0.0, ratio * k],
            [0.0, 0.0, -k, 0.0],
        ]
    )
    through = expm(slope * h)
    # No shear and the normal stress -1 on the surface, no displacement at the floor.
    surface = np.linalg.solve(through[:2, :2], through[:2, 3])
    state = expm(slope * depth) @ np.array([*surface, 0.0, -1.0])
    return float(surface[1]), float(-state[3])


@pytest.mark.parametrize("poisson", [-0.4, 0.0, 0.3, 0.45, 0.5])
@pytest.mark.parametrize("kh", [2e-4, 0.02, 0.3, 1.0, 2.5, 6.0, 9.0])
def test_a_layer_obeys_hooke_and_equilibrium(poisson: float, kh: float) -> None:
    h = 3e-3
    layer, k = Layer(h, poisson), np.array([kh / h])
    for depth in (0.0, 0.4e-3, 1.5e-3, 3e-3):
        sinks, stress = _elasticity(kh, 1.0, poisson, depth / h)
        assert layer.compliance(k)[0] == pytest.approx(sinks * h, rel=2e-6, abs=1e-9 * h)
        assert layer.transfer(k, depth)[0] == pytest.approx(stress, rel=2e-6, abs=1e-7)


@pytest.mark.parametrize("poisson", [0.0, 0.45, 0.5])
def test_a_layer_s_influence_is_its_hankel_transform(poisson: float) -> None:
    h, cells = 4.5e-3, Cells(3, 95, 0.5e-3, 1e-3)
    layer = Layer(h, poisson)
    held = layer.influence(cells) - HalfSpace().influence(cells)
    y, x = np.mgrid[:3, :95] * np.array([0.5e-3, 1e-3])[:, None, None]
    for at in ((0, 0), (1, 1), (2, 5), (0, 37), (1, 60)):
        r = np.hypot(x[at], y[at])

        def wave(k: float, r: float = r) -> float:
            return float((layer.compliance(np.array([k]))[0] * k - 2) * j0(k * r) / (2 * np.pi))

        told = quad(wave, 1e-9 / h, 18 / h, limit=400)[0] * 0.5e-6
        assert held[at] == pytest.approx(told, rel=1e-5, abs=1e-8 * abs(held[0, 0]))
    # Nothing is felt twenty thicknesses away.
    far = np.hypot(x, y) >= 20 * h
    assert (layer.influence(cells)[far] == 0).all()
    assert (layer.influence(cells)[~far & (x < 4e-3)] != 0).all()


@pytest.mark.parametrize("poisson", [0.3, 0.5])
def test_coarse_cells_sink_as_the_fine_ones_that_fill_them(poisson: float) -> None:
    layer, fine = Layer(2e-3, poisson), 8
    small = layer.influence(Cells(4 * fine, 5 * fine, 1e-3 / fine, 0.8e-3 / fine))
    coarse = layer.influence(Cells(3, 4, 1e-3, 0.8e-3))
    i = np.arange(fine)
    for row in range(3):
        for col in range(4):
            away_y = np.abs(row * fine + i[:, None] - i[None, :])[:, :, None, None]
            away_x = np.abs(col * fine + i[:, None] - i[None, :])[None, None]
            told = small[away_y, away_x].sum() / fine**2
            # A fine cell's middle sinks a little deeper than its mean.
            assert coarse[row, col] == pytest.approx(told, abs=(0.02 if row == col == 0 else 0.004) * coarse[0, 0])


def test_a_symbol_between_cells_is_the_integral_over_both() -> None:
    sigma, a, b, rows, cols = 0.45e-3, 1e-3, 0.8e-3, 24, 30
    symbol = cell_symbol(lambda k: np.exp(-((k * sigma) ** 2) / 2), rows, cols, a, b)
    kernel = np.fft.irfft2(symbol, s=(rows, cols))

    def between(away: Floats, side: float) -> Floats:
        def twice(x: Floats) -> Floats:
            return x * ndtr(x / sigma) + sigma * np.exp(-((x / sigma) ** 2) / 2) / np.sqrt(2 * np.pi)

        return (twice(away + side) - 2 * twice(away) + twice(away - side)) / side

    told = np.outer(between(np.arange(8) * a, a), between(np.arange(8) * b, b))
    np.testing.assert_allclose(kernel[:8, :8], told, atol=1e-6)
    # Three foldings on each side, and as many as are asked for.
    for aliases in (0, 1, 3):
        more = {} if aliases == 3 else {"aliases": aliases}
        flat = cell_symbol(np.ones_like, 4, 6, a, b, **more)
        folds = np.arange(-aliases, aliases + 1)
        y = sum(np.sinc(np.fft.fftfreq(4) + i) ** 2 for i in folds)
        x = sum(np.sinc(np.fft.rfftfreq(6) + i) ** 2 for i in folds)
        np.testing.assert_allclose(flat, np.outer(y, x))


# From surface to taxels


def _under_a_corner(a: Floats, b: Floats, z: float) -> Floats:
    """Normal stress under the corner of an evenly loaded rectangle a x b on a half-space (Newmark)."""
    r = np.sqrt(a * a + b * b + z * z)
    out: Floats = (np.arctan(a * b / (z * r)) + a * b * z / r * (1 / (a * a + z * z) + 1 / (b * b + z * z))) / (
        2 * np.pi
    )
    return out


def _stress(x: Floats, y: Floats, a: float, b: float, z: float) -> Floats:
    """Normal stress under a unit pressure on -a / 2 .. a / 2, -b / 2 .. b / 2."""

    def corner(u: Floats, v: Floats) -> Floats:
        return np.sign(u) * np.sign(v) * _under_a_corner(np.abs(u), np.abs(v), z)

    return (
        corner(x + a / 2, y + b / 2)
        - corner(x - a / 2, y + b / 2)
        - corner(x + a / 2, y - b / 2)
        + corner(x - a / 2, y - b / 2)
    )


@pytest.mark.parametrize("at", [(0, 0), (5, 4), (11, 0)])
def test_stress_under_one_loaded_cell_is_newmark_s(at: tuple[int, int]) -> None:
    cells, depth, fine = Cells(12, 10, 0.5e-3, 0.4e-3), 1e-3, 6
    pressure = np.zeros((12, 10))
    pressure[at] = 1.0
    taxels = Transmission(HalfSpace(), cells, depth, 2, np.float64).forward(pressure)
    assert taxels.shape == (6, 5)
    y = ((np.arange(12 * fine) + 0.5) / fine - at[0] - 0.5)[:, None] * 0.5e-3
    x = ((np.arange(10 * fine) + 0.5) / fine - at[1] - 0.5)[None, :] * 0.4e-3
    told = _stress(x, y, 0.4e-3, 0.5e-3, depth).reshape(6, 2 * fine, 5, 2 * fine).mean(axis=(1, 3))
    np.testing.assert_allclose(taxels, told, atol=2e-3 * told.max())


@pytest.mark.parametrize("per_taxel", [1, 2, 3])
@pytest.mark.parametrize("medium", [HalfSpace(), Layer(3e-3, 0.45), Winkler(3e-3, 0.3)])
def test_the_way_back_is_the_transpose(medium: object, per_taxel: int) -> None:
    rng = np.random.default_rng(per_taxel)
    t = Transmission(medium, Cells(12, 6, 0.5e-3, 0.7e-3), 1e-3, per_taxel, np.float64)  # type: ignore[arg-type]
    pressure, frame = rng.random((12, 6)), rng.random((12 // per_taxel, 6 // per_taxel))
    assert np.vdot(t.forward(pressure), frame) == pytest.approx(np.vdot(pressure, t.adjoint(frame)), rel=1e-9)
    many = rng.random((2, 3, 12, 6))
    np.testing.assert_allclose(t.forward(many)[1, 2], t.forward(many[1, 2]), rtol=1e-12)
    # Seven to twelve depths of silence keep a load from coming round, and no more is transformed.
    assert 12 + 7e-3 / 0.5e-3 < t.size[0] < 12 + 12e-3 / 0.5e-3
    assert 6 + 7e-3 / 0.7e-3 < t.size[1] < 6 + 12e-3 / 0.7e-3


def test_at_depth_zero_taxels_mean_over_their_cells() -> None:
    pressure = np.random.default_rng(0).random((6, 9))
    t = Transmission(HalfSpace(), Cells(6, 9, 1e-3, 1e-3), 0.0, 3, np.float64)
    np.testing.assert_allclose(t.forward(pressure), pressure.reshape(2, 3, 3, 3).mean(axis=(1, 3)), rtol=1e-12)


def test_a_grid_s_precision_and_how_many_cells_a_depth_needs() -> None:
    skin, cells = Skin("half-space", sensing_depth_m=0.5e-3), Cells(4, 4, 0.5e-3, 0.5e-3)
    assert transmission_of(skin, cells, 2).symbol.dtype == np.float64
    assert transmission_of(skin, cells, 2, single=True).symbol.dtype == np.float32
    for side, per_taxel, need in ((1e-3, 1, 2), (1e-3, 2, 4), (0.6e-3, 5, 6), (0.75e-3, 1, 2)):
        for wide in (Cells(4, 4, side, 0.5e-3), Cells(4, 4, 0.5e-3, side)):
            with pytest.raises(
                InputError, match=rf"cells of {side:g} m, depth 0\.0005 m; use per_taxel={need} or more"
            ):
                transmission_of(skin, wide, per_taxel)


# Influence


@pytest.mark.parametrize("kind", ["layer", "half-space", "winkler"])
def test_beyond_a_medium_s_reach_nothing_is_added_up(kind: str) -> None:
    """On a pad longer than the reach displacements are still those of all cells, each for itself."""
    skin = Skin(kind, None if kind == "half-space" else 0.4e-3, 0.3)
    medium, cells = medium_of(skin), Cells(40, 12, 0.5e-3, 1e-3)
    kernel = medium.influence(cells)
    influence = influence_of(medium, cells, 40, 12)
    pressure = np.random.default_rng(1).random((40, 12))
    i, j = np.indices((40, 12))
    told = sum(pressure[r, c] * kernel[np.abs(i - r), np.abs(j - c)] for r in range(40) for c in range(12))
    np.testing.assert_allclose(influence.displacement(pressure), told, rtol=1e-9, atol=1e-9)
    assert influence.displacement(pressure.astype(np.float32)).shape == (40, 12)
    # The transform is no longer than pad and reach.
    reach = {"layer": 8e-3, "half-space": np.inf, "winkler": 0.0}[kind]
    needed = [n + min(n - 1, np.ceil(reach / side)) for n, side in ((40, 0.5e-3), (12, 1e-3))]
    assert influence._full == tuple(next_fast_len(int(n), real=True) for n in needed)


@pytest.mark.parametrize("medium", [HalfSpace(), Layer(1e-3, 0.5), Winkler(1e-3, 0.3)])
def test_the_rough_inverse_is_that_of_the_pad_repeated(medium: object) -> None:
    """With eight silent cells beside it, and no amplification beyond a thousand."""
    rows, cols = 11, 5
    cells = Cells(rows, cols, 0.5e-3, 0.5e-3)
    kernel = medium.influence(cells)  # type: ignore[attr-defined]
    reach = int(min(np.ceil(medium.reach_m / 0.5e-3), 1e9)) if np.isfinite(medium.reach_m) else 10**9  # type: ignore[attr-defined]
    influence = Influence(kernel, (reach, reach), np.float64)
    size = [next_fast_len(n + min(8, n - 1, reach), real=True) for n in (rows, cols)]
    away = [np.abs(np.subtract.outer(np.arange(n), np.arange(n))) for n in size]
    away = [np.minimum(d, n - d) for d, n in zip(away, size, strict=True)]
    held = [np.minimum(d, n - 1) for d, n in zip(away, (rows, cols), strict=True)]
    whole = kernel[held[0][:, None, :, None], held[1][None, :, None, :]]
    whole = whole * (away[0] < rows)[:, None, :, None] * (away[1] < cols)[None, :, None, :]
    values, vectors = np.linalg.eigh(whole.reshape(size[0] * size[1], -1))
    inverse = (vectors / np.maximum(values, 1e-3 * values.max())) @ vectors.T
    given = np.random.default_rng(2).random((rows, cols))
    padded = np.zeros(size)
    padded[:rows, :cols] = given
    told = (inverse @ padded.ravel()).reshape(size)[:rows, :cols]
    np.testing.assert_allclose(influence.inverse(given), told, rtol=1e-6, atol=1e-9 * np.abs(told).max())
