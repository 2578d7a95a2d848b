"""A WebSocket whose other end does what a test tells it: how it is opened, what it says when it is lost, viewers."""

from __future__ import annotations

import json
import ssl
import struct
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
import websockets.sync.client
from tests.live_clock import Clock
from tests.live_scripted import Scripted
from websockets.exceptions import ConnectionClosedError, InvalidHandshake, InvalidURI, WebSocketException

from varishold.errors import InputError, LostSourceError
from varishold.live import PadLayout, Sample, source_at, web_sockets
from varishold.live.session import Session
from varishold.live.viewer import EVENTS_TOPIC, SUBPROTOCOLS, Viewer
from varishold.live.web_sockets import WebSocket
from varishold.recording.mcap.topics import SCHEMAS


class End:
    """The other end: gives or raises what a test puts, one after the other."""

    def __init__(self, *comes: Any, subprotocol: str | None = None) -> None:
        self.comes, self.subprotocol, self.sent, self.closed = list(comes), subprotocol, [], 0  # type: ignore[var-annotated]
        self.waits: list[float] = []

    def __enter__(self) -> End:
        return self

    def __exit__(self, *_: object) -> None:
        self.closed += 1
        raise OSError("closing failed")

    def recv(self, timeout_s: float, *, decode: bool) -> Any:
        assert decode is False
        self.waits.append(timeout_s)
        one = self.comes.pop(0) if self.comes else TimeoutError()
        if isinstance(one, Exception):
            raise one
        return one

    def send(self, text: str) -> None:
        if text == "fails":
            raise OSError("broken pipe")
        self.sent.append(text)

    def ping(self) -> Any:
        raise ConnectionClosedError(None, None)


def _socket(monkeypatch: pytest.MonkeyPatch, end: Any, *subprotocols: str) -> tuple[WebSocket, dict[str, Any]]:
    told: dict[str, Any] = {}

    def connect(uri: str, **how: Any) -> Any:
        told.update(how, uri=uri)
        if isinstance(end, Exception):
            raise end
        return end

    monkeypatch.setattr(websockets.sync.client, "connect", connect)
    return WebSocket("here", "ws://h:1/p", subprotocols), told


def _untrusted() -> Exception:
    error = ssl.SSLCertVerificationError()
    error.verify_message = "self-signed"
    return error


@pytest.mark.parametrize(
    ("error", "kind", "words"),
    [
        (InvalidURI("x", "no host"), InputError, "x isn't a valid URI: no host"),
        (InvalidHandshake("status 404"), LostSourceError, "no such WebSocket is served there: status 404"),
        (OSError("refused"), LostSourceError, "nobody answers: refused"),
        (TimeoutError("late"), LostSourceError, "nobody answers: late"),
        (WebSocketException("odd"), LostSourceError, "nobody answers: odd"),
        (_untrusted(), InputError, r"its certificate is not trusted \(self-signed\)"),
    ],
)
def test_why_a_socket_cannot_be_opened_is_said(
    error: Exception, kind: Any, words: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    socket, _ = _socket(monkeypatch, error)
    with pytest.raises(kind, match=f"^here: {words}"):
        socket.open()
    for use in (lambda: socket.receive(0.0), lambda: socket.send("a")):
        with pytest.raises(LostSourceError, match=r"^here: is not open$"):
            use()
    socket.close()


def test_what_is_offered_must_be_spoken(monkeypatch: pytest.MonkeyPatch) -> None:
    for spoken, lost in (("b", False), ("c", True), (None, True)):
        end = End(subprotocol=spoken)
        socket, told = _socket(monkeypatch, end, "a", "b")
        if lost:
            with pytest.raises(LostSourceError, match=r"^here: what is served there speaks none of a, b$"):
                socket.open()
            with pytest.raises(LostSourceError, match=r"^here: is not open$"):
                socket.receive(0.0)
        else:
            socket.open()
        assert told["subprotocols"] == ["a", "b"]
        assert told["uri"] == "ws://h:1/p"
        assert end.closed == lost
    # Where nothing is offered, nothing has to be.
    socket, told = _socket(monkeypatch, End(subprotocol="c"))
    socket.open()
    assert told["subprotocols"] is None


def test_what_came_before_the_end_is_given_first(monkeypatch: pytest.MonkeyPatch) -> None:
    clock = Clock(monkeypatch, web_sockets)
    gone = ConnectionClosedError(None, None)
    end = End(b"1", b"2", gone, gone)
    socket, _ = _socket(monkeypatch, end)
    socket.open()
    assert socket.receive(1.0) == [b"1", b"2"]
    with pytest.raises(LostSourceError, match=r"^here: has closed the connection: "):
        socket.receive(1.0)
    # The first message is waited for, what is there with it is not.
    assert end.waits == [0.15, 0, 0, 0.15]
    socket.send("a")
    assert end.sent == ["a"]
    with pytest.raises(LostSourceError, match=r"^here: has closed the connection: broken pipe$"):
        socket.send("fails")
    # Who cannot be asked is gone.
    clock.sleep(0.4)
    with pytest.raises(LostSourceError, match="has closed the connection"):
        socket.receive(0.0)
    socket.close()
    socket.close()
    assert end.closed == 1
    # Opened anew, what was open is let go.
    socket.open()
    socket.open()
    assert end.closed == 2


def test_a_greeting_is_no_reading(monkeypatch: pytest.MonkeyPatch) -> None:
    greeting = b'{"message" : "welcome", "data": [1, 2]}'
    late = b'{"data": [5, 6], "more": "' + b"x" * 1000 + b'", "message": "late"}'
    end = End(greeting, b'{"message": 4, "data": [3, 4]}', late, TimeoutError(), b"[7, 8]")
    _, told = _socket(monkeypatch, end)
    source = source_at("wss://[::1]/a/b?shape=1x2")
    source.open()
    assert told["uri"] == "wss://[::1]:5000/a/b"
    came = [one.pads["pad"].tolist() for _ in range(2) for one in source.read(0.0)]
    assert came == [[[3, 4]], [[5, 6]], [[7, 8]]]
    source.close()
    with pytest.raises(InputError, match="must name a host, as in ws://localhost:5000"):
        source_at("ws://:5000")


# Viewers.


class Log(SimpleNamespace):
    """Things that happened."""

    count = 0

    def since(self, number: int) -> list[dict[str, Any]]:
        return [{"host_time_s": time_s, "kind": str(k)} for k, time_s in enumerate(self.times)][number:]


def test_a_viewer_is_told_each_thing_under_its_channel_and_time() -> None:
    source = Scripted()
    source.pads = {"left": PadLayout((2, 3), unit="kPa"), "field": PadLayout((4,), "signals")}
    its: Any = Session(source)
    its.events = Log(times=[-5.0, 1.5, 1e12])
    viewer = Viewer(its)
    info, first = map(json.loads, viewer.greeting())
    assert info == {
        "op": "serverInfo",
        "name": "varishold: scripted:",
        "capabilities": [],
        "supportedEncodings": [],
        "metadata": {},
    }
    (channel,) = first["channels"]
    text = "std_msgs/msg/String"
    assert channel == {
        "id": 1,
        "topic": EVENTS_TOPIC,
        "encoding": "cdr",
        "schemaName": text,
        "schema": SCHEMAS[text],
        "schemaEncoding": "ros2msg",
    }
    its.stream._put([Sample(7.25, 1e9, 0, {"left": np.ones((2, 3), np.float32), "field": np.arange(4.0)})])
    told = [json.loads(message) for message in viewer.due() if isinstance(message, str)]
    (left, field) = (one["channels"][0] for one in told)
    assert [one["op"] for one in told] == ["advertise"] * 2
    assert [(one["id"], one["topic"]) for one in (left, field)] == [(2, "/left"), (3, "/field")]
    assert left["schemaName"] != field["schemaName"]
    assert (
        viewer.hear(
            json.dumps({"op": "subscribe", "subscriptions": [{"id": 40, "channelId": 1}, {"id": 9, "channelId": 2}]})
        )
        is None
    )
    its.stream._put([Sample(None, 12.5, 1, {"left": np.ones((2, 3), np.float32), "field": np.arange(4.0)})])
    its.events.count = 3
    sent = [struct.unpack_from("<BIQ", message) for message in viewer.due() if isinstance(message, bytes)]
    # A reading has the time at which it came; a time that no clock of theirs can show is the nearest that it can.
    assert sent[0] == (1, 9, 12_500_000_000)
    assert [one[:2] for one in sent[1:]] == [(1, 40)] * 3
    assert [one[2] for one in sent[1:]] == [0, 1_500_000_000, min(10**21, 2**64 - 1)]
    assert list(viewer.due()) == []
    for wrong in ('{"op": "subscribe", "subscriptions": [{"id": 1, "channelId": 4}]}', "[" * 100_000):
        assert json.loads(str(viewer.hear(wrong))) == {
            "op": "status",
            "level": 1,
            "message": "this is not understood",
        }
    assert viewer.hear('{"op": "unsubscribe", "subscriptionIds": [40, 9]}') is None
    its.stream._put([Sample(None, 12.5, 1, {"left": np.ones((2, 3), np.float32)})])
    assert list(viewer.due()) == []
    assert SUBPROTOCOLS == ("foxglove.sdk.v1", "foxglove.websocket.v1")
