"""Fitting forms to a frame through the skin."""

from __future__ import annotations

import numpy as np
import pytest

from varishold.errors import InputError
from varishold.skin import Skin, Taxels, press, reconstruct, sense
from varishold.skin.exact import _model, fit_forms, hint_of
from varishold.skin.forms import FORMS
from varishold.solids import DRAWABLE, SOLIDS, Cylinder, Pose, RectangularPillar, draw_contact

LAYER = Skin("layer", 6e-3, 0.45, 1e-3)


def test_every_drawable_solid_can_be_fitted() -> None:
    assert set(FORMS) == set(DRAWABLE)
    assert set(FORMS) <= set(SOLIDS)


@pytest.mark.parametrize("name", list(FORMS))
def test_the_right_form_costs_least(name: str) -> None:
    rng = np.random.default_rng(2)
    drawn = draw_contact(rng, name, field_m=(32e-3, 32e-3), size_m=(14e-3, 18e-3), slope=(0.08, 0.2))
    pressed = press(drawn.solid, LAYER, depth=drawn.depth_m, pose=drawn.pose)
    frame = sense(pressed, Taxels(noise=0.01), seed=3)
    forms = {name, "cylinder", "cone", "sphere", "ridge"}
    fits = fit_forms(frame, LAYER, pitch=1e-3, forms=forms)
    assert SOLIDS[fits[0].solid].name == SOLIDS[name].name
    assert fits[0].misfit < 1.0
    assert [fit.cost for fit in fits] == sorted(fit.cost for fit in fits)


def test_sizes_pose_and_depth_are_found() -> None:
    skin = Skin("layer", 6e-3, 0.45, 1e-3, youngs_modulus_pa=2e5)
    solid, pose = RectangularPillar(16e-3, 9e-3, 5e-3), Pose(2e-3, -1e-3, 0.4)
    frame = sense(press(solid, skin, depth=1.2e-3, pose=pose), Taxels(noise=0.01), seed=1)
    (fit,) = fit_forms(frame, skin, pitch=1e-3, forms=["rectangular-pillar"])
    assert fit.parameters["length_m"] == pytest.approx(16e-3, rel=0.02)
    assert fit.parameters["breadth_m"] == pytest.approx(9e-3, rel=0.03)
    assert fit.parameters["x_m"] == pytest.approx(2e-3, abs=0.1e-3)
    assert fit.parameters["y_m"] == pytest.approx(-1e-3, abs=0.1e-3)
    assert fit.parameters["yaw_rad"] == pytest.approx(0.4, abs=0.03)
    assert fit.depth == pytest.approx(1.2e-3, rel=0.03)
    assert np.abs(fit.frame - frame).max() < 0.1 * frame.max()


@pytest.mark.parametrize("name", ["cone", "hip", "cone-frustum", "lying-cylinder"])
def test_derivatives_are_those_of_the_model(name: str) -> None:
    """Against presses at moved parameters; the contact line is free there and held here, to first order alike."""
    drawn = draw_contact(
        np.random.default_rng(4), name, field_m=(32e-3, 32e-3), size_m=(15e-3, 16e-3), slope=(0.1, 0.12)
    )
    frame = sense(press(drawn.solid, LAYER, depth=drawn.depth_m, pose=drawn.pose))
    model = _model(LAYER, 32, 32, 1e-3, 1e-3)
    form = FORMS[name]
    q = form.starts(hint_of(reconstruct(frame, LAYER, pitch=1e-3)))[0]
    scales = np.full(q.size, 0.1)
    scales[:2] = 1e-3
    here = model.press(form, q, None)
    assert here is not None
    exact = model.derivative(form, q, here[0], here[2], scales)
    for k in range(q.size):
        nudge = np.zeros_like(q)
        nudge[k] = 0.2 * scales[k]
        after, before = model.press(form, q + nudge, None), model.press(form, q - nudge, None)
        assert after is not None
        assert before is not None
        difference = (after[1] - before[1]) / 0.4
        error = np.linalg.norm(difference - exact[k]) / np.linalg.norm(difference)
        assert error < 0.25


def test_what_is_wrong_is_told() -> None:
    frame = sense(press(Cylinder(10e-3, 5e-3), LAYER, depth=1e-3))
    with pytest.raises(InputError, match="cannot fit a 'ball'; known are cylinder"):
        fit_forms(frame, LAYER, pitch=1e-3, forms=["ball"])
    with pytest.raises(InputError, match="holds no contact"):
        fit_forms(np.zeros((8, 8)), LAYER, pitch=1e-3)
