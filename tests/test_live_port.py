"""A serial port that does what a test tells it: how it is opened, read, asked and lost."""

from __future__ import annotations

import errno
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from tests.live_clock import Clock
from tests.test_live_framing import _sent as frames_sent

from varishold.errors import LostSourceError
from varishold.live import source_at
from varishold.live.framing import framing_of
from varishold.live.sources import serial_port


class Port:
    """A port that gives what a test puts, at most so much at once."""

    def __init__(self, clock: Clock) -> None:
        self._clock, self.timeout, self.came, self.sent = clock, 0.0, b"", []  # type: ignore[var-annotated]
        self.closed, self.fault = 0, None  # type: ignore[var-annotated]

    @property
    def in_waiting(self) -> int:
        return len(self.came)

    def read(self, size: int) -> bytes:
        if self.fault is not None:
            raise self.fault
        if not self.came:
            self._clock.sleep(self.timeout)
        taken, self.came = self.came[:size], self.came[size:]
        return taken

    def write(self, data: bytes) -> None:
        self.sent.append(data)

    def close(self) -> None:
        self.closed += 1
        if self.fault is not None:
            raise self.fault


def _opened(clock: Clock, text: str) -> tuple[Any, Port, list[Any]]:
    source, port, how = source_at(text), Port(clock), []  # type: ignore[var-annotated]
    source._serial = SimpleNamespace(Serial=lambda *given, **named: how.append((given, named)) or port)  # type: ignore[attr-defined]
    source.open()
    return source, port, how


def test_a_port_is_opened_for_this_program_alone_and_read_whole(monkeypatch: pytest.MonkeyPatch) -> None:
    clock = Clock(monkeypatch, serial_port)
    source, port, ((given, named),) = _opened(clock, "serial:/dev/x?preset=flexitac&shape=2x2&baud=9600")
    assert given == ("/dev/x", 9600)
    assert (named["exclusive"], named["timeout"]) == (True, 0)
    assert 0.5 < named["write_timeout"] < 2
    assert [data for data in port.sent if data] == []
    packets = [b"\xaa\x55" + bytes([k, 1, 2, 3]) for k in range(5)]
    port.came = b"".join(packets)
    before_s = clock.now_s
    assert [int(one.pads["pad"][0, 0]) for one in source.read(5.0)] == [0, 1, 2, 3, 4]
    # What is there is not waited for, and what is not there no longer than that.
    assert clock.now_s == before_s
    assert source.read(0.3) == []
    assert clock.now_s == pytest.approx(before_s + 0.3)
    # Whoever is flooded can still be stopped.
    port.came = packets[0] * 100_000
    assert 1 < len(source.read(0.1)) < 50_000
    source.close()
    source.close()
    assert port.closed == 1
    with pytest.raises(LostSourceError, match="is not open"):
        source.read(0.0)


def test_a_port_that_goes_is_told_and_let_go(monkeypatch: pytest.MonkeyPatch) -> None:
    source, port, _ = _opened(Clock(monkeypatch, serial_port), "serial:/dev/x?preset=flexitac")
    port.fault = OSError(errno.EIO, "Input/output error")
    with pytest.raises(LostSourceError, match=r"the port is gone \(input/output error\)"):
        source.read(0.1)
    source.close()
    assert port.closed == 1


@pytest.mark.parametrize(
    ("number", "words"),
    [
        (errno.ENOENT, "there is no such port; varishold sources lists"),
        (errno.EACCES, "the port may not be opened by you"),
        (errno.EAGAIN, "the port is in use by another program"),
        (errno.EBUSY, "the port is in use by another program"),
        (errno.EIO, r"the port cannot be opened \(broken\)"),
    ],
)
def test_why_a_port_cannot_be_opened_is_said(number: int, words: str) -> None:
    source: Any = source_at("serial:/dev/x?preset=flexitac")

    def refuse(*_: object, **__: object) -> None:
        raise OSError(number, "Broken")

    source._serial = SimpleNamespace(Serial=refuse)
    with pytest.raises(LostSourceError, match=words):
        source.open()


def test_a_skin_that_wants_to_be_asked_is_asked_at_once_for_the_next(monkeypatch: pytest.MonkeyPatch) -> None:
    source, port, _ = _opened(Clock(monkeypatch, serial_port), "serial:/dev/x?preset=weiss-wsg")
    request = framing_of("weiss-wsg").request
    assert [data for data in port.sent if data] == [request]
    (answer,) = frames_sent("weiss-wsg", [{"pad": np.arange(24, dtype="<u2").reshape(6, 4)}])
    for k in range(3):
        # An answer that is cut is put together.
        port.came = answer[:20]
        assert source.read(0.01) == []
        port.came = answer[20:]
        assert len(source.read(0.01)) == 1
        assert [data for data in port.sent if data] == [request] * (k + 2)


def test_an_answer_that_broke_off_is_forgotten_when_it_is_asked_for_again(monkeypatch: pytest.MonkeyPatch) -> None:
    source, port, _ = _opened(Clock(monkeypatch, serial_port), "serial:/dev/x?preset=weiss-wsg")
    first, second = frames_sent("weiss-wsg", [{"pad": np.arange(24, dtype="<u2").reshape(6, 4) + k} for k in range(2)])
    for cut in (1, 20, len(first) - 1):
        port.came = first[:cut]
        # It is asked again after a fifth of a second.
        assert source.read(0.25) == []
        port.came = second
        (one,) = source.read(0.01)
        assert one.pads["pad"].ravel().tolist() == list(range(1, 25))
    assert source.damaged == 0
