"""Topics by Foxglove's protocol: a server by its specification, and the maker's own where it is installed."""

from __future__ import annotations

import base64
import json
import time
from typing import Any

import numpy as np
import pytest

pytest.importorskip("rosbags", reason="rosbags is not installed")

from tests.live_reading import read_on, read_some
from tests.live_scripted import wait_until
from tests.live_servers import FoxgloveServer, Hangup
from tests.ros_messages import as_dict, bytes_of, made, store_of, text_of

from benchmarks._silent_servers import silent_web_socket
from varishold.errors import InputError, LostSourceError
from varishold.live import Stream, source_at

RNG = np.random.default_rng(8)
ARRAY = "std_msgs/msg/Float32MultiArray"
SUBPROTOCOLS = ("foxglove.sdk.v1", "foxglove.websocket.v1")


def channel(topic: str, name: str, encoding: str = "cdr") -> dict[str, Any]:
    written = {"cdr": "ros2msg", "ros1": "ros1msg", "json": "jsonschema"}[encoding]
    text = "{}" if encoding == "json" else text_of(name)
    return {"topic": topic, "encoding": encoding, "schemaName": name, "schema": text, "schemaEncoding": written}


def on_wire(name: str, encoding: str, /, **values: Any) -> bytes:
    store = store_of(name)
    message = made(name, store, **values)
    return json.dumps(as_dict(message)).encode() if encoding == "json" else bytes_of(message, store, encoding)


def laid_out(frame: np.ndarray) -> dict[str, Any]:
    dims = [{"label": "", "size": size, "stride": size} for size in frame.shape]
    return {"layout": {"dim": dims}, "data": frame.ravel()}


@pytest.mark.parametrize("encoding", ["cdr", "ros1", "json"])
@pytest.mark.parametrize("subprotocol", SUBPROTOCOLS)
def test_what_a_bridge_sends_is_what_is_read(subprotocol: str, encoding: str) -> None:
    frames = RNG.random((300, 4, 6)).astype(np.float32)
    other = channel("/other", "std_msgs/msg/String")
    with FoxgloveServer([other, channel("/skin", ARRAY, encoding)], subprotocol) as server:
        source = source_at(f"foxglove://127.0.0.1:{server.port}/skin")
        source.open()
        for number, frame in enumerate(frames):
            server.put_message(on_wire(ARRAY, encoding, **laid_out(frame)), time_ns=10**9 + number)
        samples = read_some(source, 300)
        source.close()
    np.testing.assert_array_equal([sample.pads["pad"] for sample in samples], frames)
    assert samples[0].device_time_s == 1.0
    assert server.subscriptions == {8: 1}
    assert source.pads["pad"].shape == (4, 6)


@pytest.mark.parametrize(
    ("name", "values", "pads"),
    [
        (
            "tactile_msgs/msg/TactileState",
            {"header": {"stamp": {"sec": 3}}, "sensors": [{"name": "ff", "values": [1, 2]}]},
            {"ff": [1, 2]},
        ),
        ("somebody/msg/Skin", {"skin": [1, 2, 3, 4]}, {"pad": [[1, 2], [3, 4]]}),
        (
            "sensor_msgs/msg/Image",
            {"height": 1, "width": 2, "encoding": "mono8", "step": 4, "data": [5, 6, 0, 0]},
            {"pad": [[5, 6]]},
        ),
    ],
)
def test_types_are_known_by_the_text_on_the_wire(name: str, values: Any, pads: Any) -> None:
    options = "?field=skin&shape=2x2" if name.startswith("somebody") else ""
    with FoxgloveServer([channel("skin/left", name)]) as server:
        source = source_at(f"foxglove://127.0.0.1:{server.port}/skin/left{options}")
        source.open()
        server.put_message(on_wire(name, "cdr", **values), time_ns=10**9)
        (sample,) = read_some(source, 1)
        source.close()
    assert {pad: values.tolist() for pad, values in sample.pads.items()} == pads
    assert sample.device_time_s == (3.0 if "header" in values else 1.0)


def test_wrong_messages_are_counted_and_passed_over() -> None:
    good = [on_wire(ARRAY, "cdr", **laid_out(np.full((2, 2), k, np.float32))) for k in range(30)]
    wrong = [b"", b"\x01", b"\x01\x02", b"\x00\x01\x00\x00", good[0][:20], good[0] + b"12345678", RNG.bytes(60)]
    with FoxgloveServer([channel("/skin", ARRAY)]) as server:
        source = source_at(f"foxglove://127.0.0.1:{server.port}/skin")
        source.open()
        for number, content in enumerate(good):
            server.put_message(content)
            for each in wrong[number : number + 1]:
                server.put_message(each)
        server.put(b"", b"\x01\x02", b"\x01" + bytes(7), b"\x09nonsense", '{"op": "what"}', "{", "[]", '{"op": ["x"]}')
        server.put({"op": "advertise", "channels": [5, {"id": "x"}, {"id": 9, "topic": 4}, None]})
        server.put({"op": "advertise", "channels": 7}, {"op": "unadvertise", "channelIds": [[], "a", 5]})
        server.put_message(good[0], subscription=44)
        server.put_message(good[7])
        samples = read_some(source, 31)
        source.close()
    assert [sample.pads["pad"][0, 0] for sample in samples] == [*range(30), 7]
    assert source.damaged == len(wrong) + 3


def test_topics_are_told_where_none_or_another_is_named() -> None:
    with FoxgloveServer([channel("/b", ARRAY), channel("/a", "std_msgs/msg/String")]) as server:
        there = f"foxglove://127.0.0.1:{server.port}"
        told = r"there are /a \(std_msgs/msg/String\), /b \(std_msgs/msg/Float32MultiArray\)$"
        source = source_at(there)
        with pytest.raises(InputError, match="must name a topic, as in foxglove://localhost:8765/skin; " + told):
            source.open()
        source.close()
        source = source_at(f"{there}/c")
        with pytest.raises(LostSourceError, match="there is no topic /c; " + told):
            source.open()
        source.close()


def test_a_topic_that_comes_later_is_waited_for_and_one_that_goes_is_lost() -> None:
    with FoxgloveServer([]) as server:
        stream = Stream(source_at(f"foxglove://127.0.0.1:{server.port}/skin")).start()
        late = channel("/skin", ARRAY) | {"id": 3}
        server.put({"op": "advertise", "channels": [late]})
        wait_until(lambda: stream.state == "open")
        server.put_message(on_wire(ARRAY, "cdr", **laid_out(np.ones((1, 1)))))
        wait_until(lambda: stream.received == 1)
        server.put({"op": "unadvertise", "channelIds": [3]}, Hangup())
        wait_until(lambda: stream.state == "lost")
        assert "nobody sends the topic any more" in stream.changes[-1].words or "no topic" in stream.changes[-1].words
        stream.close()


@pytest.mark.parametrize(
    ("told", "words"),
    [
        ({"encoding": "protobuf"}, "messages encoded as 'protobuf' cannot be read; cdr, ros1, json can"),
        ({"schema": "$$"}, "the definition of std_msgs/msg/Float32MultiArray cannot be read"),
        ({"schemaName": "x y"}, "'x y' is no name of a message's type"),
    ],
)
def test_channels_that_cannot_be_read_are_told(told: Any, words: str) -> None:
    with FoxgloveServer([channel("/skin", ARRAY) | told]) as server:
        source = source_at(f"foxglove://127.0.0.1:{server.port}/skin")
        with pytest.raises(InputError, match=r"^foxglove://127\.0\.0\.1:\d+/skin: " + words):
            source.open()
        source.close()


def test_messages_that_nobody_understands_are_told() -> None:
    with FoxgloveServer([channel("/text", "std_msgs/msg/String")]) as server:
        source = source_at(f"foxglove://127.0.0.1:{server.port}/text")
        source.open()
        for _ in range(5):
            server.put_message(on_wire("std_msgs/msg/String", "cdr", data="hello"))
        with pytest.raises(InputError, match="std_msgs/msg/String is not understood: its fields are data;"):
            read_on(source)
        source.close()


def test_a_server_of_something_else_and_a_silent_one_are_told() -> None:
    with (
        silent_web_socket() as port,
        pytest.raises(LostSourceError, match=r"speaks none of foxglove\.sdk\.v1, foxglove"),
    ):
        source_at(f"foxglove://127.0.0.1:{port}/skin").open()


def test_a_server_that_leaves_is_told() -> None:
    with FoxgloveServer([channel("/skin", ARRAY)]) as server:
        source = source_at(f"foxglove://127.0.0.1:{server.port}/skin")
        source.open()
        server.put(Hangup())
        with pytest.raises(LostSourceError, match="has closed the connection"):
            read_on(source)
        source.close()


def test_the_makers_own_server_is_read() -> None:
    foxglove = pytest.importorskip("foxglove", reason="foxglove-sdk is not installed")
    frames = RNG.integers(0, 2**16, (100, 3, 4)).astype(np.uint16)
    context = foxglove.Context()
    server = foxglove.start_server(name="test", host="127.0.0.1", port=0, context=context)
    try:
        name = "sensor_msgs/msg/Image"
        schema = foxglove.Schema(name=name, encoding="ros2msg", data=text_of(name).encode())
        skin = foxglove.Channel("/skin", message_encoding="cdr", schema=schema, context=context)
        plain = foxglove.Channel("/plain", message_encoding="json", context=context)
        store = store_of(name)
        source = source_at(f"foxglove://127.0.0.1:{server.port}/skin")
        source.open()
        wait_until(skin.has_sinks)
        for number, frame in enumerate(frames):
            image = made(
                name, store, height=3, width=4, encoding="16UC1", step=8, data=np.frombuffer(frame.tobytes(), np.uint8)
            )
            skin.log(bytes_of(image, store), log_time=10**9 * (number + 1))
            time.sleep(0.001)
        samples = read_some(source, len(frames))
        source.close()
        np.testing.assert_array_equal([sample.pads["pad"] for sample in samples], frames)
        assert samples[4].device_time_s == 5.0
        source = source_at(f"foxglove://127.0.0.1:{server.port}/plain")
        source.open()
        wait_until(plain.has_sinks)
        content = base64.b64encode(frames[0].tobytes()).decode()
        plain.log({"width": 4, "height": 3, "step": 8, "encoding": "16UC1", "data": content})
        np.testing.assert_array_equal(read_some(source, 1)[0].pads["pad"], frames[0])
        source.close()
    finally:
        server.stop()


@pytest.mark.parametrize(
    ("address", "words"),
    [
        ("foxglove://h?dtype=uint8", "messages tell their types; dtype is for bare bytes"),
        ("foxglove://h?x=1", "foxglove has no option 'x'"),
        ("foxglove://h:0/t", "must be as foxglove://HOST:PORT/NAME"),
    ],
)
def test_addresses_that_cannot_be_are_told(address: str, words: str) -> None:
    with pytest.raises(InputError) as told:
        source_at(address)
    assert words in str(told.value)
