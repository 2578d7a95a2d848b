"""Zenoh without a network: who publishes and how long that is waited for, what is kept, how definitions are asked."""

from __future__ import annotations

import json
import struct
from threading import Condition
from types import SimpleNamespace
from typing import Any

import pytest

from varishold.errors import InputError, LostSourceError
from varishold.live import source_at, zenoh_types
from varishold.live.sources import zenoh_topic


def _texts(question: bytes) -> tuple[list[str], int]:
    """Return the texts of a request in CDR, each aligned to four bytes, and the byte behind them."""
    body, at, found = question[4:], 0, []
    for _ in range(2):
        at += -at % 4
        (size,) = struct.unpack_from("<I", body, at)
        found.append(body[at + 4 : at + 4 + size - 1].decode())
        assert body[at + 4 + size - 1] == 0
        at += 4 + size
    assert len(body) == at + 1
    return found, body[at]


@pytest.mark.parametrize("name", ["a/msg/B", "a/msg/Bc", "a/msg/Bcd", "a/msg/Bcde"])
def test_a_definition_is_asked_of_all_nodes_and_the_first_good_answer_taken(
    name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert _texts(zenoh_types._question(name, "RIHS01_0")) == ([name, "RIHS01_0"], 1)
    source = SimpleNamespace(type_name=name, encoding="msg", raw_file_contents="int16 a")
    inner = SimpleNamespace(type_name="x/msg/Y", encoding="msg", raw_file_contents="int8 b")
    idl = SimpleNamespace(type_name=name, encoding="idl", raw_file_contents="no")
    replies = {
        b"refused": SimpleNamespace(successful=False, type_sources=[source]),
        b"other": SimpleNamespace(successful=True, type_sources=[inner, idl]),
        b"good": SimpleNamespace(successful=True, type_sources=[inner, source, idl]),
    }
    monkeypatch.setattr(zenoh_types, "message_decoder", lambda *_: replies.__getitem__)

    class Payload(bytes):
        def to_bytes(self) -> bytes:
            return bytes(self)

    asked: list[tuple[str, Any]] = []

    def session(*contents: bytes | None) -> Any:
        answers = [SimpleNamespace(ok=None if c is None else SimpleNamespace(payload=Payload(c))) for c in contents]
        return SimpleNamespace(get=lambda key, **told: asked.append((key, told)) or answers)

    largest = bytes(1 << 20)
    replies[largest + b"0"], replies[largest] = (
        replies[b"good"],
        SimpleNamespace(successful=True, type_sources=[source]),
    )
    assert zenoh_types.asked_definition(session(largest + b"0"), 3, name, "RIHS01_0") == ""
    assert zenoh_types.asked_definition(session(largest), 3, name, "RIHS01_0") == "int16 a\n"
    asked.clear()
    told = zenoh_types.asked_definition(session(None, b"refused", b"other", b"good"), 3, name, "RIHS01_0")
    assert told == f"int16 a\n{'=' * 80}\nMSG: x/msg/Y\nint8 b\n"
    key, how = asked[0]
    assert key == "3/**/get_type_description/*/*"
    assert 2 < how["timeout"] < 5
    assert (how["payload"], len(how["attachment"])) == (zenoh_types._question(name, "RIHS01_0"), 33)
    assert zenoh_types.asked_definition(session(b"refused", b"other"), 3, name, "RIHS01_0") == ""
    # Of many that know nothing not all are heard.
    for count, last in ((63, told), (64, "")):
        assert zenoh_types.asked_definition(session(*[b"other"] * count, b"good"), 3, name, "RIHS01_0") == last


class Waiting(Condition):
    """Tells how long is waited, and waits no moment."""

    def __init__(self) -> None:
        super().__init__()
        self.waits_s: list[float | None] = []

    def wait_for(self, predicate: Any, timeout: float | None = None) -> Any:
        self.waits_s.append(timeout)
        return predicate()


def _token(topic: str, kind: str = "std_msgs::msg::dds_::Int16_") -> str:
    return f"@ros2_lv/0/a1/0/3/MP/%/%/node/{topic.replace('/', '%')}/{kind}/RIHS01_0/::,1:"


class Library:
    """As much of the library of zenoh as a source calls."""

    ZError = ConnectionError
    SampleKind = SimpleNamespace(DELETE="delete", PUT="put")

    def __init__(self) -> None:
        self.settings: dict[str, Any] = {}
        self.keys: list[str] = []
        self.peers: list[str] = ["a router"]
        self.closed = 0
        self.handlers = SimpleNamespace(Callback=lambda call, indirect: call)
        self.info = SimpleNamespace(routers_zid=lambda: self.peers, peers_zid=list)

    def Config(self) -> Any:
        return SimpleNamespace(insert_json5=lambda key, value: self.settings.update({key: json.loads(value)}))

    def open(self, config: Any) -> Library:
        return self

    def liveliness(self) -> Library:
        return self

    def declare_subscriber(self, key: str, call: Any, **_: Any) -> str:
        self.keys.append(key)
        return key

    def close(self) -> None:
        self.closed += 1


@pytest.fixture
def routed(monkeypatch: pytest.MonkeyPatch) -> tuple[Any, Library, Waiting]:
    library = Library()
    monkeypatch.setattr(zenoh_topic, "_library", lambda: library)
    source: Any = source_at("zenoh://router/skin?domain=7")
    source._news = Waiting()
    return source, library, source._news


def _life(source: Any, key: str, kind: str = "put") -> None:
    source._on_life(SimpleNamespace(key_expr=key, kind=kind))


def _value(source: Any, key: str, content: bytes) -> None:
    payload = SimpleNamespace(to_bytes=lambda: content)
    source._on_value(SimpleNamespace(attachment=None, key_expr=key, payload=payload))


def test_a_publisher_is_waited_for_a_second_and_a_list_of_topics_less(routed: Any) -> None:
    source, library, news = routed
    with pytest.raises(LostSourceError, match="nobody publishes /skin in domain 7; there are none"):
        source.open()
    assert library.keys == ["@ros2_lv/7/**", "7/skin/*/*", "skin"]
    assert library.settings["connect/endpoints"] == ["tcp/router:7447"]
    assert library.settings["scouting/multicast/enabled"] is False
    assert 300 <= library.settings["connect/timeout_ms"] <= 900
    assert 0.9 <= news.waits_s[0] <= 1.2
    listing: Any = source_at("zenoh:")
    listing._news = Waiting()
    with pytest.raises(InputError, match="must name a topic"):
        listing.open()
    assert library.settings["scouting/multicast/enabled"] is True
    assert 0.2 < listing._news.waits_s[0] < 0.5
    source.close()
    listing.close()
    assert library.closed == 2


def test_who_publishes_is_known_until_he_leaves(routed: Any) -> None:
    source, library, _ = routed
    source._session = library
    # Who has not published yet has not left.
    assert source.read(0.0) == []
    _life(source, _token("skin"))
    _life(source, _token("skin").replace("/a1/", "/b2/"))
    _life(source, _token("other"))
    _life(source, _token("node").replace("/MP/", "/MS/"))
    assert source.topics == {"/skin": "std_msgs/msg/Int16", "/other": "std_msgs/msg/Int16"}
    assert source.read(0.0) == []
    _life(source, _token("skin"), "delete")
    assert source.read(0.0) == []
    _life(source, _token("nobody"), "delete")
    _life(source, _token("skin").replace("/a1/", "/b2/"), "delete")
    # What it has sent before it left is still read.
    _value(source, "skin", b"[[1, 2], [3, 4]]")
    (one,) = source.read(0.0)
    assert one.pads["pad"].tolist() == [[1, 2], [3, 4]]
    with pytest.raises(LostSourceError, match="nobody publishes the topic any more"):
        source.read(0.0)
    library.peers.clear()
    with pytest.raises(LostSourceError, match="the connection is gone"):
        source.read(0.0)
    source.close()
    with pytest.raises(LostSourceError, match="is not open"):
        source.read(0.0)


def test_the_newest_thousand_messages_are_kept_and_the_others_counted(routed: Any) -> None:
    source, library, _ = routed
    source._session = library
    for k in range(1100):
        _value(source, "skin", b"[[%d, 2], [3, 4]]" % k)
    came = [int(one.pads["pad"][0, 0]) for one in source.read(0.0)]
    assert came == list(range(1100 - len(came), 1100))
    assert len(came) == 1024
    assert source.damaged == 1100 - len(came)
    for k in range(3000):
        _life(source, _token(f"topic{k}"))
    assert len(source.topics) == 1024


@pytest.mark.parametrize("named", [False, True])
def test_a_message_brings_its_number_and_time_by_the_old_way_and_the_new(named: bool) -> None:
    def told(number: int, time_ns: int) -> bytes:
        first, second = struct.pack("<q", number), struct.pack("<q", time_ns)
        if not named:
            return first + second + bytes([16]) + bytes(16)
        return b"\x0fsequence_number" + first + b"\x10source_timestamp" + second + b"\x0asource_gid" + bytes(17)

    assert zenoh_topic._attachment(told(300, 1_500_000_000)) == (300, pytest.approx(1.5))
    assert zenoh_topic._attachment(told(0, 0)) == (0, None)
    assert zenoh_topic._attachment(told(1, 2)[:15]) == (None, None)
    assert zenoh_topic._attachment(b"") == (None, None)
    assert zenoh_topic._attachment(struct.pack("<qq", 5, 10**9)) == (5, pytest.approx(1.0))
