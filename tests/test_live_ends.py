"""How a stream is read on, tried again and ended: what waits is read before the end, and nothing is told twice."""

from __future__ import annotations

import threading
from collections import deque
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from tests.live_clock import Clock
from tests.live_presses import LAYOUT, pressed
from tests.live_scripted import Scripted, sample, wait_until

from varishold.errors import EndOfSourceError, LostSourceError
from varishold.live import (
    Sample,
    Source,
    Stream,
    StreamHealth,
    session,
    source_at,
    stream,
    watching,
)
from varishold.live.losses import Losses
from varishold.live.session import Session
from varishold.live.stream import Change
from varishold.live.watcher import Watcher


@pytest.fixture
def clock(monkeypatch: pytest.MonkeyPatch) -> Clock:
    return Clock(monkeypatch)


class Trying:
    """A source that is lost for long; who waits for it lets the time pass."""

    address = "trying:"

    def __init__(self, clock: Clock, ends_s: float) -> None:
        self.pads: dict[str, Any] = {}
        self._clock, self._ends_s = clock, clock.now_s + ends_s
        self.tried_s: list[float] = []
        self.looked_s: list[float] = []
        self.closed = 0
        self.there = False

    def open(self) -> None:
        self.tried_s.append(self._clock.now_s)
        if self._clock.now_s >= self._ends_s:
            raise EndOfSourceError("it is over")
        if not self.there:
            raise LostSourceError("it is away")

    def read(self, timeout_s: float) -> list[Sample]:
        self.looked_s.append(timeout_s)
        self._clock.sleep(timeout_s)
        if self._clock.now_s >= self._ends_s:
            raise EndOfSourceError("it is over")
        return []

    def close(self) -> None:
        self.closed += 1


def _run(clock: Clock, source: Source) -> Stream:
    stream = Stream(source)
    unwanted = SimpleNamespace(is_set=lambda: False, wait=clock.sleep)
    stream._unwanted = unwanted  # type: ignore[assignment]
    stream._run()
    return stream


class HangingUp(Trying):
    """A source that speaks for so long each time that it is called, and hangs up."""

    def __init__(self, clock: Clock, ends_s: float, spoken_s: list[float]) -> None:
        super().__init__(clock, ends_s)
        self._spoken_s, self.there = deque(spoken_s), True

    def read(self, timeout_s: float) -> list[Sample]:
        if not self._spoken_s:
            raise EndOfSourceError("it is over")
        self._clock.sleep(self._spoken_s.popleft())
        raise LostSourceError("it has hung up")


def test_who_hangs_up_again_and_again_is_called_ever_less_often(clock: Clock, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(stream, "time", clock)
    spoken_s = [0.1] * 8 + [11.0] + [0.1] * 3 + [9.0] * 2
    source = HangingUp(clock, 1e9, spoken_s)
    changes = _run(clock, source).changes
    waits = np.diff(source.tried_s) - spoken_s
    # What was there for long is back at once when it is lost.
    expected = [0.25, 0.5, 1.0, 2.0, 2.0, 2.0, 2.0, 2.0, 0.25, 0.5, 1.0, 2.0, 2.0, 2.0]
    np.testing.assert_allclose(waits, expected, atol=1e-3)
    told = Losses()
    assert [change.state for change in changes].count("lost") == len(spoken_s)
    assert sum(told.is_news(change) for change in changes) == 2


def test_a_lost_source_is_tried_some_four_times_a_second(clock: Clock) -> None:
    source = Trying(clock, 10.0)
    stream = _run(clock, source)
    assert 35 <= len(source.tried_s) <= 50
    assert source.closed == len(source.tried_s)
    # Why it is lost is told once.
    assert [change.state for change in stream.changes] == ["opening", "lost", "ended"]
    assert [change.words for change in stream.changes] == ["", "it is away", "it is over"]


def test_an_idle_source_is_left_within_a_tenth_of_a_second_and_costs_little(clock: Clock) -> None:
    source = Trying(clock, 3.0)
    source.there = True
    stream = _run(clock, source)
    assert 0.05 < min(source.looked_s) <= max(source.looked_s) < 0.2
    assert (stream.state, stream.words, source.closed) == ("ended", "it is over", 1)


def test_a_source_that_keeps_to_no_timeout_is_left_behind() -> None:
    stream, waited_s = Stream(source_at("sim:sphere")), []
    stream._thread = SimpleNamespace(is_alive=lambda: True, join=waited_s.append)  # type: ignore[assignment]
    stream.close()
    assert len(waited_s) == 1
    assert 5 < waited_s[0] < 20


class Told:
    """A stream and its reader that tell what a test wrote down: (samples, state) of each look."""

    received, damaged, damage, overrun = 0, 0, "", 0

    def __init__(self, looks: list[tuple[list[Sample], Any]]) -> None:
        self._looks, self.number, self.missed = deque(looks), 0, 0
        self.changes: tuple[Change, ...] = (Change(0.0, "opening", ""),)
        self.waits: list[float] = []

    @property
    def state(self) -> str:
        return self.changes[-1].state

    def __enter__(self) -> Told:
        return self

    def __exit__(self, *_: object) -> None:
        self.changes = (*self.changes, Change(9.0, "ended", "closed"))

    def reader(self) -> Told:
        return self

    def read(self, timeout_s: float) -> list[Sample]:
        self.waits.append(timeout_s)
        samples, state = self._looks.popleft()
        if state != self.state:
            self.changes = (*self.changes, Change(0.0, state, ""))
        self.number += len(samples)
        return samples


def test_silence_is_no_end_and_what_waits_is_read_before_the_end(monkeypatch: pytest.MonkeyPatch) -> None:
    looks: list[Any] = [
        ([], "opening"),
        ([sample(0), sample(1)], "open"),
        ([], "open"),
        ([], "lost"),
        ([sample(2)], "open"),
        # It has ended already, and more is there.
        ([sample(3), sample(4)], "ended"),
        ([sample(5)], "ended"),
        ([], "ended"),
    ]
    told = Told(looks)
    monkeypatch.setattr(watching, "Stream", lambda source: told)
    states: list[str] = []
    came = list(watching._newest_of(Scripted(), lambda change: states.append(change.state)))
    assert [(number, one.sequence) for number, one in came if one is not None] == [(k, k) for k in range(6)]
    # While nothing comes, whoever watches is asked all the same.
    assert [number for number, one in came if one is None] == [0, 2, 2, 6]
    assert states == ["opening", "open", "lost", "open", "ended"]
    assert 0.03 < min(told.waits) <= max(told.waits) < 0.1


def test_a_watch_is_followed_without_anybody_who_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(watching, "Stream", lambda source: Told([([sample(0)], "open"), ([], "ended")]))
    assert [number for number, _ in watching._newest_of(Scripted(), None)] == [0, 1]


def test_a_press_that_ends_with_the_stream_is_told_once() -> None:
    source, kinds = Scripted(), []
    source.pads = LAYOUT
    coming = [one for one in pressed("cone", free=130, held=60) if (one.sequence or 0) < 180]
    for one in coming:
        source.script.put(one)
    source.script.put(EndOfSourceError("the cable is out"))
    seen = list(watching.watch(source, every=True, on_event=lambda pad, event: kinds.append((pad, event.kind))))
    assert [kind for kind in kinds if kind[1] in ("touched", "released")] == [("pad", "touched"), ("pad", "released")]
    assert [one.number for one in seen] == [*range(180), 180]
    assert [one.ended is not None for one in seen] == [False] * 180 + [True]
    assert seen[-1].sample is None
    assert not seen[-1].touched
    assert source.closed >= 1


def test_a_source_that_says_nothing_has_nothing_to_tell_at_its_end() -> None:
    source = Scripted()
    source.script.put(EndOfSourceError("nothing"))
    assert list(watching.watch(source, every=True)) == []
    assert Watcher().finish() is None


def test_a_session_sees_all_that_waits_and_then_ends() -> None:
    source = Scripted()
    for number in range(30):
        source.script.put(sample(number))
    source.script.put(EndOfSourceError("all of it"))
    numbers: list[int] = []
    with Session(source, on_seen=lambda seen: numbers.append(seen.number)) as its:
        assert its.wait_over(20)
        assert numbers == [*range(30), 30]
        status = its.status()
        assert (status["state"], status["words"], status["received"]) == ("ended", "all of it", 30)
        assert (status["left_out"], its.failure) == (0, None)
        assert [event["kind"] for event in its.events.since(0)][-1] == "ended"
        # Who comes when all is over is still served.
        done = threading.Event()
        its._asked.put(done.set)
        assert done.wait(20)
        its.ask_zero()
        wait_until(its._asked.empty)


def test_who_falls_behind_goes_on_with_the_newest(monkeypatch: pytest.MonkeyPatch) -> None:
    clock = Clock(monkeypatch, session)
    its = Session(Scripted())
    seen: list[int] = []
    its._on_seen = lambda one: (seen.append(one.number), clock.sleep(0.05))
    its._see([sample(k) for k in range(100)], 1000)
    # A fifth of a second may be spent, and the newest reading is seen in any case.
    assert seen[0] == 1000
    assert seen[-1] == 1099
    assert 4 <= len(seen) <= 7
    assert seen[:-1] == list(range(1000, 1000 + len(seen) - 1))
    assert its.status()["left_out"] == 100 - len(seen)


def test_closing_while_reading_is_no_failure_and_leaves_no_thread() -> None:
    source = source_at("sim:sphere?rate_hz=1000")
    with Stream(source, keep=5000) as stream:
        readers = [stream.reader() for _ in range(3)]
        counts: list[int] = []
        threads = [threading.Thread(target=lambda r=r: counts.append(sum(1 for _ in r))) for r in readers]
        for thread in threads:
            thread.start()
        wait_until(lambda: stream.received > 50)
        stream.close()
        for thread in threads:
            thread.join(20)
    assert counts == [stream.received] * 3
    assert (stream.state, stream.words) == ("ended", "")
    # What the ring keeps stays readable, and is the same to who comes later.
    assert len(stream.reader().read()) == stream.received
    newest = stream.newest()
    assert newest is not None
    assert newest.sequence == stream.received - 1


def test_who_skips_reads_what_comes_then() -> None:
    stream = Stream(Scripted(), keep=4)
    reader, other = stream.reader(), stream.reader()
    reader.skip()
    reader.skip_all()
    assert (reader.number, reader.read()) == (0, [])
    stream._put([sample(k) for k in range(3)])
    reader.skip_all()
    assert (reader.read(), reader.missed) == ([], 0)
    stream._put([sample(3)])
    reader.skip()
    assert [one.sequence for one in reader.read()] == [3]
    # Nobody goes back.
    reader.skip()
    assert reader.read() == []
    assert [one.sequence for one in other.read()] == [0, 1, 2, 3]


def test_a_stream_remembers_the_newest_of_many_changes() -> None:
    stream = Stream(Scripted())
    for k in range(2000):
        stream._become("lost", str(k))
        stream._become("lost", str(k))
    assert len(stream.changes) == 256
    assert [change.words for change in stream.changes] == [str(k) for k in range(2000 - len(stream.changes), 2000)]


def test_nothing_is_known_of_a_stream_before_two_readings() -> None:
    health = StreamHealth()
    for _ in range(2):
        report = health.report(5e9)
        figures = (report.rate_hz, report.jitter_s, report.longest_gap_s)
        assert figures == (0.0, 0.0, report.silent_s)
        assert (report.lost, report.twice, report.late, report.restarts) == (None,) * 4
        assert (report.clock_ppm, report.clock_set, report.remarks) == (None, None, ())
        health.add(Sample(None, 1e9, None, {}))
    assert health.report().longest_gap_s == 0.0
    assert health.report(1e9 + 3).silent_s == 3.0
    assert health.report(1e9 - 3).silent_s == 0.0
    # Two readings a hundredth apart are a rate.
    assert health.report().received == 2
    health = StreamHealth()
    for host_s in (0.2, 0.21):
        health.add(Sample(None, host_s, None, {}))
    report = health.report()
    assert report.rate_hz == pytest.approx(100)
    assert report.longest_gap_s == pytest.approx(0.01)
