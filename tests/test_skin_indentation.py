"""Pressure under known objects on elastic layers: against closed forms, and against the solver of contacts."""

from __future__ import annotations

import numpy as np
import pytest

from varishold.sensor import Skin
from varishold.skin import press
from varishold.skin.indentation import flat_on_layer, round_on_layer
from varishold.skin.media import Layer
from varishold.solids import Sphere

#: So thick that no floor is felt.
DEEP = Layer(10.0, 0.45)
RADIUS_M = 20e-3


@pytest.mark.parametrize("depth_m", [5e-5, 2e-4, 4e-4])
def test_a_ball_on_a_half_space_presses_as_hertz_says(depth_m: float) -> None:
    face = round_on_layer(DEEP, RADIUS_M, 5e-3, "ball")
    reach = np.sqrt(RADIUS_M * depth_m)
    assert face.reach_m(depth_m) == pytest.approx(reach, rel=0.01)
    r = np.linspace(0, 1.2, 50) * reach
    hertz = 2 / np.pi * np.sqrt(depth_m / RADIUS_M) * np.sqrt(np.maximum(1 - (r / reach) ** 2, 0))
    np.testing.assert_allclose(face.pressure(r, depth_m), hertz, atol=0.03 * hertz.max())


def test_a_thin_layer_that_can_be_squeezed_is_a_bed_of_springs() -> None:
    """Deep beneath the edge, where springs of the layer's own compliance hold."""
    layer, depth_m = Layer(2e-4, 0.2), 2e-4
    face = round_on_layer(layer, RADIUS_M, 5e-3, "ball")
    r = np.linspace(0, 0.7, 20) * np.sqrt(2 * RADIUS_M * depth_m)
    springs = (depth_m - r**2 / (2 * RADIUS_M)) / layer.compliance(np.zeros(1))[0]
    np.testing.assert_allclose(face.pressure(r, depth_m), springs, atol=0.05 * springs.max())


@pytest.mark.parametrize("thickness_m", [1e-3, 4e-3])
def test_a_ball_on_a_layer_presses_as_the_solver_of_contacts_finds(thickness_m: float) -> None:
    skin = Skin("layer", thickness_m=thickness_m, poisson=0.45)
    pressed = press(Sphere(48e-3), skin, depth=0.4e-3, shape=(16, 16), pitch_m=2e-3, per_taxel=8)
    r = np.hypot(*np.meshgrid(pressed.x_m, pressed.y_m))
    found = round_on_layer(Layer(thickness_m, 0.45), 24e-3, 15e-3, "ball").pressure(r, 0.4e-3)
    np.testing.assert_allclose(found[pressed.contact], pressed.pressure[pressed.contact], atol=0.03 * found.max())
    assert found.sum() == pytest.approx(pressed.pressure.sum(), rel=0.01)


def test_a_disc_on_a_half_space_presses_as_boussinesq_says() -> None:
    face = flat_on_layer(DEEP, 10e-3, "disc")
    r = np.linspace(0, 4e-3, 30)
    due = 1e-3 / (np.pi * np.sqrt(5e-3**2 - r**2))
    np.testing.assert_allclose(face.pressure(r, 0 * r, 1e-3, 0.0, 0.0, 1e-5), due, rtol=0.03)


def test_a_square_presses_alike_along_both_ways() -> None:
    face = flat_on_layer(Layer(3e-3, 0.45), 10e-3, "square")
    u, v = np.random.default_rng(4).uniform(-5e-3, 5e-3, (2, 40))
    np.testing.assert_allclose(
        face.pressure(u, v, 1e-3, 0.05, 0.02, 1e-5), face.pressure(v, u, 1e-3, 0.02, 0.05, 1e-5), rtol=1e-9, atol=1e-12
    )
    np.testing.assert_allclose(
        face.pressure(u, v, 1e-3, 0.05, 0.0, 1e-5), face.pressure(-u, v, 1e-3, -0.05, 0.0, 1e-5), rtol=1e-3, atol=1e-6
    )


def test_a_roller_on_a_thin_layer_is_as_wide_as_springs_and_on_a_thick_one_narrower() -> None:
    thin, thick = (round_on_layer(Layer(h, 0.3), RADIUS_M, 5e-3, "roller") for h in (2e-4, 2e-2))
    depth_m = 3e-4
    assert thin.reach_m(depth_m) == pytest.approx(np.sqrt(2 * RADIUS_M * depth_m), rel=0.1)
    assert thick.reach_m(depth_m) < 0.7 * thin.reach_m(depth_m)


def test_each_point_of_a_roller_is_as_deep_as_its_line_there() -> None:
    face = round_on_layer(Layer(2e-3, 0.45), RADIUS_M, 5e-3, "roller")
    across, deep = np.array([0.0, 1e-4, 5e-4]), np.array([1e-4, 3e-4, 2e-4])
    alone = [float(face.pressure(np.array([x]), np.array([d]))[0]) for x, d in zip(across, deep, strict=True)]
    np.testing.assert_allclose(face.pressure(across, deep), alone)
    np.testing.assert_allclose(
        alone, [float(face.pressure(x, d)) for x, d in zip(across, deep, strict=True)], rtol=0.02
    )


def test_nothing_presses_beside_a_contact_or_above_the_skin() -> None:
    face = round_on_layer(Layer(2e-3, 0.45), RADIUS_M, 5e-3, "ball")
    assert face.pressure(np.array([1.01 * float(face.reach_m(2e-4))]), 2e-4) == 0.0
    assert face.pressure(np.zeros(3), -1e-4).max() == 0.0
    assert (
        flat_on_layer(Layer(2e-3, 0.45), 1e-2, "square").pressure(np.zeros(2), np.zeros(2), -1e-3, 0, 0, 1e-5).max()
        == 0.0
    )
