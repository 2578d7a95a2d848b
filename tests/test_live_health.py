"""A stream's rate, jitter, lost numbers and clock: counters that go round, bursts, restarts, silence."""

from __future__ import annotations

import json
import pickle

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from varishold.live import Sample, StreamHealth
from varishold.live.clock_slope import ClockSlope
from varishold.live.sequence import SequenceCounter

BEGUN_S = 1.7e9


def counted(numbers, rate_hz=100.0):
    counter = SequenceCounter()
    for number in numbers:
        counter.add(number, 1 / rate_hz)
    return counter


@given(
    st.sampled_from([8, 16, 32, 64]),
    st.integers(0, 2**32),
    st.integers(0, 2**16),
    st.sampled_from([1, 2, 10]),
)
def test_what_was_lost_is_counted_round_the_end_of_any_counter(bits, start, seed, each):
    # The first loses nothing, so that the step is known.
    steps = [1, *np.random.default_rng(seed).integers(1, 10, 400).tolist()]
    counter, number = SequenceCounter(), start
    for step in (0, *steps):
        number += step * each
        counter.add(number % 2**bits, 0.01 * step)
    assert (counter.lost, counter.twice, counter.late) == (sum(steps) - len(steps), 0, 0)
    assert counter.restarts == 0


@given(st.integers(300, 60_000), st.integers(0, 100))
def test_a_counter_that_begins_anew_lost_nothing(last, first):
    counter = counted([*range(last - 200, last), *range(first, first + 50)])
    assert counter.lost == 0
    assert counter.restarts == (last != first)


def test_doubles_and_late_readings():
    counter = counted([250, 251, 251, 252, 255, 253, 0, 1, 1, 4, 3, 5])
    assert (counter.twice, counter.late) == (2, 2)
    assert counter.lost == 2  # 254 and 2
    assert counter.restarts == 0


def test_a_long_silence_may_have_lost_many():
    counter = counted(range(100))
    counter.add(1100, 10.0)
    assert (counter.lost, counter.restarts) == (1000, 0)
    counter.add(9000, 0.01)
    assert (counter.lost, counter.restarts) == (1000, 1)


def samples(n, rate_hz=100.0, *, jitter_s=0.0, ppm=0.0, seed=0):
    rng = np.random.default_rng(seed)
    for k in range(n):
        device_s = k / rate_hz * (1 + 1e-6 * ppm)
        yield Sample(device_s, BEGUN_S + k / rate_hz + rng.uniform(0, jitter_s), k % 256, {})


@given(st.floats(1, 2000), st.floats(-500, 500))
def test_rate_and_clock_are_measured(rate_hz, ppm):
    health = StreamHealth()
    for sample in samples(2000, rate_hz, ppm=ppm):
        health.add(sample)
    report = health.report()
    assert report.rate_hz == pytest.approx(rate_hz, rel=1e-3)
    assert report.jitter_s < 1e-5
    assert report.lost == 0
    if rate_hz < 190:
        assert report.clock_ppm == pytest.approx(ppm, abs=1)
    assert report.remarks == ()


def test_jitter_is_that_of_arrival():
    health = StreamHealth()
    for sample in samples(4000, jitter_s=4e-3, ppm=80):
        health.add(sample)
    report = health.report()
    # The difference of two uniform delays.
    assert report.jitter_s == pytest.approx(4e-3 / np.sqrt(6), rel=0.1)
    assert report.clock_ppm == pytest.approx(80, abs=15)
    assert 0.01 < report.longest_gap_s < 0.0145


def test_bursts_are_told_and_keep_the_rate():
    health = StreamHealth()
    for k in range(3000):
        health.add(Sample(None, BEGUN_S + 0.2 * (k // 20), None, {}))
    report = health.report()
    assert report.rate_hz == pytest.approx(100, rel=0.02)
    assert (report.lost, report.clock_ppm, report.lost_share) == (None, None, None)
    assert report.remarks == ("readings come in bursts: 44 ms of jitter at 100 /s",)


def test_a_stream_that_falls_silent_slows_down():
    health = StreamHealth()
    assert health.report(BEGUN_S).rate_hz == 0
    for sample in samples(1000):
        health.add(sample)
    rates = [health.report(BEGUN_S + 10 + silent_s).rate_hz for silent_s in (0, 1, 10, 100)]
    assert rates[0] == pytest.approx(100, rel=0.01)
    assert rates == sorted(rates, reverse=True)
    assert rates[-1] < 10
    assert health.report(BEGUN_S + 20).silent_s == pytest.approx(10, abs=0.02)


def test_what_was_lost_is_said():
    health = StreamHealth()
    for k, sample in enumerate(samples(2000)):
        if k % 50:
            health.add(sample)
    report = health.report()
    assert report.lost == 39
    assert report.remarks == ("39 readings were lost on the way, 2.0 % of all",)
    assert json.loads(json.dumps(report.to_dict()))["lost_share"] == pytest.approx(0.02, abs=1e-3)


def test_clocks_that_are_set_are_survived():
    health = StreamHealth()
    for k in range(6000):
        device_s = 0.01 * k - 30.0 * (k >= 2000)
        host_s = BEGUN_S + 0.01 * k - 3600.0 * (k >= 4000)
        health.add(Sample(device_s, host_s, None, {}))
    report = health.report()
    assert report.rate_hz == pytest.approx(100, rel=0.01)
    assert report.clock_set == 2
    assert report.clock_ppm == pytest.approx(0, abs=1)


def test_times_that_are_no_numbers_are_passed_over():
    health = StreamHealth()
    for k, sample in enumerate(samples(3000, ppm=100)):
        health.add(sample._replace(device_time_s=float("nan")) if k % 7 == 0 else sample)
        health.add(Sample(None, float("inf"), None, {}))
    assert health.report().clock_ppm == pytest.approx(100, abs=2)
    assert health.report().received == 3000


def test_a_clock_far_off_is_said():
    slope = ClockSlope()
    assert slope.ppm is None
    health = StreamHealth()
    for sample in samples(3000, ppm=-20_000):
        health.add(sample)
    assert health.report().remarks == ("the sensor's clock is 2.0 % slow",)


def test_what_it_keeps_does_not_grow():
    sizes = []
    for n in (2000, 20_000):
        health = StreamHealth()
        for sample in samples(n, jitter_s=1e-3):
            health.add(sample)
        sizes.append(len(pickle.dumps(health)))
    assert abs(sizes[1] - sizes[0]) < 200
