"""What a calibration says it knows, against sensors and presses that share no drawing with the rest of the project."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.ndimage import gaussian_filter

from varishold.calibration import (
    Calibration,
    calibrate_even,
    calibrate_objects,
    calibrate_scale,
    calibrate_unlabelled,
    known_object,
)
from varishold.recording import Pad, Recording
from varishold.sensor import Sensor

Floats = np.ndarray
SHAPE = (10, 14)
LEVELS = np.linspace(0.3, 0.9, 5)


def gains_of(rng: np.random.Generator, spread: float = 0.15) -> Floats:
    gains = np.exp(rng.normal(0.0, spread, SHAPE))
    return gains / np.median(gains)


def logarithmic(stress: Floats) -> Floats:
    return np.log1p(20.0 * stress) / np.log(21.0)


def recorded(maps: list[Floats], rng: np.random.Generator, *, span: float = 900.0, noise: float = 2.0) -> Recording:
    """Presses of a dozen frames, with a rest of a dozen frames around each."""
    frames = [np.zeros(SHAPE)] * 12
    for one in maps:
        frames += [one / 3, 2 * one / 3, *[one] * 12, 2 * one / 3, one / 3, *[np.zeros(SHAPE)] * 12]
    rest = 20.0 + rng.normal(0.0, 3.0, SHAPE)
    values = rest + span * np.array(frames)
    return Recording({"pad": Pad(values + rng.normal(0.0, noise, values.shape))}, source="bag.npz")


def foam(rng: np.random.Generator, uneven: float) -> Floats:
    """Smooth lumps over the pad, other ones for each press."""
    lumps = gaussian_filter(rng.normal(0.0, 1.0, SHAPE), 1.5)
    return 1.0 + uneven * lumps / lumps.std()


def off_by(found: Calibration, gains: Floats) -> Floats:
    """How far gains are off, in their standard errors."""
    measured = np.asarray(found.sensor.gains)
    return ((measured / np.median(measured) - gains) / found.error).ravel()


@pytest.mark.parametrize("n", [2, 3, 5])
@pytest.mark.parametrize("uneven", [0.0, 0.03])
def test_gains_of_foam_that_is_not_even_are_known_as_well_as_is_said(n: int, uneven: float) -> None:
    off, spreads = [], []
    for seed in range(12):
        rng = np.random.default_rng(seed)
        gains = gains_of(rng)
        found = calibrate_even([recorded([gains * level * foam(rng, uneven) for level in LEVELS[-n:]], rng)])
        off.append(off_by(found, gains))
        spreads.append((found.findings[0].value - np.std(gains)) / found.findings[0].error)
    assert np.mean(np.abs(off) < 1) > 0.6
    assert np.mean(np.abs(off) < 2) > 0.9
    assert np.sqrt(np.mean(np.square(spreads))) < 1.6


def test_gains_behind_a_bent_response_are_known_as_well_as_is_said() -> None:
    off = []
    for seed in range(12):
        rng = np.random.default_rng(seed)
        gains = gains_of(rng)
        recording = recorded([logarithmic(gains * level) for level in LEVELS], rng)
        off.append(off_by(calibrate_even([recording], pressure_pa=1e4 * LEVELS), gains))
    assert np.mean(np.abs(off) < 2) > 0.9
    assert np.sqrt(np.mean(np.square(off))) < 1.3


def test_uneven_presses_count_alike_whatever_their_height() -> None:
    """A press of three times the load is no better known where the foam is what differs."""
    errors = {}
    for levels in ([0.3, 0.3, 0.3, 0.9], [0.9, 0.9, 0.9, 0.9]):
        off = []
        for seed in range(8):
            rng = np.random.default_rng(seed)
            gains = gains_of(rng)
            found = calibrate_even([recorded([gains * level * foam(rng, 0.03) for level in levels], rng)])
            off.append(np.sqrt(np.mean((found.sensor.gains / gains - 1.0) ** 2)))
        errors[levels[0]] = np.mean(off)
    assert errors[0.3] == pytest.approx(errors[0.9], rel=0.15)


def test_one_press_is_told_to_show_noise_alone() -> None:
    rng = np.random.default_rng(0)
    (spread, *_) = calibrate_even([recorded([0.9 * gains_of(rng)], rng)]).findings
    assert "by noise alone: one press does not tell how even it was" in spread.says
    (spread, *_) = calibrate_even(
        [recorded([level * gains_of(np.random.default_rng(1)) for level in LEVELS], rng)]
    ).findings
    assert "as far as what presses have in common is even" in spread.says


PITCH_M, FINE = 2e-3, 16


def ball(diameter_m: float, x_m: float, y_m: float, depth_m: float) -> Floats:
    """The mean depth of a ball's cap in each taxel of a square pad, from 16 x 16 points of each."""
    n = 16
    at = ((np.arange(n * FINE) + 0.5) / FINE - n / 2) * PITCH_M
    away = (at[None, :] - x_m) ** 2 + (at[:, None] - y_m) ** 2
    radius = diameter_m / 2
    cap = np.sqrt(np.maximum(radius**2 - away, 0.0)) - radius + depth_m
    return np.maximum(cap, 0.0).reshape(n, FINE, n, FINE).mean(axis=(1, 3))


def pressed_by_a_ball(rng: np.random.Generator, n: int, exponent: float = 1.0) -> Recording:
    """Presses by a ball of 20 mm, of five frames each, read by a power of its depth."""
    frames = [np.zeros((16, 16))] * 8
    for _ in range(n):
        x_m, y_m = rng.uniform(-8e-3, 8e-3, 2)
        one = (ball(0.02, x_m, y_m, rng.uniform(1.2e-3, 4e-3)) / 4e-3) ** exponent
        frames += [one / 2, *[one] * 5, one / 2, *[np.zeros((16, 16))] * 6]
    values = 20.0 + 900.0 * np.array(frames)
    pad = Pad(values + rng.normal(0.0, 2.0, values.shape), pitch_m=PITCH_M)
    return Recording({"pad": pad}, source="ball.npz")


def test_the_response_that_a_ball_shows_is_known_as_well_as_is_said() -> None:
    off, errors = [], []
    for seed in range(6):
        rng = np.random.default_rng(seed)
        found = calibrate_objects([pressed_by_a_ball(rng, 10, 0.6)], [known_object("ball:0.02")])
        exponent = found.findings[0]
        assert exponent.name == "exponent"
        off.append((exponent.value - 0.6) / exponent.error)
        errors.append(exponent.value - 0.6)
    assert np.abs(errors).max() < 0.008
    assert np.sqrt(np.mean(np.square(off))) < 1.3


@pytest.mark.parametrize("n", [20, 60])
def test_the_spread_that_unlabelled_presses_show_is_known_as_well_as_is_said(n: int) -> None:
    y, x = np.mgrid[: SHAPE[0], : SHAPE[1]]
    off = []
    for seed in range(5):
        rng = np.random.default_rng(seed)
        gains = gains_of(rng)
        maps = []
        for _ in range(n):
            place, turn, wide = rng.uniform(0, 1, 2) * SHAPE, rng.uniform(0, np.pi), rng.uniform(3.0, 6.0, 2)
            u = np.cos(turn) * (x - place[1]) + np.sin(turn) * (y - place[0])
            v = np.cos(turn) * (y - place[0]) - np.sin(turn) * (x - place[1])
            maps.append(rng.uniform(0.4, 1.0) * gains * np.maximum(1.0 - (u / wide[0]) ** 2 - (v / wide[1]) ** 2, 0.0))
        spread = calibrate_unlabelled([recorded(maps, rng)]).findings[0]
        off.append((spread.value - np.std(np.log(gains))) / spread.error)
    assert np.sqrt(np.mean(np.square(off))) < 2.0


@pytest.mark.parametrize("n", [100, 300])
def test_the_spread_that_tips_on_a_scale_show_is_known_as_well_as_is_said(n: int) -> None:
    y, x = np.mgrid[: SHAPE[0], : SHAPE[1]]
    off = []
    for seed in range(4):
        rng = np.random.default_rng(seed)
        gains = gains_of(rng)
        tips = [
            rng.uniform(0.3, 0.9) * np.exp(-((x - col) ** 2 + (y - row) ** 2) / (2 * 0.6**2))
            for row, col in rng.uniform(-0.3, np.array(SHAPE) - 0.7, (n, 2))
        ]
        force = [10 * tip.sum() * np.exp(rng.normal(0.0, 0.02)) for tip in tips]
        found = calibrate_scale([recorded([gains * tip for tip in tips], rng)], force_n=force)
        known = np.isfinite(found.error)
        spread = found.findings[0]
        off.append((spread.value - np.std((gains / np.median(gains[known]))[known])) / spread.error)
    assert np.sqrt(np.mean(np.square(off))) < 2.0


@pytest.mark.parametrize("has_gains", [False, True])
def test_gains_that_were_given_are_not_said_to_be_unknown(has_gains: bool) -> None:
    rng = np.random.default_rng(0)
    known = Sensor(gains=np.ones((16, 16))) if has_gains else None
    found = calibrate_objects([pressed_by_a_ball(rng, 6)], [known_object("ball:0.02")], sensor=known)
    assert any(words.startswith("the gains:") for words in found.unknown) != has_gains
