"""Times of readings that are no seconds are told once, and others never."""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from varishold.live import Sample, StreamHealth
from varishold.live.odd_clock import OddClock
from varishold.live.sample_file import sample_file
from varishold.live.steady_time import SteadyTime


def told(times: list[float | None], host_step_s: float = 0.02) -> str:
    clock = OddClock()
    for k, time_s in enumerate(times):
        clock.look(Sample(time_s, 1e9 + host_step_s * k, None, {"pad": np.zeros((2, 2))}))
    return clock.words


@settings(max_examples=50)
@given(st.floats(1e-4, 0.9), st.floats(-1e9, 1e9), st.integers(0, 40))
def test_seconds_are_never_told(step_s: float, begin_s: float, gap: int) -> None:
    times: list[float | None] = [begin_s + step_s * k + 60.0 * (k > gap) for k in range(50)]
    assert told(times) == ""
    assert told([*times, *times]) == ""
    assert told([None] * 50) == ""


def test_milliseconds_and_times_that_go_back_are_told() -> None:
    words = told([20.0 * k for k in range(60)])
    assert words == "readings are 20 s apart by their own times: are these milliseconds? time_s is in seconds and rises"
    assert told([20.0 * k for k in range(60)], host_step_s=19.0) == ""
    assert told([-0.02 * k for k in range(60)]) == "the times of readings go back; time_s is in seconds and rises"


@pytest.mark.parametrize("step_s", [1.0, 2.0, 5.0])
def test_a_slow_sensor_that_is_handed_on_at_once_is_not_told(step_s: float) -> None:
    times = [1e9 + step_s * k for k in range(60)]
    assert told([*times], host_step_s=0.0) == ""
    assert told([*times], host_step_s=1e-4) == ""
    # As fast as if they were milliseconds.
    assert told([*times], host_step_s=1e-3 * step_s)


STANDS = "the times of readings stand still; time_s is in seconds and rises"


@pytest.mark.parametrize(
    "times",
    [
        [0.0] * 60,
        [0.02 * min(k, 30) for k in range(60)],
        # Whole seconds.
        [float(k // 50) for k in range(200)],
    ],
)
def test_times_that_stand_still_are_told(times: list[float | None]) -> None:
    assert told(times) == STANDS


def test_pads_that_are_read_at_one_time_are_not_told() -> None:
    clock, names = OddClock(), [f"finger {n}" for n in range(30)]
    for k in range(20):
        for name in names:
            clock.look(Sample(0.02 * k, 1e9 + 0.02 * k, None, {name: np.zeros((2, 2))}))
    assert clock.words == ""
    for _ in range(11):
        for name in names:
            clock.look(Sample(0.4, 1e9, None, {name: np.zeros((2, 2))}))
    assert clock.words == STANDS
    # A frame may come twice.
    assert told([0.02 * (k // 9) for k in range(90)]) == ""


@pytest.mark.parametrize(
    "own",
    [
        lambda k: 0.0,
        lambda k: 0.02 * min(k, 30),
        lambda k: float(k // 50),
        lambda k: 20.0 * k,
        lambda k: -0.02 * k,
        lambda k: 1e9 + 20.0 * k,
    ],
)
def test_time_goes_on_as_readings_arrive_where_their_own_times_are_no_seconds(own: Callable[[int], float]) -> None:
    clock = SteadyTime()
    times = [clock.time_s(Sample(own(k), 1e9 + 0.02 * k, None, {"pad": np.zeros((2, 2))})) for k in range(200)]
    steps = np.diff(times)
    assert steps.min() >= 0
    np.testing.assert_allclose(steps[60:], 0.02, atol=1e-6)


def milliseconds(n: int, unit_s: float = 1.0) -> list[Sample]:
    return [
        Sample(20.0 * unit_s * k, 1e9 + 0.02 * k, None, {"pad": np.full((4, 4), k % 3, np.int16)}) for k in range(n)
    ]


def test_the_health_of_a_stream_tells_a_clock_in_milliseconds_and_not_that_it_is_fast() -> None:
    health = StreamHealth()
    for sample in milliseconds(2000):
        health.add(sample)
    (remark,) = health.report().remarks
    assert remark.startswith("readings are 20 s apart by their own times: are these milliseconds?")
    assert health.report().to_dict()["odd_clock"] == remark
    seconds = StreamHealth()
    for sample in milliseconds(2000, 1e-3):
        seconds.add(sample)
    assert (seconds.report().odd_clock, seconds.report().remarks) == ("", ())


def test_a_recording_tells_that_its_times_cannot_be_seconds(tmp_path: Path) -> None:
    with sample_file(tmp_path / "a.mcap", dict) as file:
        for sample in milliseconds(20):
            file.add(sample)
    assert "milliseconds" in file.tally.odd_clock


@pytest.mark.parametrize(
    ("words", "end"),
    [
        (("record", "stdin:", "-o", "a.mcap"), "the times were written as they came"),
        (("live", "stdin:", "--json"), "the time of arrival is taken"),
    ],
)
def test_the_commands_tell_it_once(tmp_path: Path, words: tuple[str, ...], end: str) -> None:
    lines = "".join(json.dumps({"time_s": 20.0 * k, "frame": [[k % 3, 1], [2, 3]]}) + "\n" for k in range(40))
    command = [sys.executable, "-m", "varishold", *words]
    done = subprocess.run(command, input=lines, capture_output=True, text=True, timeout=120, check=True, cwd=tmp_path)
    (told,) = (line for line in done.stderr.splitlines() if "milliseconds" in line)
    assert told.endswith(f"time_s is in seconds and rises; {end}")


def test_two_senders_at_once_are_told_and_their_times_do_not_run_away() -> None:
    times = [0.02 * k + 1000.0 * (k % 2) for k in range(200)]
    assert told(list(times)).startswith("the times of readings go back")
    clock = SteadyTime()
    steady = [clock.time_s(Sample(at, 1e9 + 0.01 * k, None, {"pad": np.zeros((2, 2))})) for k, at in enumerate(times)]
    assert np.all(np.diff(steady) >= 0)
    assert np.diff(steady)[-150:].max() == pytest.approx(0.01, abs=1e-6)


def test_a_sensor_that_starts_anew_now_and_then_is_not_odd() -> None:
    assert told([0.02 * (k % 10) for k in range(95)]) == ""
