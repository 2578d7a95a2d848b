"""Presses of known objects tell the gains of the taxels that they press, and leave alone what is even."""

from __future__ import annotations

import dataclasses
from functools import cache

import numpy as np
import pytest
from numpy.typing import NDArray
from tests.test_calibration import SHAPE, depths, recorded

from varishold.calibration import Calibration, KnownObject, calibrate_objects
from varishold.calibration.agreement import Agreement, agreement_of
from varishold.calibration.gains_of_objects import ObjectGains
from varishold.recording import Recording
from varishold.report import render_calibration_report
from varishold.sensor import Linear, Logarithmic, Power, Response, Sensor

Floats = NDArray[np.float64]
BALL, PLATE = KnownObject("ball", 0.05), KnownObject("plate", 0.014)


def gains_of(seed: int, spread: float) -> Floats:
    return np.exp(spread * np.random.default_rng(seed).standard_normal(SHAPE))


def pressed(sensor: Sensor, presses: int = 12, seed: int = 2) -> list[Recording]:
    return [
        recorded(sensor.forward(depths(thing.kind, thing.size_m, presses, seed, deepest)), 5.0, name=thing.kind)
        for thing, deepest in ((BALL, 2e-3), (PLATE, 1.6e-3))
    ]


def uneven(response: Response, spread: float, seed: int = 1) -> Sensor:
    return Sensor(
        span=1000.0, full_scale=2e-3, response=response, blur_taxels=0.5, gains=gains_of(seed, spread), shape=SHAPE
    )


@cache
def calibrated(response: Response, spread: float, seed: int = 1) -> Calibration:
    return calibrate_objects(pressed(uneven(response, spread, seed), seed=seed), [BALL, PLATE])


def off(found: Calibration, true: Floats) -> tuple[Floats, Floats]:
    """Return how far the logarithms of the known gains are off, up to a common one, and their stated errors."""
    gains, known = found.sensor.gains, np.isfinite(found.error)
    assert gains is not None
    left = np.log(gains / true)[known]
    return left - np.median(left), found.error[known]


@pytest.mark.parametrize(("response", "spread"), [(Linear(), 0.25), (Logarithmic(5.0), 0.2), (Power(0.6), 0.1)])
def test_a_ball_and_a_plate_tell_the_gains_of_what_they_press(response: Response, spread: float) -> None:
    found = calibrated(response, spread)
    assert found.sensor.gains is not None
    left, error = off(found, gains_of(1, spread))
    assert np.std(left) < 0.4 * spread
    assert np.mean(np.abs(left) < 2 * error) > 0.85
    # Where nothing pressed, nothing is said.
    assert (found.sensor.gains[np.isnan(found.error)] == 1.0).all()
    assert any("hardly pressed" in note for note in found.notes) == bool(np.isnan(found.error).any())
    spread_found = next(each for each in found.findings if each.name == "gain_spread")
    assert spread_found.value == pytest.approx(spread, rel=0.25)
    assert not any(words.startswith("the gains") for words in found.unknown)
    assert found.sensor.response.kind == response.kind
    assert found.to_dict()["gains_applied"]
    # The page shows how far taxels were apart, and that they are no more.
    assert np.nanstd(found.before) > 3 * np.nanstd(found.after)
    assert "taxels that are all alike" in render_calibration_report(found, title="gains")


def test_constants_beside_gains_are_as_sure_as_they_say() -> None:
    pulls = []
    for seed in (1, 2, 3):
        told = next(each for each in calibrated(Logarithmic(5.0), 0.2, seed).findings if each.name == "a")
        # Full scale is the highest reading of the presses, beside which the same curve has an a of its own.
        pulls.append(abs(told.value - 5.0) / told.error)
        assert 3.5 < told.value < 8.0
    assert np.median(pulls) < 3.0


def test_an_even_sensor_is_left_alone() -> None:
    found = calibrate_objects(pressed(uneven(Power(0.6), 0.0)), [BALL, PLATE])
    assert found.sensor.gains is None
    assert np.isnan(found.error).all()
    assert [each.name for each in found.findings] == ["exponent", "blur_taxels"]
    assert any(words.startswith("the gains") for words in found.unknown)


def test_a_face_that_is_not_quite_the_object_makes_no_gains() -> None:
    sensor = Sensor(span=1000.0, full_scale=2e-3, blur_taxels=0.5)
    faces = [depths(thing.kind, thing.size_m, 12, 3, 1.6e-3) for thing in (BALL, PLATE)]
    # A plate that wears round: its middle stands out by a quarter.
    y, x = np.indices(SHAPE)
    for face in faces[1]:
        at = np.array([(face * x).sum(), (face * y).sum()]) / face.sum()
        face *= 1.0 - 0.25 * np.minimum(((x - at[0]) ** 2 + (y - at[1]) ** 2) / 18.0, 1.0)
    recordings = [recorded(sensor.forward(each), 5.0, name=name) for each, name in zip(faces, "bp", strict=True)]
    assert calibrate_objects(recordings, [BALL, PLATE]).sensor.gains is None


def test_gains_that_are_not_known_well_are_told_and_not_applied() -> None:
    rng, shape = np.random.default_rng(5), (8, 8)
    log = 0.2 * rng.standard_normal(shape)
    known = ObjectGains(log, np.full(shape, 0.05), Agreement(0.2, 0.9, 0.02))
    assert known.worth
    off = ObjectGains(log, np.full(shape, 0.6), Agreement(0.2, 0.9, 0.02))
    assert not off.worth
    assert "may be off by" in off.refusal
    assert "nothing is won" in ObjectGains(log, np.full(shape, 0.05), Agreement(0.01, 0.9, 0.02)).refusal


def test_gains_that_are_known_stay() -> None:
    sensor = uneven(Power(0.6), 0.2)
    found = calibrate_objects(pressed(sensor), [BALL, PLATE], sensor=Sensor(gains=sensor.gains))
    assert found.sensor.gains is not None
    np.testing.assert_array_equal(found.sensor.gains, sensor.gains)
    assert np.isnan(found.error).all()


def test_undoing_with_gains_does_better_than_a_blur_alone_and_than_nothing() -> None:
    found = calibrated(Power(1.6), 0.2).sensor
    true = depths("ball", 0.05, 1, 9, 2e-3)[0]
    frame = uneven(Power(1.6), 0.2).forward(true)

    def left(of: Floats) -> float:
        return float(np.std(of * (of * true).sum() / (of * of).sum() - true))

    blunt = dataclasses.replace(found, gains=None)
    assert left(found.undo(frame).frame) < 0.5 * min(left(blunt.undo(frame).frame), left(frame))


def test_halves_agree_on_what_both_have() -> None:
    rng = np.random.default_rng(3)
    gains, one, other = 0.1 * rng.standard_normal(4000), *(0.02 * rng.standard_normal((2, 4000)))
    agreed = agreement_of(gains + one, gains + other)
    assert agreed.worth
    assert agreed.spread == pytest.approx(0.1, rel=0.05)
    assert agreed.differ == pytest.approx(0.02 / np.sqrt(2), rel=0.05)
    assert not agreement_of(one, other).worth
    assert "nothing is won" in agreement_of(one, other).refusal
    assert not agreement_of(np.empty(0), np.empty(0)).worth


def test_a_ball_alone_tells_a_bent_response_beside_unequal_gains() -> None:
    # Beside unequal gains all responses leave much the same of these presses, and gains behind the wrong one hide it.
    sensor = uneven(Logarithmic(8.0), 0.25, 3)
    found = calibrate_objects([recorded(sensor.forward(depths("ball", 0.05, 8, 6, 2e-3)), 5.0)], [BALL])
    assert isinstance(found.sensor.response, Logarithmic)
    left, _ = off(found, gains_of(3, 0.25))
    assert np.std(left) < 0.25 * 0.25


def test_taxels_that_stay_silent_are_broken_and_pull_at_nothing() -> None:
    sensor, dead = uneven(Logarithmic(5.0), 0.15), ([5, 8, 9], [7, 7, 9])
    recordings = []
    for thing, deepest in ((BALL, 2e-3), (PLATE, 1.6e-3)):
        frames = sensor.forward(depths(thing.kind, thing.size_m, 12, 2, deepest))
        frames[:, *dead] = 0.0
        recordings.append(recorded(frames, 5.0, name=thing.kind))
    found = calibrate_objects(recordings, [BALL, PLATE])
    gains = found.sensor.gains
    assert gains is not None
    assert (np.argwhere(gains == 0.0) == np.transpose(dead)).all()
    assert any("3 taxels stay silent under presses and are marked broken" in words for words in found.notes)
    assert not any("not quite of such objects" in words for words in found.notes)
    told = {each.name: each for each in found.findings}
    assert abs(told["blur_taxels"].value - 0.5) < 3 * told["blur_taxels"].error


def test_what_nobody_explains_makes_no_blur() -> None:
    # A flat face shows no response, and what a logarithm does to its edges looks like a blur.
    sensor = uneven(Logarithmic(8.0), 0.2)
    found = calibrate_objects([recorded(sensor.forward(depths("plate", 0.014, 12, 5, 1.6e-3)), 5.0)], [PLATE])
    assert any("not quite of such objects" in words for words in found.notes)
    assert found.sensor.blur_taxels == 0.0
    assert "blur_taxels" not in [each.name for each in found.findings]
    assert any(words.startswith("a blur:") for words in found.unknown)
