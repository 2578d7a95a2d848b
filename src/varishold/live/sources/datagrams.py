"""``udp:HOST:PORT`` datagrams: a reading each, as JSON or bare numbers, or the bytes of a framing."""

from __future__ import annotations

import select
import socket
import struct
import sys
import time
from abc import ABC, abstractmethod
from collections import deque
from collections.abc import Mapping

from varishold.errors import InputError, LostSourceError, reason_of
from varishold.live.address import Address
from varishold.live.endpoint import endpoint_of
from varishold.live.framed import FRAMING_OPTIONS, FramedBytes, framing_at
from varishold.live.interpreted import InterpretedSource
from varishold.live.interpreter import OPTIONS, Interpreter
from varishold.live.sample import PadLayout, Sample
from varishold.live.source import Source
from varishold.live.sources.kind import SourceKind

__all__ = ["KIND", "Datagrams", "FramedDatagrams"]

# The port where none is named; the largest datagram, bytes.
_PORT, _LARGEST = 9000, 1 << 16
# What the system should keep while nobody reads, which most systems cut to a tenth; and what waits here until it is
# understood: a burst comes faster than that goes. Bytes.
_KEPT, _WAITING = 1 << 21, 1 << 22
# Datagrams that are understood at once, at most, so that whoever reads can still be stopped.
_MOST_AT_ONCE = 256
# Where several wait more are on the way: they are taken before any is understood, until none comes for so long, or at
# most for so long. Seconds.
_LULL_S, _BURST_S = 3e-4, 0.01
# Linux's question for what it keeps of a socket: nine numbers, of which this one is how many datagrams it has dropped.
_SO_MEMINFO, _NUMBERS, _DROPPED = 55, struct.Struct("9I"), 8


class Port:
    """Where datagrams come to. Without a host it is open to the network, with 127.0.0.1 to this machine.

    Parameters
    ----------
    address : Address

    Attributes
    ----------
    overrun : int
        How many datagrams came faster than they were read, and are lost; where the system tells that.
    """

    def __init__(self, address: Address) -> None:
        if address.place.isdigit():
            raise InputError(f"{address.text}: the port stands behind a colon, as in udp::{address.place}")
        self._place = endpoint_of(address, port=_PORT, form="udp:HOST:PORT")
        if self._place.path:
            raise InputError(f"{address.text}: a port has no path, got {self._place.path!r}")
        self._address = address.text
        self._socket: socket.socket | None = None
        self._waiting: deque[tuple[float, bytes]] = deque()
        self._size = 0
        self.overrun = self._overrun_before = 0

    def open(self) -> None:
        """Listen.

        Raises
        ------
        LostSourceError
            If the port is not to be had.
        """
        self.close()
        self._waiting.clear()
        self._size, self._overrun_before = 0, self.overrun
        place = self._place
        try:
            kind = socket.AF_INET6 if ":" in place.host else socket.AF_INET
            self._socket = socket.socket(kind, socket.SOCK_DGRAM)
            self._socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, _KEPT)
            self._socket.setblocking(False)
            self._socket.bind((place.host, place.port))
        except (OSError, UnicodeError) as error:
            self.close()
            words = reason_of(error)
            raise LostSourceError(f"{self._address}: cannot listen at port {place.port} ({words})") from error

    def wait(self, timeout_s: float) -> None:
        """Wait for a datagram, but no longer than that.

        Raises
        ------
        LostSourceError
            If it is not open.
        """
        opened = self._opened()
        if not self._waiting:
            select.select([opened], [], [], timeout_s)
        self.overrun = self._overrun_before + _dropped(opened)

    def take(self) -> tuple[float, bytes] | None:
        """Return the oldest datagram and when it was read, seconds since 1970; None where none has come.

        What comes meanwhile is taken from the system first, which keeps little.

        Raises
        ------
        LostSourceError
            If it is not open, or cannot be read.
        """
        opened = self._opened()
        if self._gather(opened) > 1:
            ends_s = time.monotonic() + _BURST_S
            while time.monotonic() < ends_s and select.select([opened], [], [], _LULL_S)[0] and self._gather(opened):
                pass
        if not self._waiting:
            return None
        oldest = self._waiting.popleft()
        self._size -= len(oldest[1])
        return oldest

    def close(self) -> None:
        """Let the port go. May be called again."""
        if self._socket is not None:
            self._socket.close()
        self._socket = None

    def _gather(self, opened: socket.socket) -> int:
        """Take what the system holds, as far as there is room; return how many datagrams that were."""
        before = len(self._waiting)
        while self._size < _WAITING:
            try:
                content = opened.recv(_LARGEST)
            except BlockingIOError:
                break
            except OSError as error:
                raise LostSourceError(f"{self._address}: cannot be read ({error})") from error
            self._waiting.append((time.time(), content))
            self._size += len(content)
        return len(self._waiting) - before

    def _opened(self) -> socket.socket:
        if self._socket is None:
            raise LostSourceError(f"{self._address}: is not open")
        return self._socket


def _dropped(opened: socket.socket) -> int:
    """Return how many datagrams the system has dropped because nobody read them; 0 where it does not tell."""
    if sys.platform != "linux":
        return 0
    try:
        told = opened.getsockopt(socket.SOL_SOCKET, _SO_MEMINFO, _NUMBERS.size)
    except OSError:
        return 0
    return int(_NUMBERS.unpack(told)[_DROPPED]) if len(told) == _NUMBERS.size else 0


class AtPort(ABC):
    """What both kinds of datagrams have in common: a port, and samples out of each datagram."""

    _port: Port

    @property
    def overrun(self) -> int:
        """How many datagrams came faster than they were read, and are lost; where the system tells that."""
        return self._port.overrun

    def read(self, timeout_s: float) -> list[Sample]:
        self._port.wait(timeout_s)
        samples: list[Sample] = []
        for _ in range(_MOST_AT_ONCE):
            if (came := self._port.take()) is None:
                break
            host_time_s, content = came
            samples += (sample._replace(host_time_s=host_time_s) for sample in self._samples(content))
        return samples

    def close(self) -> None:
        self._port.close()

    @abstractmethod
    def _samples(self, content: bytes) -> list[Sample]:
        """Return the samples of a datagram."""


class Datagrams(AtPort, InterpretedSource):
    """A port that skins send readings to, one a datagram.

    Parameters
    ----------
    address : Address
    """

    def __init__(self, address: Address) -> None:
        address.only(*OPTIONS, "preset", "framing")
        self._port = Port(address)
        super().__init__(address)

    def open(self) -> None:
        self._interpreter = Interpreter(self._of)
        self._port.open()

    def _samples(self, content: bytes) -> list[Sample]:
        try:
            return self._interpreter.payload(content)
        except InputError as error:
            # Anybody may send to a port: what nobody understands is told, and the next sender is heard.
            raise LostSourceError(str(error)) from error


class FramedDatagrams(AtPort):
    """A port that a skin sends its bytes to, framed as on a cable; a frame may go through several datagrams.

    Parameters
    ----------
    address : Address
    """

    def __init__(self, address: Address) -> None:
        address.only(*FRAMING_OPTIONS)
        self._port = Port(address)
        self._address = address.text
        framing = framing_at(address)
        # A datagram of a frame's size is a frame by itself, whatever of another one is still waited for.
        self._size = framing.packets[0].size if len(framing.packets) == 1 else 0
        self._whole = FramedBytes(address.text, framing, confirm=False)
        self._parts = FramedBytes(address.text, framing)

    @property
    def address(self) -> str:
        """As it was written."""
        return self._address

    @property
    def pads(self) -> Mapping[str, PadLayout]:
        """The pads that are known so far."""
        return {**self._parts.pads, **self._whole.pads}

    @property
    def damaged(self) -> int:
        """How often something was not as it should be."""
        return self._parts.damaged + self._whole.damaged

    def open(self) -> None:
        self._whole.restart()
        self._parts.restart()
        self._port.open()

    def _samples(self, content: bytes) -> list[Sample]:
        if len(content) != self._size:
            return self._parts.samples(content)
        self._whole.expect()
        return self._whole.samples(content)


def _make(address: Address) -> Source:
    framed = "preset" in address.options or "framing" in address.options
    return FramedDatagrams(address) if framed else Datagrams(address)


KIND = SourceKind("datagrams, JSON, bare numbers or a framing's bytes", "udp::9000?dtype=uint8&shape=16x16", _make)
