"""Calibration against plain sums: neighbours, differences, first guesses, what is left, weighed means, posteriors."""

from __future__ import annotations

import dataclasses
import itertools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from tests.test_calibration import depths
from tests.test_calibration import recorded as pressed_recording
from tests.test_calibration_laws import PAD, PLACES, presses_at

from varishold.calibration import Calibration, calibrate_objects, known_object
from varishold.calibration.explanation import FAMILIES, Observations
from varishold.calibration.imprint import OBJECTS, KnownObject, _plate_turn
from varishold.calibration.objects import _curve, _left, _observed
from varishold.calibration.press_fit import Fit, Observed, _normal
from varishold.calibration.unlabelled import _beside, _inside, _roughness, _scatter
from varishold.errors import InputError
from varishold.recording import Pad, Recording
from varishold.sensor import Linear, Logarithmic, Power, Sensor

Floats = NDArray[np.float64]
few = settings(max_examples=25)
seeds = st.integers(0, 2**32 - 1)


# Neighbours


def felt(seed: int) -> tuple[Floats, NDArray[np.bool_], Floats]:
    rng = np.random.default_rng(seed)
    stress, inside = rng.uniform(0.5, 2.0, (5, 4, 6)), rng.random((5, 4, 6)) < 0.75
    return stress, inside, rng.normal(0, 0.2, (4, 6))


@few
@given(seeds)
def test_a_taxel_is_seen_beside_its_neighbours_in_the_contact(seed: int) -> None:
    stress, inside, gains = felt(seed)
    beside = _beside(stress, inside, gains)
    for n, r, c in np.ndindex(stress.shape):
        around = [
            np.log(stress[n, i, j]) - gains[i, j]
            for i, j in ((r - 1, c), (r + 1, c), (r, c - 1), (r, c + 1))
            if 0 <= i < 4 and 0 <= j < 6 and inside[n, i, j]
        ]
        if inside[n, r, c] and len(around) >= 3:
            own = np.log(stress[n, r, c]) - gains[r, c]
            assert beside[n, r, c] == pytest.approx(own - np.mean(around), abs=1e-12)
        else:
            assert np.isnan(beside[n, r, c])
    rough, scatter = _roughness(stress, inside, gains), _scatter(stress, inside, gains)
    middles = {}
    for r, c in np.ndindex(4, 6):
        seen = beside[:, r, c][np.isfinite(beside[:, r, c])]
        if len(seen):
            middles[r, c] = np.median(seen)
        assert scatter[r, c] == pytest.approx(np.median(np.abs(seen)) if len(seen) >= 3 else np.nan, nan_ok=True)
    level = np.median(list(middles.values())) if middles else 0.0
    for r, c in np.ndindex(4, 6):
        assert rough[r, c] == pytest.approx(middles.get((r, c), 0.0) - level, abs=1e-12)
    nobody = np.zeros_like(inside)
    assert not _roughness(stress, nobody, gains).any()
    assert np.isnan(_scatter(stress, nobody, gains)).all()


def test_a_taxel_takes_part_where_its_surroundings_are_pressed() -> None:
    stress = np.zeros((6, 7, 7))
    stress[:, 2:6, 2:6] = 1.0
    stress[:, 3, 3] = 0.02
    stress[0, 3, 3] = 1.0
    usable = np.ones((7, 7), np.bool_)
    usable[4, 4] = False
    inside, broken = _inside(stress, np.full(6, 0.1), usable)
    # It stays silent in five of six presses: more than four fifths, and five at least.
    assert np.argwhere(broken).tolist() == [[3, 3]]
    around = np.zeros((7, 7), np.bool_)
    around[2:6, 2:6] = True
    around[[2, 2, 5, 5], [2, 5, 2, 5]] = False
    around[3, 3] = around[4, 4] = False
    np.testing.assert_array_equal(inside[1], around)
    assert not _inside(stress[:5], np.full(5, 0.1), usable)[1].any()
    assert not _inside(stress, np.full(6, 0.25), usable)[0].any()


# Known objects


@pytest.mark.parametrize("kind", OBJECTS)
def test_a_first_guess_is_made_of_moments_of_what_is_pressed(kind: str) -> None:
    rng = np.random.default_rng(8)
    thing = KnownObject(kind, 0.02)
    places = np.array([PLACES[kind](rng) for _ in range(4)])
    found = presses_at(thing, places, sigma=3.0)
    found.usable[2, 3] = False
    dy, dx = PAD.pitch_m
    x, y = np.meshgrid((np.arange(14) - 6.5) * dx, (np.arange(12) - 5.5) * dy)
    for k in range(4):
        frame = np.where(found.usable, found.frames[k], 0.0)
        pressed = frame > 0.1 * frame.max()
        weight = frame[pressed] / frame[pressed].sum()
        cx, cy = weight @ x[pressed], weight @ y[pressed]
        area = pressed.sum() * dx * dy
        cov = np.cov(np.array([x[pressed], y[pressed]]), aweights=weight, bias=True)
        yaw = 0.5 * np.arctan2(2 * cov[0, 1], cov[0, 0] - cov[1, 1])
        guess = _observed(found, k, thing, PAD)
        np.testing.assert_array_equal(guess.frame, frame)
        assert guess.sigma == pytest.approx(np.hypot(3.0, 0.01 * frame.max()))
        if kind == "ball":
            depth = min(area / np.pi / 0.02, 0.008)
            wanted, scale = [cx, cy, depth], [dy, dy, depth / 2]
        elif kind == "roller":
            long = np.hypot(12 * dy * np.sin(yaw), 14 * dx * np.cos(yaw))
            depth = min((area / long / 2) ** 2 / 0.02, 0.008)
            wanted = [np.cos(yaw) * cy - np.sin(yaw) * cx, yaw, depth, 0.0]
            scale = [dy, 0.1, depth / 2, depth / 2 / long]
        elif kind == "disc":
            depth = 0.5 * dy * frame.max() / found.frames.max()
            wanted, scale = [cx, cy, depth, 0, 0], [dy, dy, 0.3 * depth, depth / 0.02, depth / 0.02]
        else:
            depth = 0.5 * dy * frame.max() / found.frames.max()
            turn = _plate_turn(pressed, x - cx, y - cy, 0.02)
            wanted, scale = [cx, cy, turn, depth, 0, 0], [dy, dy, 0.1, 0.3 * depth, depth / 0.02, depth / 0.02]
        np.testing.assert_allclose(guess.start, wanted, atol=1e-12)
        np.testing.assert_allclose(guess.scale, scale)


def test_a_plates_turn_is_that_which_covers_best() -> None:
    x, y = np.meshgrid(np.linspace(-1, 1, 41), np.linspace(-1, 1, 41))
    for steps in range(18):
        turn = steps * np.pi / 36
        u, v = np.cos(turn) * x + np.sin(turn) * y, np.cos(turn) * y - np.sin(turn) * x
        inside = (np.abs(u) < 0.5) & (np.abs(v) < 0.5)
        assert _plate_turn(inside, x, y, 1.0) == pytest.approx(turn)


def fit_of(predicted: Floats) -> Fit:
    return Fit(np.zeros(3), np.zeros(3), np.zeros(3), (), np.zeros(len(predicted)), predicted)


@few
@given(seeds)
def test_what_is_left_is_a_share_of_the_peak_where_either_presses(seed: int) -> None:
    rng = np.random.default_rng(seed)
    frames, predicted, usable = *rng.uniform(0, 5, (2, 3, 4, 4)), rng.random((4, 4)) < 0.8
    observed = [Observed(KnownObject("ball", 0.02), frame, 1.0, np.zeros(3), np.ones(3)) for frame in frames]
    wanted = []
    for frame, other in zip(frames, predicted, strict=True):
        inside = [at for at in np.ndindex(4, 4) if usable[at] and max(frame[at], other[at]) > 0.1 * frame.max()]
        wanted.append(np.sqrt(np.mean([(frame[at] - other[at]) ** 2 for at in inside])) / frame.max())
    np.testing.assert_allclose(_left(fit_of(predicted), observed, usable), wanted)


@pytest.mark.parametrize("response", [Linear(), Power(0.5), Logarithmic(4.0)])
def test_a_curve_is_of_medians_in_bins_of_stress(response: Linear | Power | Logarithmic) -> None:
    rng = np.random.default_rng(2)
    sensor = Sensor(span=50.0, full_scale=3.0, response=response)
    share = rng.uniform(0, 1, (3, 9, 9))
    predicted = 50.0 * response.reading(share)
    frames = predicted + rng.normal(0, 0.5, predicted.shape)
    observed = [Observed(KnownObject("ball", 0.02), frame, 1.0, np.zeros(3), np.ones(3)) for frame in frames]
    curve = _curve(sensor, fit_of(predicted), observed)
    edges = np.linspace(0, share.max(), 25)
    flat, read = share.ravel(), frames.ravel() / 50.0
    # The lowest bin holds what is not pressed; those of fewer than five readings are left out.
    bins = [(flat >= a) & (flat < b) for a, b in itertools.pairwise(edges)][1:]
    kept = [of for of in bins if of.sum() >= 5]
    np.testing.assert_allclose(curve.stress[: len(kept)], [np.median(flat[of]) for of in kept], atol=1e-9)
    np.testing.assert_allclose(curve.reading[: len(kept)], [np.median(read[of]) for of in kept], atol=1e-9)
    assert len(curve.stress) == len(kept)
    # Five readings make a point, four do not.
    few_, many = np.repeat([0.1, 0.5, 0.9, 1.0], [99, 4, 5, 1]), observed[0]
    flat_frame = np.resize(50.0 * response.reading(few_), 121).reshape(11, 11)
    points = _curve(sensor, fit_of(flat_frame[None]), [dataclasses.replace(many, frame=flat_frame)])
    assert 0.5 not in points.stress.round(6)
    assert 0.9 in points.stress.round(6)


def test_a_sensor_is_made_of_its_constants_within_their_limits() -> None:
    base = Sensor(span=9.0, full_scale=2.0, name="kept")
    given_ = Observations(base, [], PAD, np.ones(PAD.shape, np.bool_))
    linear, power, logarithmic = FAMILIES
    made = given_.sensor(linear, np.array([0.3, 0.2, 1.44]))
    assert (made.dead_band, made.blur_taxels, made.response, made.name) == (0.2, pytest.approx(1.2), Linear(), "kept")
    made = given_.sensor(power, np.array([0, 0.9, 20.0, np.log(0.5)]))
    assert made.response.entries() == pytest.approx({"exponent": 0.5})
    ends = given_.sensor(logarithmic, np.array([0, 0.9, 20.0, np.log(7.0)]))
    assert (ends.dead_band, ends.blur_taxels) == (0.85, 4.0)
    assert ends.response.entries() == pytest.approx({"a": 7.0})
    ends = given_.sensor(linear, np.array([0, -0.1, -1.0]))
    assert (ends.dead_band, ends.blur_taxels) == (0.0, 0.0)
    for family in FAMILIES[1:]:
        assert family.low[0] < family.start[0] < family.high[0]


@pytest.fixture(scope="module")
def by_a_ball() -> tuple[Floats, Calibration]:
    sensor = Sensor(span=1000.0, full_scale=2e-3, blur_taxels=0.6)
    frames = sensor.forward(depths("ball", 0.05, 6, 2, 2e-3))
    found = calibrate_objects([pressed_recording(frames, 4.0, name="b.npz")], [KnownObject("ball", 0.05)])
    return frames, found


def test_maps_of_known_objects_mean_what_they_say(by_a_ball: tuple[Floats, Calibration]) -> None:
    frames, found = by_a_ball
    np.testing.assert_allclose(found.before, frames.max(axis=0) / frames.max(), atol=0.02)
    seen = np.isfinite(found.after)
    # Where two presses press at least, a reading is what it should be.
    often = (frames > 0.35 * frames.max(axis=(1, 2), keepdims=True)).sum(axis=0) >= 2
    seldom = (frames > 0.25 * frames.max(axis=(1, 2), keepdims=True)).sum(axis=0) < 2
    assert seen[often].all()
    assert not seen[seldom].any()
    np.testing.assert_allclose(found.after[seen], 1.0, atol=0.08)
    assert np.isnan(found.error).all()
    assert np.nanmedian(found.residual) < 0.02
    assert found.curve is not None
    line = np.polyfit(found.curve.stress, found.curve.reading, 1)
    assert np.abs(np.polyval(line, found.curve.stress) - found.curve.reading).max() < 0.03
    names = [finding.name for finding in found.findings]
    assert names == ["blur_taxels"]
    assert any(words.startswith("a dead band") for words in found.unknown)
    blur = found.findings[0]
    assert abs(blur.value - 0.6) < 0.05
    assert 0 < blur.error < 0.05
    assert found.kind == "objects"
    assert found.presses == 6
    assert found.sensor.span == pytest.approx(np.quantile(frames.max(axis=(1, 2)), 0.95), rel=0.02)
    assert any("linear" in note for note in found.notes)
    assert any(note.startswith("presses left out of the fit are explained") for note in found.notes)
    assert found.sensor.crosstalk == 0.0


def test_objects_are_as_many_as_recordings_and_presses_enough() -> None:
    frames = Sensor(span=1000.0, full_scale=2e-3).forward(depths("ball", 0.05, 6, 2, 2e-3))
    ball = KnownObject("ball", 0.05)
    with pytest.raises(InputError, match=r"one known object for all recordings or one for each: got 2 for 1"):
        calibrate_objects([pressed_recording(frames, 4.0)], [ball, ball])
    with pytest.raises(InputError, match=r"r\.npz: 4 presses of a ball are too few, 5 are the least"):
        calibrate_objects([pressed_recording(frames[:4], 4.0)], [ball])
    with pytest.raises(InputError, match="need the taxels' pitch"):
        calibrate_objects([Recording({"pad": Pad(pressed_recording(frames, 4.0).pads["pad"].frames)})], [ball])


@pytest.mark.parametrize(
    ("text", "size"), [("ball:0.02", 0.02), ("roller:999", 999.0), ("plate:2e-6", 2e-6), ("ball:1e3", None)]
)
def test_sizes_are_from_a_micrometre_to_a_kilometre(text: str, size: float | None) -> None:
    if size is not None:
        assert known_object(text).size_m == size
    for wrong in ("ball", "ball:", "ball:1e-6", "ball:nan", "ball:-1", "cube:0.02", text if size is None else ":1"):
        with pytest.raises(
            InputError, match="a known object is ball:SIZE, roller:SIZE, plate:SIZE, disc:SIZE, SIZE in metres"
        ):
            known_object(wrong)


@few
@given(seeds, st.integers(1, 3), st.integers(0, 2))
def test_normal_equations_are_those_of_one_large_matrix(seed: int, presses: int, count: int) -> None:
    rng = np.random.default_rng(seed)
    sizes, n = rng.integers(1, 4, presses), 5
    columns = [rng.normal(size=(presses, n)) for _ in range(count)]
    own = [rng.normal(size=(size, n)) for size in sizes]
    left = rng.normal(size=(presses, n))
    matrix = np.zeros((presses * n, count + sizes.sum()))
    for i, column in enumerate(columns):
        matrix[:, i] = column.ravel()
    ends = np.cumsum([0, *sizes])
    for k, block in enumerate(own):
        matrix[k * n : (k + 1) * n, count + ends[k] : count + ends[k + 1]] = block.T
    normal, right = _normal(columns, own, left, ends, count)
    np.testing.assert_allclose(normal, matrix.T @ matrix, atol=1e-12)
    np.testing.assert_allclose(right, matrix.T @ left.ravel(), atol=1e-12)
