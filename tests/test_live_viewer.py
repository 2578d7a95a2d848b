"""A viewer that speaks Foxglove's protocol gets every reading, in the messages that a recording holds."""

from __future__ import annotations

import json
import struct
from collections.abc import Iterator

import numpy as np
import pytest
from tests.live_scripted import Scripted, wait_until
from websockets.exceptions import InvalidStatus
from websockets.sync.client import ClientConnection, connect

from varishold.live import PadLayout, Sample, Stream, source_at
from varishold.live.door import Door
from varishold.live.server import PageServer
from varishold.live.session import Session
from varishold.live.viewer import EVENTS_TOPIC, Viewer

SUBPROTOCOL = "foxglove.websocket.v1"


@pytest.fixture
def served() -> Iterator[tuple[Scripted, Session, PageServer]]:
    source = Scripted()
    source.pads = {"palm": PadLayout((4, 5)), "field": PadLayout((3,), kind="signals")}
    with Session(source) as session, PageServer(session, port=0, viewers=True) as server:
        wait_until(lambda: session.stream.state == "open")
        yield source, session, server


def _sample(number: int) -> Sample:
    rng = np.random.default_rng(number)
    palm = rng.integers(0, 4096, (4, 5)).astype(np.uint16)
    return Sample(number / 100, 1e9 + number / 100, number, {"palm": palm, "field": rng.normal(size=3)})


def _connect(server: PageServer, **options: object) -> ClientConnection:
    address = server.address.replace("http", "ws")
    return connect(address, subprotocols=[SUBPROTOCOL], compression=None, **options)  # type: ignore[arg-type]


@pytest.mark.parametrize("topic", ["palm", "field"])
def test_our_own_reader_of_the_protocol_gets_what_was_sent(
    served: tuple[Scripted, Session, PageServer], topic: str
) -> None:
    source, session, server = served
    place = server.address.removeprefix("http://").strip("/")
    with Stream(source_at(f"foxglove://{place}/{topic}")) as stream:
        # A topic is told of when its first reading comes; the reader tries again until it is there, and what comes
        # before it has asked for the topic is not for it.
        number = 0
        while not stream.received:
            source.script.put(_sample(number))
            number += 1
            stream.wait_open(0.2)
        wanted = [_sample(k).pads[topic] for k in range(number, number + 20)]
        for k in range(number, number + 20):
            source.script.put(_sample(k))
        got: list[np.ndarray] = []

        def all_came() -> bool:
            samples = stream.reader().read()[-20:]
            got[:] = [next(iter(sample.pads.values())).reshape(wanted[0].shape) for sample in samples]
            return np.array_equal(got[-1], wanted[-1])

        wait_until(all_came)
    assert np.array_equal(got, wanted)
    assert session.failure is None


def test_events_are_told_as_text(served: tuple[Scripted, Session, PageServer]) -> None:
    source, _, server = served
    with _connect(server) as viewer:
        assert viewer.subprotocol == SUBPROTOCOL
        assert json.loads(viewer.recv(timeout=20))["op"] == "serverInfo"
        (channel,) = json.loads(viewer.recv(timeout=20))["channels"]
        assert (channel["topic"], channel["schemaName"]) == (EVENTS_TOPIC, "std_msgs/msg/String")
        viewer.send(json.dumps({"op": "subscribe", "subscriptions": [{"id": 7, "channelId": channel["id"]}]}))
        viewer.send(json.dumps({"op": "nonsense"}))
        for number in range(130):
            source.script.put(_sample(number))
        kind = ""
        while kind != "zero":
            message = viewer.recv(timeout=20)
            if not isinstance(message, bytes):
                continue
            opcode, subscription, time_ns = struct.unpack_from("<BIQ", message)
            assert (opcode, subscription) == (1, 7)
            assert time_ns > 1e18
            # A string of CDR: its head, its length, the text and a zero.
            kind = json.loads(message[13 + 8 : -1])["kind"]


def test_nonsense_is_told_and_survived(served: tuple[Scripted, Session, PageServer]) -> None:
    _, session, _ = served
    viewer = Viewer(session)
    wrong = ["", "[]", "7", "{}", '{"op": "subscribe"}', '{"op": "subscribe", "subscriptions": [{}]}', b"\xff\x00"]
    for subscription in ({"id": -1, "channelId": 1}, {"id": 1, "channelId": 99}, {"id": "x", "channelId": []}):
        wrong.append(json.dumps({"op": "subscribe", "subscriptions": [subscription]}))
    for message in wrong:
        answer = viewer.hear(message)
        assert answer is not None, message
        assert json.loads(answer)["op"] == "status"
    for message in ('{"op": "unsubscribe", "subscriptionIds": [5]}', '{"op": "clientInfo"}'):
        assert viewer.hear(message) is None


def test_who_may_look() -> None:
    door = Door("127.0.0.1")
    for origin in (None, "https://app.foxglove.dev", "http://localhost:1", "file://", "app://lichtblick"):
        assert door.refusal("localhost:1", origin, viewer=True) is None
    for origin in ("https://example.com", "null", "http://app.foxglove.dev", "https://app.foxglove.dev.example.com"):
        assert door.refusal("localhost:1", origin, viewer=True) is not None
    assert door.refusal("localhost:1", "https://app.foxglove.dev") is not None


def test_without_being_asked_for_viewers_get_the_page() -> None:
    with Session(Scripted()) as session, PageServer(session, port=0) as server:
        with pytest.raises(InvalidStatus) as refused, _connect(server):
            pass
        assert refused.value.response.status_code == 200
