"""Laws of calibration: imprints as geometry, mirrors, units, and errors that are as large as they say."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from varishold.calibration import Calibration, calibrate_even, calibrate_scale, calibrate_unlabelled, known_object
from varishold.calibration import even as evens
from varishold.calibration.imprint import OBJECTS, KnownObject, Points
from varishold.calibration.objects import _observed
from varishold.calibration.press_fit import fit_presses
from varishold.calibration.readings import Presses, presses_of
from varishold.calibration.response_fit import fit_response
from varishold.calibration.result import Finding
from varishold.errors import InputError
from varishold.recording import Pad, Recording
from varishold.sensor import Logarithmic, Power, Response, Sensor

Floats = NDArray[np.float64]
few = settings(max_examples=15)
PAD = Points((12, 14), (2e-3, 2.5e-3))
BALL, ROLLER, PLATE = (KnownObject(kind, 0.012) for kind in ("ball", "roller", "plate"))

# Imprints


@few
@given(st.floats(-0.006, 0.006), st.floats(-0.006, 0.006), st.floats(1e-4, 2e-3))
def test_a_ball_leaves_a_cap(x: float, y: float, depth: float) -> None:
    wide = Points((40, 40), (1e-3, 1e-3))
    face = BALL.stress(np.array([x, y, depth]), wide)
    radius = 0.006
    volume = np.pi * depth**2 * (radius - depth / 3)
    assert face.sum() * 1e-6 == pytest.approx(volume, rel=0.02)
    rows, cols = np.indices(face.shape) - 19.5
    assert (face * cols).sum() / face.sum() * 1e-3 == pytest.approx(x, abs=2e-5)
    assert (face * rows).sum() / face.sum() * 1e-3 == pytest.approx(y, abs=2e-5)
    assert face.max() <= depth
    reach = np.sqrt(2 * radius * depth - depth**2) + 0.8e-3
    assert (face[np.hypot(cols * 1e-3 - x, rows * 1e-3 - y) > reach] == 0).all()


@few
@given(st.sampled_from([BALL, ROLLER]), st.floats(0.0061, 0.1))
def test_beside_a_ball_or_roller_nothing_presses_however_deep_it_is(thing: KnownObject, depth: float) -> None:
    wide = Points((40, 40), (1e-3, 1e-3))
    face = thing.stress(np.array([0.0, 0.0, depth, 0.0]), wide)
    rows, cols = np.indices(face.shape) - 19.5
    away = np.abs(rows) if thing is ROLLER else np.hypot(rows, cols)
    assert (face[away * 1e-3 > 0.006 + 0.8e-3] == 0).all()
    assert face.max() > 0


@few
@given(st.floats(-0.004, 0.004), st.floats(-3, 3), st.floats(5e-4, 2e-3))
def test_a_roller_leaves_a_trough_along_its_axis(across: float, turn: float, depth: float) -> None:
    square = Points((16, 16), (2e-3, 2e-3))
    face = ROLLER.stress(np.array([across, turn, depth, 0.0]), square)
    # A quarter turn of the roller is one of the pad; half a turn puts it to the other side.
    quarter = ROLLER.stress(np.array([across, turn + np.pi / 2, depth, 0.0]), square)
    np.testing.assert_allclose(quarter, np.rot90(face, -1), atol=1e-12)
    np.testing.assert_allclose(ROLLER.stress(np.array([-across, turn + np.pi, depth, 0.0]), square), face, atol=1e-12)
    level = ROLLER.stress(np.array([across, 0.0, depth, 0.0]), square)
    np.testing.assert_allclose(level, level[:, :1] * np.ones(16))
    radius, half = 0.006, np.arccos(1 - depth / 0.006)
    segment = radius**2 * (half - np.sin(half) * np.cos(half))
    assert level[:, 0].sum() * 2e-3 == pytest.approx(segment, rel=0.05)
    rows = np.arange(16) - 7.5
    assert (level[:, 0] * rows).sum() / level[:, 0].sum() * 2e-3 == pytest.approx(across, abs=2e-4)


def test_a_roller_that_slopes_is_deeper_along_its_axis() -> None:
    square = Points((16, 16), (2e-3, 2e-3))
    face = ROLLER.stress(np.array([0.0, 0.0, 1e-3, 0.02]), square)
    x = 2e-3 * (np.arange(16) - 7.5)
    deepest = face.max(axis=0)
    np.testing.assert_allclose(np.diff(deepest), 0.02 * 2e-3, rtol=0.05)
    flat = ROLLER.stress(np.array([0.0, 0.0, 1e-3, 0.0]), square).max()
    np.testing.assert_allclose(deepest - flat, 0.02 * x, atol=2e-5)


@few
@given(st.floats(-0.004, 0.004), st.floats(-0.004, 0.004), st.floats(-3, 3), st.floats(-0.05, 0.05))
def test_a_plate_is_a_square_with_its_depth(x: float, y: float, turn: float, slope: float) -> None:
    wide = Points((30, 34), (1e-3, 1e-3))
    depth = 1e-3
    face = PLATE.stress(np.array([x, y, turn, depth, slope, 0.0]), wide)
    assert face.sum() * 1e-6 == pytest.approx(0.012**2 * depth, rel=0.01)
    turned = PLATE.stress(np.array([x, y, turn + np.pi / 2, depth, 0.0, -slope]), wide)
    np.testing.assert_allclose(turned, face, atol=1e-9)
    rows, cols = np.indices(face.shape)
    away_x, away_y = (cols - 16.5) * 1e-3 - x, (rows - 14.5) * 1e-3 - y
    u, v = np.cos(turn) * away_x + np.sin(turn) * away_y, np.cos(turn) * away_y - np.sin(turn) * away_x
    inside = np.maximum(np.abs(u), np.abs(v)) < 0.006 - 1e-3
    np.testing.assert_allclose(face[inside], depth + slope * u[inside], atol=1e-9)
    assert (face[np.maximum(np.abs(u), np.abs(v)) > 0.006 + 1e-3] == 0).all()


def test_axes_stand_about_the_middle_of_the_pad() -> None:
    x, y = PAD.axes
    assert (x.shape, y.shape) == ((1, 112), (96, 1))
    assert x.sum() == pytest.approx(0)
    assert np.ptp(x) == pytest.approx(14 * 2.5e-3 - 2.5e-3 / 8)
    assert np.ptp(y) == pytest.approx(12 * 2e-3 - 2e-3 / 8)
    assert PAD.spacing_m == 0.25e-3
    np.testing.assert_allclose(
        PAD.taxel_means(np.broadcast_to(y, (96, 112))), (np.arange(12)[:, None] - 5.5) * 2e-3 * np.ones(14)
    )


def test_known_objects_are_told_by_a_word_and_a_size() -> None:
    for kind in OBJECTS:
        made = known_object(f"{kind}:0.25")
        assert (made.kind, made.size_m) == (kind, 0.25)
        assert made.parameters == OBJECTS[kind].parameters
        assert made.curved == (kind not in ("plate", "disc"))
    for wrong in ("ball", "cube:0.1", "ball:x", "ball:nan", "ball:1e-6", "ball:1000", "ball:-1", ""):
        with pytest.raises(
            InputError,
            match="a known object is ball:SIZE, roller:SIZE, plate:SIZE, disc:SIZE, SIZE in metres: the diam",
        ):
            known_object(wrong)


# Fits of presses


def presses_at(thing: KnownObject, places: Floats, sigma: float = 0.0, seed: int = 0) -> Presses:
    rng = np.random.default_rng(seed)
    frames = np.array([1e6 * thing.stress(place, PAD) for place in places])
    frames += sigma * rng.standard_normal(frames.shape)
    n = len(frames)
    return Presses(
        frames, np.full(n, sigma), np.zeros(n, int), np.ones(PAD.shape, np.bool_), None, PAD.pitch_m, (), ("ball.npz",)
    )


PLACES: dict[str, Callable[[np.random.Generator], list[float]]] = {
    "ball": lambda rng: [*rng.uniform(-0.004, 0.004, 2), rng.uniform(0.8e-3, 1.5e-3)],
    "roller": lambda rng: [rng.uniform(-0.003, 0.003), rng.uniform(-1.4, 1.4), rng.uniform(0.8e-3, 1.5e-3), 0.0],
    "plate": lambda rng: [*rng.uniform(-0.003, 0.003, 2), rng.uniform(0, 1.5), 1e-3, 0.0, 0.0],
    "disc": lambda rng: [*rng.uniform(-0.003, 0.003, 2), 1e-3, 0.0, 0.0],
}


@pytest.mark.parametrize("kind", OBJECTS)
def test_the_first_guess_is_near(kind: str) -> None:
    rng = np.random.default_rng(3)
    thing = KnownObject(kind, 0.02 if kind == "plate" else 0.012)
    places = np.array([PLACES[kind](rng) for _ in range(12)])
    found = presses_at(thing, places)
    for k, place in enumerate(places):
        guess = _observed(found, k, thing, PAD)
        assert guess.start.shape == guess.scale.shape == place.shape
        assert (guess.scale > 0).all()
        for name, true, said in zip(thing.parameters, place, guess.start, strict=True):
            if name in ("x_m", "y_m", "across_m"):
                assert said == pytest.approx(true, abs=1.2e-3), (kind, name)
            elif name == "yaw_rad":
                period = np.pi / 2 if kind == "plate" else np.pi
                assert abs((said - true + period / 2) % period - period / 2) < 0.15, (
                    kind,
                    name,
                )
            elif name == "depth_m" and kind != "plate":
                assert true / 1.7 < said < 1.7 * true, (kind, name)
            elif name.startswith("slope"):
                assert said == 0
        assert guess.sigma == pytest.approx(0.01 * guess.frame.max(), rel=1.01)


@pytest.mark.parametrize("kind", OBJECTS)
def test_constants_and_places_are_found_and_errors_are_as_large_as_told(kind: str) -> None:
    thing = KnownObject(kind, 0.012)
    off = []
    for seed in range(6):
        rng = np.random.default_rng(seed)
        places = np.array([PLACES[kind](rng) for _ in range(3)])
        found = presses_at(thing, places, sigma=20.0, seed=seed)
        observed = [dataclasses.replace(_observed(found, k, thing, PAD), sigma=20.0) for k in range(3)]
        fit = fit_presses(
            lambda faces, at: at[0] * 1e6 * faces / (1 + at[1] * 1e3 * faces),
            np.array([0.7, 0.1]),
            observed,
            PAD,
            found.usable,
            low=np.array([0.1, 0.0]),
            high=np.array([5.0, 3.0]),
            places=[place + 0.2 * one.scale for place, one in zip(places, observed, strict=True)],
        )
        assert 0.7 < np.median(fit.cost) < 1.8
        assert fit.predicted.shape == found.frames.shape
        residual = (found.frames - fit.predicted) / 20.0
        np.testing.assert_allclose(fit.cost, (residual**2).mean(axis=(1, 2)))
        if kind not in ("plate", "disc"):
            off.append((fit.constants - (1.0, 0.0)) / fit.error)
            for place, said in zip(places, fit.places, strict=True):
                np.testing.assert_allclose(said[:1], place[:1], atol=3e-4)
    if off:
        # Where a constant is held at its limit it is nearer than chance would have it.
        assert 0.3 < np.sqrt(np.mean(np.square(off)[:, 0])) < 2.5


def test_held_constants_stay_and_places_move() -> None:
    place = np.array([1e-3, -2e-3, 1e-3])
    found = presses_at(BALL, place[None])
    seen = dataclasses.replace(_observed(found, 0, BALL, PAD), sigma=1.0)
    for usable in (found.usable, np.arange(14)[None] * np.ones((12, 1)) > 2):
        fit = fit_presses(
            lambda faces, at: at[0] * faces,
            np.array([1e6]),
            [seen],
            PAD,
            usable,
            low=np.array([0.0]),
            high=np.array([1e7]),
            free=False,
        )
        assert fit.constants.tolist() == [1e6]
        assert fit.error.size == 0
        np.testing.assert_allclose(fit.places[0], place, atol=2e-6)


def test_two_kinds_of_objects_are_fitted_together() -> None:
    places = [np.array([1e-3, -2e-3, 1e-3]), np.array([1e-3, 0.4, 1e-3, 0.0])]
    observed = []
    for thing, place in zip((BALL, ROLLER), places, strict=True):
        found = presses_at(thing, place[None])
        observed.append(dataclasses.replace(_observed(found, 0, thing, PAD), sigma=1.0))
    fit = fit_presses(
        lambda faces, at: at[0] * 1e6 * faces,
        np.array([0.8]),
        observed,
        PAD,
        found.usable,
        low=np.array([0.0]),
        high=np.array([10.0]),
    )
    assert fit.constants == pytest.approx(1.0, rel=0.02)
    for place, said in zip(places, fit.places, strict=True):
        np.testing.assert_allclose(said, place, atol=2e-3)
        np.testing.assert_allclose(said[-2:-1], place[-2:-1], rtol=0.05, atol=1e-4)


# A response


@pytest.mark.parametrize("response", [Power(0.5), Power(2.0), Power(0.9), Logarithmic(8.0)])
def test_points_on_a_curve_give_the_curve(response: Response) -> None:
    stress = np.array([500.0, 2e3, 5e3, 1e4, 4e4])
    reading = 900.0 * response.reading(stress / 4e4)
    made, curve, finding = fit_response(Sensor(name="kept"), stress, reading, "Pa")
    assert type(made.response) is type(response)
    x = np.linspace(0, 1, 50)
    np.testing.assert_allclose(made.response.reading(x), response.reading(x), atol=2e-3)
    assert (made.span, made.full_scale, made.unit, made.name) == (pytest.approx(900), 4e4, "Pa", "kept")
    np.testing.assert_allclose(curve.stress, stress / 4e4)
    np.testing.assert_allclose(curve.reading, reading / 900)
    assert finding.value < 1e-3
    # Neither the order of the points nor how often one was measured matters.
    twice = np.concatenate([stress[::-1], stress]), np.concatenate([reading[::-1] + 1e-3, reading - 1e-3])
    again, *_ = fit_response(Sensor(), *twice, "Pa")
    np.testing.assert_allclose(again.response.reading(x), made.response.reading(x), atol=1e-6)


def test_a_line_needs_no_curve_and_a_crooked_one_a_table() -> None:
    stress = np.array([1.0, 2, 3, 4, 5])
    made, _, finding = fit_response(Sensor(), stress, 7 * stress * (1 + 1e-3 * np.array([1, -1, 1, -1, 0])), "Pa")
    assert made.response.kind == "linear"
    assert finding.value == pytest.approx(np.sqrt(np.mean((1e-3 * stress[:4] / 5) ** 2) * 4 / 5), rel=1e-6)
    assert finding.error == pytest.approx(finding.value / np.sqrt(8))
    crooked = np.array([1.0, 1.2, 3.5, 3.6, 5])
    made, _, finding = fit_response(Sensor(), stress, crooked, "Pa")
    assert made.response.kind == "table"
    np.testing.assert_allclose(made.stress(made.forward(stress[None])), stress[None], rtol=1e-9)
    np.testing.assert_allclose(made.forward(stress[None]), crooked[None], rtol=1e-9)
    # Each inner point from its neighbours: (1 + 3.5) / 2 for 1.2 ...
    off = np.array([(1 + 3.5) / 2 - 1.2, (1.2 + 3.6) / 2 - 3.5, (3.5 + 5) / 2 - 3.6]) / 5
    left_out = np.array([off[0], off[1], off[2]])
    assert finding.value == pytest.approx(np.sqrt((left_out**2).mean()), rel=1e-6)
    made, *_ = fit_response(Sensor(), stress[:3], np.array([1.0, 1.2, 3.5]), "Pa")
    assert made.response.kind != "table"
    for falling in ([1.0, 2, 2, 4, 5], [1.0, 3, 2, 4, 5]):
        with pytest.raises(InputError, match=r"not monotone: 2 Pa reads . and 3 Pa reads 2; leave out"):
            fit_response(Sensor(), stress, np.array(falling), "Pa")


# Gains


def recorded(frames: Floats, sigma: float, seed: int = 5) -> Recording:
    rng = np.random.default_rng(seed)
    quiet = np.zeros((4, *frames.shape[1:]))
    clean = np.concatenate([quiet, *(np.concatenate([np.repeat(f[None], 3, axis=0), quiet]) for f in frames)])
    return Recording({"pad": Pad(clean + sigma * rng.standard_normal(clean.shape), pitch_m=(2e-3, 3e-3))})


def gains_of(seed: int, shape: tuple[int, int] = (8, 9)) -> Floats:
    return np.exp(0.2 * np.random.default_rng(seed).standard_normal(shape))


def evenly(seed: int, n: int = 4) -> tuple[Recording, dict[str, Any]]:
    levels = np.linspace(100, 400, n)
    return recorded(levels[:, None, None] * gains_of(seed), 3.0, seed), {}


def by_tips(seed: int, n: int = 150) -> tuple[Recording, dict[str, Any]]:
    rng = np.random.default_rng(seed)
    y, x = np.indices((8, 9))
    force, frames = rng.uniform(2, 5, n), []
    for each in force:
        share = np.maximum(1 - np.hypot(x - rng.uniform(-0.5, 8.5), y - rng.uniform(-0.5, 7.5)) / 1.4, 0.0)
        frames.append(100 * each * share / share.sum())
    return recorded(np.array(frames) * gains_of(seed), 0.5, seed), {"force_n": force}


def by_anything(seed: int, n: int = 60) -> tuple[Recording, dict[str, Any]]:
    rng = np.random.default_rng(seed)
    y, x = np.indices((8, 9))
    frames = []
    for _ in range(n):
        away = np.hypot(x - rng.uniform(1, 8), y - rng.uniform(1, 7)) / rng.uniform(4, 9)
        frames.append(300 * np.maximum(1 - away ** rng.choice([1.0, 2.0, 4.0]), 0.0) * rng.uniform(0.5, 1.0))
    return recorded(np.array(frames) * gains_of(seed), 0.5, seed), {}


WAYS: dict[str, tuple[Callable[..., tuple[Recording, dict[str, Any]]], Callable[..., Calibration]]] = {
    "even": (evenly, calibrate_even),
    "scale": (by_tips, calibrate_scale),
    "unlabelled": (by_anything, calibrate_unlabelled),
}


def maps(found: Calibration) -> dict[str, Floats]:
    assert found.sensor.gains is not None
    return {"gains": found.sensor.gains} | {
        name: getattr(found, name) for name in ("before", "after", "error", "residual")
    }


@pytest.fixture(scope="module", params=WAYS)
def way(request: pytest.FixtureRequest) -> tuple[str, Recording, dict[str, Any], Calibration]:
    make, calibrate = WAYS[request.param]
    recording, options = make(1)
    return request.param, recording, options, calibrate([recording], **options)


def with_frames(recording: Recording, frames: Floats, pitch_m: Any = (2e-3, 3e-3)) -> Recording:
    return Recording({"pad": Pad(frames, pitch_m=pitch_m)})


def test_a_mirrored_pad_has_mirrored_gains(way: Any) -> None:
    kind, recording, options, found = way
    frames = recording.pads["pad"].frames
    other = WAYS[kind][1]([with_frames(recording, frames[:, ::-1, ::-1])], **options)
    turned = WAYS[kind][1]([with_frames(recording, frames.transpose(0, 2, 1), (3e-3, 2e-3))], **options)
    for name, values in maps(found).items():
        np.testing.assert_allclose(maps(other)[name][::-1, ::-1], values, rtol=1e-6, err_msg=name)
        np.testing.assert_allclose(maps(turned)[name].T, values, rtol=1e-6, err_msg=name)
    assert [str(one) for one in other.findings] == [str(one) for one in found.findings]


def test_gains_do_not_depend_on_the_unit_of_readings(way: Any) -> None:
    kind, recording, options, found = way
    other = WAYS[kind][1]([with_frames(recording, 7.0 * recording.pads["pad"].frames)], **options)
    for name, values in maps(found).items():
        np.testing.assert_allclose(maps(other)[name], values, rtol=1e-6, err_msg=name)


def test_gains_do_not_depend_on_rest_and_polarity(way: Any) -> None:
    kind, recording, options, found = way
    frames = recording.pads["pad"].frames
    known = Sensor(name="mat", polarity="down", rest=900.0)
    other = WAYS[kind][1]([with_frames(recording, 900.0 - frames)], sensor=known, **options)
    for name, values in maps(found).items():
        np.testing.assert_allclose(maps(other)[name], values, rtol=1e-6, err_msg=name)
    np.testing.assert_allclose(np.asarray(other.sensor.rest), 900.0 - np.asarray(found.sensor.rest), rtol=1e-9)
    assert (other.sensor.polarity, other.sensor.name) == ("down", "mat")


def test_gains_are_found_and_every_map_means_what_it_says(way: Any) -> None:
    kind, _, _, found = way
    true = gains_of(1)
    true /= np.median(true)
    off = np.log(found.sensor.gains / true)
    assert np.std(off) < 0.4 * np.std(np.log(true))
    assert found.kind == kind
    assert found.sensor.shape == (8, 9)
    assert found.sensor.pitch_m == (2e-3, 3e-3)
    record = found.to_dict()
    assert record["gains_applied"]
    assert record["kind"] == found.sensor.calibration["kind"] == kind
    assert found.sensor.calibration["presses"] == found.presses == {"even": 4, "scale": 150, "unlabelled": 60}[kind]
    assert found.findings[0].name == "gain_spread"
    assert found.findings[0].value == pytest.approx(np.std(np.log(true)), rel=0.25)
    assert 0 < found.findings[0].error < 0.1 * found.findings[0].value
    # Before, a taxel reads as its gain says (beside its neighbours, where nothing else is known); after, as it should.
    before, after = found.before[1:-1, 1:-1], found.after[1:-1, 1:-1]
    assert np.corrcoef(np.log(before).ravel(), np.log(true[1:-1, 1:-1]).ravel())[0, 1] > 0.5
    assert np.nanstd(np.log(after)) < 0.6 * np.nanstd(np.log(before))
    assert np.nanmedian(after) == pytest.approx(1.0, abs=0.03)
    assert 0 < np.nanmedian(found.residual) < 0.15


@pytest.mark.parametrize("kind", WAYS)
def test_standard_errors_are_as_large_as_they_say(kind: str) -> None:
    make, calibrate = WAYS[kind]
    off = []
    for seed in range(2, 6):
        recording, options = make(seed)
        found = calibrate([recording], **options)
        true = gains_of(seed)
        assert found.sensor.gains is not None
        ratio = np.log(found.sensor.gains / true)
        off.append((ratio - np.median(ratio)) / found.error)
    assert 0.5 < 1.4826 * np.nanmedian(np.abs(off)) < 1.6


def test_twice_the_presses_have_less_error_by_the_root_of_two() -> None:
    error = [np.nanmedian(calibrate_even([evenly(3, n)[0]]).error) for n in (8, 16)]
    assert error[1] / error[0] == pytest.approx(np.sqrt(0.5), rel=0.25)


def test_a_taxel_that_feels_nothing_is_broken_and_alters_no_other(way: Any) -> None:
    kind, recording, options, found = way
    if kind == "scale":
        return
    frames = recording.pads["pad"].frames.copy()
    frames[:, 3, 4] *= 1e-3
    other = WAYS[kind][1]([with_frames(recording, frames)], **options)
    assert other.sensor.broken is not None
    assert np.argwhere(other.sensor.broken).tolist() == [[3, 4]]
    assert any("1 taxel" in note for note in other.notes)
    assert np.isnan(other.error[3, 4])
    ratio = np.delete((other.sensor.gains / found.sensor.gains).ravel(), 3 * 9 + 4)
    np.testing.assert_allclose(ratio, 1.0, rtol=0.1)


def test_one_press_over_all_is_even_whatever_its_level(monkeypatch: pytest.MonkeyPatch) -> None:
    gains = gains_of(4)
    found = calibrate_even([recorded(300 * gains[None], 1e-6)])
    assert found.sensor.gains is not None
    np.testing.assert_allclose(found.sensor.gains, gains / np.median(gains), rtol=1e-6)
    np.testing.assert_allclose(found.after, 1.0, rtol=1e-6)
    np.testing.assert_allclose(found.before, gains / np.median(gains), rtol=1e-6)
    assert any("how well it repeats is not known" in note for note in found.notes)
    # So many taxels may be silent, and not one more.
    silent = gains.copy()
    silent.ravel()[[3, 30]] = 0.0
    monkeypatch.setattr(evens, "_MOST_BROKEN", 2 / 72)
    assert calibrate_even([recorded(300 * silent[None], 1e-6)]).sensor.broken is not None
    silent.ravel()[50] = 0.0
    with pytest.raises(InputError, match="press 0 is no even pressure: 3 of 72 taxels feel next to nothing"):
        calibrate_even([recorded(300 * silent[None], 1e-6)])


def test_a_press_that_is_otherwise_is_named() -> None:
    gains = gains_of(4)
    frames = np.array([100.0, 200, 300, 400])[:, None, None] * gains
    frames[2] *= np.linspace(0.6, 1.4, 9)
    with pytest.raises(InputError, match="press 2 loads the pad otherwise than the others"):
        calibrate_even([recorded(frames, 0.1)])


# What presses are


def test_a_press_is_the_mean_of_the_frames_that_hold_it_above_rest() -> None:
    rng = np.random.default_rng(0)
    form = rng.uniform(50, 100, (6, 6))
    course = np.array([0, 0, 0, 0, 0, 0.5, 0.985, 1.0, 0.99, 0.9, 0, 0, 0, 0, 0])
    rest = np.full((6, 6), 7.0)
    frames = rest + course[:, None, None] * form + 1e-3 * rng.standard_normal((15, 6, 6))
    for sensor, turn in ((Sensor(), 1.0), (Sensor(polarity="down", rest=100.0), -1.0)):
        raw = frames if turn > 0 else 100.0 - frames
        found = presses_of([Recording({"pad": Pad(raw)})], sensor)
        assert found.n == 1
        np.testing.assert_allclose(found.frames[0], course[6:9].mean() * form, rtol=1e-3)
        assert found.noise[0] == pytest.approx(1e-3 / np.sqrt(3), rel=0.4)
        np.testing.assert_allclose(found.rest, rest, atol=3e-3)
        np.testing.assert_allclose(found.rest_of(sensor), rest if turn > 0 else 100.0 - rest, atol=3e-3)


def test_presses_that_follow_at_once_are_parted() -> None:
    left, right = np.zeros((6, 6)), np.zeros((6, 6))
    left[:, :2], right[:, 4:] = 50, 60
    quiet = np.zeros((5, 6, 6))
    frames = np.concatenate([quiet, [left] * 3, [right] * 3, quiet]) + 1e-3 * np.random.default_rng(1).normal(
        size=(16, 6, 6)
    )
    found = presses_of([Recording({"a": Pad(frames), "b": Pad(frames)})], Sensor(), pad="b")
    assert found.n == 2
    np.testing.assert_allclose(found.frames, [left, right], atol=1e-2)
    both = presses_of([Recording({"a": Pad(frames)}), Recording({"a": Pad(frames)})], Sensor())
    assert both.recording.tolist() == [0, 0, 1, 1]
    with pytest.raises(InputError, match="has no pad 'c'; it has a, b"):
        presses_of([Recording({"a": Pad(frames), "b": Pad(frames)})], Sensor(), pad="c")
    with pytest.raises(InputError, match="recording 1: has 6 x 5 taxels, the recordings before 6 x 6"):
        presses_of([Recording({"a": Pad(frames)}), Recording({"a": Pad(frames[:, :, :5])})], Sensor())
    with pytest.raises(InputError, match="at least one recording, got none"):
        presses_of([], Sensor())


def test_a_rest_that_moves_is_told_and_one_that_stays_is_not() -> None:
    rng = np.random.default_rng(2)
    form = np.zeros((6, 6))
    form[2:4, 2:4] = 100.0
    course = np.array([0.0] * 5 + [1.0] * 4 + [0.0] * 5)[:, None, None]
    for n_moved in (0, 1, 2):
        frames = course * form + 0.1 * rng.standard_normal((14, 6, 6))
        frames[9:, 0, :n_moved] += np.array([5.0, -5.0])[:n_moved]
        if n_moved < 2:
            presses_of([Recording({"pad": Pad(frames)})], Sensor())
        else:
            with pytest.raises(InputError, match=r"the rest moves: 2 taxels by up to [45]"):
                presses_of([Recording({"pad": Pad(frames)})], Sensor())


def test_findings_in_words() -> None:
    assert str(Finding("dead_band", 0.1234, 0.0156, "what", share=True)) == "dead_band 12 ± 2 %: what"
    assert str(Finding("a", 5.4321, 0.0156, "what")) == "a 5.43 ± 0.02: what"


@pytest.mark.parametrize("pressure_pa", [None, (2e3, 3e3, 4e3, 5e3)])
def test_gains_that_change_with_the_load_are_told_and_are_no_surer_for_it(pressure_pa: Any) -> None:
    """A gain behind a bent response, or before one that nobody knows, is another one at another pressure."""
    levels, gains = np.linspace(0.4, 1.0, 4)[:, None, None], gains_of(4) ** 0.7
    behind = 300 * gains * np.log1p(5 * levels) / np.log(6)
    before = 300 * np.log1p(5 * levels * gains) / np.log(6)
    in_line = 300 * gains * levels
    told = {}
    for name, frames in {"behind": behind, "before": before, "in line": in_line}.items():
        found = calibrate_even([recorded(frames, 0.5)], pressure_pa=pressure_pa)
        told[name] = any("change with the load" in note for note in found.notes)
        if told[name]:
            assert found.error is not None
            assert float(np.nanmedian(found.error)) > 0.004
    expected = {"behind": True, "before": False} if pressure_pa else {"behind": False, "before": True}
    assert told == {**expected, "in line": False}
