"""The surface under one pad: laws, known presses, and bad input."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from varishold.errors import InputError
from varishold.skin import Skin, Taxels, press, sense
from varishold.touch.pads.measures import MEASURES
from varishold.touch.pads.surface import SURFACES, PadSurface, feel_surface

SKIN = Skin("layer", thickness_m=0.004, poisson=0.45, sensing_depth_m=0.001, youngs_modulus_pa=1.5e5)
PITCH = 0.002
SHAPE = (8, 20)
X = (np.arange(2 * SHAPE[1]) + 0.5 - SHAPE[1]) * PITCH / 2
Y = ((np.arange(2 * SHAPE[0]) + 0.5 - SHAPE[0]) * PITCH / 2)[:, None]

FORMS = {
    "flat": 0 * X + 0 * Y,
    "curved": -(X**2) / (2 * 0.035) + 0 * Y,
    "edge": -np.abs(X - 0.002) * 0.9 + 0 * Y,
    "point": -np.maximum(np.abs(X), np.abs(Y)) * 0.9,
}


def pressed(height: np.ndarray, force: float = 4.0, *, noise: float = 0.01, seed: int = 1) -> np.ndarray:
    """The frame of a height map pressed on the pad."""
    done = press(height, SKIN, force=force, shape=SHAPE, pitch_m=PITCH, per_taxel=2, tolerance=1e-3)
    return sense(done, Taxels(noise=noise), seed=seed)


def felt(frame: np.ndarray, skin: Skin | None = SKIN, **options: object) -> PadSurface:
    out = feel_surface(frame, skin, pitch_m=PITCH, **options)  # type: ignore[arg-type]
    assert out is not None
    return out


@pytest.fixture(scope="module")
def frames() -> dict[str, np.ndarray]:
    return {name: pressed(height) for name, height in FORMS.items()}


@pytest.mark.parametrize("name", SURFACES)
def test_names_plain_forms(frames, name):
    assert felt(frames[name]).name == name


@pytest.mark.parametrize("name", ["flat", "curved", "edge"])
def test_names_plain_forms_without_a_skin(frames, name):
    assert felt(frames[name], None).name == name


def test_a_curved_surface_tells_its_radius(frames):
    surface = felt(frames["curved"])
    low, high = surface.radius_interval_m
    assert low < 0.035 < high
    assert surface.radius_m == pytest.approx(0.035, rel=0.4)
    assert surface.curvature_1_m[0] > surface.curvature_1_m[1]


@pytest.mark.parametrize("skin", [SKIN, None])
def test_everything_told_is_finite_and_consistent(frames, skin):
    for frame in frames.values():
        surface = felt(frame, skin)
        assert surface.log_likelihood.shape == (4,)
        assert surface.log_likelihood.max() == 0
        assert surface.measures.shape == (len(MEASURES),)
        assert np.isfinite(surface.measures).all()
        assert np.isfinite(surface.log_likelihood).all()
        assert np.isfinite([*surface.curvature_1_m, *surface.curvature_sigma_1_m]).all()
        assert min(surface.curvature_sigma_1_m) > 0
        assert surface.probability == pytest.approx(surface.posterior()[SURFACES.index(surface.name)])
        assert surface.posterior().sum() == pytest.approx(1)
        assert 0 < surface.area_share <= 1
        assert surface.reasons


def test_force_and_place_are_those_of_the_press(frames):
    surface = felt(pressed(FORMS["curved"] + 0 * Y - (X - 0.006) ** 2 * 5, 5.0))
    assert surface.force_n == pytest.approx(5.0, rel=0.1)
    off = felt(pressed(-((X - 0.008) ** 2) / 0.05 + 0 * Y))
    assert off.centre_m[0] == pytest.approx(0.008, abs=0.001)
    assert off.centre_m[1] == pytest.approx(0.0, abs=0.001)
    assert off.borders == (False, False, True, True)


def test_a_prior_moves_the_posterior(frames):
    surface = felt(frames["edge"])
    assert surface.posterior([1, 0, 0, 0])[0] == 1
    np.testing.assert_allclose(surface.posterior(), surface.posterior([2, 2, 2, 2]))


@given(factor=st.floats(1e-3, 1e3))
@settings(max_examples=20)
def test_without_a_skin_the_unit_does_not_matter(frames, factor):
    np.testing.assert_allclose(
        felt(frames["edge"] * factor, None).log_likelihood, felt(frames["edge"], None).log_likelihood, atol=1e-6
    )


@pytest.mark.parametrize("skin", [SKIN, None])
@pytest.mark.parametrize("axis", [0, 1])
def test_a_mirrored_pad_feels_the_same(frames, skin, axis):
    for name in ("curved", "edge"):
        here, there = felt(frames[name], skin), felt(np.flip(frames[name], axis), skin)
        np.testing.assert_allclose(here.measures, there.measures, atol=0.05)
        np.testing.assert_allclose(here.posterior(), there.posterior(), atol=0.05)


def test_the_same_frame_gives_the_same_answer(frames):
    first, second = felt(frames["curved"]), felt(frames["curved"].copy())
    assert np.array_equal(first.log_likelihood, second.log_likelihood)
    assert first.radius_m == second.radius_m


@given(seed=st.integers(0, 2**32 - 1), scale=st.floats(1e-6, 1e8), rows=st.integers(3, 24), cols=st.integers(3, 24))
@settings(max_examples=30)
def test_no_frame_crashes_or_gives_what_is_not_finite(seed, scale, rows, cols):
    rng = np.random.default_rng(seed)
    y, x = np.ogrid[:rows, :cols]
    wide = rng.uniform(0.3, 8)
    frame = np.exp(-((x - rng.uniform(0, cols)) ** 2 + rng.uniform(0, 1) * (y - rng.uniform(0, rows)) ** 2) / wide**2)
    frame = (frame + 0.02 * rng.normal(size=(rows, cols))) * scale
    for skin in (SKIN, None):
        surface = feel_surface(frame, skin, pitch_m=PITCH)
        if surface is not None:
            assert np.isfinite(surface.log_likelihood).all()
            assert np.isfinite([*surface.curvature_1_m, *surface.curvature_sigma_1_m]).all()


@pytest.mark.parametrize("skin", [SKIN, None])
def test_one_pressed_taxel_and_an_evenly_pressed_pad(skin):
    single = np.zeros(SHAPE)
    single[3, 5] = 1e4
    for frame in (single, np.full(SHAPE, 1e4), np.pad([[1e4]], ((0, 7), (0, 19)))):
        surface = feel_surface(frame, skin, pitch_m=PITCH)
        assert surface is None or np.isfinite(surface.log_likelihood).all()


@pytest.mark.parametrize("skin", [SKIN, None])
def test_nothing_presses(skin):
    assert feel_surface(np.zeros(SHAPE), skin, pitch_m=PITCH) is None
    assert feel_surface(np.full(SHAPE, -3.0), skin, pitch_m=PITCH) is None
    noise = np.random.default_rng(4).normal(size=SHAPE)
    assert feel_surface(noise, skin, pitch_m=PITCH) is None


def test_a_skin_without_modulus_is_none_at_all(frames):
    soft = Skin("layer", thickness_m=0.004, poisson=0.45, sensing_depth_m=0.001)
    assert np.array_equal(felt(frames["edge"], soft).log_likelihood, felt(frames["edge"], None).log_likelihood)


def test_broken_taxels_are_filled(frames):
    frame, valid = frames["curved"].copy(), np.ones(SHAPE, dtype=bool)
    valid[[2, 5], [9, 12]] = False
    frame[~valid] = np.nan
    assert felt(frame, valid=valid).name == "curved"


def test_a_dead_taxel_that_nobody_marked_is_found(frames: dict[str, np.ndarray]) -> None:
    frame, valid = frames["curved"].copy(), np.ones(SHAPE, dtype=bool)
    valid[np.unravel_index(frame.argmax(), SHAPE)] = False
    frame[~valid] = 0.0
    unmarked, marked = felt(frame), felt(frame, valid=valid)
    np.testing.assert_allclose(unmarked.measures, marked.measures, rtol=1e-9, atol=1e-9)
    assert (unmarked.name, unmarked.radius_m) == (marked.name, marked.radius_m)


def test_taxels_outside_the_field_say_nothing(frames):
    field = np.ones(SHAPE, dtype=bool)
    field[0, 0] = False
    frame = frames["curved"].copy()
    frame[0, 0] = np.nan
    assert felt(frame, field=field).name == "curved"


def test_bad_input_is_refused(frames):
    frame = frames["flat"]
    with pytest.raises(InputError, match=r"3 x 3 taxels or more, got an array of shape \(2, 5\)"):
        feel_surface(np.ones((2, 5)), SKIN, pitch_m=PITCH)
    with pytest.raises(InputError, match=r"numbers of shape \(rows, cols\), got float64 of shape \(4,\)"):
        feel_surface(np.ones(4), SKIN, pitch_m=PITCH)
    with pytest.raises(InputError, match="rows of different lengths"):
        feel_surface([[1.0, 2.0], [1.0]], SKIN, pitch_m=PITCH)  # type: ignore[list-item]
    with pytest.raises(InputError, match="skin must be a Skin or None, got 'layer'"):
        feel_surface(np.ones((4, 4)), "layer", pitch_m=PITCH)  # type: ignore[arg-type]
    broken = frame.copy()
    broken[1, 2] = np.nan
    with pytest.raises(InputError, match=r"finite, got nan at \(row, col\) = \(1, 2\); mark broken taxels in valid"):
        feel_surface(broken, SKIN, pitch_m=PITCH)
    with pytest.raises(InputError, match=r"valid must have the shape of a frame, \(8, 20\), got \(8, 19\)"):
        feel_surface(frame, SKIN, pitch_m=PITCH, valid=np.ones((8, 19), dtype=bool))
    with pytest.raises(InputError, match="taxel"):
        feel_surface(frame, SKIN, pitch_m=PITCH, valid=np.zeros(SHAPE, dtype=bool))
    for pitch in (0.0, -1.0, np.nan, 2.0, "wide"):
        with pytest.raises(InputError, match="pitch_m must"):
            feel_surface(frame, SKIN, pitch_m=pitch)  # type: ignore[arg-type]
    for prior in ([1, 2], [0, 0, 0, 0], [1, 1, 1, -1], [np.nan, 1, 1, 1]):
        with pytest.raises(InputError, match="prior must be 4 weights"):
            felt(frame).posterior(prior)


@pytest.mark.parametrize("variant", ["seen", "bare"])
def test_the_kernel_gives_what_three_layers_of_tanh_units_give(variant):
    from varishold.touch.pads.surface import _load

    network, layers = _load(variant)
    rng = np.random.default_rng(4)
    for white in np.clip(rng.normal(0, 3, (20, layers["shift"].size)), -layers["clip"], layers["clip"]):
        for part, told in zip(("surface", "bend", "spread"), np.split(network.outputs(white), (4, 7)), strict=True):
            hidden = np.tanh(white @ layers[f"{part}_weight_1"] + layers[f"{part}_bias_1"])
            expected = hidden @ layers[f"{part}_weight_2"] + layers[f"{part}_bias_2"]
            assert told == pytest.approx(expected, abs=2e-4)
