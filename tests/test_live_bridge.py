"""A bridge that says what a test puts: which topic is asked for and how, and what is made of each message."""

from __future__ import annotations

import json
import struct
from typing import Any

import pytest
from tests.live_clock import Clock

from varishold.errors import InputError, LostSourceError
from varishold.live import source_at
from varishold.live.sources import foxglove


class Bridge:
    """Gives batches of messages, and then nothing."""

    def __init__(self, clock: Clock, *batches: list[Any]) -> None:
        self._clock, self.batches, self.sent, self.opened = clock, list(batches), [], 0  # type: ignore[var-annotated]
        self.waits: list[float] = []

    def open(self) -> None:
        self.opened += 1

    def close(self) -> None:
        self.opened -= 1

    def send(self, text: str) -> None:
        self.sent.append(json.loads(text))

    def receive(self, timeout_s: float) -> list[bytes]:
        self.waits.append(timeout_s)
        if not self.batches:
            self._clock.sleep(timeout_s)
            return []
        return [one if isinstance(one, bytes) else json.dumps(one).encode() for one in self.batches.pop(0)]


def _channel(number: int, topic: str, **more: Any) -> dict[str, Any]:
    told = {"topic": topic, "encoding": "json", "schemaName": "a/B", "schema": "text", "schemaEncoding": "jsonschema"}
    return {"id": number, **told, **more}


def _advertised(*channels: Any) -> dict[str, Any]:
    return {"op": "advertise", "channels": list(channels)}


def _message(content: Any, *, opcode: int = 1, subscription: int = 1, time_ns: int = 0) -> bytes:
    return struct.pack("<BIQ", opcode, subscription, time_ns) + json.dumps(content).encode()


def _decoded(content: bytes) -> Any:
    try:
        return json.loads(content)
    except ValueError:
        raise InputError("no JSON") from None


@pytest.fixture
def bridged(monkeypatch: pytest.MonkeyPatch) -> Any:
    made: list[tuple[Any, ...]] = []

    def decoder(*how: str) -> Any:
        made.append(how)
        if how[0] == "odd":
            raise InputError("messages encoded as 'odd' cannot be read")
        return _decoded

    clock = Clock(monkeypatch, foxglove)
    monkeypatch.setattr(foxglove, "message_decoder", decoder)

    def source(place: str, *batches: list[Any]) -> Any:
        one: Any = source_at(f"foxglove://h{place}")
        one._socket, one.made = Bridge(clock, *batches), made
        return one

    return source


@pytest.mark.parametrize("place", ["/skin", "/skin/", "//skin"])
@pytest.mark.parametrize("topic", ["/skin", "skin", "skin/"])
def test_the_topic_is_asked_for_as_the_bridge_tells_it(bridged: Any, place: str, topic: str) -> None:
    source = bridged(
        place, [{"op": "serverInfo"}, _advertised(_channel(4, "/other"), _channel(9, topic), _channel(5, topic))]
    )
    source.open()
    # The first of its name is taken, once.
    assert source._socket.sent == [{"op": "subscribe", "subscriptions": [{"id": 1, "channelId": 9}]}]
    assert source.made == [("json", "a/B", "text", "jsonschema")]
    assert source.topics == {"/other": "a/B", "/skin": "a/B"}
    # Definitions may be long: none is kept.
    assert {channel.text for channel in source._channels.values()} == {""}


def test_messages_of_the_subscription_are_read_and_no_others(bridged: Any) -> None:
    source = bridged("/skin?shape=1x2", [_advertised(_channel(9, "skin")), _message({"data": [0, 0]})])
    source.open()
    source._socket.batches = [
        [
            _message({"data": [1, 2]}, time_ns=2_500_000_000),
            _message({"data": [9, 9]}, subscription=2),
            _message({"data": [9, 9]}, opcode=2),
            b"",
            b"\x01" + bytes(11),
            struct.pack("<BIQ", 1, 1, 0),
            _message({"data": "nothing"}),
        ],
        [_message({"data": [3, 4]})],
    ]
    first = source.read(0.4)
    assert [(one.pads["pad"].tolist(), one.device_time_s) for one in first] == [([[1, 2]], 2.5)]
    assert source._socket.waits[-1] == 0.4
    (second,) = source.read(0.0)
    assert (second.pads["pad"].tolist(), second.device_time_s) == ([[3, 4]], None)
    # One without its head, one without a content, one of no taxels.
    assert source.damaged == 3


def test_a_topic_that_is_taken_back_is_lost_and_no_other(bridged: Any) -> None:
    channels = [_channel(k, f"/t{k}") for k in range(4)]
    source = bridged("/t2", [_advertised(*channels)])
    source.open()
    for gone in ({"channelIds": [0, "a", None, 99]}, {"channelIds": 2}, {}):
        source._socket.batches = [[{"op": "unadvertise", **gone}]]
        assert source.read(0.0) == []
    assert sorted(source.topics) == ["/t1", "/t2", "/t3"]
    source._socket.batches = [[{"op": "unadvertise", "channelIds": [1, 2]}]]
    with pytest.raises(LostSourceError, match=r"^foxglove://h/t2: nobody sends the topic any more$"):
        source.read(0.0)
    assert sorted(source.topics) == ["/t3"]
    # Opened anew, nothing of before is known.
    source._socket.batches = [[_advertised(_channel(7, "/t2"))]]
    source.open()
    assert (source.topics, source._subscribed) == ({"/t2": "a/B"}, 7)
    assert len(source._socket.sent) == 2
    source.close()
    assert source._socket.opened == 1


def test_what_is_said_and_is_nothing_is_passed_over(bridged: Any) -> None:
    wrong: list[Any] = [
        {"op": "advertise"},
        {"op": "advertise", "channels": [1, "a", None, [], {}]},
        _advertised({"id": "1", "topic": "/skin"}, {"id": 2, "topic": 5}, {"id": 3, "topic": "/skin", "encoding": 7}),
        {"op": "status", "level": 2},
    ]
    source = bridged("/skin", wrong, [_advertised({"id": 8, "topic": "/skin", "schemaName": None})])
    source.open()
    assert source._subscribed == 8
    assert source.made == [("", "", "", "")]
    for nonsense in (b"{", b'{"op": }', b"{\xff}"):
        source._socket.batches = [[_message({"data": [1, 2]}), nonsense]]
        source.read(0.0)
    assert source.damaged == 3


def test_what_cannot_be_read_can_never_be(bridged: Any) -> None:
    source = bridged("/skin", [_advertised(_channel(9, "/skin", encoding="odd"))])
    with pytest.raises(InputError, match=r"^foxglove://h/skin: messages encoded as 'odd' cannot be read$"):
        source.open()
