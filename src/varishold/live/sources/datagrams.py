"""``udp:HOST:PORT`` one reading a datagram: JSON, or bare numbers where their type is named."""

from __future__ import annotations

import select
import socket
import time

from varishold.errors import InputError, LostSourceError
from varishold.live.address import Address
from varishold.live.endpoint import endpoint_of
from varishold.live.interpreted import InterpretedSource
from varishold.live.interpreter import OPTIONS, Interpreter
from varishold.live.sample import Sample
from varishold.live.sources.kind import SourceKind

__all__ = ["KIND", "Datagrams"]

# The port where none is named; the largest datagram; what the system should keep while nobody reads. Bytes.
_PORT, _LARGEST, _KEPT = 9000, 1 << 16, 1 << 21
# Datagrams that are taken at once, at most, so that whoever reads can still be stopped.
_MOST_AT_ONCE = 256


class Datagrams(InterpretedSource):
    """A port that skins send datagrams to. Without a host it is open to the network, with 127.0.0.1 to this machine.

    Parameters
    ----------
    address : Address
    """

    def __init__(self, address: Address) -> None:
        address.only(*OPTIONS)
        if address.place.isdigit():
            raise InputError(f"{address.text}: the port stands behind a colon, as in udp::{address.place}")
        self._place = endpoint_of(address, port=_PORT)
        if self._place.path:
            raise InputError(f"{address.text}: a port has no path, got {self._place.path!r}")
        super().__init__(address)
        self._socket: socket.socket | None = None

    def open(self) -> None:
        self.close()
        self._interpreter = Interpreter(self._of)
        place = self._place
        try:
            kind = socket.AF_INET6 if ":" in place.host else socket.AF_INET
            self._socket = socket.socket(kind, socket.SOCK_DGRAM)
            self._socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, _KEPT)
            self._socket.setblocking(False)
            self._socket.bind((place.host, place.port))
        except (OSError, UnicodeError) as error:
            self.close()
            words = (getattr(error, "strerror", None) or str(error)).lower()
            raise LostSourceError(f"{self.address}: cannot listen at port {place.port} ({words})") from error

    def read(self, timeout_s: float) -> list[Sample]:
        if self._socket is None:
            raise LostSourceError(f"{self.address}: is not open")
        if not select.select([self._socket], [], [], timeout_s)[0]:
            return []
        samples: list[Sample] = []
        for _ in range(_MOST_AT_ONCE):
            try:
                content = self._socket.recv(_LARGEST)
            except BlockingIOError:
                break
            except OSError as error:
                raise LostSourceError(f"{self.address}: cannot be read ({error})") from error
            samples += self._samples(content)
        return samples

    def close(self) -> None:
        if self._socket is not None:
            self._socket.close()
        self._socket = None

    def _samples(self, content: bytes) -> list[Sample]:
        try:
            return self._interpreter.payload(content, host_time_s=time.time())
        except InputError as error:
            # Anybody may send to a port: what nobody understands is told, and the next sender is heard.
            raise LostSourceError(str(error)) from error


KIND = SourceKind("datagrams, JSON or bare numbers", "udp::9000?dtype=uint8&shape=16x16", Datagrams)
