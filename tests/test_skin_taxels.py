"""From a press to a frame: the skin's transmission, and what taxels do to it."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from varishold.errors import InputError
from varishold.skin import Skin, Taxels, press, sense, taxel_stress
from varishold.skin.media import HalfSpace, Layer
from varishold.solids import Cylinder, Sphere

LAYER = Skin("layer", 6e-3, 0.45, 1e-3)


@pytest.mark.parametrize("skin", [LAYER, Skin("half-space", sensing_depth_m=1e-3), Skin("winkler", 6e-3, 0.3, 1e-3)])
def test_the_load_arrives(skin: Skin) -> None:
    """Stress spreads but its sum stays, as long as it does not leave the pad."""
    pressed = press(Sphere(20e-3), skin, depth=0.5e-3)
    frame = sense(pressed)
    assert frame.shape == (32, 32)
    assert frame.sum() * 1e-6 == pytest.approx(pressed.force_n, rel=0.02)
    assert frame.max() <= pressed.pressure.max() * (1 + 1e-9)


def test_the_surface_itself_is_read_at_depth_zero() -> None:
    pressed = press(Sphere(20e-3), Skin("layer", 6e-3, 0.45), depth=0.5e-3)
    blocks = pressed.pressure.reshape(32, 4, 32, 4).mean(axis=(1, 3))
    assert np.allclose(sense(pressed), blocks, atol=1e-9 * blocks.max())


@pytest.mark.parametrize(("depth", "ratio"), [(0.1, 2.7), (0.2, 1.9), (0.4, 1.3), (0.8, 1.0)])
def test_a_punch_s_ring_fades_with_depth(depth: float, ratio: float) -> None:
    radius = 6e-3
    pressed = press(
        Cylinder(2 * radius, 10e-3),
        Skin("half-space", sensing_depth_m=depth * radius),
        depth=1e-3,
        shape=(128, 128),
        pitch_m=20e-3 / 128,
    )
    stress = taxel_stress(pressed)
    centre = stress[63:65, 63:65].mean()
    assert stress.max() / centre == pytest.approx(ratio, abs=0.12)


@pytest.mark.parametrize("poisson", [0.0, 0.3, 0.45, 0.5])
def test_transmission_laws(poisson: float) -> None:
    """1 at the surface and for an even load; a deep layer is a half-space; never above the load's own."""
    k = np.concatenate([[0.0], np.geomspace(1.0, 1e5, 60)])
    layer = Layer(6e-3, poisson)
    assert layer.transfer(k, 0.0) == pytest.approx(np.ones(k.size))
    assert layer.transfer(np.zeros(1), 3e-3)[0] == pytest.approx(1.0)
    deep = Layer(1.0, poisson)
    assert deep.transfer(k[20:], 1e-3) == pytest.approx(HalfSpace().transfer(k[20:], 1e-3), abs=2e-3)
    for depth in (1e-3, 3e-3, 6e-3):
        answer = layer.transfer(k, depth)
        assert np.isfinite(answer).all()
        assert answer.max() < 1.3
        assert abs(answer[-1]) < 1e-6


def test_a_layer_s_transmission_solves_its_equations() -> None:
    """Equilibrium by finite differences: f'''' - 2 k^2 f'' + k^4 f = 0, and no shear at the surface."""
    layer, k, step = Layer(6e-3, 0.45), 400.0, 0.05e-3
    z = np.arange(0, 41) * step
    f = np.array([layer.transfer(np.array([k]), depth)[0] for depth in z])
    second = (f[2:] - 2 * f[1:-1] + f[:-2]) / step**2
    fourth = (second[2:] - 2 * second[1:-1] + second[:-2]) / step**2
    assert np.abs(fourth - 2 * k**2 * second[1:-1] + k**4 * f[2:-2]).max() < 2e-3 * k**4
    assert abs((-3 * f[0] + 4 * f[1] - f[2]) / (2 * step)) < 1e-2 * k


FRAMES = np.random.default_rng(0).uniform(0.5, 1.0, (6, 12, 14))


def test_ideal_taxels_change_nothing() -> None:
    assert np.array_equal(Taxels().read(FRAMES), FRAMES)
    assert np.array_equal(Taxels().read(FRAMES[0]), FRAMES[0])


def test_the_seed_fixes_pad_and_noise() -> None:
    taxels = Taxels(0.02, 0.05, 0.1, 12, None, 0.05, 0.03, 0.03)
    assert np.array_equal(taxels.read(FRAMES, seed=4), taxels.read(FRAMES, seed=4))
    assert not np.array_equal(taxels.read(FRAMES, seed=4), taxels.read(FRAMES, seed=5))


def test_noise_is_a_share_of_the_peak() -> None:
    wide = np.full((1, 200, 200), 3.0)
    assert (Taxels(noise=0.01).read(wide, seed=1) - wide).std() == pytest.approx(0.03, rel=0.05)


def test_crosstalk_keeps_the_load_inside() -> None:
    spot = np.zeros((9, 9))
    spot[4, 4] = 1.0
    read = Taxels(crosstalk=0.1).read(spot)
    assert read.sum() == pytest.approx(1.0)
    assert read[4, 4] == pytest.approx(0.6)
    assert read[4, 5] == read[3, 4] == pytest.approx(0.1)


def test_hysteresis_shows_on_the_way_down_only() -> None:
    up_down = np.array([0.0, 0.5, 1.0, 0.5, 0.0])[:, None, None] * np.ones((1, 3, 3))
    read = Taxels(hysteresis=0.1).read(up_down)[:, 1, 1]
    assert read == pytest.approx([0.0, 0.5, 1.0, 0.6, 0.0])


def test_scale_and_steps() -> None:
    read = Taxels(bits=3, full_scale=0.8).read(FRAMES)
    assert read.max() == pytest.approx(0.8)
    steps = read / (0.8 / 7)
    assert np.allclose(steps, np.round(steps))


def test_dead_and_stuck_taxels_are_the_pad_s_own() -> None:
    read = Taxels(dead=0.1, stuck=0.1).read(FRAMES, seed=2)
    dead = (read == 0).all(axis=0)
    still = np.ptp(read, axis=0) == 0
    assert dead.sum() == round(0.1 * dead.size)
    assert still.sum() == round(0.1 * dead.size) * 2
    assert np.array_equal(read[:, ~still], FRAMES[:, ~still])


@pytest.mark.parametrize(
    ("make", "says"),
    [
        (lambda: Taxels(noise=-0.1), "noise of taxels must be finite and not negative, got -0.1"),
        (lambda: Taxels(crosstalk=0.3), "crosstalk of taxels must be below .25"),
        (lambda: Taxels(bits=0), "bits of taxels must lie in 1 .. 32"),
        (lambda: Taxels(full_scale=0.0), "full_scale of taxels must be positive"),
        (lambda: Taxels(dead=0.7, stuck=0.7), "must not exceed 1 together"),
        (lambda: Taxels().read(np.zeros(3)), "stress must have shape"),
    ],
)
def test_what_is_wrong_is_told(make: Callable[[], object], says: str) -> None:
    with pytest.raises(InputError) as caught:
        make()
    assert says in str(caught.value)


def test_a_grid_too_coarse_for_the_sensing_depth_is_told() -> None:
    skin = Skin("half-space", sensing_depth_m=0.4e-3)
    pressed = press(Sphere(20e-3), skin, depth=1e-3, per_taxel=2)
    with pytest.raises(InputError, match=r"too coarse for the sensing depth.*per_taxel=3 or more"):
        sense(pressed)
