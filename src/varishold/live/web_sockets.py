"""One end of a WebSocket that tells within a second that the other one is gone."""

from __future__ import annotations

import logging
import time
from contextlib import ExitStack, suppress
from threading import Event
from typing import TYPE_CHECKING, Any

from varishold.errors import InputError, LostSourceError
from varishold.live.endpoint import untrusted

if TYPE_CHECKING:
    from websockets.sync.client import ClientConnection

__all__ = ["WebSocket"]

# Connecting, and saying goodbye, may take so long. Seconds.
_OPEN_S, _CLOSE_S = 1.0, 0.2
# After so long without a word the other end is asked for one, and given up so long after that. Seconds.
_ASK_S, _ANSWER_S = 0.3, 0.6
# A message has at most so many bytes, and at most so many are kept until they are read.
_LARGEST, _MOST = 1 << 24, 16
# What the library says of itself where a peer leaves in the middle of a greeting is no word for a person.
_SILENT = logging.getLogger("varishold.live.web_sockets")
_SILENT.addHandler(logging.NullHandler())
_SILENT.propagate = False


class WebSocket:
    """A connection to a server that sends; one thread's only.

    Parameters
    ----------
    where : str
        The source's address: it opens every message.
    uri : str
    subprotocols : tuple of str
        Offered to the server, the liked one first.
    """

    def __init__(self, where: str, uri: str, subprotocols: tuple[str, ...] = ()) -> None:
        self._where, self._uri, self._subprotocols = where, uri, subprotocols
        self._stack: ExitStack | None = None
        self._connection: ClientConnection | None = None
        # When a message, or an answer, came last, and when any byte did: a large message may be long on its way.
        self._heard_s: float
        self._byte_s = 0.0
        self._asked: Event | None = None

    def open(self) -> None:
        """Connect.

        Raises
        ------
        LostSourceError
            If nobody answers.
        InputError
            If it is no address of a server, or the server speaks something else or shows a certificate that nobody
            trusts.
        """
        from websockets.exceptions import InvalidHandshake, InvalidURI, WebSocketException
        from websockets.sync.client import connect

        self.close()
        stack = ExitStack()
        try:
            self._connection = stack.enter_context(
                connect(  # type: ignore[call-overload]
                    self._uri,
                    create_connection=self._listening,
                    subprotocols=list(self._subprotocols) or None,
                    compression=None,
                    proxy=None,
                    open_timeout=_OPEN_S,
                    close_timeout=_CLOSE_S,
                    ping_interval=None,
                    max_size=_LARGEST,
                    max_queue=_MOST,
                    logger=_SILENT,
                )
            )
        except InvalidURI as error:
            raise InputError(f"{self._where}: {error}") from None
        except InvalidHandshake as error:
            raise LostSourceError(f"{self._where}: no such WebSocket is served there: {error}") from None
        except AssertionError:
            # The library takes for granted that a peer that has answered with nonsense has not left meanwhile.
            raise LostSourceError(f"{self._where}: nobody answers: the connection was closed at once") from None
        except (OSError, TimeoutError, WebSocketException) as error:
            if (wrong := untrusted(self._where, error)) is not None:
                raise wrong from None
            raise LostSourceError(f"{self._where}: nobody answers: {error}") from None
        self._stack = stack
        if self._subprotocols and self._connection.subprotocol not in self._subprotocols:
            self.close()
            raise LostSourceError(f"{self._where}: what is served there speaks none of {', '.join(self._subprotocols)}")
        self._heard_s, self._asked = time.monotonic(), None

    def send(self, text: str) -> None:
        """Send a text; raises LostSourceError where the other end is gone."""
        from websockets.exceptions import ConnectionClosed

        connection = self._open_connection()
        try:
            connection.send(text)
        except (ConnectionClosed, OSError, AssertionError) as error:
            raise self._lost(error) from None

    def receive(self, timeout_s: float) -> list[bytes]:
        """Return the messages that came, in their order; an empty list if none came within the timeout.

        Raises
        ------
        LostSourceError
            If the other end is gone, or says nothing when asked.
        """
        ends_s = time.monotonic() + timeout_s
        came: list[bytes] = []
        while not came:
            left_s = ends_s - time.monotonic()
            self._take(came, min(max(left_s, 0.0), _ASK_S / 2))
            if not came:
                self._look_alive()
                if left_s <= 0:
                    break
        while len(came) < 4 * _MOST and self._take(came, 0):
            pass
        return came

    def close(self) -> None:
        """Let it go. Never raises, and may be called twice."""
        stack, self._stack, self._connection = self._stack, None, None
        if stack is not None:
            with suppress(Exception):
                stack.close()

    def _take(self, came: list[bytes], timeout_s: float) -> bool:
        from websockets.exceptions import ConnectionClosed

        connection = self._open_connection()
        try:
            came.append(connection.recv(timeout_s, decode=False))
        except TimeoutError:
            return False
        except (ConnectionClosed, OSError, AssertionError) as error:
            if came:
                return False
            raise self._lost(error) from None
        self._heard_s, self._asked = time.monotonic(), None
        return True

    def _look_alive(self) -> None:
        from websockets.exceptions import ConnectionClosed

        silent_s = time.monotonic() - max(self._heard_s, self._byte_s)
        if self._asked is not None and self._asked.is_set():
            self._heard_s, self._asked = time.monotonic(), None
        elif self._asked is None and silent_s >= _ASK_S:
            connection = self._open_connection()
            try:
                self._asked = connection.ping()
            except (ConnectionClosed, OSError, AssertionError) as error:
                raise self._lost(error) from None
        elif silent_s >= _ASK_S + _ANSWER_S:
            raise LostSourceError(f"{self._where}: has been silent for {silent_s:.1f} s and does not answer")

    def _listening(self, *given: Any, **how: Any) -> ClientConnection:
        """Return a connection that notes when bytes come."""
        from websockets.sync.client import ClientConnection

        connection = ClientConnection(*given, **how)
        take = connection.protocol.receive_data

        def receive_data(data: bytes | bytearray) -> None:
            # What comes behind a fault of the peer's is thrown away.
            if connection.protocol.parser_exc is None:
                self._byte_s = time.monotonic()
            take(data)

        connection.protocol.receive_data = receive_data  # type: ignore[method-assign]
        return connection

    def _open_connection(self) -> ClientConnection:
        if self._connection is None:
            raise LostSourceError(f"{self._where}: is not open")
        return self._connection

    def _lost(self, error: Exception) -> LostSourceError:
        return LostSourceError(f"{self._where}: has closed the connection: {error}")
