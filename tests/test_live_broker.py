"""A broker that does what a test tells it, and how servers are spoken to."""

from __future__ import annotations

from collections import deque
from types import SimpleNamespace
from typing import Any

import pytest
import websockets.sync.client
from tests.live_clock import Clock

from varishold.errors import InputError, LostSourceError
from varishold.live import server, source_at
from varishold.live.server import PageServer
from varishold.live.session import Session
from varishold.live.sources import mqtt_topic
from varishold.live.web_sockets import WebSocket


class Broker:
    """A broker that does what a test says, and a library that makes clients of it."""

    CallbackAPIVersion = SimpleNamespace(VERSION2=2)

    def __init__(self, clock: Clock, *, says: str = "welcome", after_s: float = 0.0) -> None:
        self._clock, self._says, self._at_s = clock, says, clock.now_s + after_s
        self.topics: list[str] = []
        self.waiting: deque[Any] = deque()
        self.on_connect: Any = None
        self.on_subscribe: Any = None
        self.on_message: Any = None

    def Client(self, version: int) -> Broker:
        return self

    def connect(self, host: str, port: int) -> None:
        assert (host, port) == ("localhost", 1883)

    def subscribe(self, topic: str) -> None:
        self.topics.append(topic)

    def unsubscribe(self, topic: str) -> None:
        """It is a question; nobody waits so long for the answer here."""

    def loop(self, timeout_s: float) -> Any:
        if self._says == "hangs up":
            return SimpleNamespace(name="MQTT_ERR_CONN_LOST")
        if self._says != "welcome" or self._clock.now_s < self._at_s:
            self._clock.sleep(max(timeout_s, 0.001))
        elif not self.topics:
            self.on_connect(self, None, None, SimpleNamespace(is_failure=False), None)
            self.on_subscribe(self, None, 1, [SimpleNamespace(is_failure=False)], None)
        elif self.waiting:
            self.on_message(self, None, self.waiting.popleft())
        else:
            self._clock.sleep(timeout_s)
        return 0

    def put(self, topic: str, payload: bytes, *, retain: bool = False) -> None:
        self.waiting.append(SimpleNamespace(topic=topic, payload=payload, retain=retain))


def _at_broker(monkeypatch: pytest.MonkeyPatch, text: str, **how: Any) -> tuple[Any, Broker, Clock]:
    clock = Clock(monkeypatch, mqtt_topic)
    broker = Broker(clock, **how)
    monkeypatch.setattr(mqtt_topic, "_library", lambda: broker)
    return source_at(text), broker, clock


def test_a_broker_may_take_most_of_a_second_to_welcome(monkeypatch: pytest.MonkeyPatch) -> None:
    source, broker, clock = _at_broker(monkeypatch, "mqtt:///skin", after_s=0.8)
    source.open()
    assert broker.topics == ["skin"]
    assert 0.6 <= broker.connect_timeout <= 1.5  # type: ignore[attr-defined]
    for says in ("nothing", "hangs up"):
        source, _, clock = _at_broker(monkeypatch, "mqtt:///skin", says=says)
        began_s = clock.now_s
        with pytest.raises(LostSourceError, match="what answers is no broker"):
            source.open()
        assert 0.9 <= clock.now_s - began_s <= 1.2 if says == "nothing" else clock.now_s == began_s


def test_what_is_published_is_read_in_its_order_and_under_its_name(monkeypatch: pytest.MonkeyPatch) -> None:
    source, broker, clock = _at_broker(monkeypatch, "mqtt:///hand/+")
    source.open()
    broker.put("hand/left", b"[[9, 2], [3, 4]]", retain=True)
    for k in range(300):
        broker.put(f"hand/{('left', 'right/')[k % 2]}", b"[[%d, 2], [3, 4]]" % k)
    came = [source.read(0.05) for _ in range(10)]
    values = [int(pad[0, 0]) for each in came for one in each for pad in one.pads.values()]
    assert values == list(range(300))
    # Whoever is flooded can still be stopped.
    assert 10 <= max(map(len, came)) <= 65
    assert list(source.pads) == ["left", "right"]
    before_s = clock.now_s
    assert source.read(0.1) == []
    assert clock.now_s - before_s == pytest.approx(0.1, abs=0.01)
    broker._says = "hangs up"
    with pytest.raises(LostSourceError, match=r"the broker is gone \(MQTT_ERR_CONN_LOST\)"):
        source.read(0.1)


def test_how_a_web_socket_is_opened_and_the_page_served(monkeypatch: pytest.MonkeyPatch) -> None:
    told: dict[str, Any] = {}

    def nobody(*_: object, **named: Any) -> None:
        told.update(named)
        raise OSError("nobody")

    monkeypatch.setattr(websockets.sync.client, "connect", nobody)
    with pytest.raises(LostSourceError, match="nobody answers"):
        WebSocket("here", "ws://nowhere").open()
    # Opening and closing stay well within the second in which a lost source is told; nothing is compressed or
    # asked behind our back; a frame of 512 x 512 numbers as text is taken.
    assert 0.6 <= told["open_timeout"] <= 1.5
    assert 0.15 <= told["close_timeout"] <= 0.3
    assert (told["compression"], told["proxy"], told["ping_interval"]) == (None, None, None)
    assert (told["max_size"], told["max_queue"]) == (1 << 24, 16)
    monkeypatch.setattr(server, "serve", nobody)
    with pytest.raises(InputError, match=r"cannot listen at 127\.0\.0\.1, port 8765: nobody"):
        PageServer(Session(SimpleNamespace(address="a:", pads={}))).__enter__()  # type: ignore[arg-type]
    # A browser that is silent is looked after within some seconds, and saying goodbye holds nobody up.
    assert 5 < told["ping_interval"] < 20
    assert 5 < told["ping_timeout"] < 20
    assert 0.3 < told["close_timeout"] < 0.9
    assert (told["compression"], told["subprotocols"], told["server_header"]) == (None, None, None)
    assert (told["max_size"], told["max_queue"]) == (4096, 16)
