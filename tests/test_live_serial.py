"""Skins on a serial port: each preset through a pair of pseudo-terminals, and what befalls a cable."""

from __future__ import annotations

import os
import select
import sys
import threading
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from tests.live_scripted import wait_until

from benchmarks._skin_senders import SENDERS, Frame, frames_of
from varishold.errors import InputError, LostSourceError
from varishold.live import Reader, Sample, Source, Stream, source_at
from varishold.live.recorder import Recorder
from varishold.live.sources import serial_port

pytest.importorskip("serial", reason="needs pyserial")
if sys.platform == "win32":
    pytest.skip("needs pseudo-terminals", allow_module_level=True)

REQUEST = bytes.fromhex("AAAAAA200100008F83")


class Cable:
    """A skin's end of a cable, and the port's name at the other; it can be pulled and put in again."""

    def __init__(self, folder: Path) -> None:
        self.port = folder / "port"
        self.skin = -1
        self.plug()

    def plug(self) -> None:
        import tty

        self.skin, other = os.openpty()
        tty.setraw(other)
        os.set_blocking(self.skin, False)
        self.port.unlink(missing_ok=True)
        self.port.symlink_to(os.ttyname(other))
        os.close(other)

    def pull(self) -> None:
        if self.skin >= 0:
            os.close(self.skin)
        self.skin = -1
        self.port.unlink(missing_ok=True)

    def write(self, data: bytes, limit_s: float = 30.0) -> None:
        """Write all of it, as fast as the other end reads."""
        ends_s = time.monotonic() + limit_s
        while data:
            assert time.monotonic() < ends_s, f"{len(data)} bytes were not taken"
            if select.select([], [self.skin], [], 0.1)[1]:
                data = data[os.write(self.skin, data[:1024]) :]

    def read(self) -> bytes:
        if not select.select([self.skin], [], [], 0.02)[0]:
            return b""
        try:
            return os.read(self.skin, 4096)
        except OSError:
            # Nobody has the port open at this moment.
            time.sleep(0.01)
            return b""


@pytest.fixture
def cable(tmp_path: Path) -> Iterator[Cable]:
    made = Cable(tmp_path)
    yield made
    made.pull()


def _sent(name: str, frames: list[Frame]) -> list[bytes]:
    return [SENDERS[name].bytes_of(frame) for frame in frames]


def _is_same(sample: Sample, frame: Frame) -> bool:
    return set(sample.pads) == set(frame) and all(np.array_equal(sample.pads[pad], frame[pad]) for pad in frame)


def _read_up_to(reader: Reader, count: int, came: list[Sample]) -> None:
    """Read until so many have come."""
    while len(came) < count:
        more = reader.read(20)
        assert more, f"{len(came)} of {count} came"
        came += more


@pytest.mark.parametrize("name", sorted(set(SENDERS) - {"weiss-wsg"}))
def test_frames_are_what_was_sent(cable: Cable, name: str) -> None:
    frames = frames_of(name, 60)
    shape = "&shape=6x6" if name == "arduino-line" else ""
    with Stream(source_at(f"serial:{cable.port}?preset={name}{shape}")) as stream:
        assert stream.wait_open(20)
        reader = stream.reader()
        # The blank line, the head or the next frame tells of some that they are complete.
        data = b"".join(_sent(name, frames))
        cable.write(data)
        first = 1 if name == "arduino-rows" else 0
        came: list[Sample] = []
        _read_up_to(reader, len(frames) - first, came)
    assert all(_is_same(sample, frame) for sample, frame in zip(came, frames[first:], strict=True))
    assert reader.missed == 0
    assert abs(came[-1].host_time_s - time.time()) < 60
    for pad, values in came[-1].pads.items():
        assert stream.pads[pad].shape == values.shape


def _answer(cable: Cable, answers: list[bytes], wanted: threading.Event) -> None:
    """Answer every request with the next answer."""
    asked = b""
    while not wanted.is_set() and answers:
        asked += cable.read()
        if REQUEST in asked:
            asked = asked.split(REQUEST, 1)[1]
            cable.write(answers.pop(0))


def test_a_skin_that_wants_to_be_asked_is_asked(cable: Cable) -> None:
    frames = frames_of("weiss-wsg", 40)
    answers = _sent("weiss-wsg", frames)
    # One with an error for its status, one that is cut off, and one with a wrong checksum: asked again.
    answers.insert(3, answers[3][:6] + b"\x01" + answers[3][7:])
    answers.insert(9, answers[9][:30])
    answers.insert(20, answers[20][:20] + b"\xff\xff" + answers[20][22:])
    done = threading.Event()
    answering = threading.Thread(target=_answer, args=(cable, answers, done))
    with Stream(source_at(f"serial:{cable.port}?preset=weiss-wsg")) as stream:
        assert stream.wait_open(20)
        reader = stream.reader()
        answering.start()
        came: list[Sample] = []
        _read_up_to(reader, len(frames), came)
        done.set()
        answering.join()
    assert all(_is_same(sample, frame) for sample, frame in zip(came, frames, strict=True))


@pytest.mark.parametrize("name", ["flexitac", "anyskin", "matsense", "jq-glove", "arduino-rows"])
def test_damaged_bytes_are_survived(cable: Cable, name: str) -> None:
    frames = frames_of(name, 200)
    data = np.frombuffer(b"".join(_sent(name, frames)), np.uint8).copy()
    rng = np.random.default_rng(1)
    hit = rng.random(data.size) < 1e-3
    data[hit] = rng.integers(0, 256, int(hit.sum()), np.uint8)
    with Stream(source_at(f"serial:{cable.port}?preset={name}")) as stream:
        assert stream.wait_open(20)
        cable.write(data.tobytes())
        cable.write(b"".join(_sent(name, frames[:5])))
        reader, came = stream.reader(), []
        while more := reader.read(0.5):
            came += more
        assert stream.state == "open"
        same = sum(any(_is_same(sample, frame) for sample in came[-8:]) for frame in frames[:4])
    assert same >= 3
    assert len(came) > 100


def test_a_pulled_cable_is_told_and_comes_back(cable: Cable) -> None:
    frames = frames_of("flexitac", 6)
    with Stream(source_at(f"serial:{cable.port}?preset=flexitac")) as stream:
        reader = stream.reader()
        assert stream.wait_open(20)
        cable.write(b"".join(_sent("flexitac", frames[:3])))
        came: list[Sample] = []
        _read_up_to(reader, 3, came)
        pulled_s = time.time()
        cable.pull()
        wait_until(lambda: stream.state == "lost")
        told_s = next(change.host_time_s for change in stream.changes if change.state == "lost")
        # A second is what is promised; a busy machine is given more.
        assert told_s - pulled_s < 5
        wait_until(lambda: "there is no such port" in stream.words)
        cable.plug()
        wait_until(lambda: stream.state == "open")
        cable.write(b"".join(_sent("flexitac", frames[3:])))
        _read_up_to(reader, 6, came)
    assert all(_is_same(sample, frame) for sample, frame in zip(came, frames, strict=True))
    assert "the port is gone" in " ".join(change.words for change in stream.changes)


def _chatter(cable: Cable, source: Source) -> None:
    for _ in range(1000):
        cable.write(b"ets Jun  8 2016 00:22:57\r\nrst:0x1 (POWERON_RESET)\r\n" * 20)
        source.read(0.05)


def test_what_is_no_frame_is_told(cable: Cable, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("varishold.live.framed._PATIENCE_S", 0.1)
    source = source_at(f"serial:{cable.port}?preset=jq-mat-32")
    source.open()
    try:
        with pytest.raises(LostSourceError, match="and no frame in them; is it another preset, shape or baud"):
            _chatter(cable, source)
    finally:
        source.close()
        source.close()


def test_a_recording_that_ends_without_a_whole_frame_says_what_came(cable: Cable, tmp_path: Path) -> None:
    def some_bytes() -> None:
        time.sleep(0.3)
        cable.write(b"\xaa\x55" + bytes(30))

    out = tmp_path / "a.mcap"
    source = source_at(f"serial:{cable.port}?preset=flexitac")
    sending = threading.Thread(target=some_bytes)
    sending.start()
    with Recorder(Stream(source).start(), out) as recorder:
        wait_until(lambda: recorder.damage == "32 bytes came and no whole frame in them")
    sending.join()
    assert not out.exists()


def test_a_port_in_use_is_told(cable: Cable) -> None:
    first, second = (source_at(f"serial:{cable.port}?preset=flexitac") for _ in range(2))
    first.open()
    try:
        with pytest.raises(LostSourceError, match="the port is in use by another program"):
            second.open()
    finally:
        first.close()
    second.open()
    second.close()
    with pytest.raises(LostSourceError, match="is not open"):
        second.read(0)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("serial:", "name the port, as in serial:/dev/ttyACM0?preset=flexitac"),
        ("serial:/dev/x", "say what it sends: ?preset= with one of anyskin"),
        ("serial:/dev/x?preset=flexitac&framing=a.toml", "give preset or framing, not both"),
        ("serial:/dev/x?preset=nobody", "nobody: is no framing file (TOML) and no preset; presets are anyskin"),
        ("serial:/dev/x?framing=missing.toml", "missing.toml"),
        ("serial:/dev/x?preset=flexitac&baud=fast", "baud must be a number from 50 to"),
        ("serial:/dev/x?preset=flexitac&shape=0x9", "shape must be rows x columns"),
        ("serial:/dev/x?preset=jq-glove&shape=8x8", "shape cannot be given: this framing has the pads"),
        ("serial:/dev/x?preset=flexitac&parity=even", "serial has no option 'parity'; known are preset, framing"),
        ("serial:/dev/x?preset=flexitac&pitch_m=0", "pitch_m must be a number from"),
    ],
)
def test_what_cannot_be_is_told(text: str, words: str) -> None:
    with pytest.raises(InputError) as told:
        source_at(text)
    assert words in str(told.value)


def test_options_go_on_top() -> None:
    source = source_at("serial:/dev/x?preset=flexitac&shape=16x32&pitch_m=0.002&baud=9600")
    assert source.pads["pad"].shape == (16, 32)
    assert source.pads["pad"].pitch_m == (0.002, 0.002)
    assert isinstance(source, serial_port.SerialPort)
    assert source._framing.baud == 9600
    signals = source_at("serial:/dev/x?preset=anyskin&shape=2x4").pads["pad"]
    assert signals.shape == (8,)


def test_a_port_that_is_not_there_and_one_that_may_not_be_opened(tmp_path: Path) -> None:
    with pytest.raises(LostSourceError, match="there is no such port; varishold sources lists"):
        source_at(f"serial:{tmp_path}/none?preset=flexitac").open()
    (tmp_path / "file").write_text("no port")
    for none in (tmp_path / "file", tmp_path, "/dev/null"):
        with pytest.raises(InputError, match=f"{none} is no serial port; varishold sources lists those that are"):
            source_at(f"serial:{none}?preset=flexitac").open()
