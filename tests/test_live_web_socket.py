"""Readings from WebSockets: what a server sends is what is read; what is none is counted; who is gone is told."""

from __future__ import annotations

import json
import os
import re
import socket
import threading
import time
from contextlib import suppress
from http.server import BaseHTTPRequestHandler, HTTPServer
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from tests.live_reading import read_on, read_some
from tests.live_scripted import wait_until
from tests.live_servers import Hangup, SocketServer
from websockets.utils import accept_key

from benchmarks._silent_servers import silent_web_socket
from varishold.errors import InputError, LostSourceError
from varishold.live import Stream, source_at, web_sockets

RNG = np.random.default_rng(3)


def xela(number: int, counts: np.ndarray, *, time_s: float = 0.0, forces: np.ndarray | None = None) -> dict[str, Any]:
    """A reading of XELA's server: counts of shape (rows, cols, 3)."""
    sensor = {
        "time": time_s,
        "sensor": "1",
        "model": f"uSPa{counts.shape[0]}{counts.shape[1]}",
        "taxels": counts.size // 3,
        "data": ",".join(f"{count:04X}" for count in counts.ravel()),
    }
    if forces is not None:
        sensor["calibrated"] = forces.ravel().tolist()
    return {"message": number, "type": "routine", "1": sensor}


WELCOME = {"message": "Welcome", "client": "127.0.0.1", "version": "1.7.6"}


def test_what_xela_sends_is_what_is_read() -> None:
    frames = RNG.integers(0, 2**16, (300, 4, 6, 3))
    with SocketServer() as server:
        server.put(WELCOME, *(xela(k, frame, time_s=1e9 + k / 100) for k, frame in enumerate(frames)))
        source = source_at(f"ws://127.0.0.1:{server.port}")
        assert dict(source.pads) == {}
        source.open()
        before_s = time.time()
        samples = read_some(source, 300)
        source.close()
    assert [sample.sequence for sample in samples] == list(range(300))
    np.testing.assert_array_equal([sample.pads["1"] for sample in samples], frames[..., 2])
    np.testing.assert_array_equal([sample.pads["shear.1"] for sample in samples], frames[..., :2].reshape(300, -1))
    assert [sample.device_time_s for sample in samples] == [1e9 + k / 100 for k in range(300)]
    assert all(before_s - 5 < sample.host_time_s < time.time() + 5 for sample in samples)
    layout = source.pads["1"]
    assert (layout.shape, layout.kind, layout.unit) == ((4, 6), "pressure", "raw")
    assert (source.pads["shear.1"].kind, source.pads["shear.1"].names[:3]) == ("signals", ("x0", "y0", "x1"))


def test_calibrated_forces_go_before_counts() -> None:
    forces = RNG.normal(size=(4, 4, 3))
    with SocketServer() as server:
        server.put(xela(1, np.zeros((4, 4, 3), int), forces=forces))
        source = source_at(f"ws://localhost:{server.port}/")
        source.open()
        (sample,) = read_some(source, 1)
        source.close()
    np.testing.assert_array_equal(sample.pads["1"], forces[..., 2])
    assert source.pads["1"].unit == "N"


@pytest.mark.parametrize(
    ("options", "sent", "pads"),
    [
        ("?shape=2x3", [1, 2, 3, 4, 5, 6], {"pad": [[1, 2, 3], [4, 5, 6]]}),
        ("", [[1, 2.5], [3, 4]], {"pad": [[1, 2.5], [3, 4]]}),
        ("", {"left": [[1, 2]], "right": [[3, 4]]}, {"left": [[1, 2]], "right": [[3, 4]]}),
        ("?field=msg.skin", {"op": "publish", "msg": {"skin": [7, 8]}}, {"pad": [7, 8]}),
        ("?dtype=uint16&shape=1x2", np.array([1, 65535], "<u2").tobytes(), {"pad": [[1, 65535]]}),
        ("?dtype=float32", np.array([1.5], "<f4").tobytes(), {"pad": [1.5]}),
    ],
)
def test_plain_values_are_read(options: str, sent: Any, pads: Any) -> None:
    with SocketServer() as server:
        server.put(sent)
        source = source_at(f"ws://127.0.0.1:{server.port}{options}")
        source.open()
        (sample,) = read_some(source, 1)
        source.close()
    assert {name: values.tolist() for name, values in sample.pads.items()} == pads


def test_wrong_messages_are_counted_and_passed_over() -> None:
    good = [xela(k, np.full((2, 2, 3), k)) for k in range(40)]
    wrong = [
        "{",
        "[1, 2",
        "[]]",
        '"text"',
        "null",
        "17",
        b"\xff\x00\x01nonsense",
        '{"1": {"sensor": "1", "model": "uSPa22", "taxels": 4, "data": "12,13"}}',
        '{"1": {"sensor": "1", "model": "uSPa22", "taxels": 4, "data": "zz,13"}}',
        "[" * 5000,
        '{"data": NaN}',
        '{"data": [1, "two"]}',
        '{"data": 1e999}',
    ]
    with SocketServer() as server:
        for number, message in enumerate(good):
            server.put(message, *wrong[number : number + 1])
        source = source_at(f"ws://127.0.0.1:{server.port}")
        source.open()
        samples = read_some(source, 40)
        source.close()
    assert [sample.sequence for sample in samples] == list(range(40))
    assert source.damaged == len(wrong)
    assert "data" in source.damage


@settings(max_examples=1, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.lists(st.binary(max_size=40) | st.text(max_size=40), min_size=200, max_size=200))
def test_nonsense_between_readings_is_survived(nonsense: list[str | bytes]) -> None:
    with SocketServer() as server:
        for number, junk in enumerate(nonsense):
            server.put(xela(number, np.full((2, 2, 3), number)), junk)
        source = source_at(f"ws://127.0.0.1:{server.port}")
        source.open()
        samples = [sample for sample in read_some(source, 200) if sample.sequence is not None]
        source.close()
    assert [sample.sequence for sample in samples] == list(range(200))


@pytest.mark.parametrize(
    ("options", "sent", "words"),
    [
        ("", {"a": [1, 2, 3]}, r"is not understood: its fields are a\[3\]; .* add \?field=NAME to the address"),
        ("?shape=2x2", [1, 2, 3], r"3 values came, which are no 2 x 2, .* does the address say another"),
        ("?field=q", {"a": 1}, "has no array of numbers called 'q'"),
        ("", b"\xff\xfe", r"2 bytes came that are no JSON; add \?dtype=TYPE"),
        ("?dtype=float64", b"123", "3 bytes are no row of float64"),
        ("", "true", "a message has fields, and bool has none"),
    ],
)
def test_what_nobody_understands_is_told(options: str, sent: Any, words: str) -> None:
    with SocketServer() as server:
        server.put(*[sent] * 5)
        source = source_at(f"ws://127.0.0.1:{server.port}{options}")
        source.open()
        with pytest.raises(InputError, match=words) as told:
            read_some(source, 1)
        source.close()
    assert str(told.value).startswith(f"ws://127.0.0.1:{server.port}")


def test_a_server_that_leaves_is_told_and_comes_back() -> None:
    with SocketServer() as server:
        server.put(xela(1, np.zeros((2, 2, 3), int)), Hangup())
        source = source_at(f"ws://127.0.0.1:{server.port}")
        source.open()
        assert read_some(source, 1)[0].sequence == 1
        with pytest.raises(LostSourceError, match=r"^ws://127\.0\.0\.1:\d+: has closed the connection"):
            read_on(source)
        with pytest.raises(LostSourceError, match=r"is not open|has closed"):
            source.read(0.0)
        source.close()
        source.close()
        with pytest.raises(LostSourceError, match="is not open"):
            source.read(0.0)


def test_a_stream_finds_a_server_that_was_started_anew() -> None:
    with SocketServer() as server:
        port = server.port
        server.put(xela(1, np.zeros((2, 2, 3), int)))
        stream = Stream(source_at(f"ws://127.0.0.1:{port}"))
        stream.start()
        wait_until(lambda: stream.received == 1)
    wait_until(lambda: stream.state == "lost")
    with SocketServer(port=port) as server:
        server.put(xela(2, np.zeros((2, 2, 3), int)))
        wait_until(lambda: stream.received == 2)
        stream.close()
    assert [change.state for change in stream.changes][:4] == ["opening", "open", "lost", "open"]


def test_silence_behind_a_pulled_cable_is_told() -> None:
    with silent_web_socket() as port:
        source = source_at(f"ws://127.0.0.1:{port}")
        source.open()
        with pytest.raises(LostSourceError, match=r"has been silent for \d+\.\d s and does not answer"):
            read_on(source)
        source.close()


def test_a_message_may_be_longer_on_its_way_than_a_silence_lasts(monkeypatch: pytest.MonkeyPatch) -> None:
    """As a depth map is through a slow radio link: the server cannot answer in the middle of it."""
    monkeypatch.setattr(web_sockets, "_ANSWER_S", 0.4)
    content = b"[[1, 2], [3, 4]]".ljust(90)
    with silent_web_socket(b"\x81" + bytes([len(content)]) + content) as port:
        source = source_at(f"ws://127.0.0.1:{port}")
        source.open()
        (one,) = read_some(source, 1)
        with pytest.raises(LostSourceError, match=r"has been silent for \d+\.\d s and does not answer"):
            read_on(source)
        source.close()
    assert one.pads["pad"].tolist() == [[1, 2], [3, 4]]


def test_a_message_that_never_ends_is_given_up() -> None:
    def flood(server: socket.socket) -> None:
        peer, _ = server.accept()
        with peer, suppress(OSError):
            key = re.search(rb"Sec-WebSocket-Key: (\S+)", peer.recv(4096), re.IGNORECASE)
            assert key is not None
            accepted = accept_key(key[1].decode())
            peer.sendall(b"HTTP/1.1 101 Switching Protocols\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n")
            peer.sendall(f"Sec-WebSocket-Accept: {accepted}\r\n\r\n".encode())
            piece = b"\x7f" + (1 << 20).to_bytes(8, "big") + bytes(1 << 20)
            peer.sendall(b"\x02" + piece)
            while True:
                peer.sendall(b"\x00" + piece)

    with socket.create_server(("127.0.0.1", 0)) as server:
        sending = threading.Thread(target=flood, args=(server,), daemon=True)
        sending.start()
        source = source_at(f"ws://127.0.0.1:{server.getsockname()[1]}")
        source.open()
        with pytest.raises(LostSourceError, match="message too big"):
            read_on(source)
        source.close()
        sending.join()


def test_a_server_with_nothing_to_say_is_not_lost(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(web_sockets, "_ANSWER_S", 1.0)
    with SocketServer() as server:
        source = source_at(f"ws://127.0.0.1:{server.port}")
        source.open()
        ends_s = time.monotonic() + 2.0
        while time.monotonic() < ends_s:
            assert source.read(0.2) == []
        source.close()


def test_nobody_there_and_somebody_else_are_told() -> None:
    free = socket.create_server(("127.0.0.1", 0))
    port = free.getsockname()[1]
    free.close()
    with pytest.raises(LostSourceError, match=f"^ws://127.0.0.1:{port}: nobody answers"):
        source_at(f"ws://127.0.0.1:{port}").open()
    web = HTTPServer(("127.0.0.1", 0), BaseHTTPRequestHandler)
    thread = threading.Thread(target=web.handle_request)
    web.RequestHandlerClass.log_message = lambda *_: None  # type: ignore[assignment]
    thread.start()
    with pytest.raises(LostSourceError, match="no such WebSocket is served there"):
        source_at(f"ws://127.0.0.1:{web.server_port}").open()
    thread.join()
    web.server_close()


def test_a_reader_that_is_slow_fills_no_memory() -> None:
    sent: list[int] = []
    ends = threading.Event()
    big = json.dumps({"data": [0] * 100_000})

    class Flood(SocketServer):
        def greet(self, connection: Any) -> None:
            with suppress(Exception):
                while not ends.is_set():
                    connection.send(big)
                    sent.append(1)

    with Flood() as server:
        source = source_at(f"ws://127.0.0.1:{server.port}")
        source.open()
        assert len(source.read(5.0)) >= 1
        wait_until(lambda: stands_still(sent))
        assert len(sent) * len(big) < 1 << 26
        ends.set()
        source.close()


def test_names_that_never_come_twice_fill_no_memory() -> None:
    with SocketServer() as server:
        source = source_at(f"ws://127.0.0.1:{server.port}")
        source.open()
        for number in range(12):
            server.put({"sensors": [{"name": f"{number}-{k}", "values": [k]} for k in range(100)]})
        server.put({"sensors": [{"name": "0-0", "values": [5]}]})
        samples = read_some(source, 11)
        source.close()
    assert samples[-1].pads["0-0"].tolist() == [5]
    assert len(source.pads) == 1000
    assert "more than 1024 are known" in source.damage


def stands_still(sent: list[int]) -> bool:
    before = len(sent)
    time.sleep(0.3)
    return len(sent) == before


@pytest.mark.parametrize(
    ("address", "words"),
    [
        ("ws://", "ws://: must name a host, as in ws://localhost:5000"),
        ("ws://a b", "ws://a b: must be as ws://HOST:PORT/NAME, got 'a b'"),
        ("ws://h:99999", "must be as ws://HOST:PORT/NAME"),
        ("ws://h?speed=1", "ws has no option 'speed'; known are shape, field, dtype"),
        ("ws://h?shape=4", "shape must be rows x columns"),
        ("ws://h?dtype=int", "dtype must be one of uint8, int8,"),
    ],
)
def test_addresses_that_cannot_be_are_told(address: str, words: str) -> None:
    with pytest.raises(InputError) as told:
        source_at(address)
    assert words in str(told.value)


def test_a_peer_that_greets_with_nonsense_and_leaves_is_told_in_one_line(capfd: pytest.CaptureFixture[str]) -> None:
    peer = socket.create_server(("127.0.0.1", 0))
    over = threading.Event()

    def greet() -> None:
        while not over.is_set():
            with suppress(OSError):
                met, _ = peer.accept()
                met.sendall(os.urandom(4096))
                met.close()

    thread = threading.Thread(target=greet, daemon=True)
    thread.start()
    source = source_at(f"ws://127.0.0.1:{peer.getsockname()[1]}")
    for _ in range(60):
        with pytest.raises(LostSourceError):
            source.open()
        source.close()
    over.set()
    peer.close()
    # The library that carries it says nothing of itself either.
    assert capfd.readouterr().err == ""


def test_a_library_that_stumbles_over_a_peer_is_a_lost_source(monkeypatch: pytest.MonkeyPatch) -> None:
    def stumbles(*_: object, **__: object) -> None:
        raise AssertionError

    monkeypatch.setattr("websockets.sync.client.connect", stumbles)
    with pytest.raises(
        LostSourceError, match=r"^ws://127\.0\.0\.1:9: nobody answers: the connection was closed at once"
    ):
        source_at("ws://127.0.0.1:9").open()
