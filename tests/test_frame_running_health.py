"""Taxels of a stream: every fault gets its word, and only it; what is kept does not grow."""

from __future__ import annotations

import json
import pickle

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from varishold.errors import InputError
from varishold.frame import TaxelHealth

SHAPE, RATE_HZ = (8, 8), 30.0


def watch(
    seconds=40.0, *, spoil=None, shape=SHAPE, rate_hz=RATE_HZ, whole=False, seed=0, noise=2.0, touched=None, **options
):
    """Watch noise over an uneven rest; `spoil(time_s, frame)` writes into each frame."""
    rng = np.random.default_rng(seed)
    rest = rng.uniform(200, 400, shape)
    health = TaxelHealth(shape, **options)
    for k in range(round(seconds * rate_hz)):
        time_s = k / rate_hz
        frame = rest + rng.normal(0, noise, shape)
        if spoil is not None:
            spoil(time_s, frame, rng)
        frame = np.rint(frame).astype(np.uint16) if whole else frame
        health.update(time_s, frame, touched=touched is not None and touched(time_s))
    return health


def words(health):
    return {(bad.row, bad.col, bad.word) for bad in health.report().bad}


@pytest.mark.parametrize("whole", [False, True])
def test_a_sound_pad_has_no_bad_taxels(whole):
    report = watch(80, whole=whole).report()
    assert report.bad == ()
    assert report.remarks == ()
    assert report.noise == pytest.approx(2.0, rel=0.1)
    assert report.drift_per_min == pytest.approx(0, abs=1)


def dead(_, frame, rng):
    frame[2, 3] = 0.0


def hardly_noisy(_, frame, rng):
    frame[2, 3] = 300 + 0.01 * (frame[2, 3] - 300)


@pytest.mark.parametrize(("share", "is_dead"), [(0.02, True), (0.04, True), (0.08, False), (0.5, False)])
def test_a_taxel_of_hardly_any_noise_is_dead(share, is_dead):
    """Less than a twentieth of the others'; more is a taxel that feels little."""

    def quiet(_, frame, rng):
        frame[2, 3] = 300 + 2.0 * share * rng.standard_normal()

    assert words(watch(60, spoil=quiet)) == ({(2, 3, "dead")} if is_dead else set())


def stuck(_, frame, rng):
    frame[2, 3] = 117.0


def noisy(_, frame, rng):
    frame[2, 3] += rng.normal(0, 15)


def impulses(_, frame, rng):
    frame[2, 3] += 300 * (rng.random() < 0.01)


def dropouts(_, frame, rng):
    frame[2, 3] -= 150 * (rng.random() < 0.01)


def saturated(time_s, frame, rng):
    if 20 < time_s < 25:
        frame[2, 3] = 4095.0


def no_number(_, frame, rng):
    if rng.random() < 0.1:
        frame[2, 3] = np.nan


@pytest.mark.parametrize(
    ("spoil", "word", "figure", "low", "high"),
    [
        (dead, "dead", "noise_times_median", 0, 0),
        (hardly_noisy, "dead", "noise_times_median", 0, 0.05),
        (stuck, "stuck", "value", 117, 117),
        (noisy, "noisy", "noise_times_median", 5, 10),
        (impulses, "impulses", "impulses_per_min", 8, 30),
        (dropouts, "impulses", "impulses_per_min", 8, 30),
        (saturated, "saturated", "saturated_share", 0.08, 0.25),
        (no_number, "no number", "not_finite_share", 0.05, 0.15),
    ],
)
def test_each_fault_has_its_word_and_figure(spoil, word, figure, low, high):
    health = watch(spoil=spoil, whole=spoil is saturated)
    assert words(health) == {(2, 3, word)}
    report = health.report()
    assert low <= report.bad[0].figures[figure] <= high
    assert len(report.remarks) == 1
    assert report.remarks[0].startswith("taxel (2, 3) ")


def test_open_lines_are_told_apart_from_dead_taxels():
    def open_lines(_, frame, rng):
        frame[5, :], frame[:, 1], frame[0, 0] = 0.0, 4.0, 0.0

    report = watch(spoil=open_lines).report()
    assert (report.open_rows, report.open_cols) == ((5,), (1,))
    assert {(bad.row, bad.col) for bad in report.bad if bad.word == "dead"} == {(0, 0)}
    assert sum(bad.word == "open line" for bad in report.bad) == 15
    assert report.remarks[:2] == ("row 5 is silent: an open line", "column 1 is silent: an open line")


def test_a_skin_that_shows_zeros_at_rest_has_no_dead_taxels():
    def threshold(time_s, frame, rng):
        frame[:] = 0.0
        if time_s % 10 < 2:
            frame[1:4, 2:5] = 60 + rng.normal(0, 2, (3, 3))

    assert watch(spoil=threshold, whole=True).report().bad == ()


def press(shape=SHAPE):
    y, x = np.mgrid[: shape[0], : shape[1]]
    return 200 * np.exp(-((y - 3) ** 2 + (x - 4) ** 2) / 4)


def test_what_is_slow_to_return_is_told_by_how_much_and_how_long():
    def presses(time_s, frame, rng):
        form, phase = press(), time_s % 20
        held, after_s = phase < 3, phase - 3
        frame += form * (held or 0.04 * np.exp(-after_s / 2))
        if not held:
            frame[3, 3] += form[3, 3] * 0.4 * np.exp(-after_s / 3)

    health = watch(100, spoil=presses, touched=lambda time_s: time_s % 20 < 3.2)
    assert words(health) == {(3, 3, "slow to return")}
    figures = health.report().bad[0].figures
    assert figures["stays_share"] == pytest.approx(0.44 * np.exp(-0.5 / 3), abs=0.06)
    assert 4 < figures["return_s"] < 10
    assert "half a second after it" in health.report().remarks[0]


def test_a_taxel_that_drifts_alone_is_told_by_its_rate():
    def drift(time_s, frame, rng):
        frame += 5 * time_s / 60
        frame[6, 6] += 20 * time_s / 60

    health = watch(150, spoil=drift)
    assert words(health) == {(6, 6, "drifts alone")}
    assert health.report().drift_per_min == pytest.approx(5, abs=1)
    assert health.report().bad[0].figures["drift_per_min"] == pytest.approx(25, abs=2)


def test_taps_of_one_frame_are_no_impulses():
    def taps(time_s, frame, rng):
        if round(time_s * RATE_HZ) % 60 == 30:
            frame += press()

    assert not any(word == "impulses" for _, _, word in words(watch(spoil=taps)))


def test_nothing_is_said_before_it_is_known():
    assert watch(5, spoil=dead).report().bad == ()
    assert TaxelHealth((3, 3)).report().bad == ()


def test_masked_taxels_are_not_spoken_of():
    valid = np.ones(SHAPE, bool)
    valid[2, 3] = False
    for spoil in (dead, stuck, noisy, impulses, no_number):
        assert watch(spoil=spoil, valid=valid).report().bad == ()


def test_a_full_scale_that_is_given_is_taken():
    def high(time_s, frame, rng):
        frame[2, 3] = min(frame[2, 3] + 900 * (time_s % 10 < 1), 1000.0)

    assert words(watch(spoil=high, full_scale=1000.0)) >= {(2, 3, "saturated")}
    assert watch(spoil=high).report().saturated_share == 0


def test_json_holds_the_figures():
    told = json.loads(json.dumps(watch(spoil=noisy).report().to_dict()))
    assert told["bad"][0]["word"] == "noisy"
    assert told["bad"][0]["noise_times_median"] > 4
    assert told["remarks"]
    assert told["n_frames"] == 1200


def test_what_it_keeps_does_not_grow():
    def everything(time_s, frame, rng):
        for spoil in (impulses, no_number):
            spoil(time_s, frame, rng)
        frame += press() * (time_s % 7 < 2)

    sizes = [len(pickle.dumps(watch(seconds, spoil=everything, touched=lambda t: t % 7 < 2))) for seconds in (40, 160)]
    assert abs(sizes[1] - sizes[0]) < 2000


def test_pauses_and_jumps_of_the_clock_are_survived():
    rng = np.random.default_rng(0)
    health = TaxelHealth(SHAPE)
    time_s = 0.0
    for k in range(1500):
        time_s += 1 / RATE_HZ + (500.0 if k == 500 else -2000.0 if k == 900 else 0.0)
        health.update(time_s, rng.normal(300, 2, SHAPE))
    assert health.report().bad == ()
    assert health.report().watched_s == pytest.approx(1497 / RATE_HZ, abs=0.1)


@settings(max_examples=20, deadline=None)
@given(
    st.sampled_from([(1, 1), (1, 8), (8, 1), (2, 2), (4, 6)]),
    st.sampled_from([4.0, 30.0, 200.0]),
    st.integers(0, 2**16),
)
def test_sound_pads_of_any_shape_and_rate_are_sound(shape, rate_hz, seed):
    assert watch(15, shape=shape, rate_hz=rate_hz, seed=seed).report().bad == ()


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: TaxelHealth((3, -1)), "two whole numbers from 1"),
        (lambda: TaxelHealth((3, 3)).update(0, np.ones((2, 2))), r"shape of the pad, \(3, 3\), got \(2, 2\)"),
        (lambda: TaxelHealth((3, 3)).update(np.inf, np.ones((3, 3))), "time_s must be finite"),
    ],
)
def test_what_it_says_of_bad_input(make, message):
    with pytest.raises(InputError, match=message):
        make()


@pytest.mark.parametrize("step_s", [0.5, 2.0, 5.0, 10.0])
@pytest.mark.parametrize("sigma", [1.0, 4.0])
def test_of_readings_far_apart_sound_taxels_are_not_called_broken_and_broken_ones_are(
    step_s: float, sigma: float
) -> None:
    rng, health, told = np.random.default_rng(3), TaxelHealth((12, 12)), []
    for k in range(400):
        frame = np.round(50 + sigma * rng.normal(size=(12, 12))).astype(int)
        frame[3, 4] = 17
        frame[5, 6] = round(50 + 10 * sigma * rng.normal())
        health.update(k * step_s, frame)
        if k % 5 == 0:
            told.append({(bad.row, bad.col) for bad in health.report().bad})
    assert set().union(*told) == {(3, 4), (5, 6)}
    assert all(places == {(3, 4), (5, 6)} for places in told[10:])
