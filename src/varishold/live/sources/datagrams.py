"""``udp:HOST:PORT`` datagrams: a reading each, as JSON or bare numbers, or the bytes of a framing."""

from __future__ import annotations

import select
import socket
import time
from abc import ABC, abstractmethod
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

# The port where none is named; the largest datagram; what the system should keep while nobody reads. Bytes.
_PORT, _LARGEST, _KEPT = 9000, 1 << 16, 1 << 21
# Datagrams that are taken at once, at most, so that whoever reads can still be stopped.
_MOST_AT_ONCE = 256


class Port:
    """Where datagrams come to. Without a host it is open to the network, with 127.0.0.1 to this machine.

    Parameters
    ----------
    address : Address
    """

    def __init__(self, address: Address) -> None:
        if address.place.isdigit():
            raise InputError(f"{address.text}: the port stands behind a colon, as in udp::{address.place}")
        self._place = endpoint_of(address, port=_PORT, form="udp:HOST:PORT")
        if self._place.path:
            raise InputError(f"{address.text}: a port has no path, got {self._place.path!r}")
        self._address = address.text
        self._socket: socket.socket | None = None

    def open(self) -> None:
        """Listen.

        Raises
        ------
        LostSourceError
            If the port is not to be had.
        """
        self.close()
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

    def read(self, timeout_s: float) -> list[bytes]:
        """Return the datagrams that have come; wait for the first, but no longer than that.

        Raises
        ------
        LostSourceError
            If it is not open, or cannot be read.
        """
        if self._socket is None:
            raise LostSourceError(f"{self._address}: is not open")
        if not select.select([self._socket], [], [], timeout_s)[0]:
            return []
        came: list[bytes] = []
        for _ in range(_MOST_AT_ONCE):
            try:
                came.append(self._socket.recv(_LARGEST))
            except BlockingIOError:
                break
            except OSError as error:
                raise LostSourceError(f"{self._address}: cannot be read ({error})") from error
        return came

    def close(self) -> None:
        """Let the port go. May be called again."""
        if self._socket is not None:
            self._socket.close()
        self._socket = None


class AtPort(ABC):
    """What both kinds of datagrams have in common: a port, and samples out of each datagram."""

    _port: Port

    def read(self, timeout_s: float) -> list[Sample]:
        return [sample for content in self._port.read(timeout_s) for sample in self._samples(content)]

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
            return self._interpreter.payload(content, host_time_s=time.time())
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
