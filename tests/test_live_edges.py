"""What happens at the edges: a stream that ends while samples wait, one that is late, who comes when all is over."""

from __future__ import annotations

import asyncio
import json
import threading
from collections import deque
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from tests.live_clock import Clock
from tests.live_presses import LAYOUT, pressed
from tests.live_scripted import Scripted, sample, wait_until
from tests.test_live_believer import library

from varishold.errors import EndOfSourceError, InputError, LostSourceError
from varishold.live import PadLayout, Sample, Stream, StreamHealth, session, source_at, watching
from varishold.live.address import parse_address
from varishold.live.interpreted import topics_at
from varishold.live.page_recorder import PageRecorder, free_path
from varishold.live.press_believer import BelievedObject, PressBeliever
from varishold.live.press_namer import PressNamer
from varishold.live.sample_file import Limits, SampleFile
from varishold.live.server import PageServer
from varishold.live.session import Session
from varishold.live.stream import Change
from varishold.live.teaching import Teaching
from varishold.live.viewer import Viewer
from varishold.live.watcher import Watcher
from varishold.perceive import BeliefUpdate, Perceiver, Perception

# The end of a stream.


class Told:
    """A stream and its reader that tell what a test wrote down: (samples, state) of each look."""

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
    assert 0.02 < min(told.waits) <= max(told.waits) <= 0.1


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
    assert 100 <= len(stream.changes) <= 256
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


# Names of presses.


def test_presses_that_wait_too_long_go_without_a_name_the_oldest_first() -> None:
    free, named = threading.Event(), []

    def name(kept: Any) -> Any:
        free.wait(20)
        named.append(kept.number)
        if kept.number % 2:
            raise InputError("too little")
        return "a thing"

    namer = PressNamer(name)
    for number in range(200):
        namer.ask(SimpleNamespace(number=number, start_s=1.0 * number, end_s=number + 0.5), over=number > 5)  # type: ignore[arg-type]
        if number == 0:
            wait_until(lambda: namer._busy and not namer._waiting)
    assert not namer.idle
    free.set()
    done = namer.finish(20)
    assert namer.idle
    assert named[0] == 0
    assert named[1:] == list(range(200 - len(named) + 1, 200))
    assert 32 <= len(done) <= 64
    for one in done:
        assert (one.start_s, one.end_s, one.over) == (one.number, one.number + 0.5, one.number > 5)
        assert (one.recognition, one.words) == ((None, "too little") if one.number % 2 else ("a thing", ""))
        assert ("refusal" in one.to_dict()) if one.number % 2 else one.words == ""
    assert namer.done() == []
    namer.close()
    namer.close()


@pytest.mark.parametrize(("units", "told"), [(("kPa", "kPa"), "kPa"), (("kPa", "N"), "raw"), (("N",), "N")])
def test_a_press_is_a_recording_of_its_own_pads_in_their_unit(units: tuple[str, ...], told: str) -> None:
    field, sound = np.ones((4, 5), bool), np.ones((4, 5), bool)
    field[0, 0] = sound[1, 1] = False
    watched = {
        f"pad {k}": SimpleNamespace(unit=unit, pitch_m=(0.001 * (k + 1), 0.003), field=field, sound=sound)
        for k, unit in enumerate(units)
    }
    pads = {name: np.full((3, 4, 5), 7.0) for name in watched}
    watched["another"] = SimpleNamespace(unit="lbf", pitch_m=None, field=field, sound=sound)
    believer = PressBeliever(Perceiver(library()), watched)  # type: ignore[arg-type]
    recording = believer._recording(
        SimpleNamespace(press=SimpleNamespace(pads=pads, time_s=np.arange(3.0)))  # type: ignore[arg-type]
    )
    assert (list(recording.pads), recording.unit) == (list(pads), told)
    for k, pad in enumerate(recording.pads.values()):
        assert pad.pitch_m == (0.001 * (k + 1), 0.003)
        assert not pad.field[0, 0]
        assert not pad.valid[1, 1]
        assert np.all(pad.frames[:, 2, 2] == 7.0)
    assert recording.time_s is not None
    assert recording.time_s.tolist() == [0, 1, 2]


def test_what_is_believed_is_told_with_six_digits() -> None:
    update = BeliefUpdate("grasp", {"a": 1 / 3}, None, None, 1 / 7, "go on", "why", ("because",))
    answer = Perception("a", 2 / 3, 0.04, (0.03, 0.05), {"b": 1 / 9}, (update, update), ("odd",))
    one = BelievedObject(update, answer)
    assert json.loads(json.dumps(one.to_dict())) == {
        "object": "a",
        "probability": 0.666667,
        "alternatives": {"b": 0.111111},
        "size_m": 0.04,
        "size_interval_m": [0.03, 0.05],
        "p_value": 0.142857,
        "touches": 2,
        "verdict": "go on",
        "why": "why",
        "reasons": ["because"],
        "remarks": ["odd"],
    }
    assert (one.touches, one.unknown, one.probability) == (2, False, 2 / 3)


# The page's server and its visitors.


def test_who_was_woken_asks_again_before_it_is_woken_again() -> None:
    server = PageServer(Session(Scripted()))
    first, second = asyncio.Event(), asyncio.Event()
    server._waiting |= {first, second}
    server._wake_all()
    assert first.is_set()
    assert second.is_set()
    first.clear()
    second.clear()
    server._waiting.add(second)
    server._wake_all()
    assert not first.is_set()
    assert second.is_set()


def test_news_wake_nobody_where_nobody_waits_and_no_loop_that_is_gone() -> None:
    server, calls = PageServer(Session(Scripted())), []
    server._there_is_news()
    server._waiting.add(asyncio.Event())
    server._there_is_news()
    server._loop = SimpleNamespace(call_soon_threadsafe=calls.append)  # type: ignore[assignment]
    server._there_is_news()
    assert calls == [server._wake_all]

    def gone(call: object) -> None:
        raise RuntimeError("Event loop is closed")

    server._loop = SimpleNamespace(call_soon_threadsafe=gone)  # type: ignore[assignment]
    server._there_is_news()


@pytest.mark.parametrize(
    ("host", "address"),
    [("127.0.0.1", "http://127.0.0.1:80/"), ("::1", "http://[::1]:80/"), ("robot.local", "http://robot.local:80/")],
)
def test_the_page_is_where_the_server_listens(host: str, address: str) -> None:
    assert PageServer(Session(Scripted()), host=host, port=80).address == address


def test_a_viewer_that_comes_late_gets_what_comes_then_and_wants_no_more_than_it_may() -> None:
    its = Session(Scripted())
    its.stream._put([sample(k) for k in range(3)])
    its.events.add("zero", 0.0, "before")
    viewer = Viewer(its)
    assert list(viewer.due()) == []
    its.stream._put([sample(3)])
    (told,) = [json.loads(message) for message in viewer.due() if isinstance(message, str)]
    (channel,) = told["channels"]
    assert channel["topic"] == "/pad"
    wish = {"op": "subscribe", "subscriptions": [{"id": k, "channelId": channel["id"]} for k in range(256)]}
    assert viewer.hear(json.dumps(wish)) is None
    for number in (256, -1, 2**32, "a"):
        wish["subscriptions"] = [{"id": number, "channelId": channel["id"]}]
        assert "not understood" in str(viewer.hear(json.dumps(wish)))
    its.stream._put([sample(4)])
    sent = [message for message in viewer.due() if isinstance(message, bytes)]
    assert sorted(int.from_bytes(message[1:5], "little") for message in sent) == list(range(256))
    (time_ns,) = {int.from_bytes(message[5:13], "little") for message in sent}
    assert time_ns == pytest.approx(1_000_000_000_040_000_000, abs=1000)
    assert viewer.hear(json.dumps({"op": "unsubscribe", "subscriptionIds": [*range(1, 256), 900]})) is None
    its.stream._put([sample(5)])
    assert len(list(viewer.due())) == 1
    # A number that is no channel's is refused.
    assert "not understood" in str(viewer.hear('{"op": "subscribe", "subscriptions": [{"id": 1, "channelId": 99}]}'))


# Recordings and what is taught.


def test_a_page_records_once_at_a_time_and_says_what_became_of_it(tmp_path: Path) -> None:
    said: list[tuple[bool, str]] = []
    stream = Stream(Scripted(), keep=50)
    stream._put([sample(k) for k in range(5)])
    recorder = PageRecorder(stream, tmp_path, lambda well, words: said.append((well, words)))
    assert recorder.to_dict() is None
    recorder.mark("nobody hears")
    recorder.look()
    with pytest.raises(InputError, match="nothing is being written"):
        recorder.end()
    path = recorder.begin("cone")
    with pytest.raises(InputError, match="is being written; end it first"):
        recorder.begin(None)
    # Number 7 of the sensor's own never came.
    stream._put([sample(k) for k in (5, 6, 8)])
    wait_until(lambda: recorder.to_dict() == {"file": path.name, "frames": 3, "missed": 0})
    recorder.mark(None)
    recorder.zeroed({"pad": "pad"})
    recorder.close()
    assert said == [(True, f"{path}: 3 readings in 0.0\u202fs, 1 never came")]
    assert recorder.to_dict() is None
    recorder.begin(None)
    recorder.close()
    recorder.close()
    assert said[1:] == [(False, "recording ended: nothing came")]


def test_a_free_path_is_named_after_the_time_and_nobody_elses(tmp_path: Path) -> None:
    taken = [free_path(tmp_path, ".npz")]
    for _ in range(12):
        taken[-1].touch()
        taken.append(free_path(tmp_path, ".npz"))
    assert len(set(taken)) == 13
    assert not taken[-1].exists()
    assert all(path.parent == tmp_path and path.suffix == ".npz" for path in taken)


def test_what_is_forgotten_is_not_kept_under_and_only_the_newest_presses_are() -> None:
    teaching = Teaching(lambda model: None)
    kept: Any = SimpleNamespace(press="a press")
    assert teaching.take(kept) is None
    teaching.set_label(" cone ")
    assert [teaching.take(kept) for _ in range(3)] == [("cone", 1), ("cone", 2), ("cone", 3)]
    teaching.set_label("pillar")
    assert teaching.take(kept) == ("pillar", 1)
    with pytest.raises(InputError, match="there are: cone: 3, pillar: 1"):
        teaching.learn()
    # Another's presses may be forgotten while this label is set.
    teaching.forget("cone")
    assert teaching.to_dict() == {"label": "pillar", "counts": [["pillar", 1]], "words": ""}
    teaching.forget("pillar")
    teaching.forget("nothing of the kind")
    assert teaching.take(kept) is None
    assert teaching.to_dict() == {"label": None, "counts": [], "words": ""}
    teaching.set_label("ridge")
    assert [teaching.take(kept) for _ in range(205)][-1] == ("ridge", 200)


class Disk:
    """A file that counts how often something is handed to it."""

    shown = True

    def write(self, data: bytes) -> int:
        return len(data)

    def show(self) -> None:
        """It is there."""


def test_what_waits_is_handed_over_within_half_a_second_and_a_silent_source_ends_in_time(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    from varishold.live import sample_file

    clock, flushed = Clock(monkeypatch, sample_file), []
    writer = SimpleNamespace(flush=lambda: flushed.append(clock.now_s), describe=lambda facts: None)
    writer.reading = lambda pads, **told: None
    monkeypatch.setattr(sample_file, "TopicWriter", lambda file, name: writer)
    file = SampleFile(Disk(), dict, "", Limits(seconds=3.0))  # type: ignore[arg-type]
    file.look()
    assert flushed == []
    began_s = clock.now_s
    file.add(sample(0))
    while not file.full:
        clock.sleep(0.05)
        file.look()
        assert clock.now_s < began_s + 10
    # It ends when the reading that would be too late must have come.
    assert 3.2 <= clock.now_s - began_s <= 4.0
    steps = np.diff([began_s, *flushed])
    assert 0.2 < steps.min() <= steps.max() <= 0.5
    # Without limits it never ends by itself.
    file = SampleFile(Disk(), dict, "", Limits())  # type: ignore[arg-type]
    file.add(sample(0))
    clock.sleep(1e6)
    file.look()
    assert not file.full


@pytest.mark.parametrize("error", [LostSourceError("nobody"), InputError("must name a topic"), None])
def test_topics_are_told_in_their_order_however_opening_ends(error: Exception | None) -> None:
    source: Any = Scripted()
    source.wrong, source.topics = error, {"/b": "Image", "/a": "Int16"}
    assert topics_at("root:", source) == [("root:/a", "Int16"), ("root:/b", "Image")]
    assert source.closed == 1


# Limits of options.

_FROM_TO = [
    ("sim:sphere?seed=", "0", "2147483648", "-1", "2147483649"),
    ("sim:sphere?pads=", "1", "64", "0", "65"),
    ("sim:sphere?rate_hz=", "0.1", "1e5", "0.09", "1.1e5"),
    ("sim:sphere?speed=", "0", "1e6", "-0.1", "1.1e6"),
    ("sim:sphere?duration_s=", "0", "inf", "-0.1", "nan"),
    ("sim:sphere?noise=", "0", "4095", "-0.1", "4096"),
    ("sim:sphere?drift=", "-4095", "4095", "-4096", "4096"),
    ("sim:sphere?creep=", "0", "1", "-0.1", "1.1"),
    ("sim:sphere?moves=", "0", "1", "-0.1", "1.1"),
    ("sim:sphere?hold_s=", "0.01", "1e5", "0.009", "1.1e5"),
    ("sim:sphere?rest_s=", "0.01", "1e5", "0.009", "1.1e5"),
    ("sim:sphere?pitch_m=", "1e-5", "1", "0.9e-5", "1.1"),
    ("sim:sphere?shape=", "4x4", "256x256", "3x9", "257x9"),
    ("replay:FILE?speed=", "0", "1e6", "-0.1", "1.1e6"),
    ("replay:FILE?rate_hz=", "1e-3", "1e6", "0.9e-3", "1.1e6"),
    ("replay:FILE?loop=", "0", "1", "-1", "2"),
    ("replay:FILE?pitch_m=", "1e-9", "1e3", "0.9e-9", "1.1e3"),
    ("replay:FILE?shape=", "1x1", "4096x4096", "0x1", "4097x1"),
    ("serial:/dev/x?preset=flexitac&baud=", "50", "100000000", "49", "100000001"),
    ("serial:/dev/x?preset=flexitac&pitch_m=", "1e-9", "1e3", "0.9e-9", "1.1e3"),
    ("stdin:?preset=arduino-rows&rate_hz=", "1e-3", "1e6", "0.9e-3", "1.1e6"),
    ("zenoh://h/skin?domain=", "0", "232", "-1", "233"),
    ("udp::9000?shape=", "1x1", "4096x4096", "1x0", "1x4097"),
]


@pytest.mark.parametrize(("text", "least", "most", "below", "above"), _FROM_TO)
def test_an_option_may_be_its_least_and_its_most_and_nothing_beyond(
    text: str, least: str, most: str, below: str, above: str, tmp_path: Path
) -> None:
    file = tmp_path / "press.npz"
    file.touch()
    text = text.replace("FILE", str(file))
    for value in (least, most):
        assert source_at(text + value).address == text + value
    for value in (below, above):
        with pytest.raises(InputError) as told:
            source_at(text + value)
        assert str(told.value).startswith(f"{text}{value}: ")


@pytest.mark.parametrize(
    ("text", "host", "port"), [("udp::1", "", 1), ("udp::65535", "", 65535), ("udp:127.0.0.1", "127.0.0.1", 9000)]
)
def test_a_port_is_from_1_to_65535_and_there_is_a_usual_one(text: str, host: str, port: int) -> None:
    source: Any = source_at(text)
    assert (source._place.host, source._place.port) == (host, port)
    for wrong in ("udp::0", "udp::65536"):
        with pytest.raises(InputError, match="must be as udp://HOST:PORT/NAME"):
            source_at(wrong)


def test_only_what_comes_when_it_is_asked_for_can_wait() -> None:
    waits = {"stdin:": True, "sim:cone?speed=0": True, "sim:cone": False, "replay:a.npz?speed=2": False, "udp:": False}
    assert {text: parse_address(text).can_wait for text in waits} == waits


def test_pads_of_a_session_are_those_of_its_source() -> None:
    source = Scripted()
    source.pads = {"left": PadLayout((2, 3), unit="kPa")}
    source.script.put(sample(0)._replace(pads={"left": np.ones((2, 3))}))
    with Session(source) as its:
        wait_until(lambda: its.newest is not None)
        assert its.newest is not None
        assert its.newest.pads["left"].unit == "kPa"
        assert its.status()["zero"] == {"left": "starting"}
