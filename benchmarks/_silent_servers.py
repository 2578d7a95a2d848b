"""Servers that greet and then never say a word again, as behind a pulled cable; or one, through a slow link."""

from __future__ import annotations

import socket
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager

__all__ = ["silent_broker", "silent_web_socket"]

# A message through a slow link comes in so many pieces, so far apart. Seconds.
_PIECES, _APART_S = 30, 0.05


@contextmanager
def _silent(greet: Callable[[socket.socket], None]) -> Iterator[int]:
    """Serve whoever comes: greet him, keep the connection and say nothing; yield the port."""
    ends = threading.Event()
    listener = socket.create_server(("127.0.0.1", 0))
    listener.settimeout(0.05)

    def run() -> None:
        kept = []
        while not ends.is_set():
            try:
                client, _ = listener.accept()
            except TimeoutError:
                continue
            kept.append(client)
            client.settimeout(10)
            greet(client)
        for client in kept:
            client.close()

    thread = threading.Thread(target=run)
    thread.start()
    try:
        yield int(listener.getsockname()[1])
    finally:
        ends.set()
        thread.join()
        listener.close()


def _slowly(client: socket.socket, content: bytes) -> None:
    size = -(-len(content) // _PIECES)
    for at in range(0, len(content), size or 1):
        client.sendall(content[at : at + size])
        time.sleep(_APART_S)


def silent_web_socket(slowly: bytes = b"") -> AbstractContextManager[int]:
    """Serve WebSockets that shake hands, send these bytes slowly, and nothing more; yield the port."""
    from websockets.server import ServerProtocol

    def greet(client: socket.socket) -> None:
        protocol = ServerProtocol()
        while not (events := protocol.events_received()):
            protocol.receive_data(client.recv(4096))
        protocol.send_response(protocol.accept(events[0]))  # type: ignore[arg-type]
        client.sendall(b"".join(protocol.data_to_send()))
        _slowly(client, slowly)

    return _silent(greet)


def silent_broker(slowly: bytes = b"") -> AbstractContextManager[int]:
    """Serve MQTT up to the subscription, send these bytes slowly, and nothing more; yield the port."""

    def greet(client: socket.socket) -> None:
        client.recv(1000)
        client.sendall(b"\x20\x02\x00\x00")
        asked = client.recv(1000)
        client.sendall(b"\x90\x03" + asked[2:4] + b"\x00")
        _slowly(client, slowly)

    return _silent(greet)
