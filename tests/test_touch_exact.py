"""Recognition by fitting forms through the skin."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from varishold.errors import InputError, NotConvergedError
from varishold.recording import Pad, Recording
from varishold.skin import Skin, press, sense
from varishold.skin.synthesis import synthesis_of
from varishold.solids import Cone, ConeFrustum, Cylinder, LyingCylinder, Pose, RectangularPillar, Solid, Sphere
from varishold.touch import find_contacts, recognize_recording
from varishold.touch.exact import FITTED, recognize_exact
from varishold.touch.exact.form import Grid, Start
from varishold.touch.names import KINDS

LAYER = Skin("layer", thickness_m=6e-3, poisson=0.45, sensing_depth_m=1e-3)
START = Start(x=0.3, y=-0.4, long=7.0, short=4.4, yaw=0.4, square_yaw=0.3, descent=0.7)
FORMS = [form for forms in FITTED.values() for form in forms]


def _grid(rows: int, cols: int, per_taxel: int) -> Grid:
    x, y = synthesis_of(LAYER, rows, cols, (1e-3, 1e-3), per_taxel).points_m
    return Grid(x * 1e3, y * 1e3, 1 / per_taxel, 1 / per_taxel)


def _frame(solid: Solid, pose: Pose, *, skin: Skin = LAYER, depth: float = 1e-3, seed: int = 5) -> np.ndarray:
    made = press(solid, skin, depth=depth, pose=pose, shape=(24, 24), pitch_m=1e-3, per_taxel=4, tolerance=1e-4)
    frame = sense(made)
    return frame + np.random.default_rng(seed).normal(0, 0.01 * frame.max(), frame.shape)


def test_every_kind_with_a_name_is_fitted() -> None:
    named = {kind.key for kind in KINDS if kind.name != "unknown"}
    assert set(FITTED) == named


@pytest.mark.parametrize("form", FORMS, ids=lambda form: type(form).__name__)
def test_gradients_are_those_of_the_frame(form) -> None:
    synthesis, grid = synthesis_of(LAYER, 14, 14, (1e-3, 1e-3), 2), _grid(14, 14, 2)
    q = form.start(START)
    made = synthesis.frame(form.face(q, grid))
    for i in range(len(q)):
        # A change so large that single precision does not matter, so small that the contact hardly does.
        step = np.zeros(len(q))
        step[i] = 0.002
        high = synthesis.frame(form.face(q + step, grid), start=made.active).frame
        low = synthesis.frame(form.face(q - step, grid), start=made.active).frame
        difference = (high - low) / 0.004
        away = np.linalg.norm(made.gradient[i] - difference)
        assert away < 0.1 * np.linalg.norm(difference) + 1e-3 * np.linalg.norm(made.frame), form.names[i]


@settings(max_examples=10)
@given(st.floats(-2, 2), st.floats(-2, 2), st.floats(0, 1.5), st.floats(4, 8))
def test_covered_cells_add_up_to_the_face(x: float, y: float, yaw: float, breadth: float) -> None:
    grid = _grid(16, 16, 2)
    square = FITTED["square-pillar"][0].face(np.array([x, y, yaw, breadth]), grid)
    disc = FITTED["cylinder"][0].face(np.array([x, y, breadth]), grid)
    assert square.covered.sum() / 4 == pytest.approx(breadth**2, rel=0.02)
    assert disc.covered.sum() / 4 == pytest.approx(np.pi * breadth**2 / 4, rel=0.03)


def test_a_contact_pushes_everywhere_and_meets_the_face() -> None:
    synthesis, grid = synthesis_of(LAYER, 16, 16, (1e-3, 1e-3), 1), _grid(16, 16, 1)
    made = synthesis.frame(FITTED["sphere"][0].face(np.array([0.0, 0.0, 10.0]), grid))
    assert (made.pressure >= 0).all()
    assert np.array_equal(made.pressure > 0, made.active)
    np.testing.assert_allclose(made.frame, made.frame[::-1, ::-1], rtol=1e-3, atol=1e-3 * made.frame.max())


def test_the_coarse_frame_is_nearly_the_fine_solvers() -> None:
    sphere = Sphere(40e-3)
    fine = sense(press(sphere, LAYER, depth=0.5e-3, shape=(16, 16), pitch_m=1e-3, per_taxel=4, tolerance=1e-4))
    synthesis, grid = synthesis_of(LAYER, 16, 16, (1e-3, 1e-3), 1), _grid(16, 16, 1)
    # The cap meets the free skin where a circle of that radius is .5 mm deep.
    diameter = 2 * np.sqrt(2 * 20.0 * 0.5)
    coarse = 0.5e-3 * synthesis.frame(FITTED["sphere"][0].face(np.array([0.0, 0.0, diameter]), grid)).frame
    assert np.abs(coarse - fine).max() < 0.03 * fine.max()


def test_a_face_that_leaves_the_window_touches_nothing() -> None:
    synthesis, grid = synthesis_of(LAYER, 16, 16, (1e-3, 1e-3), 1), _grid(16, 16, 1)
    face = FITTED["cylinder"][0].face(np.array([50.0, 0.0, 6.0]), grid)
    with pytest.raises(NotConvergedError, match="nothing touches"):
        synthesis.frame(face)


@pytest.mark.parametrize(
    ("solid", "key", "sizes"),
    [
        (Cone(24e-3, 2e-3), "cone", {"diameter_m": 12e-3}),
        (Cylinder(11e-3, 4e-3), "cylinder", {"diameter_m": 11e-3}),
        (ConeFrustum(20e-3, 6e-3, 2e-3), "cone-frustum", {"diameter_m": 13e-3, "top_share": 6 / 13}),
        (RectangularPillar(14e-3, 7e-3, 4e-3), "rectangular-pillar", {"length_m": 14e-3, "breadth_m": 7e-3}),
    ],
    ids=lambda value: value if isinstance(value, str) else "",
)
def test_a_fit_finds_what_was_pressed(solid: Solid, key: str, sizes: dict[str, float]) -> None:
    pose = Pose(1.3e-3, -0.8e-3, 0.5)
    contact = find_contacts(_frame(solid, pose), pitch=1e-3)[0]
    surface = recognize_exact(contact, LAYER)
    assert next(iter(surface.fits)) == key
    assert surface.name == solid.name
    assert surface.fitted["x_m"] == pytest.approx(pose.x_m, abs=0.15e-3)
    assert surface.fitted["y_m"] == pytest.approx(pose.y_m, abs=0.15e-3)
    for name, value in sizes.items():
        assert surface.fitted[name] == pytest.approx(value, rel=0.08), name
    assert surface.kind_probability.sum() == pytest.approx(1)
    assert surface.reasons[0].startswith(f"fitted through the skin as {key.replace('-', ' ')}: chi^2 ")
    assert surface.reasons[2].startswith("next best ")


def test_a_large_contact_is_fitted_on_means_of_taxels() -> None:
    skin = Skin("layer", thickness_m=6e-3, poisson=0.45, sensing_depth_m=1e-3)
    made = press(
        Cylinder(21e-3, 4e-3), skin, depth=1e-3, pose=Pose(1e-3, -2e-3), shape=(61, 64), pitch_m=0.5e-3, per_taxel=2
    )
    surface = recognize_exact(find_contacts(sense(made), pitch=0.5e-3)[0], skin)
    assert surface.name == "cylinder"
    assert surface.unit == pytest.approx(1e-3)
    assert surface.fitted["x_m"] == pytest.approx(1e-3, abs=0.1e-3)
    assert surface.fitted["y_m"] == pytest.approx(-2e-3, abs=0.1e-3)
    assert surface.fitted["diameter_m"] == pytest.approx(21e-3, rel=0.03)


def test_the_depth_is_told_where_modulus_and_unit_are_known() -> None:
    skin = Skin("layer", thickness_m=6e-3, poisson=0.45, sensing_depth_m=1e-3, youngs_modulus_pa=2e5)
    contact = find_contacts(_frame(Sphere(40e-3), Pose(), skin=skin, depth=0.8e-3), pitch=1e-3)[0]
    assert recognize_exact(contact, skin).depth_m is None
    surface = recognize_exact(contact, skin, pascal=1.0)
    assert surface.depth_m == pytest.approx(0.8e-3, rel=0.05)
    assert "depth_m" in surface.reasons[1]


@pytest.mark.parametrize(
    "solid", [Sphere(24e-3), Sphere(50e-3), LyingCylinder(12e-3, 18e-3), LyingCylinder(30e-3, 18e-3)]
)
@pytest.mark.parametrize("depth", [0.5e-3, 1.5e-3])
def test_the_radius_is_that_of_what_was_pressed(solid: Solid, depth: float) -> None:
    """A paraboloid through the contact line, below the top by the depth, is of another curvature."""
    skin = Skin("half-space", poisson=0.45, sensing_depth_m=1e-3, youngs_modulus_pa=2e5)
    contact = find_contacts(_frame(solid, Pose(0.4e-3, -0.3e-3, 0.4), skin=skin, depth=depth), pitch=1e-3)[0]
    assert recognize_exact(contact, skin).radius_m is None
    surface = recognize_exact(contact, skin, pascal=1.0)
    assert surface.name == solid.name
    assert surface.radius_m == pytest.approx(solid.diameter_m / 2, rel=0.06)


def test_a_frame_that_no_form_makes_is_unknown() -> None:
    y, x = np.mgrid[-12:12, -12:12] + 0.5
    # A star of five points.
    star = np.maximum(1 - np.hypot(x, y) / (6 + 5 * np.cos(5 * np.arctan2(y, x))), 0.0)
    made = press(np.repeat(np.repeat(3e-3 * star, 2, 0), 2, 1), LAYER, depth=1.5e-3, shape=(24, 24), per_taxel=2)
    surface = recognize_exact(find_contacts(sense(made), pitch=1e-3)[0], LAYER)
    assert surface.name == "unknown"


def test_the_same_frame_gives_the_same_answer() -> None:
    contact = find_contacts(_frame(Sphere(30e-3), Pose()), pitch=1e-3)[0]
    first, second = recognize_exact(contact, LAYER), recognize_exact(contact, LAYER)
    assert np.array_equal(first.kind_probability, second.kind_probability)


def test_fitting_needs_pitch_and_skin() -> None:
    frame = _frame(Sphere(30e-3), Pose())
    with pytest.raises(InputError, match="needs the contact's pitch"):
        recognize_exact(find_contacts(frame)[0], LAYER)
    recording = Recording(pads={"pad": Pad(frames=frame[None], pitch_m=(1e-3, 1e-3))})
    with pytest.raises(InputError, match="fits forms through the skin and needs one"):
        next(recognize_recording(recording, exact=True))
    answer = next(recognize_recording(recording, skin=LAYER, exact=True))
    assert answer.surface.name == "sphere"
    assert answer.to_dict()["reasons"][0].startswith("fitted through the skin as sphere")


def test_what_no_form_fits_well_stays_what_the_taxels_say() -> None:
    """A flat face and its skin end beyond the pad, which no form knows: a bowl fits best, and badly."""
    skin = Skin("half-space", poisson=0.45, sensing_depth_m=0.5e-3)
    frame = sense(press(np.full((28 * 3, 28 * 3), 2e-3), skin, depth=1e-3, shape=(28, 28), pitch_m=1e-3, per_taxel=3))
    seen = frame[6:-6, 6:-6] + np.random.default_rng(3).normal(0, 0.02 * frame.max(), (16, 16))
    surface = recognize_exact(find_contacts(seen, pitch=1e-3)[0], skin)
    assert next(iter(surface.fits)) != "plane"
    assert surface.name == "plane"
