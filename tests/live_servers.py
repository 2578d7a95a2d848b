"""Servers on this machine that send what a test gives them: a WebSocket, and Foxglove's protocol on top of it."""

from __future__ import annotations

import json
import ssl
import struct
import threading
from contextlib import suppress
from queue import Empty, SimpleQueue
from types import TracebackType
from typing import Any, Self

from websockets.exceptions import ConnectionClosed
from websockets.protocol import State
from websockets.sync.server import Server, ServerConnection, serve

__all__ = ["FoxgloveServer", "Hangup", "SocketServer"]


class Hangup:
    """Put among messages: the server closes the connection there."""


class SocketServer:
    """A WebSocket server; each message that is put goes to the connection that is open, or to the next one."""

    subprotocols: tuple[str, ...] = ()

    def __init__(self, *, port: int = 0, tls: ssl.SSLContext | None = None) -> None:
        self.messages: SimpleQueue[str | bytes | Hangup] = SimpleQueue()
        self._ends = threading.Event()
        self.connections: list[ServerConnection] = []
        self.heard: list[Any] = []
        self.server: Server = serve(
            self.handle,
            "127.0.0.1",
            port,
            subprotocols=list(self.subprotocols) or None,
            close_timeout=0.5,
            compression=None,
            ssl=tls,
        )
        self.port: int = self.server.socket.getsockname()[1]
        self._thread = threading.Thread(target=self.server.serve_forever)

    def __enter__(self) -> Self:
        self._thread.start()
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        self._ends.set()
        self.server.shutdown()
        for connection in self.connections:
            connection.close()
        self._thread.join()

    def put(self, *messages: Any) -> None:
        for message in messages:
            as_it_is = isinstance(message, str | bytes | Hangup)
            self.messages.put(message if as_it_is else json.dumps(message))

    def handle(self, connection: ServerConnection) -> None:
        self.connections.append(connection)
        self.greet(connection)
        listener = threading.Thread(target=self._listen, args=(connection,))
        listener.start()
        try:
            while not self._ends.is_set() and connection.state is State.OPEN:
                with suppress(Empty):
                    message = self.messages.get(timeout=0.02)
                    if isinstance(message, Hangup):
                        break
                    connection.send(message)
        except ConnectionClosed:
            pass
        finally:
            connection.close()
            listener.join()

    def greet(self, connection: ServerConnection) -> None:
        """Say what is said to all who come."""

    def _listen(self, connection: ServerConnection) -> None:
        with suppress(ConnectionClosed):
            for said in connection:
                self.heard.append(json.loads(said))
                self.obey(connection, self.heard[-1])

    def obey(self, connection: ServerConnection, said: Any) -> None:
        """Do what the client says."""


class FoxgloveServer(SocketServer):
    """A server as the protocol's specification has it.

    Parameters
    ----------
    channels : list of dict
        As they stand in an advertisement; their ids are their places.
    """

    def __init__(self, channels: list[dict[str, Any]], subprotocol: str = "foxglove.sdk.v1", **options: Any) -> None:
        self.subprotocols = (subprotocol,)
        self.channels = [{"id": number + 7, **channel} for number, channel in enumerate(channels)]
        self.subscriptions: dict[int, int] = {}
        super().__init__(**options)

    def greet(self, connection: ServerConnection) -> None:
        connection.send(json.dumps({"op": "serverInfo", "name": "test", "capabilities": ["time"], "sessionId": "1"}))
        connection.send(json.dumps({"op": "status", "level": 1, "message": "mind the gap"}))
        connection.send(json.dumps({"op": "advertise", "channels": self.channels}))
        connection.send(b"\x02" + struct.pack("<Q", 5))

    def obey(self, connection: ServerConnection, said: Any) -> None:
        if said["op"] == "subscribe":
            self.subscriptions |= {each["channelId"]: each["id"] for each in said["subscriptions"]}

    def put_message(self, content: bytes, *, time_ns: int = 0, subscription: int = 1) -> None:
        self.put(struct.pack("<BIQ", 1, subscription, time_ns) + content)
