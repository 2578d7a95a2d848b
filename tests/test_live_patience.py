"""How long is waited, by a clock of the test's own: for an answer, for a lost source, for a browser, for a topic."""

from __future__ import annotations

import json
from collections import deque
from collections.abc import Callable
from threading import Event
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from tests.live_clock import Clock

from varishold.errors import EndOfSourceError, InputError, LostSourceError
from varishold.live import Sample, Source, Stream, browsers, source_at, web_sockets
from varishold.live.browsers import Browser, Offer
from varishold.live.event_log import EventLog
from varishold.live.sources import foxglove, lab_stream, mqtt_topic, serial_port
from varishold.live.watcher import Watcher
from varishold.live.web_sockets import WebSocket


class Silence:
    """The other end of a cable that was pulled, or of one that has nothing to say but answers.

    Parameters
    ----------
    clock : Clock
    answers : bool
    """

    def __init__(self, clock: Clock, *, answers: bool) -> None:
        self._clock, self._answers = clock, answers
        self.asked_s: list[float] = []
        self.says: deque[bytes] = deque()
        self.heard: Callable[[], None] = lambda: None

    def recv(self, timeout_s: float, *, decode: bool) -> bytes:
        if self.says:
            return self.says.popleft()
        self._clock.sleep(timeout_s)
        raise TimeoutError

    def ping(self) -> Event:
        self.asked_s.append(self._clock.now_s)
        answered = Event()
        if self._answers:
            answered.set()
        return answered

    def loop(self, timeout_s: float) -> int:
        self._clock.sleep(timeout_s)
        return 0

    def unsubscribe(self, topic: str) -> None:
        self.asked_s.append(self._clock.now_s)
        if self._answers:
            self.heard()


def _socket(clock: Clock, other: Silence) -> Callable[[float], list[Any]]:
    socket = WebSocket("here", "ws://nowhere")
    socket._connection, socket._heard_s = other, clock.now_s  # type: ignore[assignment]
    return socket.receive  # type: ignore[return-value]


def _broker(clock: Clock, other: Silence) -> Callable[[float], list[Any]]:
    source: Any = source_at("mqtt://nowhere/skin")
    source._client, other.heard = other, source._heard
    source._heard()
    return source.read  # type: ignore[no-any-return]


@pytest.fixture
def clock(monkeypatch: pytest.MonkeyPatch) -> Clock:
    return Clock(monkeypatch, web_sockets, mqtt_topic, foxglove, lab_stream, serial_port)


def _until(clock: Clock, read: Callable[[float], list[Any]], timeout_s: float, limit_s: float = 10.0) -> float:
    """Return after how long a source is told to be lost; infinite where it is not."""
    began_s = clock.now_s
    while clock.now_s < began_s + limit_s:
        before_s = clock.now_s
        try:
            assert read(timeout_s) == []
        except LostSourceError:
            return clock.now_s - began_s
        assert clock.now_s - before_s <= timeout_s + 1e-3
        clock.sleep(0.01)
    return float("inf")


@pytest.mark.parametrize("opened", [_socket, _broker])
@pytest.mark.parametrize("timeout_s", [0.03, 0.1, 0.5, 5.0])
def test_who_falls_silent_is_asked_and_given_up_within_a_second(opened: Any, timeout_s: float, clock: Clock) -> None:
    began_s, other = clock.now_s, Silence(clock, answers=False)
    lost_s = _until(clock, opened(clock, other), timeout_s)
    # A skin of five readings a second is not asked for more, and an answer may take half a second.
    (asked_s,) = other.asked_s
    assert 0.25 <= asked_s - began_s <= 0.5
    assert asked_s - began_s + 0.5 <= lost_s <= 1.1


@pytest.mark.parametrize("opened", [_socket, _broker])
@pytest.mark.parametrize("timeout_s", [0.03, 0.1, 5.0])
def test_who_answers_is_not_given_up_and_is_seldom_asked(opened: Any, timeout_s: float, clock: Clock) -> None:
    other = Silence(clock, answers=True)
    assert _until(clock, opened(clock, other), timeout_s) == float("inf")
    assert 10 <= len(other.asked_s) <= 40


def test_what_comes_counts_as_an_answer(clock: Clock) -> None:
    other = Silence(clock, answers=False)
    receive = _socket(clock, other)
    for _ in range(50):
        clock.sleep(0.2)
        other.says.append(b"a")
        assert receive(0.0) == [b"a"]
    assert other.asked_s == []
    # Who is flooded can still be stopped: what is taken at once has an end, and the rest is kept for the next time.
    other.says.extend(b"%d" % number for number in range(500))
    came = [receive(0.0) for _ in range(500)]
    assert [int(one) for each in came for one in each] == list(range(500))
    assert max(map(len, came)) <= 65


@pytest.mark.parametrize(("promised_hz", "lost"), [(0.0, False), (3.9, False), (4.0, True), (100.0, True)])
def test_a_steady_stream_of_a_lab_is_given_up_within_a_second(
    promised_hz: float, lost: bool, clock: Clock, monkeypatch: pytest.MonkeyPatch
) -> None:
    waits: list[float] = []

    class Inlet:
        def __init__(self, *_: object, **__: object) -> None:
            pass

        def open_stream(self, timeout: float) -> None:
            waits.append(timeout)

        def info(self, timeout: float) -> Any:
            waits.append(timeout)
            return info

        def close_stream(self) -> None:
            pass

        def pull_sample(self, timeout: float) -> tuple[None, None]:
            clock.sleep(timeout)
            return None, None

    nothing = SimpleNamespace(empty=lambda: True, child=lambda name: nothing, child_value=lambda name: "")
    info = SimpleNamespace(nominal_srate=lambda: promised_hz, channel_count=lambda: 4, channel_format=lambda: 1)
    info.desc, info.source_id = lambda: nothing, lambda: ""
    errors = SimpleNamespace(LostError=ConnectionError, TimeoutError=TimeoutError)
    library = SimpleNamespace(StreamInlet=Inlet, util=errors)
    library.resolve_byprop = lambda *_, timeout, **__: waits.append(timeout) or [info]
    monkeypatch.setattr(lab_stream, "_library", lambda: library)
    source = source_at("lsl:skin")
    source.open()
    assert sum(waits) <= 3
    assert min(waits) >= 0.9
    (layout,) = source.pads.values()
    assert (layout.shape, layout.kind) == ((4,), "pressure")
    for timeout_s in (0.03, 0.1):
        source.open()
        told_s = _until(clock, source.read, timeout_s, limit_s=5.0)
        assert 0.8 <= told_s <= 1.05 if lost else told_s == float("inf")


class SilentPort:
    """A port behind which nobody answers, or everybody at once."""

    def __init__(self, clock: Clock) -> None:
        self._clock, self.timeout, self.in_waiting = clock, 0.0, 0
        self.asked_s: list[float] = []

    def write(self, data: bytes) -> None:
        self.asked_s.append(self._clock.now_s)

    def read(self, size: int) -> bytes:
        assert size == 1
        self._clock.sleep(self.timeout)
        return b""


@pytest.mark.parametrize("timeout_s", [0.02, 0.05])
def test_a_skin_that_wants_to_be_asked_is_asked_again_after_a_fifth_of_a_second(timeout_s: float, clock: Clock) -> None:
    source: Any = source_at("serial:/dev/null?preset=weiss-wsg")
    port = source._port = SilentPort(clock)
    assert _until(clock, source.read, timeout_s, limit_s=6.0) == float("inf")
    steps = np.diff(port.asked_s)
    assert 0.15 <= steps.min() <= steps.max() <= 0.3
    # A skin that sends by itself is asked for nothing.
    source = source_at("serial:/dev/null?preset=flexitac")
    port = source._port = SilentPort(clock)
    assert _until(clock, source.read, timeout_s, limit_s=2.0) == float("inf")
    assert port.asked_s == []


# Foxglove's bridge.


class Bridge:
    """A bridge that says something at some times after it was connected to."""

    def __init__(self, clock: Clock, says: dict[float, Any]) -> None:
        self._clock, self._says, self.sent = clock, dict(says), []  # type: ignore[var-annotated]
        self._began_s = clock.now_s

    def open(self) -> None:
        self._began_s = self._clock.now_s

    def close(self) -> None:
        pass

    def send(self, text: str) -> None:
        self.sent.append(json.loads(text))

    def receive(self, timeout_s: float) -> list[bytes]:
        ends_s = self._clock.now_s + timeout_s
        due = min(self._says, default=float("inf"))
        self._clock.now_s = min(max(self._began_s + due, self._clock.now_s), ends_s)
        if self._clock.now_s < self._began_s + due:
            return []
        return [json.dumps(self._says.pop(due)).encode()]


def _channel(number: int, topic: str) -> dict[str, Any]:
    told = {"id": number, "topic": topic, "encoding": "json", "schemaName": "", "schema": "", "schemaEncoding": ""}
    return {"op": "advertise", "channels": [told]}


def _bridged(clock: Clock, place: str, says: dict[float, Any]) -> Any:
    source: Any = source_at(f"foxglove://nowhere{place}")
    source._socket = Bridge(clock, says)
    return source


def test_a_topic_may_be_told_within_a_second_and_is_then_not_waited_for(clock: Clock) -> None:
    began_s = clock.now_s
    source = _bridged(clock, "/skin", {0.1: _channel(3, "/other"), 0.8: _channel(5, "/skin")})
    source.open()
    assert clock.now_s - began_s == pytest.approx(0.8, abs=0.05)
    assert source._socket.sent == [{"op": "subscribe", "subscriptions": [{"id": 1, "channelId": 5}]}]
    began_s = clock.now_s
    source = _bridged(clock, "/skin", {0.1: _channel(3, "/other"), 1.5: _channel(5, "/skin")})
    with pytest.raises(LostSourceError, match="there is no topic /skin; there are /other"):
        source.open()
    assert 0.9 <= clock.now_s - began_s <= 1.3


def test_a_list_of_topics_ends_with_a_short_silence(clock: Clock) -> None:
    began_s = clock.now_s
    source = _bridged(clock, "", {0.05: _channel(3, "/b"), 0.15: _channel(4, "/a"), 0.9: _channel(5, "/late")})
    with pytest.raises(InputError, match=r"must name a topic.*there are /a \(\), /b \(\)"):
        source.open()
    assert 0.25 <= clock.now_s - began_s <= 0.5
    assert sorted(source.topics) == ["/a", "/b"]


# A stream.


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


# Browsers.


class Shown:
    """A session of 100 readings a second, and a browser that is served as the server does it."""

    def __init__(self, clock: Clock, monkeypatch: pytest.MonkeyPatch) -> None:
        self.clock, self.events = clock, EventLog()
        self.newest: Any = None
        self.named, self.looked_at = None, ()
        self.pictures, self.asleep_s = 0, 0.0
        self.told: list[tuple[float, str]] = []
        monkeypatch.setattr(browsers, "picture_of", lambda seen: b"picture %d" % seen.number)
        monkeypatch.setattr(browsers, "words_of", lambda seen, also: {"number": seen.number})

    def status(self) -> dict[str, Any]:
        return {"at_s": self.clock.now_s}

    def serve(self, browser: Browser, for_s: float, *, shows: bool = True, silent: bool = False) -> None:
        ends_s, news_s = self.clock.now_s + for_s, self.clock.now_s
        while self.clock.now_s < ends_s:
            if not silent and self.clock.now_s >= news_s - 1e-9:
                number = 0 if self.newest is None else self.newest.number + 1
                self.newest, news_s = SimpleNamespace(number=number), news_s + 0.01
            for message in browser.due():
                if isinstance(message, bytes):
                    self.pictures += 1
                    assert message == b"picture %d" % self.newest.number
                    if shows:
                        browser.has_shown(self.pictures)
                else:
                    self.told.append((self.clock.now_s, json.loads(message)["kind"]))
            wake_s = self.clock.now_s + max(browser.wait_s(), 1e-6)
            if not silent:
                # The server wakes for news only who wants them; here everybody else sleeps on.
                while news_s < wake_s and not browser.wants_news:
                    number = 0 if self.newest is None else self.newest.number + 1
                    self.newest, news_s = SimpleNamespace(number=number), news_s + 0.01
                wake_s = min(wake_s, news_s)
            self.clock.now_s = wake_s

    def count(self, kind: str) -> int:
        return sum(one == kind for _, one in self.told)


@pytest.fixture
def shown(monkeypatch: pytest.MonkeyPatch) -> Shown:
    return Shown(Clock(monkeypatch, browsers), monkeypatch)


def test_a_browser_gets_fifty_pictures_eight_words_and_two_states_a_second(shown: Shown) -> None:
    shown.serve(Browser(Offer(shown)), 10.0)  # type: ignore[arg-type]
    assert 300 <= shown.pictures <= 501
    assert 70 <= shown.count("words") <= 84
    assert 19 <= shown.count("status") <= 21
    assert shown.count("events") == 0


def test_a_browser_that_shows_nothing_gets_two_pictures_and_learns_how_the_source_is(shown: Shown) -> None:
    browser = Browser(Offer(shown))  # type: ignore[arg-type]
    shown.serve(browser, 5.0, shows=False)
    assert (shown.pictures, browser.wants_picture, browser.wants_news) == (2, False, False)
    assert 9 <= shown.count("status") <= 11
    assert shown.count("words") <= 2
    # What it has not got yet it cannot have shown.
    browser.has_shown(99)
    shown.serve(browser, 5.0, shows=False)
    assert shown.pictures == 4
    # Nor does it forget what it has shown.
    browser.has_shown(4)
    browser.has_shown(0)
    assert browser.wants_picture


def test_a_browser_of_a_silent_source_sleeps_until_the_next_state(shown: Shown) -> None:
    browser = Browser(Offer(shown))  # type: ignore[arg-type]
    shown.serve(browser, 3.0, silent=True)
    assert shown.pictures == 0
    assert 5 <= shown.count("status") <= 7
    list(browser.due())
    assert 0 < browser.wait_s() <= 0.5


def test_a_browser_that_comes_late_is_told_the_newest_events_and_each_new_one_at_once(shown: Shown) -> None:
    for number in range(100):
        shown.events.add("zero", 0.0, str(number))
    browser = Browser(Offer(shown))  # type: ignore[arg-type]
    (events,) = [json.loads(m) for m in browser.due() if b"events" in m.encode() and '"kind":"events"' in m]
    words = [event["words"] for event in events["events"]]
    assert words == [str(number) for number in range(40, 100)]
    shown.clock.sleep(0.1)
    assert list(browser.due()) == []
    shown.events.add("touched", 0.0, "now")
    browser.answers.append({"ok": True})
    told = [json.loads(message) for message in browser.due()]
    assert [one["kind"] for one in told] == ["answer", "events", "status"]
    assert [event["words"] for event in told[1]["events"]] == ["now"]
    # How the source is is asked anew, for it may have changed with that.
    assert told[2]["at_s"] == shown.clock.now_s


def test_one_state_and_one_picture_are_made_for_all_browsers(shown: Shown, monkeypatch: pytest.MonkeyPatch) -> None:
    made: list[int] = []
    monkeypatch.setattr(browsers, "picture_of", lambda seen: made.append(seen.number) or b"picture")
    shown.newest = SimpleNamespace(number=5)
    offer = Offer(shown)  # type: ignore[arg-type]
    told = [list(Browser(offer).due()) for _ in range(8)]
    assert made == [5]
    assert all(one == told[0] for one in told)


def test_a_press_that_lasts_is_named_some_four_times_a_second() -> None:
    watcher, asked = Watcher(), []
    namer = SimpleNamespace(idle=True, done=list, close=lambda: None, finish=lambda timeout_s: [])
    namer.ask = lambda kept, *, over: asked.append((watcher.now_s, over))
    watcher._namer = namer  # type: ignore[assignment]
    rng, heap = np.random.default_rng(0), np.zeros((16, 16))
    heap[5:10, 5:10] = 100.0
    for k in range(600):
        frame = rng.normal(0, 1, (16, 16)) + heap * (150 <= k < 450)
        watcher.see(Sample(k / 100, 0.0, k, {"pad": frame}))
    steps = np.diff([at_s for at_s, over in asked if not over])
    assert 0.2 <= steps.min() <= steps.max() <= 0.35
    assert [over for _, over in asked].count(True) == 1
    # While one is being named none waits behind it.
    namer.idle = False
    asked.clear()
    for k in range(600, 900):
        watcher.see(Sample(k / 100, 0.0, k, {"pad": rng.normal(0, 1, (16, 16)) + heap * (650 <= k)}))
    assert asked == []
    # A press that ends with the source is named all the same.
    last = watcher.finish()
    assert last is not None
    assert last.ended is not None
    assert [over for _, over in asked] == [True]
    assert [event.kind for event in last.pads["pad"].events] == ["released"]
