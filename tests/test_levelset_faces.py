"""A flat face that presses hardest at its rim is one contact, and two things beside each other are two."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from hostile.sections import Case, compare
from varishold.levelset import find_contacts
from varishold.skin import Skin, Taxels, press, sense
from varishold.solids import Cylinder, Pose, RectangularPillar, Solid, SquarePillar
from varishold.touch import recognize

HALF_SPACE = Skin("half-space", poisson=0.45)
FACES: list[Solid] = [Cylinder(8e-3, 3e-3), SquarePillar(8e-3, 3e-3), RectangularPillar(11e-3, 6e-3, 3e-3)]


def pressed(solid: Solid, yaw: float, side: int, seed: int) -> NDArray[np.float64]:
    """Return what taxels of a millimetre feel that lie at the surface of a bare half-space."""
    rng = np.random.default_rng(seed)
    at = rng.uniform(-0.5e-3, 0.5e-3, 2)
    pose = Pose(yaw_rad=yaw, x_m=float(at[0]), y_m=float(at[1]))
    found = press(solid, HALF_SPACE, depth=0.5e-3, pose=pose, shape=(side, side), pitch_m=16e-3 / side)
    frame = sense(found, Taxels(noise=0.01, gain_spread=0.03), seed=seed)
    return np.asarray(frame / frame.max())


@pytest.mark.parametrize("solid", FACES, ids=lambda solid: solid.name)
@pytest.mark.parametrize("side", [16, 32])
def test_a_face_on_a_half_space_is_one_contact(solid: Solid, side: int) -> None:
    right = 0
    for seed in range(6):
        frame = pressed(solid, 0.3 * seed, side, seed)
        for found in (find_contacts(frame), find_contacts(frame, sigma=0.01)):
            assert len(found) == 1
            right += recognize(found[0]).name == solid.name
    assert right >= 11


def bowl(rng: np.random.Generator) -> NDArray[np.float64]:
    """Draw a face, or two beside each other, whose rims stand as high as they like."""
    rows, cols = rng.integers(7, 13, 2)
    y, x = np.mgrid[:rows, :cols]
    frame = np.abs(rng.normal(0, 0.01, (rows, cols)))
    for _ in range(rng.integers(1, 3)):
        middle, half = rng.uniform(0, (rows, cols)), rng.uniform(2, 5, 2)
        deep = 1 - np.maximum(np.abs(y - middle[0]) / half[0], np.abs(x - middle[1]) / half[1])
        high = 0.3 + rng.uniform(0, 1.2) * np.exp(-half.min() * deep / rng.uniform(0.5, 2))
        frame = np.where(deep > 0, high * rng.uniform(0.8, 1.2, frame.shape), frame)
    return frame


def test_faces_are_those_of_the_reference() -> None:
    one = 0
    for seed in range(300):
        frame = bowl(np.random.default_rng(seed))
        floor = 0.06 * float(frame.max())
        assert compare(Case(frame, np.array([0.5, 0.2]) * frame.max(), floor, (1.0, 1.0))) == []
        one += len(find_contacts(frame, floor=floor)) == 1
    assert 60 < one < 270


@pytest.mark.parametrize("gap", [2, 3])
def test_two_faces_beside_each_other_are_two(gap: int) -> None:
    one = pressed(SquarePillar(8e-3, 3e-3), 0.0, 32, 1)[6:26, 6:26]
    frame = np.zeros((32, 48)) + np.random.default_rng(0).normal(0, 0.005, (32, 48))
    frame[6:26, 2:22] += one
    frame[6:26, 20 + gap : 40 + gap] += one
    assert len(find_contacts(frame)) == 2


@pytest.mark.parametrize("side", [16, 32])
def test_pins_on_a_plate_are_several(side: int) -> None:
    y, x = np.mgrid[:side, :side] - (side - 1) / 2
    plate = 0.2 * (np.maximum(np.abs(x), np.abs(y)) < 0.35 * side)
    for n_pins in (2, 3, 4, 5):
        frame = plate + np.random.default_rng(n_pins).normal(0, 0.005, plate.shape)
        for turn in 2 * np.pi * np.arange(n_pins) / n_pins:
            away = np.hypot(x - 0.24 * side * np.cos(turn), y - 0.24 * side * np.sin(turn))
            frame += np.exp(-((away / (0.07 * side)) ** 2))
        assert len(find_contacts(frame)) == n_pins
