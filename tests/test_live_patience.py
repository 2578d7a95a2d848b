"""How long is waited, by a clock of the test's own: for an answer, for a lost source, for a topic."""

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

from varishold.errors import InputError, LostSourceError
from varishold.live import source_at, web_sockets
from varishold.live.sources import foxglove, lab_stream, mqtt_topic, serial_port
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

    def socket(self) -> None:
        """No byte ever comes through one."""

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
        if data:
            self.asked_s.append(self._clock.now_s)

    def read(self, size: int) -> bytes:
        assert size == 1
        self._clock.sleep(self.timeout)
        return b""


def _listening(address: str, clock: Clock) -> tuple[Any, SilentPort]:
    source, port = source_at(address), SilentPort(clock)
    source._serial = SimpleNamespace(Serial=lambda *_, **__: port)  # type: ignore[attr-defined]
    source.open()
    return source, port


@pytest.mark.parametrize("timeout_s", [0.02, 0.05])
def test_a_skin_that_wants_to_be_asked_is_asked_again_after_a_fifth_of_a_second(timeout_s: float, clock: Clock) -> None:
    source, port = _listening("serial:/dev/null?preset=weiss-wsg", clock)
    assert _until(clock, source.read, timeout_s, limit_s=6.0) == float("inf")
    steps = np.diff(port.asked_s)
    assert 0.15 <= steps.min() <= steps.max() <= 0.3
    # A skin that sends by itself is asked for nothing.
    source, port = _listening("serial:/dev/null?preset=flexitac", clock)
    assert _until(clock, source.read, timeout_s, limit_s=2.0) == float("inf")
    assert port.asked_s == []


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
    assert 0.3 <= clock.now_s - began_s <= 0.5
    assert sorted(source.topics) == ["/a", "/b"]
