"""Datagrams on a loopback socket: one reading each, and whatever else is sent to a port."""

from __future__ import annotations

import json
import socket
import time
from collections.abc import Iterator

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from tests.live_scripted import wait_until

from varishold.errors import InputError, LostSourceError
from varishold.live import Sample, Source, Stream, source_at


@pytest.fixture
def port() -> int:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


@pytest.fixture
def sender(port: int) -> Iterator[socket.socket]:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as made:
        made.connect(("127.0.0.1", port))
        yield made


def _all(source: Source, count: int) -> list[Sample]:
    came: list[Sample] = []
    ends_s = time.monotonic() + 20
    while len(came) < count:
        assert time.monotonic() < ends_s, f"{len(came)} of {count} came"
        came += source.read(0.05)
    return came


@pytest.mark.parametrize("dtype", ["uint8", "int16", "float32", "float64"])
def test_bare_numbers_come_as_they_were_sent(port: int, sender: socket.socket, dtype: str) -> None:
    frames = np.random.default_rng(0).normal(100, 30, (100, 6, 7)).astype(dtype)
    source = source_at(f"udp:127.0.0.1:{port}?dtype={dtype}&shape=6x7")
    source.open()
    try:
        came: list[Sample] = []
        for frame in frames:
            sender.send(frame.astype(frame.dtype.newbyteorder("<")).tobytes())
            came += source.read(0)
        came += _all(source, len(frames) - len(came))
    finally:
        source.close()
    assert np.array_equal([sample.pads["pad"] for sample in came], frames)
    assert came[0].pads["pad"].dtype == frames.dtype
    assert source.pads["pad"].shape == (6, 7)


def test_json_comes_with_its_time(port: int, sender: socket.socket) -> None:
    with Stream(source_at(f"udp:127.0.0.1:{port}")) as stream:
        assert stream.wait_open(20)
        reader = stream.reader()
        for number in range(20):
            said = {"left": [[number, 2.5], [3, 4]], "right": [[5, 6, 7]] * 2, "time_s": number / 10}
            sender.send(json.dumps(said).encode())
        came: list[Sample] = []
        while len(came) < 20:
            more = reader.read(20)
            assert more
            came += more
    assert [sample.device_time_s for sample in came] == pytest.approx(np.arange(20) / 10)
    assert came[7].pads["left"].tolist() == [[7, 2.5], [3, 4]]
    assert came[7].pads["right"].shape == (2, 3)


@given(content=st.one_of(st.binary(max_size=300), st.text(max_size=100).map(str.encode)))
@settings(max_examples=30, suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_whatever_is_sent_is_survived(port: int, sender: socket.socket, content: bytes) -> None:
    source = source_at(f"udp:127.0.0.1:{port}")
    source.open()
    try:
        sender.send(b"[[1, 2], [3, 4]]")
        sender.send(content)
        sender.send(b"[[5, 6], [7, 8]]")
        came: list[Sample] = []
        while not came or came[-1].pads["pad"].tolist() != [[5, 6], [7, 8]]:
            came += _all(source, 1)
        assert came[0].pads["pad"].tolist() == [[1, 2], [3, 4]]
    finally:
        source.close()


def test_what_nobody_understands_is_told_and_the_next_sender_is_heard(port: int, sender: socket.socket) -> None:
    with Stream(source_at(f"udp:127.0.0.1:{port}")) as stream:
        assert stream.wait_open(20)
        for _ in range(5):
            sender.send(b"\xff\xfe nonsense")
        wait_until(lambda: any(change.state == "lost" for change in stream.changes))
        told = " ".join(change.words for change in stream.changes)
        assert "add ?dtype=TYPE to the address" in told
        wait_until(lambda: stream.state == "open")
        sender.send(b"[[1, 2], [3, 4]]")
        assert stream.reader().read(20)


def test_a_port_in_use_is_told(port: int) -> None:
    first, second = source_at(f"udp:127.0.0.1:{port}"), source_at(f"udp:127.0.0.1:{port}")
    first.open()
    try:
        with pytest.raises(LostSourceError, match=f"cannot listen at port {port} "):
            second.open()
        assert first.read(0.01) == []
    finally:
        first.close()
        first.close()
    with pytest.raises(LostSourceError, match="is not open"):
        first.read(0)
    with pytest.raises(LostSourceError, match="cannot listen"):
        source_at("udp:nowhere.invalid:9000").open()


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("udp:9000", "the port stands behind a colon, as in udp::9000"),
        ("udp::70000", "must be as udp://HOST:PORT"),
        ("udp::9000/skin", "a port has no path, got 'skin'"),
        ("udp::9000?dtype=object", "dtype must be one of"),
        ("udp::9000?shape=3", "shape must be rows x columns"),
        ("udp::9000?port=4", "udp has no option 'port'"),
    ],
)
def test_what_cannot_be_is_told(text: str, words: str) -> None:
    with pytest.raises((InputError, LostSourceError), match=words):
        source_at(text).open()
