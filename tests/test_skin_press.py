"""The contact solver: its laws on every skin, then Hertz's and the flat punch's closed forms."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from varishold.errors import InputError
from varishold.skin import PressedSolid, Skin, press
from varishold.skin.media import Cells, HalfSpace, Layer
from varishold.solids import SOLIDS, Cone, Cylinder, Pose, Sphere, solid_of_size

SKINS = (
    Skin("layer", 6e-3, 0.45),
    Skin("layer", 6e-3, 0.5),
    Skin("layer", 1e-3, 0.3),
    Skin("half-space"),
    Skin("winkler", 6e-3, 0.3),
)


def _press(name: str, skin: Skin, pose: Pose | None = None, depth: float = 1e-3) -> PressedSolid:
    return press(solid_of_size(name, 14e-3), skin, depth=depth, pose=pose, per_taxel=2)


@pytest.mark.parametrize("skin", SKINS, ids=lambda skin: f"{skin.kind}-{skin.poisson}")
@pytest.mark.parametrize("name", list(SOLIDS))
def test_every_solid_is_solved_on_every_skin(name: str, skin: Skin) -> None:
    pressed = _press(name, skin, Pose(1e-3, -0.5e-3, 0.3))
    assert pressed.converged
    assert pressed.rms_gap <= 1e-5
    assert pressed.iterations < 40
    assert (pressed.pressure >= 0).all()
    # Nothing pulls, nothing penetrates, and pressure stands only where the gap is closed.
    assert pressed.gap_m.min() > -1e-4 * pressed.depth_m
    assert np.abs(pressed.gap_m[pressed.contact]).max() < 2e-4 * pressed.depth_m


@pytest.mark.parametrize("skin", SKINS, ids=lambda skin: f"{skin.kind}-{skin.poisson}")
def test_a_quarter_turn_turns_the_answer(skin: Skin) -> None:
    one = _press("hip", skin, Pose(0.0, 0.0, 0.2))
    other = _press("hip", skin, Pose(0.0, 0.0, 0.2 + np.pi / 2))
    assert np.allclose(np.rot90(one.pressure, -1), other.pressure, atol=2e-3 * one.pressure.max())


@settings(max_examples=15)
@given(shift=st.tuples(st.integers(-4, 4), st.integers(-4, 4)))
def test_a_shift_by_taxels_shifts_the_answer(shift: tuple[int, int]) -> None:
    skin = SKINS[0]
    here = press(Cone(8e-3, 4e-3), skin, depth=1e-3, per_taxel=2)
    there = press(Cone(8e-3, 4e-3), skin, depth=1e-3, pose=Pose(shift[1] * 1e-3, shift[0] * 1e-3), per_taxel=2)
    moved = np.roll(here.pressure, (2 * shift[0], 2 * shift[1]), axis=(0, 1))
    assert np.allclose(moved, there.pressure, atol=1e-3 * here.pressure.max())


@settings(max_examples=10)
@given(factor=st.floats(0.3, 3.0))
def test_lengths_scale_together(factor: float) -> None:
    """Pressure over the modulus has no unit: the same press at another scale gives the same pressure."""
    one = press(Sphere(10e-3), Skin("layer", 4e-3, 0.4), depth=0.8e-3, shape=(16, 16), pitch_m=1e-3)
    other = press(
        Sphere(10e-3 * factor),
        Skin("layer", 4e-3 * factor, 0.4),
        depth=0.8e-3 * factor,
        shape=(16, 16),
        pitch_m=1e-3 * factor,
    )
    assert np.allclose(one.pressure, other.pressure, atol=1e-3 * one.pressure.max())
    assert other.force_n == pytest.approx(one.force_n * factor**2, rel=1e-3)


def test_hertz() -> None:
    radius, depth, n = 10e-3, 0.15e-3, 256
    pressed = press(Sphere(2 * radius), Skin("half-space"), depth=depth, shape=(n, n), pitch_m=5e-3 / n)
    side = pressed.x_m[1] - pressed.x_m[0]
    contact_radius = np.sqrt(np.count_nonzero(pressed.contact) * side**2 / np.pi)
    assert contact_radius == pytest.approx(np.sqrt(radius * depth), rel=0.01)
    assert pressed.pressure.max() == pytest.approx(2 / np.pi * np.sqrt(depth / radius), rel=0.005)
    assert pressed.force_n == pytest.approx(4 / 3 * np.sqrt(radius) * depth**1.5, rel=0.005)


def test_flat_punch() -> None:
    radius, depth, n = 2.5e-3, 0.3e-3, 256
    pressed = press(Cylinder(2 * radius, 5e-3), Skin("half-space"), depth=depth, shape=(n, n), pitch_m=8e-3 / n)
    r = np.hypot(pressed.x_m[None, :], pressed.y_m[:, None])
    inside = r < 0.8 * radius
    exact = depth / (np.pi * np.sqrt(radius**2 - r[inside] ** 2))
    assert np.abs(pressed.pressure[inside] / exact - 1).max() < 0.01
    assert pressed.force_n == pytest.approx(2 * radius * depth, rel=0.005)
    # Highest at the rim: the highest level set of the pressure is a ring.
    assert r[pressed.pressure > 0.8 * pressed.pressure.max()].min() > 0.9 * radius


@settings(max_examples=30)
@given(shift=st.floats(-0.5, 0.5), radius_cells=st.floats(6, 20))
def test_a_punch_s_force_does_not_see_the_grid(shift: float, radius_cells: float) -> None:
    """Edges are antialiased: without it the force would jump by a row of cells (several per cent)."""
    side = 0.25e-3
    radius = radius_cells * side
    pressed = press(
        Cylinder(2 * radius, 5e-3),
        Skin("half-space"),
        depth=0.2e-3,
        shape=(48, 48),
        pitch_m=side,
        per_taxel=1,
        pose=Pose(shift * side, 0.3 * shift * side),
    )
    assert pressed.force_n == pytest.approx(2 * radius * 0.2e-3, rel=0.02)


def test_winkler_is_the_height_map() -> None:
    skin = Skin("winkler", 6e-3, 0.3)
    pressed = press(Sphere(20e-3), skin, depth=1e-3)
    stiffness = (1 - 0.3) ** 2 / ((1 - 2 * 0.3) * 6e-3)
    assert np.allclose(pressed.pressure, stiffness * np.maximum(pressed.displacement_m, 0), atol=1e-6)
    assert pressed.displacement_m.max() == pytest.approx(1e-3, rel=1e-2)


@pytest.mark.parametrize("poisson", [-0.5, 0.0, 0.3, 0.45, 0.499, 0.5])
def test_layer_compliance_limits(poisson: float) -> None:
    """Even load: the oedometer's; fine load: a half-space's; finite in between, series and closed form meet."""
    h = 6e-3
    layer = Layer(h, poisson)
    assert layer.compliance(np.zeros(1))[0] == pytest.approx(h * (1 - 2 * poisson) / (1 - poisson) ** 2)
    k = np.array([20.0, 30.0]) / h
    assert layer.compliance(k) == pytest.approx(HalfSpace().compliance(k))
    near = layer.compliance(np.array([0.9999e-3, 1.0001e-3]) / h)
    assert near[0] == pytest.approx(near[1], rel=1e-3)
    assert (layer.compliance(np.geomspace(1e-4, 1e3, 200) / h) > 0).all()


@pytest.mark.parametrize(("poisson", "ratio"), [(0.3, 0.27), (0.45, 1.5), (0.49, 3.9), (0.499, 12.9)])
def test_layer_smooths_over_the_known_length(poisson: float, ratio: float) -> None:
    """Pressure is displacement smoothed over l: compliance(k) ~ compliance(0) (1 + (k l)^2)."""
    h = 1.0
    layer = Layer(h, poisson)
    k = np.array([0.0, 0.02])
    compliance = layer.compliance(k)
    length = np.sqrt(np.abs(compliance[1] / compliance[0] - 1)) / k[1]
    assert length == pytest.approx(ratio, rel=0.1)


def test_layer_influence_is_its_compliance() -> None:
    """A wave pressed onto a wide field sinks as the closed form says."""
    h, side, n = 1e-3, 0.1e-3, 160
    layer = Layer(h, 0.45)
    kernel = layer.influence(Cells(n, n, side, side))
    away = np.minimum(np.arange(n), n - np.arange(n))
    even = kernel[np.ix_(away, away)]
    symbol = np.fft.rfft2(even).real
    k = 2 * np.pi * np.fft.rfftfreq(n, side)
    part = (k > 0.5 / h) & (k < 4 / h)
    # A load on cells is the wave's samples held constant: sinc(k side / 2 pi).
    expected = layer.compliance(k[part]) * np.sinc(k[part] * side / (2 * np.pi))
    assert symbol[0][part] == pytest.approx(expected, rel=0.01)


def test_thin_and_thick_layers_meet_their_limits() -> None:
    solid = Sphere(10e-3)
    thick = press(solid, Skin("layer", 0.2, 0.3), depth=0.3e-3, shape=(64, 64), pitch_m=0.1e-3)
    body = press(solid, Skin("half-space", poisson=0.3), depth=0.3e-3, shape=(64, 64), pitch_m=0.1e-3)
    assert thick.force_n == pytest.approx(body.force_n, rel=0.02)
    thin = press(solid, Skin("layer", 0.05e-3, 0.0), depth=0.01e-3, shape=(64, 64), pitch_m=0.02e-3)
    springs = press(solid, Skin("winkler", 0.05e-3, 0.0), depth=0.01e-3, shape=(64, 64), pitch_m=0.02e-3)
    assert thin.force_n == pytest.approx(springs.force_n, rel=0.08)


@pytest.mark.parametrize("name", ["sphere", "cylinder", "cone", "plane"])
def test_a_press_by_force_is_the_press_by_its_depth(name: str) -> None:
    skin = Skin("layer", 6e-3, 0.45, youngs_modulus_pa=3e5)
    by_force = press(solid_of_size(name, 14e-3), skin, force=5.0, per_taxel=2)
    assert by_force.force_n == pytest.approx(5.0, rel=1e-4)
    by_depth = press(solid_of_size(name, 14e-3), skin, depth=by_force.depth_m, per_taxel=2)
    assert by_depth.force_n == pytest.approx(5.0, rel=1e-3)


def test_a_height_map_is_pressed_like_its_solid() -> None:
    x = (np.arange(128) + 0.5 - 64) * 0.25e-3
    sphere = np.sqrt(np.maximum(100e-6 - x[None, :] ** 2 - x[:, None] ** 2, 0.0))
    mapped = press(sphere, SKINS[0], depth=1e-3)
    solid = press(Sphere(20e-3), SKINS[0], depth=1e-3)
    assert mapped.force_n == pytest.approx(solid.force_n, rel=0.01)


def test_unequal_pitch() -> None:
    even = press(Sphere(20e-3), SKINS[0], depth=1e-3, shape=(32, 32), pitch_m=1e-3)
    uneven = press(Sphere(20e-3), SKINS[0], depth=1e-3, shape=(16, 32), pitch_m=(2e-3, 1e-3))
    assert uneven.force_n == pytest.approx(even.force_n, rel=0.01)
    assert uneven.pressure.shape == (64, 128)


def test_short_of_its_tolerance_it_says_so() -> None:
    with pytest.warns(RuntimeWarning, match="did not converge: rms gap"):
        pressed = press(Cone(10e-3, 5e-3), SKINS[0], depth=1e-3, max_iterations=1)
    assert not pressed.converged


def test_a_fine_tolerance_is_reached_in_double_precision() -> None:
    pressed = press(Cylinder(10e-3, 5e-3), SKINS[0], depth=1e-3, tolerance=1e-9)
    assert pressed.converged
    assert pressed.rms_gap <= 1e-9


SPHERE = Sphere(10e-3)


@pytest.mark.parametrize(
    ("options", "says"),
    [
        ({}, "give either depth"),
        ({"depth": 1e-3, "force": 1.0}, "give either depth"),
        ({"depth": 0.0}, "depth must be positive and finite, got 0.0"),
        ({"depth": float("nan")}, "depth must be positive and finite"),
        ({"depth": 6e-3}, "depth must not exceed the solid's height, 0.005 m"),
        ({"force": 1.0}, "needs the skin's youngs_modulus_pa"),
        ({"depth": 1e-3, "pose": Pose(x_m=0.1)}, "lies outside the field of 0.032 x 0.032 m"),
        ({"depth": 1e-3, "shape": (0, 4)}, "shape must be (rows, cols), two whole numbers from 1"),
        ({"depth": 1e-3, "pitch_m": -1.0}, "pitch_m must be one spacing in metres"),
        ({"depth": 1e-3, "per_taxel": 0}, "per_taxel must be a whole number from 1"),
    ],
)
def test_what_is_wrong_is_told(options: dict[str, object], says: str) -> None:
    with pytest.raises(InputError) as caught:
        press(SPHERE, SKINS[0], **options)  # type: ignore[arg-type]
    assert says in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_force_beyond_the_solid_is_told() -> None:
    with pytest.raises(InputError, match="the force is too large"):
        press(Cone(4e-3, 1e-3), Skin("half-space", youngs_modulus_pa=1e5), force=1e4, per_taxel=2)


@pytest.mark.parametrize(
    ("height", "says"),
    [
        (np.zeros(4), "must be numbers of shape (rows, cols)"),
        (np.zeros((1, 4)), "2 x 2 points or more"),
        (np.full((3, 3), np.nan), "must be finite, got nan at (row, col) = (0, 0)"),
    ],
)
def test_a_wrong_height_map_is_told(height: np.ndarray, says: str) -> None:
    with pytest.raises(InputError) as caught:
        press(height, SKINS[0], depth=1e-3)
    assert says in str(caught.value)


def test_a_height_map_takes_no_pose() -> None:
    with pytest.raises(InputError, match="give no pose"):
        press(np.eye(8) * 1e-3, SKINS[0], depth=1e-3, pose=Pose())
