"""Topics of ROS 2 over zenoh: sessions in this process that publish as rmw_zenoh does."""

from __future__ import annotations

import json
import socket
import struct
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import pytest

pytest.importorskip("zenoh", reason="eclipse-zenoh is not installed")
pytest.importorskip("rosbags", reason="rosbags is not installed")

import zenoh
from rosbags.typesys import Stores, get_types_from_msg, get_typestore
from tests.live_reading import read_on, read_some
from tests.live_scripted import wait_until
from tests.ros_messages import bytes_of, made, store_of, text_of

from varishold.errors import InputError, LostSourceError
from varishold.live import Stream, source_at
from varishold.live.sources import source_kind
from varishold.live.zenoh_types import _REPLY

RNG = np.random.default_rng(9)
ARRAY = "std_msgs/msg/Float32MultiArray"


def free_port() -> int:
    with socket.create_server(("127.0.0.1", 0)) as listener:
        return int(listener.getsockname()[1])


@contextmanager
def router(port: int | None = None) -> Iterator[tuple[Any, int]]:
    """Yield a session that routes, as rmw_zenohd does, and its port."""
    port = port or free_port()
    config = zenoh.Config()
    config.insert_json5("mode", '"router"')
    config.insert_json5("scouting/multicast/enabled", "false")
    config.insert_json5("listen/endpoints", json.dumps([f"tcp/127.0.0.1:{port}"]))
    with zenoh.open(config) as session:
        yield session, port


class Node:
    """A node of ROS 2 with one publisher.

    Parameters
    ----------
    session : zenoh.Session
    topic : str
    name : str
        The type's.
    domain : int
    named : bool
        Attach the names of numbers, as the first versions did.
    """

    def __init__(self, session: Any, topic: str, name: str, *, domain: int = 0, named: bool = False) -> None:
        package, _, kind = name.split("/")
        on_wire = f"{package}::msg::dds_::{kind}_"
        self.name, self.store, self.named, self.number = name, store_of(name), named, 0
        mangled = topic.replace("/", "%")
        self.token = session.liveliness().declare_token(
            f"@ros2_lv/{domain}/{session.zid()}/0/10/MP/%/%/skin_driver/%{mangled}/{on_wire}/RIHS01_ab/::,7:,:,:,,"
        )
        # A busy machine must not lose messages of the test's own.
        self.publisher = session.declare_publisher(
            f"{domain}/{topic}/{on_wire}/RIHS01_ab", congestion_control=zenoh.CongestionControl.BLOCK
        )

    def publish(self, **values: Any) -> None:
        self.put(bytes_of(made(self.name, self.store, **values), self.store))

    def put(self, content: bytes) -> None:
        self.number += 1
        number, time_ns = (struct.pack("<q", value) for value in (self.number, self.number * 10**9))
        if self.named:
            attached = b"\x0fsequence_number" + number + b"\x10source_timestamp" + time_ns + b"\x0asource_gid\x10"
        else:
            attached = number + time_ns + b"\x10"
        self.publisher.put(content, attachment=attached + bytes(16))

    def leave(self) -> None:
        self.publisher.undeclare()
        self.token.undeclare()


def laid_out(frame: np.ndarray) -> dict[str, Any]:
    dims = [{"label": "", "size": size, "stride": size} for size in frame.shape]
    return {"layout": {"dim": dims}, "data": frame.ravel()}


@pytest.mark.parametrize("named", [False, True])
@pytest.mark.parametrize(("topic", "domain"), [("skin", 0), ("hand/left/skin", 7)])
def test_what_a_node_publishes_is_what_is_read(topic: str, domain: int, named: bool) -> None:
    frames = RNG.random((300, 4, 6)).astype(np.float32)
    with router() as (session, port):
        node = Node(session, topic, ARRAY, domain=domain, named=named)
        source = source_at(f"zenoh://127.0.0.1:{port}/{topic}?domain={domain}")
        source.open()
        wait_until(lambda: node.publisher.matching_status.matching)
        for frame in frames:
            node.publish(**laid_out(frame))
        samples = read_some(source, 300)
        source.close()
        source.close()
    np.testing.assert_array_equal([sample.pads["pad"] for sample in samples], frames)
    assert [sample.sequence for sample in samples] == list(range(1, 301))
    assert [sample.device_time_s for sample in samples] == [pytest.approx(k) for k in range(1, 301)]
    assert source.pads["pad"].shape == (4, 6)


def test_types_in_no_standard_package_need_their_definition(tmp_path: Path) -> None:
    name = "tactile_msgs/msg/TactileState"
    (tmp_path / "TactileState.msg").write_text(text_of(name))
    with router() as (session, port):
        node = Node(session, "skin", name)
        values = {"header": {"stamp": {"sec": 3}}, "sensors": [{"name": "ff", "values": [1, 2]}]}
        source = source_at(f"zenoh://127.0.0.1:{port}/skin")
        source.open()
        wait_until(lambda: node.publisher.matching_status.matching)
        node.publish(**values)
        with pytest.raises(InputError, match=r"lacks that of tactile_msgs/msg/TactileState; no node tells .*msg="):
            read_on(source)
        source.close()
        wait_until(lambda: not node.publisher.matching_status.matching)
        source = source_at(f"zenoh://127.0.0.1:{port}/skin?msg={tmp_path / 'TactileState.msg'}")
        source.open()
        wait_until(lambda: node.publisher.matching_status.matching)
        node.publish(**values)
        (sample,) = read_some(source, 1)
        assert sample.pads["ff"].tolist() == [1, 2]
        assert sample.device_time_s == 3.0
        source.close()


def told_by(session: Any, node: str, asked: list[tuple[str, str, bool]], sources: dict[str, str], *, ok: bool) -> Any:
    """Declare the service of a node that tells the definitions of types."""
    key = f"0/{node}/get_type_description/type_description_interfaces::srv::dds_::GetTypeDescription_/RIHS01_7"
    name = "type_description_interfaces/msg/Reply"
    standard = "".join(
        f"{'=' * 80}\nMSG: {kind}\n{text_of(kind).split('=' * 80)[0]}"
        for kind in (
            "type_description_interfaces/msg/TypeDescription",
            "type_description_interfaces/msg/IndividualTypeDescription",
            "type_description_interfaces/msg/Field",
            "type_description_interfaces/msg/FieldType",
            "type_description_interfaces/msg/TypeSource",
            "type_description_interfaces/msg/KeyValue",
        )
    )
    store = get_typestore(Stores.EMPTY)
    store.register(get_types_from_msg(_REPLY + standard, name))
    store.register(get_types_from_msg("string type_name\nstring type_hash\nbool include_type_sources", "a/msg/Ask"))

    def answer(query: Any) -> None:
        question = store.deserialize_cdr(query.payload.to_bytes(), "a/msg/Ask")
        asked.append((question.type_name, question.type_hash, question.include_type_sources))
        assert len(query.attachment.to_bytes()) == 33
        listed = [{"type_name": key, "encoding": "msg", "raw_file_contents": text} for key, text in sources.items()]
        reply = made(name, store, successful=ok, type_sources=listed)
        query.reply(key, bytes_of(reply, store))

    return session.declare_queryable(key, answer, complete=True)


def test_nodes_tell_the_definitions_of_their_types() -> None:
    name = "tactile_msgs/msg/TactileState"
    first, *others = text_of(name).split("=" * 80 + "\nMSG: ")
    sources = {name: first}
    for other in others:
        kind, _, text = other.partition("\n")
        sources[kind.replace("/", "/msg/")] = text
    with router() as (session, port):
        asked: list[tuple[str, str, bool]] = []
        services = [
            told_by(session, "hand/other", [], {}, ok=False),
            told_by(session, "skin_driver", asked, sources, ok=True),
        ]
        node = Node(session, "skin", name)
        source = source_at(f"zenoh://127.0.0.1:{port}/skin")
        source.open()
        wait_until(lambda: node.publisher.matching_status.matching)
        node.publish(sensors=[{"name": "ff", "values": [1, 2]}])
        (sample,) = read_some(source, 1)
        source.close()
        for service in services:
            service.undeclare()
    assert sample.pads["ff"].tolist() == [1, 2]
    assert asked == [(name, "RIHS01_ab", True)]


def test_wrong_messages_are_counted_and_passed_over() -> None:
    with router() as (session, port):
        node = Node(session, "skin", ARRAY)
        source = source_at(f"zenoh://127.0.0.1:{port}/skin")
        source.open()
        wait_until(lambda: node.publisher.matching_status.matching)
        good = [
            bytes_of(made(ARRAY, node.store, **laid_out(np.full((2, 2), k, np.float32))), node.store) for k in range(9)
        ]
        wrong = [b"", b"\x00", b"\x00\x01\x00\x00", good[0][:20], good[0] + bytes(9), RNG.bytes(50)]
        for number, content in enumerate(good):
            node.put(content)
            for each in wrong[number : number + 1]:
                node.put(each)
        node.publisher.put(good[8], attachment=b"short")
        samples = read_some(source, 10)
        source.close()
    assert [sample.pads["pad"][0, 0] for sample in samples] == [*range(9), 8]
    assert samples[-1].sequence is None
    assert source.damaged == len(wrong)


def test_plain_keys_are_read() -> None:
    with router() as (session, port):
        publisher = session.declare_publisher("lab/skin")
        stream = Stream(source_at(f"zenoh://127.0.0.1:{port}/lab/skin?shape=1x2&dtype=uint16")).start()

        def put_until_heard() -> bool:
            publisher.put(np.array([7, 8], "<u2").tobytes())
            return stream.received > 0

        wait_until(put_until_heard)
        newest = stream.newest()
        assert newest is not None
        assert newest.pads["pad"].tolist() == [[7, 8]]
        stream.close()


def test_a_node_that_leaves_is_told_and_found_again() -> None:
    with router() as (session, port):
        node = Node(session, "skin", ARRAY)
        stream = Stream(source_at(f"zenoh://127.0.0.1:{port}/skin")).start()
        wait_until(lambda: stream.state == "open")
        node.leave()
        wait_until(lambda: stream.state == "lost")
        assert "nobody publishes" in stream.words
        node = Node(session, "skin", ARRAY)
        wait_until(lambda: stream.state == "open")
        wait_until(lambda: node.publisher.matching_status.matching)
        node.publish(**laid_out(np.ones((1, 1))))
        wait_until(lambda: stream.received == 1)
        stream.close()


def test_a_router_that_leaves_is_told() -> None:
    with router() as (session, port):
        node = Node(session, "skin", ARRAY)
        source = source_at(f"zenoh://127.0.0.1:{port}/skin")
        source.open()
        wait_until(lambda: node.publisher.matching_status.matching)
    with pytest.raises(LostSourceError, match=r"the connection is gone|nobody publishes the topic any more"):
        read_on(source)
    source.close()
    with pytest.raises(LostSourceError, match="is not open"):
        source.read(0.0)
    with pytest.raises(LostSourceError, match=f"^zenoh://127.0.0.1:{port}/skin: nobody answers"):
        source.open()


def test_topics_are_told_where_none_or_another_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    with router() as (session, port):
        nodes = [Node(session, "skin", ARRAY), Node(session, "text", "std_msgs/msg/String")]
        nonsense = session.liveliness().declare_token("@ros2_lv/0/nonsense/MP/%")
        there = f"zenoh://127.0.0.1:{port}"
        told = r"there are /skin \(std_msgs/msg/Float32MultiArray\), /text \(std_msgs/msg/String\)$"
        source = source_at(there)
        with pytest.raises(InputError, match="must name a topic, as in zenoh://localhost:7447/skin; " + told):
            source.open()
        source.close()
        source = source_at(f"{there}/other")
        with pytest.raises(LostSourceError, match="nobody publishes /other in domain 0; " + told):
            source.open()
        source.close()
        from varishold.live.sources import zenoh_topic

        monkeypatch.setattr(zenoh_topic, "_PORT", port)
        kind = source_kind("zenoh")
        assert kind.found is not None
        assert kind.found() == [
            (f"zenoh://localhost:{port}/skin", ARRAY),
            (f"zenoh://localhost:{port}/text", "std_msgs/msg/String"),
        ]
        nonsense.undeclare()
        for node in nodes:
            node.leave()


def test_nothing_in_reach_is_no_error() -> None:
    from varishold.live.sources import zenoh_topic

    kind = source_kind("zenoh")
    assert kind.found is not None
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(zenoh_topic, "_PORT", free_port())
        assert kind.found() == []


def test_a_reader_that_is_slow_fills_no_memory() -> None:
    with router() as (session, port):
        node = Node(session, "skin", ARRAY)
        source = source_at(f"zenoh://127.0.0.1:{port}/skin")
        source.open()
        wait_until(lambda: node.publisher.matching_status.matching)
        content = bytes_of(made(ARRAY, node.store, **laid_out(np.ones((1, 1), np.float32))), node.store)
        for _ in range(3000):
            node.put(content)
        wait_until(lambda: source.damaged >= 3000 - 1024)
        samples = read_some(source, 1024)
        source.close()
    assert samples[-1].sequence == 3000


@pytest.mark.parametrize(
    ("address", "words"),
    [
        ("zenoh://h/*", "'*' is no topic"),
        ("zenoh://h/t?domain=-1", "domain must be a number from 0 to 232"),
        ("zenoh://h/t?domain=1.5", "domain must be a whole number"),
        ("zenoh://h/t?speed=1", "zenoh has no option 'speed'; known are shape, field, dtype, skip, domain, msg"),
        ("zenoh://h/t?msg=/nowhere/x.msg", "/nowhere/x.msg"),
    ],
)
def test_addresses_that_cannot_be_are_told(address: str, words: str) -> None:
    with pytest.raises(InputError) as told:
        source_at(address)
    assert words in str(told.value)
