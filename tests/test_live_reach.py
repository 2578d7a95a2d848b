"""What is listed: kinds of sources in the registry's order, what is missing for each, and what is in reach of each."""

from __future__ import annotations

import sys
from threading import Barrier
from types import SimpleNamespace
from typing import Any

import pytest
from tests.live_clock import Clock
from tests.test_live_nodes import Library, _token
from tests.test_live_patience import Bridge, _channel

from varishold.errors import InputError, MissingExtraError
from varishold.live import reach, source_at, sources
from varishold.live.reach import ReachableKind, reachable_kinds
from varishold.live.sources import KINDS, SourceKind, foxglove, lab_stream, source_kind, zenoh_topic


def _registry(monkeypatch: pytest.MonkeyPatch, files: dict[str, str], kinds: dict[str, SourceKind]) -> None:
    monkeypatch.setattr(reach, "KINDS", files)
    monkeypatch.setattr(reach, "source_kind", lambda name: kinds[files[name]])


def _kind(title: str, found: Any = None, needs: tuple[str, ...] = ()) -> SourceKind:
    return SourceKind(title, f"{title}:example", lambda address: None, found, needs)  # type: ignore[arg-type, return-value]


def test_kinds_are_listed_in_their_order_each_with_all_its_names(monkeypatch: pytest.MonkeyPatch) -> None:
    together = Barrier(2, timeout=20)

    def look(*found: tuple[str, str]) -> Any:
        # Nobody is looked for after somebody else.
        return lambda: together.wait() is not None and list(found)

    files = {"b": "two", "a": "one", "bs": "two", "c": "three"}
    kinds = {"one": _kind("One", look()), "two": _kind("Two", look(("b:1", "x"), ("b:2", ""))), "three": _kind("Three")}
    _registry(monkeypatch, files, kinds)
    assert reachable_kinds() == [
        ReachableKind(("b", "bs"), "Two", "Two:example", "", (("b:1", "x"), ("b:2", ""))),
        ReachableKind(("a",), "One", "One:example", "", ()),
        ReachableKind(("c",), "Three", "Three:example", "", ()),
    ]


def test_what_is_missing_is_said_of_the_first_that_is_and_nobody_is_looked_for(monkeypatch: pytest.MonkeyPatch) -> None:
    looked: list[str] = []

    def look() -> list[tuple[str, str]]:
        looked.append("looked")
        return [("a:1", "")]

    def refuse(error: Exception) -> Any:
        def look() -> list[tuple[str, str]]:
            raise error

        return look

    monkeypatch.setattr(reach, "find_spec", lambda module: None if module in ("serial", "paho") else module)
    gone = ModuleNotFoundError("No module named 'zenoh'", name="zenoh")
    kinds = {
        "has": _kind("Has", look, ("json", "math")),
        "lacks": _kind("Lacks", look, ("json", "serial", "paho")),
        "broken": _kind("Broken", refuse(InputError("it cannot be loaded"))),
        "gone": _kind("Gone", refuse(gone)),
    }
    _registry(monkeypatch, {name: name for name in kinds}, kinds)
    told = {kind.title: (kind.missing, kind.found) for kind in reachable_kinds()}
    assert told["Has"] == ("", (("a:1", ""),))
    assert looked == ["looked"]
    assert told["Lacks"][0].startswith("this needs serial, ")
    assert told["Broken"] == ("it cannot be loaded", ())
    assert told["Gone"][0].startswith("this needs zenoh, ")
    assert told["Lacks"][1] == told["Gone"][1] == ()


def test_ports_are_listed_by_their_names_and_what_they_say_of_themselves(monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("serial", reason="needs pyserial")
    from serial.tools.list_ports_common import ListPortInfo

    ports = [ListPortInfo(f"/dev/ttyUSB{number}") for number in (10, 2, 1)]
    for port, words in zip(ports, ("n/a", None, "A mat"), strict=True):
        port.description = words
    monkeypatch.setattr("serial.tools.list_ports.comports", lambda: ports)
    found = source_kind("serial").found
    assert found is not None
    assert found() == [("serial:/dev/ttyUSB1", "A mat"), ("serial:/dev/ttyUSB2", ""), ("serial:/dev/ttyUSB10", "")]


def test_streams_of_a_lab_are_listed_with_what_they_promise(monkeypatch: pytest.MonkeyPatch) -> None:
    def info(name: str, kind: str, channels: int, rate_hz: float) -> Any:
        told = {"name": name, "type": kind, "channel_count": channels, "nominal_srate": rate_hz}
        return SimpleNamespace(**{key: lambda value=value: value for key, value in told.items()})

    waits: list[float] = []
    streams = [info("skin", "", 256, 100.0), info("glove", "Tactile", 65, 0.0)]
    library = SimpleNamespace(resolve_streams=lambda wait_s: waits.append(wait_s) or streams)
    monkeypatch.setattr(lab_stream, "_library", lambda: library)
    assert lab_stream._found() == [
        ("lsl:glove", "Tactile, 65 channels, 0 Hz"),
        ("lsl:skin", "a stream, 256 channels, 100 Hz"),
    ]
    # All kinds are listed within a second.
    assert 0.5 <= waits[0] <= 1.0


def test_topics_of_a_bridge_are_listed_with_their_types(monkeypatch: pytest.MonkeyPatch) -> None:
    clock, opened = Clock(monkeypatch, foxglove), []
    says = _channel(3, "/skin")
    says["channels"] += [{**says["channels"][0], "id": 4, "topic": "arm/left/", "schemaName": "std_msgs/msg/Int16"}]
    # What is none is passed over.
    says["channels"] += [{"id": "5", "topic": "/a"}, {"id": 6, "topic": 7}, {"topic": "/b"}, 8]

    def made(where: str, uri: str, subprotocols: tuple[str, ...]) -> Bridge:
        opened.append(uri)
        return Bridge(clock, {0.1: says})

    monkeypatch.setattr(foxglove, "WebSocket", made)
    found = source_kind("foxglove").found
    assert found is not None
    assert found() == [
        ("foxglove://localhost:8765/arm/left", "std_msgs/msg/Int16"),
        ("foxglove://localhost:8765/skin", ""),
    ]
    assert opened == ["ws://localhost:8765"]


def test_topics_of_a_router_are_listed_with_their_types(monkeypatch: pytest.MonkeyPatch) -> None:
    class Router(Library):
        def declare_subscriber(self, key: str, call: Any, **_: Any) -> str:
            for topic in ("skin", "arm/left", "skin"):
                call(SimpleNamespace(key_expr=_token(topic), kind="put"))
            return super().declare_subscriber(key, call)

    library = Router()
    monkeypatch.setattr(zenoh_topic, "_library", lambda: library)
    monkeypatch.setattr(zenoh_topic, "_LIST_S", 0.0)
    assert zenoh_topic._found() == [
        ("zenoh://localhost:7447/arm/left", "std_msgs/msg/Int16"),
        ("zenoh://localhost:7447/skin", "std_msgs/msg/Int16"),
    ]
    assert library.settings["connect/endpoints"] == ["tcp/localhost:7447"]
    assert library.settings["mode"] == "client"
    assert (library.keys, library.closed) == (["@ros2_lv/0/**"], 1)


@pytest.mark.parametrize("name", KINDS)
def test_a_kind_whose_library_is_not_there_says_what_installs_it(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    def missing(address: object) -> Any:
        raise ModuleNotFoundError("No module named 'serial'", name="serial")

    kind = source_kind(name)
    monkeypatch.setattr(sources, "source_kind", lambda _: SourceKind(kind.title, kind.example, missing))
    with pytest.raises(MissingExtraError, match=r"^this needs serial, "):
        source_at(kind.example)


def test_every_topic_that_is_listed_can_be_asked_for() -> None:
    """What is told in reach is an address."""
    for root in ("foxglove://localhost:8765", "zenoh://localhost:7447"):
        kind = source_kind(root.partition(":")[0])
        if any(module not in sys.modules and reach.find_spec(module) is None for module in kind.needs):
            continue
        source: Any = source_at(f"{root}/arm/left")
        assert source._topic.strip("/") == "arm/left"
