"""``ws://HOST:PORT/PATH`` and ``wss:`` JSON from a WebSocket: XELA's server, plain arrays, messages of robots."""

from __future__ import annotations

import re

from varishold.errors import InputError
from varishold.live.address import Address
from varishold.live.endpoint import endpoint_of
from varishold.live.interpreted import InterpretedSource
from varishold.live.interpreter import OPTIONS
from varishold.live.sample import Sample
from varishold.live.sources.kind import SourceKind
from varishold.live.web_sockets import WebSocket

__all__ = ["KIND", "WebSocketSource"]

# XELA's server, and the first thing it says: in its readings the message is a number.
_PORT = 5000
_GREETING = re.compile(rb'"message"\s*:\s*"')


class WebSocketSource(InterpretedSource):
    """A server that sends a reading a message, as soon as somebody connects.

    Parameters
    ----------
    address : Address
    """

    def __init__(self, address: Address) -> None:
        address.only(*OPTIONS)
        super().__init__(address)
        place = endpoint_of(address, port=_PORT)
        if not place.host:
            raise InputError(f"{address.text}: must name a host, as in {KIND.example}")
        self._socket = WebSocket(address.text, f"{address.kind}://{place.host_and_port}/{place.path}")

    def open(self) -> None:
        self._socket.open()

    def read(self, timeout_s: float) -> list[Sample]:
        return [
            sample
            for content in self._socket.receive(timeout_s)
            if not _GREETING.search(content[:1000])
            for sample in self._interpreter.payload(content)
        ]

    def close(self) -> None:
        self._socket.close()


KIND = SourceKind("XELA's server, or JSON from any WebSocket", "ws://localhost:5000", WebSocketSource)
