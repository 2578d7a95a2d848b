"""Known objects pressed through an elastic cover: its thickness and the response behind it."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from numpy.typing import NDArray
from tests.test_calibration import recorded as pressed_recording

from varishold.calibration import Calibration, KnownObject, calibrate_objects
from varishold.calibration.covers import SPRINGS, Elastic, cover_of
from varishold.calibration.imprint import OBJECTS, Points
from varishold.calibration.thickness import _turning_point, has_floor
from varishold.sensor import Logarithmic, Sensor, Skin
from varishold.skin import press
from varishold.solids import Pose, Sphere, SquarePillar

PITCH_M, SIDE = 2e-3, 12
PAD = Points((SIDE, SIDE), (PITCH_M, PITCH_M))
BALL_M, PLATE_M = 48e-3, 10e-3


def pressed(skin: Skin, seed: int) -> list[NDArray[np.float64]]:
    """Return six presses of a ball and of a square plate by the solver of contacts, each object's highest 1."""
    rng = np.random.default_rng(seed)
    made = []
    for solid, reach, depths in (
        (Sphere(BALL_M), 6e-3, (0.2e-3, 0.7e-3)),
        (SquarePillar(PLATE_M, 5e-3), 5e-3, (1e-4, 3e-4)),
    ):
        frames = []
        for _ in range(6):
            pose = Pose(*rng.uniform(-reach, reach, 2), rng.uniform(0, np.pi / 2))
            found = press(
                solid, skin, depth=rng.uniform(*depths), shape=(SIDE, SIDE), pitch_m=PITCH_M, pose=pose, per_taxel=12
            )
            frames.append(found.pressure.reshape(SIDE, 12, SIDE, 12).mean(axis=(1, 3)))
        made.append(np.array(frames) / np.max(frames))
    return made


@pytest.fixture(scope="module")
def through_a_layer() -> Calibration:
    frames = pressed(Skin("layer", thickness_m=4e-3, poisson=0.45), 3)
    recordings = [pressed_recording(1000 * np.log1p(5 * each) / np.log(6), 8.0) for each in frames]
    return calibrate_objects(recordings, [KnownObject("ball", BALL_M), KnownObject("plate", PLATE_M)])


def test_a_ball_and_a_plate_tell_how_thick_a_cover_is_and_the_response_behind_it(through_a_layer: Calibration) -> None:
    found = {each.name: each for each in through_a_layer.findings}
    assert found["thickness_m"].value == pytest.approx(4e-3, rel=0.15)
    assert abs(found["a"].value - 5.0) < 3 * found["a"].error
    assert isinstance(through_a_layer.sensor.response, Logarithmic)
    # By springs alone the logarithm's a is some forty.
    assert through_a_layer.sensor.response.a == pytest.approx(5.0, rel=0.5)


def test_the_thickness_is_kept_in_the_file_and_no_skin_is_written(through_a_layer: Calibration) -> None:
    assert through_a_layer.sensor.calibration["thickness_m"] == pytest.approx(4e-3, rel=0.15)
    assert through_a_layer.sensor.cover is None
    assert any("no [skin] is written" in note for note in through_a_layer.notes)
    assert any("Poisson" in each for each in through_a_layer.unknown)


@pytest.mark.parametrize(
    ("before", "here", "after", "due"), [(1, 0, 1, 0.0), (2, 1, 1, 0.5), (3, 2, 1, 1), (1, 2, 3, -1)]
)
def test_a_parabola_turns_where_it_is_lowest(before: float, here: float, after: float, due: float) -> None:
    assert _turning_point(before, here, after) == pytest.approx(due)


def test_a_cover_of_a_file_is_what_it_says() -> None:
    assert cover_of(Skin("winkler", thickness_m=1e-3, poisson=0.2), 0.05) is SPRINGS
    assert cover_of(Skin("layer", thickness_m=1e-3, poisson=0.4), 0.05) == Elastic(1e-3, 0.4, 0.05)
    assert not has_floor(cover_of(Skin("half-space"), 0.05))
    assert has_floor(Elastic(1e-3, 0.4, 0.05))
    assert not has_floor(SPRINGS)


@pytest.mark.parametrize("kind", OBJECTS)
@pytest.mark.parametrize("cover", [SPRINGS, Elastic(3e-3, 0.45, PAD.diagonal_m)])
def test_what_lies_beyond_the_taxels_looked_at_is_not_pressed(kind: str, cover: Elastic) -> None:
    """Only taxels near the press are looked at: the same as looking at all of a larger pad."""
    thing, pad = KnownObject(kind, 0.014), dataclasses.replace(PAD, cover=cover)
    at = np.zeros(len(thing.parameters))
    at[list(thing.parameters).index("depth_m")] = 4e-4
    small = thing.stress(at, pad)
    large = thing.stress(at, dataclasses.replace(pad, shape=(SIDE + 8, SIDE + 8)))
    np.testing.assert_allclose(large[4:-4, 4:-4], small, atol=1e-12)
    moved = at.copy()
    for name in ("x_m", "across_m"):
        if name in thing.parameters:
            moved[list(thing.parameters).index(name)] = 3 * PITCH_M
    if kind != "roller":
        np.testing.assert_allclose(thing.stress(moved, pad)[:, 3:], small[:, :-3], atol=1e-9)
    assert small.sum() > 0


def test_a_sensor_whose_skin_is_known_is_fitted_through_it() -> None:
    skin = Skin("layer", thickness_m=4e-3, poisson=0.45)
    frames = pressed(skin, 5)
    recordings = [pressed_recording(1000 * each, 8.0) for each in frames]
    things = [KnownObject("ball", BALL_M), KnownObject("plate", PLATE_M)]
    known, said = Sensor(cover=skin, gains=np.ones((SIDE, SIDE))), list[dict[str, int]]()
    found = calibrate_objects(recordings, things, sensor=known, tick=lambda **step: said.append(step))
    assert [step["total"] for step in said if "total" in step] == [sum(step.get("advance", 0) for step in said)]
    assert found.sensor.cover == skin
    assert {each.name for each in found.findings} == {"blur_taxels"}
    assert any("response is linear" in note for note in found.notes)
