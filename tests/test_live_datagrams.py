"""Datagrams on a loopback socket: one reading each, and whatever else is sent to a port."""

from __future__ import annotations

import json
import socket
import sys
import time
from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from tests.live_scripted import wait_until

from varishold.cli import record
from varishold.cli.app import app
from varishold.errors import InputError, LostSourceError
from varishold.live import Sample, Source, Stream, lull, source_at
from varishold.live.sources import datagrams


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


def test_bytes_before_the_numbers_are_passed_over(port: int, sender: socket.socket) -> None:
    source = source_at(f"udp:127.0.0.1:{port}?dtype=int16&shape=1x3&skip=5")
    source.open()
    try:
        sender.send(b"12345" + np.array([7, -8, 9], "<i2").tobytes())
        assert _all(source, 1)[0].pads["pad"].tolist() == [[7, -8, 9]]
    finally:
        source.close()


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


@pytest.mark.skipif(sys.platform != "linux", reason="this system does not tell what it drops")
@pytest.mark.parametrize("options", ["dtype=uint8&shape=16x16", "preset=flexitac&shape=16x16"])
def test_what_came_and_what_was_lost_is_all_that_was_sent(
    port: int, sender: socket.socket, options: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(datagrams, "_KEPT", 1)
    source: Any = source_at(f"udp:127.0.0.1:{port}?{options}")
    content = b"\xaa\x55" * ("preset" in options) + bytes(256)
    came = 0
    # What was lost before it was opened anew counts on.
    for sent in (200, 400):
        source.open()
        for _ in range(200):
            sender.send(content)
        came += len(source.read(1.0)) + len(source.read(0.0))
        assert came + source.overrun == sent
        assert source.overrun > sent // 2
        source.close()


def test_a_burst_waits_here_while_it_is_understood(
    port: int, sender: socket.socket, monkeypatch: pytest.MonkeyPatch
) -> None:
    """What the system keeps is little, and what is read at once is not all that has come."""
    monkeypatch.setattr(datagrams, "_KEPT", 1 << 16)
    monkeypatch.setattr(datagrams, "_MOST_AT_ONCE", 2)
    source: Any = source_at(f"udp:127.0.0.1:{port}?dtype=uint8&shape=16x16")
    source.open()
    try:
        came = []
        for number in range(400):
            sender.send(bytes([number % 256]) * 256)
            if number % 20 == 19:
                came += source.read(0.0)
        came += _all(source, 400 - len(came))
    finally:
        source.close()
    assert source.overrun == 0
    assert [int(one.pads["pad"][0, 0]) for one in came] == [number % 256 for number in range(400)]
    assert all(first.host_time_s <= second.host_time_s for first, second in pairwise(came))


def test_what_waits_has_a_bound(port: int, sender: socket.socket, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(datagrams, "_WAITING", 1000)
    source: Any = source_at(f"udp:127.0.0.1:{port}?dtype=uint8&shape=16x16")
    source.open()
    try:
        for _ in range(20):
            sender.send(bytes(256))
        source._port.take()
        assert len(source._port._waiting) == 3
        assert len(_all(source, 19)) == 19
    finally:
        source.close()


@pytest.mark.parametrize(("platform", "told"), [("win32", bytes(36)), ("linux", None), ("linux", bytes(20))])
def test_of_a_system_that_does_not_tell_what_it_drops_nothing_is_known(
    platform: str, told: bytes | None, monkeypatch: pytest.MonkeyPatch
) -> None:
    def getsockopt(*_: int) -> bytes:
        if told is None:
            raise OSError("no such option")
        return told

    monkeypatch.setattr(datagrams.sys, "platform", platform)
    asked: Any = SimpleNamespace(getsockopt=getsockopt)
    assert datagrams._dropped(asked) == 0


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


FRAMING = """
dtype = "uint16"
shape = [4, 5]
head = "A5 5A ?? ??"
sequence = { at = 2, dtype = "uint16" }
"""


def test_numbers_behind_a_head_come_by_a_framing_and_what_is_cut_spoils_no_other(
    port: int, sender: socket.socket, tmp_path: Path
) -> None:
    (tmp_path / "mine.toml").write_text(FRAMING)
    frames = np.random.default_rng(1).integers(0, 4000, (40, 4, 5)).astype("<u2")
    source = source_at(f"udp:127.0.0.1:{port}?framing={tmp_path / 'mine.toml'}&pitch_m=0.002")
    source.open()
    try:
        came: list[Sample] = []
        for number, frame in enumerate(frames):
            if number % 7 == 3:
                sender.send(b"\xa5\x5a\0\0" + frame.tobytes()[:-3])
            sender.send(b"\xa5\x5a" + number.to_bytes(2, "little") + frame.tobytes())
            came += source.read(0)
        came += _all(source, len(frames) - len(came))
    finally:
        source.close()
    assert [sample.sequence for sample in came] == list(range(len(frames)))
    assert np.array_equal([sample.pads["pad"] for sample in came], frames)
    assert source.pads["pad"].pitch_m == (0.002, 0.002)


@pytest.mark.parametrize("pieces", [2, 3])
def test_a_frame_may_go_through_several_datagrams(port: int, sender: socket.socket, pieces: int) -> None:
    """As a bridge from a cable to a network sends it."""
    frames = np.random.default_rng(2).integers(0, 255, (20, 4, 4)).astype(np.uint8)
    source = source_at(f"udp:127.0.0.1:{port}?preset=matsense-simple&shape=4x4")
    source.open()
    try:
        for frame in frames:
            content = frame.tobytes() + b"\xff"
            for k in range(pieces):
                sender.send(content[len(content) * k // pieces : len(content) * (k + 1) // pieces])
        # The first tail tells where the second frame begins.
        came = _all(source, len(frames) - 1)
    finally:
        source.close()
    assert np.array_equal([sample.pads["pad"] for sample in came][-19:], frames[1:])


@pytest.mark.parametrize(
    ("options", "size", "words"),
    [
        (
            "dtype=uint16&shape=4x5",
            44,
            "22 values came, which are no 4 x 5, .*does the address say another than is sent",
        ),
        ("dtype=uint16&shape=4x5", 41, "41 bytes are no row of uint16; does the address say another than is sent"),
        ("shape=4x5", 40, r"40 bytes came that are no JSON; add \?dtype=TYPE"),
    ],
)
def test_the_remedy_is_not_what_the_address_says_already(
    port: int, sender: socket.socket, options: str, size: int, words: str
) -> None:
    source = source_at(f"udp:127.0.0.1:{port}?{options}")
    source.open()
    try:
        for _ in range(5):
            sender.send(b"\xff" * size)
        with pytest.raises(LostSourceError, match=words):
            _all(source, 1)
    finally:
        source.close()


def test_a_silent_port_is_told_once_and_a_speaking_one_is_not(
    port: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(lull, "_SILENT_S", 0.2)
    monkeypatch.setattr(record, "_PATIENCE_S", 0.5)
    words = ["record", f"udp:127.0.0.1:{port}", "-o", str(tmp_path / "a.mcap"), "--seconds", "0.3"]
    assert CliRunner().invoke(app, words).stderr.count("no reading has come in 0 s; waiting") == 1
    words = ["record", "sim:sphere?rate_hz=50", "-o", str(tmp_path / "b.mcap"), "--seconds", "0.6"]
    assert CliRunner().invoke(app, words).stderr == ""


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
        ("udp::70000", "must be as udp:HOST:PORT, got ':70000'; a port is a number from 1 to 65535"),
        ("udp::9000/skin", "a port has no path, got 'skin'"),
        ("udp::9000?dtype=object", "dtype must be one of"),
        ("udp::9000?shape=3", "shape must be rows x columns"),
        ("udp::9000?port=4", "udp has no option 'port'"),
        ("udp::9000?preset=matsense&dtype=uint8", "udp has no option 'dtype'"),
        ("udp::9000?preset=nobody", "nobody"),
        ("udp::9000?skip=4", "skip is of bare numbers: say their dtype"),
        ("udp::9000?dtype=uint8&skip=-1", "skip must be"),
    ],
)
def test_what_cannot_be_is_told(text: str, words: str) -> None:
    with pytest.raises((InputError, LostSourceError), match=words):
        source_at(text).open()
