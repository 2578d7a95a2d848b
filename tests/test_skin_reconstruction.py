"""Seeing the object through the skin."""

from __future__ import annotations

import numpy as np
import pytest

from varishold.errors import InputError
from varishold.skin import PressedSolid, Relief, Skin, Taxels, press, reconstruct, sense
from varishold.solids import SOLIDS, Pose, Sphere, SquarePillar, solid_of_size

LAYER = Skin("layer", 6e-3, 0.45, 1e-3)
BODY = Skin("half-space", sensing_depth_m=1e-3)


def _shape_error(relief: Relief, pressed: PressedSolid) -> float:
    cells = pressed.displacement_m.shape[0] // relief.core.shape[0]
    rows, cols = relief.core.shape
    true = pressed.displacement_m.reshape(rows, cells, cols, cells).mean(axis=(1, 3))[relief.core]
    seen = relief.displacement[relief.core]
    return float(np.std(seen - true) / pressed.depth_m)


@pytest.mark.parametrize("skin", [LAYER, BODY], ids=["layer", "half-space"])
@pytest.mark.parametrize("name", list(SOLIDS))
def test_every_solid_is_seen(name: str, skin: Skin) -> None:
    pose = Pose(1e-3, -0.5e-3, 0.3)
    pressed = press(solid_of_size(name, 14e-3), skin, depth=1.5e-3, pose=pose)
    relief = reconstruct(sense(pressed, Taxels(noise=0.01), seed=3), skin, pitch=1e-3)
    assert _shape_error(relief, pressed) < 0.06
    true = pressed.contact.reshape(64, 2, 64, 2).mean(axis=(1, 3)) > 0.5
    # Steep crests are seen worst: their contact is hardly broader than the sensing depth.
    assert (relief.mask & true).sum() > 0.4 * (relief.mask | true).sum()
    assert (relief.core & ~relief.mask).sum() == 0
    assert (relief.height[~relief.core] == 0).all()
    assert (relief.pressure >= 0).all()


def test_scale_follows_the_frame() -> None:
    frame = sense(press(Sphere(30e-3), LAYER, depth=1e-3), Taxels(noise=0.01), seed=1)
    one, other = reconstruct(frame, LAYER, pitch=1e-3), reconstruct(1e4 * frame, LAYER, pitch=1e-3)
    assert np.allclose(other.height, 1e4 * one.height, rtol=1e-4, atol=1e-3 * other.height.max())
    assert np.array_equal(one.mask, other.mask)


def test_with_a_modulus_heights_are_metres() -> None:
    skin = Skin("layer", 6e-3, 0.45, 1e-3, youngs_modulus_pa=2e5)
    pressed = press(Sphere(30e-3), skin, depth=1e-3)
    relief = reconstruct(sense(pressed), skin, pitch=1e-3)
    assert relief.displacement.max() == pytest.approx(1e-3, rel=0.03)


def test_a_tilt_is_found_and_taken_off() -> None:
    pose = Pose(tip_x=0.03)
    pressed = press(SquarePillar(12e-3, 10e-3), LAYER, depth=1.5e-3, pose=pose)
    relief = reconstruct(sense(pressed), LAYER, pitch=1e-3)
    assert relief.tilt[0] == pytest.approx(0.03, abs=0.008)
    assert relief.tilt[1] == pytest.approx(0.0, abs=0.003)
    level = reconstruct(sense(press(SquarePillar(12e-3, 10e-3), LAYER, depth=1.5e-3)), LAYER, pitch=1e-3)
    assert np.std(relief.height[relief.core]) < 2 * np.std(level.height[level.core])


def test_the_noise_it_states_is_the_noise_it_has() -> None:
    pressed = press(Sphere(30e-3), LAYER, depth=1e-3)
    seen = [reconstruct(sense(pressed, Taxels(noise=0.01), seed=seed), LAYER, pitch=1e-3) for seed in range(12)]
    core = np.logical_and.reduce([relief.core for relief in seen])
    spread = np.stack([relief.displacement for relief in seen]).std(axis=0, ddof=1)[core]
    assert np.median([relief.noise for relief in seen]) == pytest.approx(np.sqrt(np.mean(spread**2)), rel=0.6)


def test_a_stream_goes_on_from_the_frame_before() -> None:
    frame = sense(press(Sphere(30e-3), LAYER, depth=1e-3), Taxels(noise=0.01), seed=1)
    cold = reconstruct(frame, LAYER, pitch=1e-3)
    warm = reconstruct(frame * 1.001, LAYER, pitch=1e-3, start=cold)
    assert warm.iterations < cold.iterations
    assert np.allclose(warm.displacement, cold.displacement, atol=0.02 * cold.displacement.max())


def test_a_matrix_and_transforms_agree() -> None:
    """Small pads use a matrix, larger ones transforms: the same press gives the same surface."""
    small = reconstruct(sense(press(Sphere(30e-3), LAYER, depth=0.5e-3, shape=(17, 17))), LAYER, pitch=1e-3)
    large = reconstruct(sense(press(Sphere(30e-3), LAYER, depth=0.5e-3, shape=(21, 21))), LAYER, pitch=1e-3)
    assert np.allclose(small.displacement, large.displacement[4:-4, 4:-4], atol=0.03 * large.displacement.max())


@pytest.mark.parametrize(
    ("frame", "options", "says"),
    [
        (np.zeros((8, 8)), {}, "holds no contact: its largest value is 0"),
        (np.zeros(8), {}, "a frame must be numbers of shape (rows, cols), got float64 of shape (8,)"),
        (np.full((8, 8), np.inf), {}, "a frame must be finite, got inf at (row, col) = (0, 0)"),
        (np.ones((8, 8)), {"pitch": 0.0}, "pitch must be one spacing in metres"),
        (np.ones((8, 8)), {"pitch": 0.1e-3}, "too deep to be seen through"),
        (np.ones((8, 8)), {"pitch": 0.1}, "too coarse for the sensing depth"),
    ],
)
def test_what_is_wrong_is_told(frame: np.ndarray, options: dict[str, float], says: str) -> None:
    with pytest.raises(InputError) as caught:
        reconstruct(frame, LAYER, **({"pitch": 1e-3} | options))
    assert says in str(caught.value)
