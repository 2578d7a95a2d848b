"""The parts of a stream and of what watches it, each against a slow reference or by what is said of it."""

from __future__ import annotations

import math
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from varishold.frame.fill import fill_invalid
from varishold.live import Sample, StreamHealth
from varishold.live.clock_slope import ClockSlope
from varishold.live.health import StreamReport
from varishold.live.press_keeper import PressKeeper
from varishold.live.sequence import SequenceCounter
from varishold.live.since import since

gaps = st.lists(st.sampled_from([0.0, 0.01, 0.02, 0.5, 3.0, 12.0]), min_size=1, max_size=60)


@given(gaps, st.sampled_from([0.0, 0.005, 1.0, 30.0]))
@settings(max_examples=200)
def test_rate_jitter_and_gaps_are_those_of_sums_that_fade(passed: list[float], silent_s: float) -> None:
    health = StreamHealth()
    at = np.concatenate([[0.0], np.cumsum(passed)]) + 1e9
    for host_s in at.tolist():
        health.add(Sample(None, host_s, None, {}))
    report = health.report(at[-1] + silent_s)
    steps = np.diff(at)
    weight = np.exp(-(at[-1] - at[1:]) / 10)
    count, mean = weight.sum(), (weight @ steps) / weight.sum()
    assert report.received == len(at)
    assert report.silent_s == pytest.approx(silent_s, abs=1e-6)
    lately = weight @ steps + max(silent_s - 2 * mean, 0.0)
    assert report.rate_hz == pytest.approx(count / lately if lately > 0 else 0.0, rel=1e-6)
    assert report.jitter_s == pytest.approx(math.sqrt(weight @ (steps - mean) ** 2 / count), abs=1e-6)
    # The longest of the last ten seconds at least, and of no more than those, the ten before, and one step.
    ages = at[-1] - at[1:]
    assert report.longest_gap_s >= max(steps[ages <= 0].max(initial=0.0), silent_s) - 1e-6
    within = steps[ages <= 20 + 2 * steps.max()]
    assert report.longest_gap_s <= max(within.max(initial=0.0), silent_s) + 1e-6


def test_a_long_gap_is_told_for_ten_seconds_and_then_forgotten() -> None:
    health, told = StreamHealth(), []
    for k in range(4000):
        health.add(Sample(None, 1e9 + 0.01 * k + 2.0 * (k > 500), None, {}))
        told.append(health.report().longest_gap_s)
    assert told[500] == pytest.approx(0.01, abs=1e-6)
    assert told[501] == told[501 + 900] == pytest.approx(2.01, abs=1e-6)
    assert told[501 + 2200] == pytest.approx(0.01, abs=1e-6)


def report(**how: Any) -> StreamReport:
    usual = dict.fromkeys(("lost", "twice", "late", "restarts", "clock_ppm", "clock_set"))
    plain = {"received": 1000, "rate_hz": 100.0, "jitter_s": 0.0, "longest_gap_s": 0.0, "silent_s": 0.0}
    return StreamReport(**{**usual, **plain, **how})


@pytest.mark.parametrize(
    ("how", "told"),
    [
        ({}, 0),
        ({"lost": 0, "restarts": 0, "clock_ppm": 0.0}, 0),
        ({"lost": 1}, 0),
        ({"lost": 2}, 1),
        ({"restarts": 1}, 1),
        ({"jitter_s": 0.009}, 0),
        ({"jitter_s": 0.011}, 1),
        ({"jitter_s": 0.011, "received": 19}, 0),
        ({"clock_ppm": 1900.0}, 0),
        ({"clock_ppm": -1900.0}, 0),
        ({"clock_ppm": 2100.0}, 1),
        ({"clock_ppm": -2100.0}, 1),
        ({"lost": 9, "restarts": 1, "jitter_s": 0.1, "clock_ppm": 1e4}, 4),
    ],
)
def test_what_is_worth_a_remark_is_told(how: dict[str, Any], told: int) -> None:
    remarks = report(**how).remarks
    assert len(remarks) == told
    if "clock_ppm" in how and told:
        assert ("fast" in remarks[-1]) == (how["clock_ppm"] > 0)


def test_the_share_that_was_lost_is_that_of_all_that_were_sent() -> None:
    assert report().lost_share is None
    assert report(lost=10, received=30).lost_share == 0.25
    assert report(lost=0, received=0).lost_share == 0.0


@given(
    st.lists(st.tuples(st.floats(0.01, 30), st.floats(-0.002, 0.002)), min_size=3, max_size=60),
    st.floats(-2000, 2000),
)
@settings(max_examples=100)
def test_a_clock_runs_as_a_line_through_its_times_does(steps: list[tuple[float, float]], ppm: float) -> None:
    """Weighted least squares, where what is two minutes old counts a third."""
    slope = ClockSlope()
    host = np.cumsum([step for step, _ in steps])
    device = host * (1 + 1e-6 * ppm) + [noise for _, noise in steps]
    for device_s, host_s in zip(device.tolist(), host.tolist(), strict=True):
        slope.add(device_s, 1e9 + host_s)
    if host[-1] - host[0] < 9.99:
        assert slope.ppm is None
    elif host[-1] - host[0] > 10.01:
        weight = np.exp(-(host[-1] - host) / 120)
        x, y = host - host[0], (device - device[0]) - (host - host[0])
        x, y = x - (weight @ x) / weight.sum(), y - (weight @ y) / weight.sum()
        assert slope.ppm == pytest.approx(1e6 * (weight @ (x * y)) / (weight @ (x * x)), abs=1.0)
    assert slope.n_set == 0


@pytest.mark.parametrize(("leap_s", "sets"), [(4.0, 0), (-4.0, 0), (6.0, 1), (-6.0, 1), (-3600.0, 1)])
def test_a_clock_that_leaps_far_was_set(leap_s: float, sets: int) -> None:
    slope = ClockSlope()
    for k in range(2000):
        slope.add(0.01 * k + leap_s * (k >= 1000), 1e9 + 0.01 * k)
    assert slope.n_set == sets
    # Only what came since tells how it runs.
    assert (slope.ppm is None) == bool(sets)


@pytest.mark.parametrize(("silent_s", "known"), [(119.0, True), (121.0, False), (3600.0, False), (5e4, False)])
def test_after_a_long_silence_the_measure_begins_anew(silent_s: float, known: bool) -> None:
    """A moment tells nothing of how a clock runs."""
    slope, rng = ClockSlope(), np.random.default_rng(0)
    for k in range(3000):
        host_s = 0.01 * k + silent_s * (k >= 2000)
        slope.add(host_s * (1 + 50e-6) + rng.normal(0, 1e-4), 1e9 + host_s)
        if k == 2100:
            assert (slope.ppm is not None) == known
    assert slope.n_set == 0
    assert slope.ppm is None or slope.ppm == pytest.approx(50, abs=20)
    slope.add((30.02 + silent_s) * (1 + 50e-6), 1e9 + 30.02 + silent_s)
    assert slope.ppm == pytest.approx(50, abs=20)


def test_a_machine_that_is_set_back_begins_the_measure_anew() -> None:
    slope = ClockSlope()
    for k in range(4000):
        slope.add(0.01 * k, 1e9 + 0.01 * k - 2.0 * (k >= 2000))
    assert slope.n_set == 1
    assert slope.ppm == pytest.approx(0.0, abs=1e-3)


@given(
    st.sampled_from([8, 16]),
    st.lists(st.sampled_from(["lost", "twice", "late", "next"]), min_size=30, max_size=120),
    st.integers(0, 2**16),
)
@settings(max_examples=150)
def test_what_was_lost_twice_or_late_is_counted_one_by_one(bits: int, course: list[str], start: int) -> None:
    """A late one comes right after the one that overtook it."""
    numbers, number = [0, 1, 2], 2
    expected = {"lost": 0, "twice": 0, "late": 0}
    for what in course:
        if what == "twice":
            numbers.append(numbers[-1])
        elif what == "late":
            numbers += [number + 2, number + 1, number + 3]
            number += 3
        else:
            number += 1 + (what == "lost")
            numbers.append(number)
        expected[what] = expected.get(what, 0) + 1
    counter = SequenceCounter()
    for each in numbers:
        counter.add((start + each) % 2**bits, 0.01)
    assert {name: getattr(counter, name) for name in ("lost", "twice", "late")} == {
        name: expected[name] for name in ("lost", "twice", "late")
    }
    assert counter.restarts == 0


@given(st.lists(st.integers(), max_size=6), st.integers(0, 6))
def test_what_has_come_since_is_what_stands_behind_the_last(values: list[int], at: int) -> None:
    log = [[value] for value in values]
    assert since(log, None) == log
    assert since(log, [99]) == log
    if at < len(log):
        assert since(log, log[at]) == log[at + 1 :]


course = st.lists(st.tuples(st.booleans(), st.integers(1, 12)), min_size=1, max_size=14)


@given(course, st.sampled_from([0.01, 0.04]))
@settings(max_examples=150)
def test_presses_are_kept_as_a_look_at_the_whole_course_finds_them(runs: list[tuple[bool, int]], step_s: float) -> None:
    touched = [state for state, n in runs for _ in range(n)]
    keeper, ended = PressKeeper(), []
    keeper.begin_anew({"pad": np.ones((1, 1), np.bool_)})
    assert keeper.so_far() is None
    for k, state in enumerate(touched):
        kept = keeper.see(k * step_s, {"pad": np.full((1, 1), float(k))}, touched=state)
        ended += [] if kept is None else [kept]
        assert keeper.lasts == (keeper.so_far() is not None)
    # Touches closer than 0.15 s are one press; it ends with the first reading after that.
    presses: list[list[int]] = []
    for k in np.flatnonzero(touched).tolist():
        if presses and not any_end(presses[-1][1], k, step_s):
            presses[-1][1] = k
        else:
            presses.append([k, k])
    over = [(first, last) for first, last in presses if any_end(last, len(touched), step_s)]
    assert [(kept.start_s, kept.end_s) for kept in ended] == [(first * step_s, last * step_s) for first, last in over]
    assert [kept.number for kept in ended] == list(range(len(over)))
    assert keeper.number == len(over)
    free = 0
    for kept, (first, last) in zip(ended, over, strict=True):
        end = last + 1
        while end * step_s - last * step_s <= 0.15:
            end += 1
        expected = [*range(max(free, first - 8), end)]
        assert kept.press.pads["pad"].ravel().tolist() == expected
        assert kept.press.time_s == pytest.approx([k * step_s for k in expected])
        assert kept.press.place == f"press {kept.number}"
        free = end


def any_end(last: int, until: int, step_s: float) -> bool:
    """Whether a press that was touched last in a frame ends before another."""
    return any((k * step_s) - (last * step_s) > 0.15 for k in range(last + 1, until))


def test_a_press_that_lasts_is_kept_evenly_in_little_memory() -> None:
    keeper = PressKeeper()
    keeper.begin_anew({"pad": np.ones((1, 1), np.bool_)})
    for k in range(20_000):
        keeper.see(k / 100, {"pad": np.full((1, 1), float(k))}, touched=True)
    kept = keeper.so_far()
    assert kept is not None
    frames = kept.press.pads["pad"].ravel()
    assert 1000 <= len(frames) <= 2048
    apart = np.diff(frames)
    assert (apart.min(), np.median(apart)) == (16, 16)
    assert apart.max() < 32
    assert (kept.start_s, kept.end_s) == (0.0, 199.99)
    keeper.begin_anew({"pad": np.ones((1, 1), np.bool_)})
    assert keeper.so_far() is None
    # The next press is kept with all its frames again.
    for k in range(30):
        keeper.see(300 + k / 100, {"pad": np.zeros((1, 1))}, touched=True)
    assert len(keeper.so_far().press.time_s) == 30  # type: ignore[union-attr]


@given(st.integers(0, 2**32 - 1))
@settings(max_examples=40, deadline=None)
def test_broken_taxels_of_kept_presses_are_filled_as_those_of_files_are(seed: int) -> None:
    rng = np.random.default_rng(seed)
    field = rng.random((5, 6)) < 0.9
    works = field & (rng.random((5, 6)) < 0.8)
    works[2, 2] = field[2, 2] = True
    frames = rng.random((6, 5, 6))
    keeper = PressKeeper()
    keeper.begin_anew({"pad": field, "other": np.ones((1, 1), np.bool_)})
    # What breaks within a press is told where most of it is filled.
    breaks_at = int(rng.integers(0, 6))
    for k, frame in enumerate(frames):
        told = {"pad": works} if k >= breaks_at else {}
        keeper.see(k / 100, {"pad": frame, "other": np.ones((1, 1))}, told, touched=True)
    kept = keeper.so_far()
    assert kept is not None
    expected = [fill_invalid(frame, works, field) if k >= breaks_at else frame for k, frame in enumerate(frames)]
    np.testing.assert_array_equal(kept.press.pads["pad"], expected)
    mostly = breaks_at < 3 and bool((field & ~works).any())
    assert list(kept.press.filled) == (["pad"] if mostly else [])
    if mostly:
        np.testing.assert_array_equal(kept.press.filled["pad"], field & ~works)


SCRIPTS = {
    "stream": "from varishold.live import Stream\nStream(source_at(SIM)).start()",
    "recorder": "from varishold.live import Recorder\nRecorder(source_at(SIM), PATH).start()",
    "session": "from varishold.live.session import Session\nSession(source_at(SIM)).__enter__()",
    "page": (
        "from varishold.live.session import Session\nfrom varishold.live.server import PageServer\n"
        "PageServer(Session(source_at(SIM)), port=0).__enter__()"
    ),
    "names": "from varishold.live.press_namer import PressNamer\nPressNamer(lambda kept: None)",
}


@pytest.mark.parametrize("what", SCRIPTS)
def test_a_program_that_closes_nothing_ends_all_the_same(what: str, tmp_path: Path) -> None:
    script = f"from varishold.live import source_at\nSIM, PATH = 'sim:sphere', {str(tmp_path / 'a.mcap')!r}\n"
    done = subprocess.run(
        [sys.executable, "-c", f"{script}{SCRIPTS[what]}\nprint('over')"],
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
    )
    assert (done.returncode, done.stdout) == (0, "over\n"), done.stderr
