"""Time that goes on, and readings that come when they are due."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from varishold.live import Sample, pace
from varishold.live.pace import Pace
from varishold.live.steady_time import SteadyTime

device = st.one_of(st.none(), st.floats(-10, 200_000))


@given(st.lists(st.tuples(device, st.floats(0, 200_000)), min_size=1, max_size=12))
@settings(max_examples=200)
def test_time_goes_on_by_the_sensors_clock_or_else_by_this_machines(clocks: list[tuple[float | None, float]]) -> None:
    steady, offset, last = SteadyTime(), 0.0, None
    assert steady.now_s == 0.0
    for device_s, host_s in clocks:
        time_s = steady.time_s(Sample(device_s, host_s, None, {}))
        own = host_s if device_s is None else device_s
        if last is None:
            expected = own
        else:
            expected = own + offset
            # A day ahead, or back: the clock began anew.
            if expected < last[0] or expected > last[0] + 86400:
                passed = host_s - last[1]
                expected = last[0] + (passed if 0 <= passed <= 86400 else 0.0)
                offset = expected - own
        assert time_s == steady.now_s == expected
        last = expected, host_s


class Clock:
    """Time that passes by sleeping, and a little by looking at it."""

    def __init__(self) -> None:
        self.now_s = 1000.0

    def sleep(self, seconds: float) -> None:
        assert seconds >= 0
        self.now_s += seconds

    def monotonic(self) -> float:
        self.now_s += 1e-7
        return self.now_s

    def time(self) -> float:
        return 5e8 + self.now_s


@given(
    st.lists(st.integers(0, 300), min_size=1, max_size=200),
    st.sampled_from([0.5, 1.0, 8.0]),
    st.sampled_from([0.01, 0.1, 1.0]),
)
@settings(max_examples=60)
def test_readings_come_when_they_are_due_and_none_is_left_out(steps: list[int], speed: float, wait_s: float) -> None:
    due = (np.cumsum(steps) / 1000).tolist()
    with pytest.MonkeyPatch.context() as patch:
        clock = Clock()
        patch.setattr(pace, "time", clock)
        its, first = Pace(speed), 0
        for _ in range(20_000):
            if first >= len(due):
                break
            before_s = clock.now_s
            last = its.due(lambda k: due[k], first, len(due), wait_s)
            assert clock.now_s - before_s <= wait_s + 1e-6
            passed_s = (clock.now_s - 1000.0) * speed
            assert all(due[k] <= passed_s + 1e-5 for k in range(first, last))
            assert last == len(due) or last - first == 64 or due[last] > passed_s - 1e-5
            assert its.host_time_s(9.0) == clock.time()
            first = last
        assert first == len(due)
        assert clock.now_s - 1000.0 == pytest.approx(due[-1] / speed, abs=1e-2)


def test_without_a_speed_all_come_at_once_but_not_too_many() -> None:
    its = Pace(0)
    assert its.due(lambda k: 1e9, 0, 10, 0.0) == 10
    assert its.due(lambda k: 1e9, 0, 1000, 0.0) == 64
    assert its.due(lambda k: 1e9, 900, 1000, 0.0) == 964
    assert its.due(lambda k: 1e9, 7, 7, 0.0) == 7
    assert its.host_time_s(5.0) - its.host_time_s(2.0) == pytest.approx(3.0)
