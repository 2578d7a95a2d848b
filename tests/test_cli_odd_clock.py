"""Times of readings that are no seconds are told once, and others never."""

from __future__ import annotations

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from varishold.cli.odd_clock import OddClock


def told(times: list[float | None], capsys: pytest.CaptureFixture[str]) -> str:
    capsys.readouterr()
    clock = OddClock("udp::9000")
    for time_s in times:
        clock.look(time_s)
    return capsys.readouterr().err


@settings(max_examples=50, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.floats(1e-4, 0.9), st.floats(-1e9, 1e9), st.integers(0, 40))
def test_seconds_are_never_told(capsys: pytest.CaptureFixture[str], step_s: float, begin_s: float, gap: int) -> None:
    times: list[float | None] = [begin_s + step_s * k + 60.0 * (k > gap) for k in range(50)]
    assert told(times, capsys) == ""
    assert told([*times, *times], capsys) == ""
    assert told([None] * 50, capsys) == ""


def test_milliseconds_and_times_that_go_back_are_told_once(capsys: pytest.CaptureFixture[str]) -> None:
    (line,) = told([20.0 * k for k in range(60)], capsys).splitlines()
    assert line.startswith("varishold: udp::9000: readings are 20 s apart by their own times: are these milliseconds?")
    (line,) = told([-0.02 * k for k in range(60)], capsys).splitlines()
    assert "the times of readings go back; time_s is in seconds and rises" in line
