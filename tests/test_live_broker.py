"""A broker that does what a test tells it, and how servers are spoken to."""

from __future__ import annotations

import ssl
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


class Reason:
    """Why something was done or not, as the library has it."""

    def __init__(self, words: str, is_failure: bool) -> None:
        self._words, self.is_failure = words, is_failure

    def __str__(self) -> str:
        return self._words


class Broker:
    """A broker that does what a test says, and a library that makes clients of it."""

    CallbackAPIVersion = SimpleNamespace(VERSION2=2)
    refuses = ""

    def __init__(self, clock: Clock, *, says: Any = "welcome", after_s: float = 0.0) -> None:
        self._clock, self._says, self._at_s = clock, says, clock.now_s + after_s
        self.topics: list[str] = []
        self.asked: list[Any] = []
        self.waiting: deque[Any] = deque()
        self.on_connect: Any = None
        self.on_subscribe: Any = None
        self.on_message: Any = None

    def Client(self, version: int) -> Broker:
        self.topics.clear()
        return self

    def connect(self, host: str, port: int) -> None:
        self.asked.append((host, port))
        if isinstance(self._says, Exception):
            raise self._says

    def username_pw_set(self, user: str, password: str | None) -> None:
        self.asked.append((user, password))

    def tls_set(self) -> None:
        self.asked.append("secure")

    def disconnect(self) -> None:
        self.asked.append("goodbye")
        raise OSError("it is gone")

    def subscribe(self, topic: str) -> None:
        if self.refuses == "name":
            raise ValueError("Invalid subscription filter.")
        self.topics.append(topic)

    def unsubscribe(self, topic: str) -> None:
        """It is a question; nobody waits so long for the answer here."""

    def socket(self) -> None:
        """No byte ever comes through one."""

    def loop(self, timeout_s: float) -> Any:
        if self._says == "hangs up":
            return SimpleNamespace(name="MQTT_ERR_CONN_LOST")
        if self._says != "welcome" or self._clock.now_s < self._at_s:
            self._clock.sleep(max(timeout_s, 0.001))
        elif not self.topics:
            self.on_connect(self, None, None, Reason("Not authorized", self.refuses == "user"), None)
            if self.topics:
                last = Reason("Not yours", self.refuses == "topic")
                self.on_subscribe(self, None, 1, [last, Reason("ok", False)], None)
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
    assert (broker.topics, broker.asked) == (["skin"], [("localhost", 1883)])
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


@pytest.mark.parametrize(
    ("text", "asked"),
    [
        ("mqtt://h:5/a", [("h", 5)]),
        ("mqtts://h/a", ["secure", ("h", 8883)]),
        ("mqtt://[::1]/a?user=anna", [("anna", "secret"), ("::1", 1883)]),
    ],
)
def test_a_broker_is_asked_as_the_address_says(text: str, asked: list[Any], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("VARISHOLD_MQTT_PASSWORD", "secret")
    source, broker, _ = _at_broker(monkeypatch, text)
    source.open()
    assert broker.asked == asked
    # Saying goodbye is no failure, and what was open is let go before it is opened anew.
    source.open()
    assert broker.asked == [*asked, "goodbye", *asked]
    source.close()
    source.close()
    assert broker.asked[-1] == "goodbye"
    with pytest.raises(LostSourceError, match="is not open"):
        source.read(0.0)


@pytest.mark.parametrize(
    ("refuses", "words"),
    [
        ("user", r"the broker says: Not authorized; give \?user=NAME, and the password in \$VARISHOLD_MQTT_PASSWORD$"),
        ("topic", "the broker does not give the topic: Not yours$"),
        ("name", r"'a/#' is no topic: Invalid subscription filter\.$"),
    ],
)
def test_what_a_broker_refuses_can_never_be_read(refuses: str, words: str, monkeypatch: pytest.MonkeyPatch) -> None:
    source, broker, _ = _at_broker(monkeypatch, "mqtt://h/a/#")
    broker.refuses = refuses
    with pytest.raises(InputError, match=f"^mqtt://h/a/#: {words}"):
        source.open()
    # A refusal is not remembered.
    broker.refuses, broker.topics = "", []
    source.open()
    assert source.read(0.0) == []


@pytest.mark.parametrize("error", [OSError("unreachable"), ValueError("no host"), ssl.SSLCertVerificationError("it")])
def test_a_broker_that_is_not_there_is_told(error: Exception, monkeypatch: pytest.MonkeyPatch) -> None:
    source, _, _ = _at_broker(monkeypatch, "mqtts://h/a", says=error)
    trusted = not isinstance(error, ssl.SSLCertVerificationError)
    if trusted:
        with pytest.raises(LostSourceError, match=f"^mqtts://h/a: no broker answers: {error}$"):
            source.open()
    else:
        error.verify_message = "self-signed"  # type: ignore[attr-defined]
        with pytest.raises(
            InputError, match=r"^mqtts://h/a: its certificate is not trusted \(self-signed\); name a file"
        ):
            source.open()
    with pytest.raises(LostSourceError, match="is not open"):
        source.read(0.0)


@pytest.mark.parametrize(
    ("asked", "topic", "name"),
    [
        ("a/#", "a/tip", "tip"),
        ("a/+", "a/tip/", "tip"),
        ("a/#", "a/b/tip", "b/tip"),
        # Two hands, a tip each, are two pads.
        ("hand/+/tip", "hand/left/tip", "left/tip"),
        ("hand/+/tip", "hand/right/tip", "right/tip"),
        ("+/tip", "left/tip", "left/tip"),
        # What stands for nothing names nothing.
        ("a/#", "a", "pad"),
        ("a/b/tip", "a/b/tip", "pad"),
        ("a/+", "a/\x1b[31m", "\\x1b[31m"),
    ],
)
def test_pads_under_a_wildcard_are_called_by_what_stands_for_it_and_behind(
    asked: str, topic: str, name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    source, broker, _ = _at_broker(monkeypatch, f"mqtt://h/{asked}")
    source.open()
    broker.put(topic, b"[[1, 2]]")
    (one,) = source.read(0.0)
    assert list(one.pads) == [name]
    assert name.isprintable()


def test_what_has_come_is_read_though_the_broker_hangs_up(monkeypatch: pytest.MonkeyPatch) -> None:
    for asked in ("a/#", "a/b/tip"):
        source, broker, _ = _at_broker(monkeypatch, f"mqtt://h/{asked}")
        source.open()
        broker.put("a/b/tip", b"[[3, 4]]")
        took = broker.loop

        def hangs_up(timeout_s: float, took: Any = took, broker: Broker = broker) -> Any:
            took(timeout_s)
            broker.loop = lambda _: SimpleNamespace(name="GONE")  # type: ignore[method-assign]
            return SimpleNamespace(name="GONE")

        broker.loop = hangs_up  # type: ignore[method-assign]
        with pytest.raises(LostSourceError, match=r"the broker is gone \(GONE\)"):
            source.read(0.0)


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
