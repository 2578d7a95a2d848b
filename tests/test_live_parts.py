"""The parts of a stream and of what watches it, each against a slow reference or by what is said of it."""

from __future__ import annotations

import math
import subprocess
import sys
from collections import deque
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from varishold.live import Sample, StreamHealth, pace
from varishold.live.clock_slope import ClockSlope
from varishold.live.health import StreamReport
from varishold.live.pace import Pace
from varishold.live.press_keeper import PressKeeper
from varishold.live.press_namer import PressNamer
from varishold.live.sequence import SequenceCounter
from varishold.live.simulated_skin import SimulatedSkin, SkinTraits
from varishold.live.since import since
from varishold.live.steady_time import SteadyTime
from varishold.live.teaching import MOST_PRESSES, Teaching
from varishold.solids import ideal_frame

# How a stream is.

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


# Time and pace.

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


@given(st.lists(st.integers(), max_size=6), st.integers(0, 6))
def test_what_has_come_since_is_what_stands_behind_the_last(values: list[int], at: int) -> None:
    log = [[value] for value in values]
    assert since(log, None) == log
    assert since(log, [99]) == log
    if at < len(log):
        assert since(log, log[at]) == log[at + 1 :]


# Presses that are kept.

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


def kept_press(number: int) -> Any:
    return SimpleNamespace(number=number, start_s=0.5 * number, end_s=0.5 * number + 0.25, press=number)


def test_presses_are_named_in_their_order_and_each_once() -> None:
    named_of = PressNamer(lambda kept: SimpleNamespace(to_dict=lambda: {"object": kept.number}))  # type: ignore[arg-type, return-value]
    assert named_of.idle
    for k in range(9):
        named_of.ask(kept_press(k), over=k % 2 == 0)
    named = named_of.finish(20.0)
    assert named_of.idle
    assert named_of.done() == []
    assert [each.to_dict() for each in named] == [
        {"object": k, "press": k, "start_s": 0.5 * k, "end_s": 0.5 * k + 0.25} for k in range(9)
    ]
    assert [each.over for each in named] == [k % 2 == 0 for k in range(9)]
    named_of.close()
    named_of.close()


# What is taught.


def test_presses_are_kept_under_the_label_that_is_set_the_newest_of_them() -> None:
    teaching = Teaching(lambda model: None)
    assert teaching.take(kept_press(0)) is None
    teaching.set_label(" cone ")
    assert teaching.to_dict() == {"label": "cone", "counts": [["cone", 0]], "words": ""}
    counts = [teaching.take(kept_press(k)) for k in range(MOST_PRESSES + 3)]
    assert counts == [("cone", min(k + 1, MOST_PRESSES)) for k in range(MOST_PRESSES + 3)]
    assert teaching._presses["cone"] == [*range(3, MOST_PRESSES + 3)]
    teaching.set_label("pillar")
    assert teaching.take(kept_press(0)) == ("pillar", 1)
    teaching.forget("cone")
    assert teaching.to_dict() == {"label": "pillar", "counts": [["pillar", 1]], "words": ""}
    teaching.forget("pillar")
    assert teaching.to_dict() == {"label": None, "counts": [], "words": ""}
    assert teaching.take(kept_press(0)) is None
    teaching.set_label("ball")
    teaching.set_label(None)
    assert teaching.take(kept_press(0)) is None
    assert teaching.to_dict() == {"label": None, "counts": [["ball", 0]], "words": ""}


# The simulated skin.


def readings(count: int, rate_hz: float = 100.0, *, seed: int = 0, **traits: Any) -> tuple[np.ndarray, list[Any]]:
    """Return frames of a simulated skin, the rest taken off, and the presses that they show."""
    plain = {"forms": ("sphere",), "noise": 0.0, "drift": 0.0, "creep": 0.0, "moves": 0.0}
    skin, frames, presses = SimulatedSkin(SkinTraits(**{**plain, **traits}), rate_hz=rate_hz, seed=seed), [], deque()
    for _ in range(count):
        frames.append(skin.next_frame().astype(float) - 200)
        if not presses or presses[-1] is not skin.press:
            presses.append(skin.press)
    return np.array(frames), list(presses)


def test_a_simulated_skin_shows_what_is_said_to_press_and_nothing_else() -> None:
    frames, presses = readings(3000)
    at = np.arange(3000) / 100
    total = frames.sum(axis=(1, 2))
    pressed = np.zeros(3000, np.bool_)
    ends_s = 0.0
    for press in presses:
        assert 0.6 <= press.start_s - ends_s <= 1.6
        assert 0.5 <= press.hold_s <= 2.5
        assert press.end_s == pytest.approx(press.start_s + press.hold_s + 0.3)
        ends_s = press.end_s
        inside = (at > press.start_s + 0.02) & (at < press.end_s - 0.02)
        held = (at > press.start_s + 0.16) & (at < press.end_s - 0.16)
        pressed |= (at >= press.start_s) & (at <= press.end_s)
        assert (total[inside] > 0).all()
        assert np.ptp(total[held]) == 0
        assert total[inside].max(initial=0) <= total[held].max(initial=np.inf)
        rises = total[(at > press.start_s) & (at < press.start_s + 0.15)]
        assert (np.diff(rises) >= 0).all()
    assert (frames[~pressed] == 0).all()
    # How high it stands: 1500 counts at an eighth of the pad's side.
    deep = max(press.drawn.depth_m for press in presses[:-1])
    assert frames.max() == pytest.approx(1500 * deep / (16 * 2e-3 / 8), rel=0.1)


def test_warmth_lifts_a_skin_taxel_by_taxel_and_load_creeps_up() -> None:
    rest = {"rest_s": (1e5, 1e5)}
    frames, _ = readings(1200, 1.0, drift=500.0, seed=3, **rest)
    mean = frames.mean(axis=(1, 2))
    assert mean[300] - mean[0] == pytest.approx(500 * (1 - math.exp(-1)), abs=0.3 * 500 * 2.1)
    assert mean[600:].mean() > 300
    # Each by its own share, a quarter more or less.
    share = frames[1000] / frames[1000].mean()
    assert 0.15 < share.std() < 0.35
    swings, _ = readings(4000, 1.0, drift=500.0, seed=3, **rest)
    late = swings[2000:].mean(axis=(1, 2))
    assert np.ptp(late[:1200]) == pytest.approx(0.6 * 500, rel=0.15)
    assert late[:600].mean() + late[600:1200].mean() == pytest.approx(2 * late[1200:].mean(), rel=0.15)
    # It swings in twenty minutes: the same comes back, and in between its opposite.
    slow = swings.mean(axis=(1, 2))
    assert slow[2600:2800] == pytest.approx(slow[1400:1600], abs=10)
    assert slow[2000:2200] + slow[2600:2800] == pytest.approx(np.full(200, 2 * slow[1600:2800].mean()), abs=15)
    pressed, (press, *_) = readings(4000, 100.0, creep=0.5, hold_s=(30.0, 30.0), rest_s=(1.0, 1.0))
    begins = round(100 * (press.start_s + 0.2))
    total = pressed.sum(axis=(1, 2))
    grown = [total[begins + 100 * k] / total[begins] for k in (0, 8, 24)]
    for ratio, time_s in zip(grown, (0.0, 8.0, 24.0), strict=True):
        assert ratio == pytest.approx(1 + 0.5 * (1 - math.exp(-time_s / 8)), abs=0.03)
    # It comes back as slowly.
    left = total[round(100 * press.end_s) + 5 + 100]
    assert 0.2 * total[begins] < left < 0.5 * total[begins]


def test_noise_is_as_strong_as_is_said_and_full_scale_is_the_end() -> None:
    frames, _ = readings(300, noise=7.0, rest_s=(1e5, 1e5))
    assert frames.std() == pytest.approx(7.0, rel=0.05)
    assert abs(frames.mean()) < 0.2
    high, _ = readings(400, creep=30.0, hold_s=(3.0, 3.0), rest_s=(0.1, 0.1))
    assert high.max() == 4095 - 200
    low, _ = readings(50, noise=400.0)
    assert low.min() == -200


@pytest.mark.parametrize("moves", [0.0, 0.5, 1.0])
def test_so_many_presses_move_and_all_ways(moves: float) -> None:
    skin = SimulatedSkin(SkinTraits(("sphere", "cone"), moves=moves), rate_hz=0.5, seed=4)
    presses = []
    while len(presses) < 200:
        if not presses or presses[-1] is not skin.press:
            presses.append(skin.press)
        skin.next_frame()
    far = np.array([math.hypot(*press.motion_m) for press in presses]) / 2e-3
    assert np.mean(far > 0) == pytest.approx(moves, abs=0.15)
    assert ((far == 0) | ((far > 1 - 1e-9) & (far < 3 + 1e-9))).all()
    assert {press.form for press in presses} == {"sphere", "cone"}
    # What presses is a third to six tenths of the pad wide, and deep in proportion: none is too small to be told.
    deep = np.array([press.drawn.depth_m for press in presses])
    assert deep.min() > 0.5 * 0.35 * 0.2 * 16 * 2e-3
    assert deep.max() < 0.6 * 0.35 * 16 * 2e-3 + 1e-9
    wide = []
    for press in presses[:60]:
        face = ideal_frame(press.drawn.solid, (64, 64), 0.5e-3, depth_m=press.drawn.depth_m)
        wide.append(2 * math.sqrt(np.count_nonzero(face > 0) / math.pi) / 64)
    assert 0.3 < min(wide) < 0.4
    assert 0.53 < max(wide) < 0.63
    if moves:
        toward = np.array([press.motion_m for press in presses])[far > 0]
        assert (np.abs(np.mean(np.sign(toward), axis=0)) < 0.35).all()
    for press in presses[:20]:
        half = press.place_at(press.start_s + 0.15 + press.hold_s / 2)
        pose = press.drawn.pose
        assert half == pytest.approx((pose.x_m + press.motion_m[0] / 2, pose.y_m + press.motion_m[1] / 2))


# What is left running.

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
