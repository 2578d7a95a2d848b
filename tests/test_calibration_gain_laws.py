"""Responses from end to end, gains as weighed means and posteriors, presses as they are parted."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from tests.test_calibration_laws import by_anything, by_tips, evenly, recorded

from varishold.calibration import calibrate_even, calibrate_scale, calibrate_unlabelled, readings
from varishold.calibration.even import _error
from varishold.calibration.imprint import Points
from varishold.calibration.readings import Presses, _parts, presses_of
from varishold.calibration.response_fit import _fitted, _left_out
from varishold.calibration.scale import _solved as scale_solved
from varishold.calibration.unlabelled import _inside, _roughness, _scatter
from varishold.calibration.unlabelled import _solved as unlabelled_solved
from varishold.errors import InputError
from varishold.recording import Pad, Recording
from varishold.sensor import Logarithmic, Power, Sensor

Floats = NDArray[np.float64]
few = settings(max_examples=25)
seeds = st.integers(0, 2**32 - 1)


# Responses


@pytest.mark.parametrize(
    ("family", "constant"),
    [(Power, 0.101), (Power, 0.5), (Power, 9.9), (Logarithmic, 1.1e-3), (Logarithmic, 8.0), (Logarithmic, 9e4)],
)
def test_a_family_is_searched_from_end_to_end(family: type[Power] | type[Logarithmic], constant: float) -> None:
    x = np.linspace(0.05, 1, 12)
    found = _fitted(family, x, family(constant).reading(x))
    (value,) = found.entries().values()
    assert value == pytest.approx(constant, rel=1e-3 if constant > 1e-2 else 0.05)


@pytest.mark.parametrize(
    ("family", "beyond", "end"),
    [(Power, 0.06, 0.1), (Power, 15.0, 10.0), (Logarithmic, 1e7, 1e5)],
)
def test_no_constant_is_found_beyond_its_ends(
    family: type[Power] | type[Logarithmic], beyond: float, end: float
) -> None:
    x = np.linspace(0.05, 1, 12)
    (value,) = _fitted(family, x, family(beyond).reading(x)).entries().values()
    assert value == pytest.approx(end, rel=1e-3)


def test_a_table_is_judged_by_the_points_it_is_not_told_of() -> None:
    x, y = np.array([0.2, 0.5, 0.6, 1.0]), np.array([0.3, 0.4, 0.8, 1.0])
    off = [0.3 + (0.8 - 0.3) * 0.3 / 0.4 - 0.4, 0.4 + (1.0 - 0.4) * 0.1 / 0.5 - 0.8]
    assert _left_out(x, y) == pytest.approx(np.sqrt(np.mean(np.square(off))))
    assert _left_out(x[:2], y[:2]) == 0.0


# Gains


@few
@given(seeds, st.integers(2, 5))
def test_a_weighed_gain_has_the_error_of_a_weighed_mean(seed: int, n: int) -> None:
    rng = np.random.default_rng(seed)
    frames = rng.uniform(50, 100, (n, 3, 4))
    noise = rng.uniform(1e-4, 30.0, n)
    usable = rng.random((3, 4)) < 0.9
    usable[0, 0] = True
    found = Presses(frames, noise, np.zeros(n, int), usable, None, None, (), ("even.npz",))
    beside, weight = rng.uniform(0.8, 1.2, (n, 3, 4)), rng.uniform(0.1, 1.0, n)
    typical = np.array([np.median(frame[usable]) for frame in frames])
    floor = 1 / np.sqrt(sum((t / s) ** 2 for t, s in zip(typical, noise, strict=True)))
    share = weight / weight.sum()
    error = _error(beside, weight, found)
    for at in np.ndindex(3, 4):
        values = beside[(slice(None), *at)]
        mean = share @ values
        wanted = np.sqrt(sum(w * w * (v - mean) ** 2 for w, v in zip(share, values, strict=True)) * n / (n - 1))
        assert error[at] == pytest.approx(max(wanted, floor))
    one = dataclasses.replace(found, frames=frames[:1], noise=noise[:1])
    np.testing.assert_allclose(_error(beside[:1], weight[:1], one), noise[0] / typical[0])


def test_presses_of_one_recording_share_the_error_of_their_rest() -> None:
    rng = np.random.default_rng(0)
    frames, usable = rng.uniform(50, 100, (5, 3, 4)), np.ones((3, 4), np.bool_)
    which, rests = np.array([0, 0, 1, 1, 1]), np.array([2.0, 0.5])
    plain = Presses(frames, np.full(5, 0.1), which, usable, None, None, (), ("a.npz", "b.npz"))
    found = dataclasses.replace(plain, rest_noise=rests)
    typical = np.median(frames.reshape(5, -1), axis=1)
    beside, weight = frames / typical[:, None, None], rng.uniform(0.5, 1.0, 5)
    gains = np.average(beside, axis=0, weights=weight)
    drawn = []
    for _ in range(4000):
        off = rng.normal(0, rests)[which]
        drawn.append(np.average(beside + (off / typical)[:, None, None], axis=0, weights=weight)[0, 0] - gains[0, 0])
    of_rest = np.sqrt(_error(beside, weight, found) ** 2 - _error(beside, weight, plain) ** 2)
    np.testing.assert_allclose(of_rest, np.std(drawn), rtol=0.05)


def pressed_evenly(
    seed: int, n: int, held: int, pause: int, recordings: int, noise: float = 2.0
) -> tuple[list[Recording], Floats]:
    """Recordings of even presses of a hundred counts with pauses between them, and the gains that they show."""
    rng = np.random.default_rng(seed)
    gains = np.exp(rng.normal(0, 0.08, (8, 9)))
    gains /= np.median(gains)
    made = []
    for _ in range(recordings):
        load = np.concatenate([np.zeros(pause), *[np.r_[np.full(held, 100.0), np.zeros(pause)] for _ in range(n)]])
        frames = load[:, None, None] * gains + rng.normal(0, noise, (len(load), 8, 9)) + 20
        made.append(Recording({"pad": Pad(frames)}))
    return made, gains


@pytest.mark.parametrize(
    ("n", "held", "pause", "recordings"),
    [(1, 20, 4, 1), (3, 20, 4, 1), (5, 30, 3, 1), (2, 10, 30, 1), (2, 30, 5, 4), (1, 60, 60, 1)],
)
def test_the_error_that_is_stated_of_gains_is_the_one_that_they_have(
    n: int, held: int, pause: int, recordings: int
) -> None:
    ratios = []
    for seed in range(8):
        given, gains = pressed_evenly(seed, n, held, pause, recordings)
        found = calibrate_even(given)
        assert found.sensor.gains is not None
        ratios.append(float(np.std(found.sensor.gains - gains) / np.median(found.error)))
    assert 0.8 < np.mean(ratios) < 1.15
    assert 0.6 < min(ratios) <= max(ratios) < 1.4


def test_pressures_are_one_positive_number_for_each_press() -> None:
    recording, _ = evenly(1)
    with pytest.raises(InputError, match="pressure_pa must be one positive number for each of the 4 presses found"):
        calibrate_even([recording], pressure_pa=[1e3, 2e3, 3e3])
    for wrong in ([1e3, 2e3, 3e3, 0.0], [np.nan], [1e3, -2e3], ["x"], []):
        # Before the presses are looked at.
        with pytest.raises(InputError, match="pressure_pa must be positive and finite numbers, pascal, got"):
            calibrate_even([], pressure_pa=wrong)
    # A response needs three different pressures, the highest twice the lowest.
    for pressures, told in (
        ([1e3, 2e3, 3e3, 4e3], True),
        ([1e3, 1e3, 2e3, 2e3], False),
        ([1000.0, 1333.0, 1666.0, 1999.0], False),
        ([1000.0, 1333.0, 1666.0, 2000.0], True),
    ):
        found = calibrate_even([recording], pressure_pa=pressures)
        assert (found.curve is not None) == told
        assert any(words.startswith("the response: it needs three or more") for words in found.unknown) == (not told)
        assert [finding.name for finding in found.findings] == ["gain_spread", *(["response_residual"] if told else [])]


def test_gains_from_totals_are_the_posterior_of_their_own_noise() -> None:
    rng = np.random.default_rng(1)
    true = np.exp(0.2 * rng.standard_normal(6))
    force = rng.uniform(1, 4, 80)
    shares = rng.dirichlet(np.full(6, 0.4), 80)
    stress = 50 * force[:, None] * shares * true * (1 + 0.01 * rng.standard_normal((80, 1)))
    gains, error, seen = scale_solved(stress, force)
    assert seen.all()
    np.testing.assert_allclose(gains / true * np.median(true), 1.0, atol=0.05)
    assert np.median(gains) == pytest.approx(1.0)
    rows = stress / force[:, None] / np.median(stress.sum(axis=1) / force)
    inverse = 1 / gains
    # At rest, noise and scatter are those of what is left: the normal equations hold up to the common factor.
    off = rows @ (inverse / np.median(rows @ inverse)) - 1
    assert np.std(off) < 0.02
    assert (np.abs(gains / true * np.median(true) - 1) < 6 * error + 0.01).all()
    # A taxel that nobody pressed is not known.
    lonely = np.column_stack([stress, np.zeros(80)])
    assert scale_solved(lonely, force)[2].tolist() == [True] * 6 + [False]


def plainly_solved(stress: Floats, force: Floats) -> tuple[Floats, Floats]:
    """Inverse gains by least squares with a prior, whose noise and scatter are what is left of the data."""
    rows = stress / force[:, None]
    rows = rows / np.median(rows.sum(axis=1))
    n, size = rows.shape
    noise, scatter = 0.05, 0.25
    for _ in range(8):
        design = np.vstack([rows / noise, np.eye(size) / scatter])
        wanted = np.concatenate([np.ones(n) / noise, np.ones(size) / scatter])
        inverse = np.linalg.lstsq(design, wanted, rcond=None)[0]
        variance = np.diag(np.linalg.inv(design.T @ design))
        # So many of the constants the data tell, the prior the others.
        told = size - sum(variance) / scatter**2
        noise = np.sqrt(sum((rows @ inverse - 1) ** 2) / (n - told))
        scatter = np.sqrt(np.mean((inverse - 1) ** 2 + variance))
    gains = 1 / inverse / np.median(1 / inverse)
    return gains, np.sqrt(variance) * gains


def test_gains_from_totals_are_least_squares_with_a_prior_that_the_data_tell() -> None:
    recording, options = by_tips(3, 120)
    found, force = presses_of([recording], Sensor()), np.asarray(options["force_n"])
    stress = found.frames.reshape(found.n, -1)
    gains, error = plainly_solved(stress, force)
    told = scale_solved(stress, force)
    np.testing.assert_allclose(told[0], gains, rtol=1e-6)
    np.testing.assert_allclose(told[1], error, rtol=1e-6)
    whole = calibrate_scale([recording], **options)
    assert told[2].all()
    np.testing.assert_allclose(whole.sensor.gains.ravel(), gains, rtol=1e-6)
    halves = [plainly_solved(stress[k::2], force[k::2])[0] for k in (0, 1)]
    spread = np.std(halves[0] - halves[1]) / 2
    (finding,) = whole.findings
    assert finding.value == pytest.approx(np.std(gains), rel=1e-6)
    unseen = np.sqrt(np.var(gains) + np.mean(error**2)) - np.std(gains)
    assert finding.error == pytest.approx(np.hypot(spread / np.sqrt(72), unseen), rel=1e-5)
    assert finding.error > spread / np.sqrt(2 * 72)
    np.testing.assert_allclose(whole.error.ravel(), np.maximum(error, spread), rtol=1e-5)
    assert f"each is known to {100 * np.median(np.maximum(error, spread)):.2g} %" in finding.says
    # Maps: what presses say of a total, shared among the taxels that felt them.
    share = np.maximum(stress, 0) / np.maximum(stress, 0).sum(axis=1, keepdims=True)
    totals = stress.sum(axis=1) / force
    np.testing.assert_allclose(
        whole.before.ravel(), (totals / np.median(totals)) @ share / share.sum(axis=0), rtol=1e-6
    )
    totals = (stress / gains).sum(axis=1) / force
    off = totals / np.median(totals) - 1
    np.testing.assert_allclose(whole.after.ravel(), 1 + off @ share / share.sum(axis=0), rtol=1e-6)
    np.testing.assert_allclose(whole.residual.ravel(), np.sqrt(off**2 @ share / share.sum(axis=0)), rtol=1e-5)


def test_even_gains_are_means_weighed_by_what_stands_above_the_noise() -> None:
    recording, _ = evenly(2, 5)
    found, whole = presses_of([recording], Sensor()), calibrate_even([recording])
    typical = np.median(found.frames.reshape(5, -1), axis=1)
    beside = found.frames / typical[:, None, None]
    weight = (typical / found.noise) ** 2
    gains = np.tensordot(weight / weight.sum(), beside, 1)
    gains = gains / np.median(gains)
    np.testing.assert_allclose(whole.sensor.gains, gains, rtol=1e-9)
    np.testing.assert_allclose(whole.before, beside.mean(axis=0), rtol=1e-9)
    np.testing.assert_allclose(whole.after, (beside / gains).mean(axis=0), rtol=1e-9)
    np.testing.assert_allclose(whole.residual, np.sqrt(((beside / gains - 1) ** 2).mean(axis=0)), rtol=1e-9)
    np.testing.assert_allclose(whole.error, _error(beside, weight, found), rtol=1e-9)
    (finding,) = whole.findings
    assert finding.value == pytest.approx(np.std(gains))
    own = np.sqrt(np.sum(((gains - gains.mean()) * whole.error) ** 2)) / (72 * np.std(gains))
    assert finding.error == pytest.approx(np.hypot(own, np.std(gains) * np.median(whole.error) / np.sqrt(2)))
    assert finding.error > np.median(whole.error) / np.sqrt(2 * 72)


def test_gains_of_anything_are_told_as_halves_of_the_presses_agree() -> None:
    recording, _ = by_anything(2, 40)
    found, whole = presses_of([recording], Sensor()), calibrate_unlabelled([recording])
    inside, broken = _inside(found.frames, found.noise, found.usable)
    assert not broken.any()
    gains, error = unlabelled_solved(found.frames, found.noise, inside)
    one, other = (unlabelled_solved(found.frames[k::2], found.noise[k::2], inside[k::2])[0] for k in (0, 1))
    pressed = inside.sum(axis=0) >= 3
    one, other = one[pressed], other[pressed]
    (finding,) = whole.findings
    assert finding.value == pytest.approx(np.sqrt(np.mean(one * other)))
    unseen = np.sqrt(np.mean(gains[pressed] ** 2 + error[pressed] ** 2)) - finding.value
    assert finding.error == pytest.approx(np.hypot(np.std(one - other) / 2 / np.sqrt(pressed.sum()), unseen))
    assert finding.error > np.std(one - other) / 2 / np.sqrt(2 * pressed.sum())
    wanted = 1.3 * np.maximum(error, np.std(one - other) / 2)
    np.testing.assert_allclose(whole.error[pressed], wanted[pressed])
    np.testing.assert_allclose(whole.sensor.gains, np.exp(gains - np.median(gains)))
    nothing = np.zeros_like(gains)
    for name, rough in (("before", nothing), ("after", gains)):
        told = np.exp(_roughness(found.frames, inside, rough))
        np.testing.assert_allclose(getattr(whole, name)[pressed], told[pressed])
        assert np.isnan(getattr(whole, name)[~pressed]).all()
    np.testing.assert_allclose(whole.residual, _scatter(found.frames, inside, gains))
    assert f"each is known to {100 * np.median(wanted[pressed]):.2g} %" in finding.says


def test_what_all_places_share_is_no_gain_however_many_presses_there_are() -> None:
    rng = np.random.default_rng(7)
    y, x = np.mgrid[:8, :8] + 0.5
    gains = np.exp(rng.normal(0.0, 0.2, (8, 8)))
    off = []
    for n in (60, 480):
        radius, height = rng.uniform(4.0, 14.0, n), rng.uniform(0.5, 2.0, n)
        at = rng.uniform(1.0, 7.0, (n, 2))
        away = (y - at[:, :1, None]) ** 2 + (x - at[:, 1:, None]) ** 2
        caps = np.maximum(height[:, None, None] - away / (2 * radius[:, None, None]), 0.0)
        found = calibrate_unlabelled([recorded(gains * caps, 0.01, n)]).sensor.gains
        assert found is not None
        off.append(np.log(found / gains).ravel())
    # A slope and a bend of the gains themselves are all that is left: nothing tells them from what forms share.
    bends = np.stack([np.ones(64), *(each.ravel() for each in (x, y, x * x, x * y, y * y))], axis=1)
    for each in off:
        assert np.std(each - bends @ np.linalg.lstsq(bends, each, rcond=None)[0]) < 0.02
    assert np.std(off[1]) < 1.1 * np.std(off[0])


# Presses


def test_presses_part_where_frames_are_unlike() -> None:
    a, b = np.array([[1.0, 0.0]]), np.array([[0.44, 1.0]])
    c = np.array([[0.5, 1.0]])
    values = np.array([a, a, 3 * a, b, c, c, a, a])
    pad = Pad(values)
    assert _parts(pad, range(8)) == [range(3), range(3, 6), range(6, 8)]
    assert _parts(pad, range(1, 5)) == [range(1, 3), range(3, 5)]
    assert _parts(pad, range(2, 3)) == [range(2, 3)]


def test_presses_say_what_was_not_unloaded_and_which_taxels_count(monkeypatch: pytest.MonkeyPatch) -> None:
    rng = np.random.default_rng(0)
    form = np.zeros((6, 6))
    form[1:4, 1:4] = rng.uniform(50, 100, (3, 3))
    course = np.array([0.0] * 5 + [1.0] * 3 + [0.0] * 5)
    frames = course[:, None, None] * form + 1e-3 * rng.standard_normal((13, 6, 6))
    valid = np.ones((6, 6), np.bool_)
    valid[5, 5] = False
    told = presses_of([Recording({"p": Pad(frames, valid=valid)}), Recording({"p": Pad(frames)})], Sensor())
    np.testing.assert_array_equal(told.usable, valid)
    assert told.recording.tolist() == [0, 1]
    assert (told.n, told.pitch_m, told.notes) == (2, None, ())
    assert told.rest is not None
    monkeypatch.setattr(readings, "_FEWEST_QUIET", 20)
    without = presses_of([Recording({"p": Pad(frames)}, source="x.npz")], Sensor(pitch_m=(1e-3, 2e-3)))
    assert without.rest is None
    assert without.rest_of(Sensor(rest=3.0)) == 3.0
    assert without.pitch_m == (1e-3, 2e-3)
    assert without.notes == ("x.npz: no unloaded frame: its rest is taken as known",)


def test_points_of_a_pad_are_eight_along_a_taxel() -> None:
    pad = Points((2, 3), (2e-3, 1e-3))
    x, y = pad.axes
    np.testing.assert_allclose(x[0], (np.arange(24) - 11.5) * 0.125e-3)
    np.testing.assert_allclose(y[:, 0], (np.arange(16) - 7.5) * 0.25e-3)
    assert pad.spacing_m == 0.125e-3
