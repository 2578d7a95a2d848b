"""Calibration brings back what a sensor made of pressure, says how sure it is, and refuses what tells nothing."""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner
from numpy.typing import NDArray

from varishold.calibration import (
    Calibration,
    KnownObject,
    calibrate_even,
    calibrate_objects,
    calibrate_scale,
    calibrate_unlabelled,
    known_object,
)
from varishold.calibration.gains_behind import gains_behind, known_readings
from varishold.calibration.readings import presses_of
from varishold.cli.app import app
from varishold.errors import InputError
from varishold.recording import Pad, Recording
from varishold.report import render_calibration_report
from varishold.sensor import Linear, Logarithmic, Power, Response, Sensor, read_sensor, write_sensor
from varishold.skin import Skin, press, sense
from varishold.solids import Pose, Sphere

Floats = NDArray[np.float64]
SHAPE, PITCH_M = (16, 16), 2e-3


def true_gains(seed: int = 1, spread: float = 0.25, shape: tuple[int, int] = SHAPE) -> Floats:
    rng = np.random.default_rng(seed)
    gains = np.maximum(1 + spread * rng.standard_normal(shape), 0.1)
    gains.ravel()[rng.choice(gains.size, 3, replace=False)] = 0.3
    return gains


def recorded(frames: Floats, sigma: float, seed: int = 5, *, drift: float = 0.0, name: str = "r.npz") -> Recording:
    """Return presses with rests between them, in noise."""
    rng = np.random.default_rng(seed)
    quiet = np.zeros((4, *frames.shape[1:]))
    parts = [quiet, quiet]
    for frame in frames:
        parts += [np.repeat(frame[None], 3, axis=0), quiet]
    clean = np.concatenate(parts)
    slow = drift * np.linspace(0, 1, len(clean))[:, None, None]
    return Recording(
        {"pad": Pad(clean + slow + rng.normal(0, sigma, clean.shape), pitch_m=(PITCH_M, PITCH_M))}, source=name
    )


def bumps(n: int, seed: int, shape: tuple[int, int] = SHAPE) -> Floats:
    """Return presses of balls, cones and domes of an oval outline, drawn here and nowhere else."""
    rng = np.random.default_rng(seed)
    y, x = np.indices(shape).astype(float)
    made = []
    for _ in range(n):
        breadth = rng.uniform(3.0, 9.0)
        cx, cy = (rng.uniform(1, side - 2) for side in (shape[1], shape[0]))
        turn, oval = rng.uniform(0, np.pi), rng.uniform(0.6, 1.0)
        u = np.cos(turn) * (x - cx) + np.sin(turn) * (y - cy)
        v = (np.cos(turn) * (y - cy) - np.sin(turn) * (x - cx)) / oval
        away = np.hypot(u, v) / breadth
        made.append(np.maximum(1 - away ** rng.choice([1.0, 2.0, 4.0]), 0.0) * rng.uniform(0.5, 1.0))
    return np.array(made)


def left_over(found: Calibration, true: Floats) -> float:
    """Return the standard deviation of what is left of the gains, up to a common factor."""
    gains = found.sensor.gains
    assert gains is not None
    ratio = gains / true
    return float(np.std(ratio / np.median(ratio)))


def test_an_even_pressure_gives_the_gains_to_a_per_cent() -> None:
    true = true_gains()
    levels = np.array([0.4, 0.7, 1.0])[:, None, None]
    found = calibrate_even([recorded(100 * levels * true, 1.0)])
    assert left_over(found, true) < 0.015
    assert np.nanmedian(found.error) == pytest.approx(left_over(found, true), rel=0.5)
    assert np.nanstd(found.after) < 0.02 < 0.2 < np.nanstd(found.before)
    assert any(words.startswith("the response") for words in found.unknown)


@pytest.mark.parametrize("response", [Linear(), Power(0.5), Power(2.0), Logarithmic(5.0)])
def test_known_even_pressures_give_the_response_too(response: Response) -> None:
    true = true_gains(2)
    pressures = np.array([3e3, 5e3, 6.5e3, 8e3, 1e4])
    sensor = Sensor(span=1000.0, full_scale=1e4, response=response, gains=true)
    readings = sensor.forward(np.ones((5, *SHAPE)) * pressures[:, None, None])
    found = calibrate_even([recorded(readings, 2.0)], pressure_pa=pressures)
    assert found.sensor.response.kind == response.kind
    x = np.linspace(0.2, 1, 20)
    measured = found.sensor.response.reading(x) * found.sensor.span
    truth = response.reading(x) * sensor.span
    assert np.ptp(np.log(measured / truth)) < 0.05
    assert left_over(found, true) < 0.03
    assert found.sensor.unit == "Pa"
    assert found.curve is not None


def test_a_curve_of_no_family_becomes_a_table() -> None:
    pressures = np.linspace(1e3, 1e4, 10)
    reading = 500 * (pressures / 1e4 + 0.25 * np.sin(2 * np.pi * pressures / 1e4) / np.pi)
    found = calibrate_even([recorded(reading[:, None, None] * np.ones(SHAPE), 1.0)], pressure_pa=pressures)
    assert found.sensor.response.kind == "table"
    assert np.allclose(found.sensor.response.reading(pressures / 1e4) * found.sensor.span, reading, atol=5)


def ramped(frames: Floats, loads: list[float], read: Callable[[Floats], Floats], sigma: float) -> Recording:
    """Return presses that grow to each frame and let go again by these shares of the load, in readings that rest."""
    rng = np.random.default_rng(8)
    quiet = np.zeros((6, *frames.shape[1:]))
    parts = [quiet, *(part for f in frames for part in (np.multiply.outer(loads, f), quiet))]
    values = 200.0 + read(np.concatenate(parts))
    return Recording({"pad": Pad(values + rng.normal(0, sigma, values.shape), pitch_m=(PITCH_M, PITCH_M))}, source="r")


@pytest.mark.parametrize("loads", [[0.3, 0.8, 1, 1, 1, 1, 0.8, 0.3], [0.8, 0.95, 1, 1, 0.9], [0.95, 1, 0.95]])
def test_what_is_on_its_way_to_a_press_or_from_it_is_none_of_its_reading(loads: list[float]) -> None:
    pressures = np.array([2e3, 5e3, 1e4, 1.5e4, 2e4])
    sensor = Sensor(span=2400.0, full_scale=2e4, response=Logarithmic(5.0))
    recording = ramped(pressures[:, None, None] * np.ones(SHAPE), loads, sensor.forward, 5.0)
    found = calibrate_even([recording], pressure_pa=pressures)
    assert found.sensor.span == pytest.approx(2400, rel=2e-3)
    assert found.sensor.response.entries() == {"a": pytest.approx(5.0, rel=0.03)}


@pytest.mark.parametrize("response", [Linear(), Logarithmic(5.0), Power(0.5)])
def test_a_press_that_grows_and_lets_go_is_one(response: Response) -> None:
    sensor = Sensor(span=2400.0, full_scale=2e-3, response=response)
    balls = depths("ball", 0.03, 12, 4, 2e-3)
    loads = [0.3, 0.7, 0.95, 1, 1, 1, 0.9, 0.5]
    # A ball that is let in less far leaves a smaller print, not a lower one.
    steps = [[np.maximum(ball - (1 - share) * ball.max(), 0) for share in loads] for ball in balls]
    quiet = np.zeros((6, *SHAPE))
    frames = sensor.forward(np.concatenate([quiet, *(part for each in steps for part in (each, quiet))]))
    pad = Pad(200 + frames + np.random.default_rng(3).normal(0, 10.0, frames.shape))
    assert presses_of([Recording({"pad": pad})], Sensor()).n == 12


@pytest.mark.parametrize("seed", [1, 2])
def test_unlabelled_presses_take_more_than_half_of_the_spread_away(seed: int) -> None:
    true = true_gains(seed)
    found = calibrate_unlabelled([recorded(100 * bumps(100, seed) * true, 1.0, seed)])
    before = float(np.std(true / np.median(true)))
    assert left_over(found, true) < 0.5 * before
    (spread,) = found.findings
    assert spread.value == pytest.approx(float(np.std(np.log(true))), rel=0.35)
    assert np.nanstd(found.after) < 0.5 * np.nanstd(found.before)


@pytest.mark.parametrize("spread", [0.1, 0.25])
@pytest.mark.parametrize("n", [40, 100])
def test_gains_of_unlabelled_presses_are_known_as_well_as_is_said(spread: float, n: int) -> None:
    ratios = []
    for seed in range(4):
        true = np.exp(spread * np.random.default_rng(seed).standard_normal(SHAPE))
        # Forms that are all high in the middle of the pad have much in common.
        near = np.concatenate([bumps(n // 2, seed), np.roll(bumps(n // 2, 50 + seed)[:, ::-1], 2, axis=1)])
        found = calibrate_unlabelled([recorded(100 * near * true, 0.5, seed)])
        assert found.sensor.gains is not None
        off = np.log(found.sensor.gains / true)[np.isfinite(found.error)]
        said = found.error[np.isfinite(found.error)]
        ratios.append(np.median(np.abs(off - np.median(off)) / said) / 0.6745)
    assert np.mean(ratios) < 1.0 < 4 * np.mean(ratios)


def test_presses_that_leave_half_of_the_pad_alone_are_refused() -> None:
    frames = bumps(40, 5, (16, 7))
    wide = np.zeros((40, *SHAPE))
    wide[:, :, :7] = frames
    with pytest.raises(InputError, match=r"40 unlabelled presses press only \d+ of 256 taxels three times or more"):
        calibrate_unlabelled([recorded(100 * wide, 0.5)])


def test_gains_that_hardly_differ_are_told_and_not_applied() -> None:
    true = 1 + 0.01 * np.random.default_rng(0).standard_normal(SHAPE)
    found = calibrate_unlabelled([recorded(100 * bumps(60, 3) * true, 1.0)])
    assert found.sensor.gains is None
    assert any("were not applied" in words for words in found.notes)


def test_a_silent_taxel_is_marked_broken() -> None:
    true = true_gains(4)
    true[8, 8] = 0.0
    found = calibrate_unlabelled([recorded(100 * bumps(80, 4) * true, 0.5)])
    assert found.sensor.broken is not None
    assert np.argwhere(found.sensor.broken).tolist() == [[8, 8]]
    assert "What was found" in render_calibration_report(found, title="a map with a hole")


def depths(kind: str, size_m: float, n: int, seed: int, deepest_m: float) -> Floats:
    """Return how deep a ball or a turned square plate stands in each taxel, drawn here and nowhere else."""
    rng = np.random.default_rng(seed)
    fine = 8
    at = [((np.arange(side * fine) + 0.5) / fine - side / 2) * PITCH_M for side in SHAPE]
    y, x = np.meshgrid(*at, indexing="ij")
    made = []
    for _ in range(n):
        depth = deepest_m * rng.uniform(0.3, 1.0)
        reach = np.sqrt(depth * size_m) if kind == "ball" else 0.75 * size_m
        cx, cy = rng.uniform(-1, 1, 2) * max(SHAPE[0] * PITCH_M / 2 - reach, 0.0)
        if kind == "ball":
            gap = size_m / 2 - np.sqrt(np.maximum((size_m / 2) ** 2 - (x - cx) ** 2 - (y - cy) ** 2, 0))
            face = np.maximum(depth - gap, 0.0)
        else:
            turn = rng.uniform(0, np.pi / 2)
            u = np.cos(turn) * (x - cx) + np.sin(turn) * (y - cy)
            v = np.cos(turn) * (y - cy) - np.sin(turn) * (x - cx)
            away = np.hypot(u, v) if kind == "disc" else np.maximum(np.abs(u), np.abs(v))
            face = np.where(away < size_m / 2, depth, 0.0)
        made.append(face.reshape(SHAPE[0], fine, SHAPE[1], fine).mean(axis=(1, 3)))
    return np.array(made)


@pytest.mark.parametrize(
    ("response", "dead", "blur"),
    [(Logarithmic(5.0), 0.0, 0.7), (Power(0.5), 0.0, 0.4), (Power(2.0), 0.0, 0.5), (Linear(), 0.2, 1.0)],
)
def test_a_ball_and_a_plate_give_response_dead_band_and_blur(response: Response, dead: float, blur: float) -> None:
    sensor = Sensor(span=1000.0, full_scale=2e-3, response=response, dead_band=dead, blur_taxels=blur)
    recordings = [
        recorded(sensor.forward(depths(kind, size, 10, 2, deepest)), 10.0, name=kind)
        for kind, size, deepest in (("ball", 0.05, 2e-3), ("plate", 0.014, 1.6e-3))
    ]
    found = calibrate_objects(recordings, [KnownObject("ball", 0.05), KnownObject("plate", 0.014)])
    measured = found.sensor
    assert measured.response.kind == response.kind
    assert measured.blur_taxels == pytest.approx(blur, abs=0.05)
    # Full scale is the highest reading: another scale, the same curve.
    stress = np.linspace(1.3 * dead, 0.9, 30)[None] * sensor.full_scale
    plain = Sensor(span=1000.0, full_scale=2e-3, response=response, dead_band=dead)
    back = Sensor(
        span=measured.span,
        full_scale=measured.full_scale,
        response=measured.response,
        dead_band=measured.dead_band,
    ).stress(plain.forward(stress))
    line = np.polyfit(stress.ravel(), back.ravel(), 1)
    assert np.abs(np.polyval(line, stress) - back).max() < 0.03 * np.ptp(back)
    assert (measured.dead_band > 0) == (dead > 0)


@pytest.mark.parametrize("response", [Linear(), Logarithmic(5.0)])
def test_a_round_plate_is_a_disc_and_no_dead_band_makes_a_square_one_of_it(response: Response) -> None:
    sensor = Sensor(span=1000.0, full_scale=2e-3, response=response)
    recordings = [
        recorded(sensor.forward(depths(kind, size, 10, 2, deepest)), 4.0, name=kind)
        for kind, size, deepest in (("ball", 0.05, 2e-3), ("disc", 0.014, 1.6e-3))
    ]
    ball = KnownObject("ball", 0.05)
    right = calibrate_objects(recordings, [ball, KnownObject("disc", 0.014)])
    assert right.sensor.response.kind == response.kind
    assert right.sensor.blur_taxels < 0.2
    assert not any("not quite of such objects" in words for words in right.notes)
    with pytest.raises(InputError, match=r"disc: is not of a plate of 0\.014 m"):
        calibrate_objects(recordings, [ball, KnownObject("plate", 0.014)])


@pytest.mark.parametrize("response", [Logarithmic(5.0), Power(0.5), Linear()])
def test_gains_of_an_even_pressure_are_put_behind_the_response_that_objects_find(
    response: Response, tmp_path: Path
) -> None:
    true = true_gains(3)
    sensor = Sensor(span=1000.0, full_scale=2e-3, response=response, gains=true)
    evenly = sensor.forward(2e-3 * np.array([0.3, 0.6, 0.9])[:, None, None] * np.ones(SHAPE))
    write_sensor(calibrate_even([recorded(evenly, 4.0)]).sensor, tmp_path / "bag.toml")
    bag = read_sensor(tmp_path / "bag.toml")
    recordings = [
        recorded(sensor.forward(depths(kind, size, 10, 2, deepest)), 4.0, name=kind)
        for kind, size, deepest in (("ball", 0.05, 2e-3), ("plate", 0.014, 1.6e-3))
    ]
    objects = [KnownObject("ball", 0.05), KnownObject("plate", 0.014)]
    found = calibrate_objects(recordings, objects, sensor=bag)
    assert found.sensor.response.kind == response.kind
    assert left_over(found, true) < 0.02
    bent = not isinstance(response, Linear)
    assert any("without this response, and are now those behind it" in words for words in found.notes) == bent
    again = calibrate_even([recorded(evenly, 4.0)], sensor=found.sensor)
    assert left_over(again, true) < 0.02
    assert any(words.startswith("the response") for words in again.unknown) != bent
    # Of gains that come without a word nobody knows at what readings they were found.
    silent = dataclasses.replace(bag, calibration={})
    told = calibrate_objects(recordings, objects, sensor=silent)
    assert any("find them once more" in words for words in told.notes) == (told.sensor.response.kind != "linear")


def test_gains_behind_a_response_are_those_that_made_the_readings() -> None:
    true, levels = true_gains(4), np.array([0.2, 0.5, 1.1])
    for response in (Logarithmic(20.0), Power(0.4), Power(2.0), Linear()):
        usual = 300.0 * response.reading(levels)
        beside = response.reading(true * levels[:, None, None]) / response.reading(levels)[:, None, None]
        seen = np.average(beside, axis=0, weights=usual**2)
        np.testing.assert_allclose(gains_behind(response, 300.0, seen, usual), true, rtol=2e-3)
    assert gains_behind(Power(0.4), 300.0, np.array([0.0, 1.0]), usual)[0] == 0
    for wrong in ([], "twelve", [1, "a"], [-1.0], 3):
        assert known_readings(Sensor(gains=true, calibration={"gain_readings": wrong})) is None


def test_a_ball_on_a_thin_skin_leaves_a_curve_that_explains_it() -> None:
    skin = Skin("layer", 1.5e-3, 0.3, 0.6e-3)
    rng = np.random.default_rng(3)
    frames = []
    for _ in range(6):
        pose = Pose(*rng.uniform(-5e-3, 5e-3, 2))
        pressed = press(
            Sphere(0.04), skin, depth=rng.uniform(2e-4, 5e-4), shape=SHAPE, pitch_m=PITCH_M, pose=pose, per_taxel=4
        )
        frames.append(sense(pressed))
    true = Sensor(span=1000.0, full_scale=float(np.max(frames)), response=Logarithmic(5.0))
    found = calibrate_objects([recorded(true.forward(np.array(frames)), 5.0)], [KnownObject("ball", 0.04)])
    assert found.sensor.response.kind != "linear"
    assert np.nanmean(found.residual) < 0.05


def tips(n: int, seed: int, true: Floats) -> tuple[Floats, Floats]:
    """Return readings of a small tip at random places, and its forces."""
    rng = np.random.default_rng(seed)
    y, x = np.indices(true.shape)
    forces = rng.uniform(2.0, 5.0, n)
    frames = []
    for force in forces:
        cy, cx = rng.uniform(0, true.shape[0] - 1), rng.uniform(0, true.shape[1] - 1)
        share = np.maximum(1 - np.hypot(x - cx, y - cy) / 1.4, 0.0)
        frames.append(100 * force * share / share.sum())
    return np.array(frames) * true, forces


def test_a_small_tip_on_a_scale_gives_the_gains() -> None:
    true = true_gains(6, shape=(8, 8))
    readings, forces = tips(400, 6, true)
    found = calibrate_scale([recorded(readings, 0.5)], force_n=forces)
    assert left_over(found, true) < 0.5 * np.std(true)


def test_what_is_known_already_is_kept() -> None:
    base = Sensor(name="mat", polarity="down", rest=900.0, span=800.0, cover=Skin("half-space"))
    true = true_gains(7)
    readings = base.forward(np.array([0.5, 0.8])[:, None, None] * 800 * true)
    pad = recorded(903.0 - readings, 1.0).pads["pad"]
    raw = Recording({"pad": Pad(903.0 - pad.frames, pitch_m=pad.pitch_m)})
    found = calibrate_even([raw], sensor=base).sensor
    assert (found.name, found.polarity, found.cover) == ("mat", "down", base.cover)
    assert np.allclose(found.rest, 903.0, atol=2.0)
    assert found.pitch_m == (PITCH_M, PITCH_M)


EVEN = np.ones((3, *SHAPE)) * 50.0


@pytest.mark.parametrize(
    ("call", "says"),
    [
        (lambda: calibrate_unlabelled([recorded(100 * bumps(10, 1), 1.0)]), "from 10 unlabelled presses: 20 are the"),
        (lambda: calibrate_even([recorded(100 * bumps(3, 1), 1.0)]), "press 0 is no even pressure"),
        (lambda: calibrate_even([recorded(EVEN, 1.0, drift=20.0)]), "r.npz: the rest moves: 256 taxels by up to"),
        (
            lambda: calibrate_even([recorded(EVEN * true_gains(i), 1.0) for i in (1, 2, 3)]),
            "loads the pad otherwise than the others",
        ),
        (
            lambda: calibrate_even([recorded(EVEN, 1.0)], pressure_pa=[1.0, 2.0]),
            "pressure_pa must be one positive number for each of the 3 presses found, got 2",
        ),
        (
            lambda: calibrate_even([recorded(EVEN * np.array([1, 2, 1.5])[:, None, None], 1.0)], pressure_pa=[1, 2, 3]),
            "the response is not monotone: 2 Pa reads",
        ),
        (
            lambda: calibrate_scale([recorded(100 * bumps(5, 1), 1.0)], force_n=np.ones(5)),
            "broad presses on a scale do not identify gains",
        ),
        (
            lambda: calibrate_scale([recorded(tips(5, 1, np.ones(SHAPE))[0], 0.1)], force_n=None),
            "one positive number for each of the 5 presses found, got 0",
        ),
        (
            lambda: calibrate_scale([recorded(tips(5, 1, np.ones(SHAPE))[0], 0.1)], force_n=np.ones(5)),
            "from 5 presses of a tip: 100 are the least",
        ),
        (
            lambda: calibrate_objects([recorded(depths("ball", 0.05, 3, 1, 2e-3), 1e-5)], [KnownObject("ball", 0.05)]),
            "3 presses of a ball are too few, 5 are the least",
        ),
        (
            lambda: calibrate_objects([recorded(EVEN, 1.0)], [KnownObject("ball", 0.05)] * 2),
            "give one known object for all recordings or one for each: got 2 for 1",
        ),
        (lambda: known_object("ball"), "a known object is ball:SIZE, roller:SIZE, plate:SIZE"),
        (
            lambda: calibrate_even([recorded(np.zeros((3, *SHAPE)), 1.0)]),
            "no press found: the total never rises above its noise",
        ),
        (
            lambda: calibrate_even([recorded(200 - EVEN, 1.0)], sensor=Sensor(gains=np.ones((4, 4)))),
            "is for 4 x 4 taxels, pad 'pad' of r.npz has 16 x 16",
        ),
    ],
)
def test_what_tells_nothing_is_refused_in_one_line(call: Any, says: str) -> None:
    with pytest.raises(InputError) as caught:
        call()
    assert says in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_recording_of_two_pads_asks_which() -> None:
    pad = recorded(EVEN, 1.0).pads["pad"]
    both = Recording({"left": pad, "right": pad})
    with pytest.raises(InputError, match="has the pads left, right; calibrate one at a time: say which"):
        calibrate_even([both])
    assert calibrate_even([both], pad="left").presses == 3


def _run(*words: str) -> Any:
    return CliRunner().invoke(app, ["sensor", *words], catch_exceptions=False)


def test_the_command_writes_file_map_and_page_and_is_read_back(tmp_path: Path) -> None:
    true = true_gains()
    pad = recorded(100 * np.array([0.5, 1.0])[:, None, None] * true, 1.0).pads["pad"]
    np.savez(tmp_path / "bag.npz", pressure=pad.frames)
    said = _run(
        "calibrate",
        str(tmp_path / "bag.npz"),
        "--kind",
        "even",
        "-o",
        str(tmp_path / "mat.toml"),
        "--report",
        str(tmp_path / "mat.html"),
    )
    assert said.exit_code == 0
    assert "found: gain_spread" in said.stdout
    assert "not known: the response" in said.stdout
    sensor = read_sensor(tmp_path / "mat.toml")
    assert sensor.gains is not None
    assert np.std(sensor.gains / true / np.median(sensor.gains / true)) < 0.02
    assert sensor.calibration["kind"] == "even"
    page = (tmp_path / "mat.html").read_text()
    assert "What was found" in page
    assert "http" not in page.replace("http://www.w3.org", "")
    again = _run("calibrate", str(tmp_path / "bag.npz"), "--kind", "even", "-o", str(tmp_path / "again.toml"), "--json")
    assert json.loads(again.stdout)["found"]["gain_spread"]["value"] == pytest.approx(0.27, abs=0.05)


def test_the_command_lists_and_shows_sensors() -> None:
    listed = _run("list").stdout
    assert "weiss-dsa" in listed
    assert "(third-party)" in listed
    assert {"preset", "shape", "polarity"} <= set(json.loads(_run("list", "--json").stdout.splitlines()[0]))
    assert "downward" in _run("show", "wuji").stdout


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (("--kind", "objects", "-o", "a.toml"), "--kind objects needs --object"),
        (("--kind", "even", "-o", "a.json"), "a sensor file is TOML: name it *.toml"),
        (("--kind", "even", "-o", "a.toml", "--pressure-pa", "1;2"), "--pressure-pa must be numbers between commas"),
        (("--kind", "even", "-o", "none/a.toml"), "there is no folder"),
    ],
)
def test_the_command_refuses_in_one_line(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, words: tuple[str, ...], says: str
) -> None:
    monkeypatch.chdir(tmp_path)
    np.savez("bag.npz", pressure=recorded(EVEN, 1.0).pads["pad"].frames)
    with pytest.raises(InputError) as caught:
        _run("calibrate", "bag.npz", *words)
    assert says in str(caught.value)
    assert "\n" not in str(caught.value)
