"""The page's server: the page at ``/``, the stream at ``/ws``, each browser at its own pace."""

from __future__ import annotations

import asyncio
import errno
import logging
import re
from contextlib import suppress
from socket import gaierror, gethostname
from threading import Event as ThreadEvent
from threading import Thread
from typing import Any
from weakref import WeakSet

from websockets.asyncio.server import Server, ServerConnection, serve
from websockets.datastructures import Headers
from websockets.exceptions import ConnectionClosed
from websockets.http11 import Request, Response

from varishold.errors import InputError
from varishold.live.browsers import Browser, Offer
from varishold.live.door import Door
from varishold.live.page_text import page_security, page_text
from varishold.live.requests import asked
from varishold.live.session import Session
from varishold.live.viewer import SUBPROTOCOLS, Viewer

__all__ = ["PageServer"]

# A browser that is silent for so long is looked after, and given up after as long again. Seconds.
_SILENT_S = 10.0
_MOST_BROWSERS = 16
# So long browsers may take to say goodbye. Seconds.
_CLOSE_S = 0.5
# Viewers are told what has come so often. Seconds.
_VIEWER_S = 0.01
# No request is longer. Bytes.
_LONGEST_REQUEST = 4096
# A server that listens here listens at every address of this machine.
_EVERYWHERE = ("0.0.0.0", "::")
# How many pictures a browser says it has shown.
_COUNT = re.compile("[0-9]{1,15}")

# A port that is scanned is no news to whoever runs this.
_QUIET = logging.getLogger("varishold.live.server")
_QUIET.addHandler(logging.NullHandler())
_QUIET.propagate = False


class PageServer:
    """Serves a session to browsers, in a thread of its own.

    Each browser gets the newest picture when it has shown those before; what came between is dropped. One that stalls
    or dies delays nobody.

    Parameters
    ----------
    session : Session
    host : str
        The machine's name or address to listen at.
    port : int
        0 for one that is free.
    viewers : bool
        Whether Foxglove's app is served too, at ``/``.
    """

    def __init__(self, session: Session, *, host: str = "127.0.0.1", port: int = 8765, viewers: bool = False) -> None:
        self._session = session
        self._host, self._port = host, port
        self._door, self._viewers = Door(host), viewers
        self._offer = Offer(session)
        self._visitors: WeakSet[ServerConnection] = WeakSet()
        self._waiting: set[asyncio.Event] = set()
        self._loop: asyncio.AbstractEventLoop | None = None
        self._stop = asyncio.Event()
        self._server: Server | None = None
        self._ready = ThreadEvent()
        self._failure: OSError | None = None
        self._thread = Thread(target=lambda: asyncio.run(self._run()), name="varishold serves", daemon=True)

    @property
    def address(self) -> str:
        """What to open in a browser."""
        host = gethostname() if self._host in _EVERYWHERE else self._host
        name = f"[{host}]" if ":" in host else host
        return f"http://{name}:{self._port}/"

    def __enter__(self) -> PageServer:
        self._thread.start()
        self._ready.wait()
        if self._failure is not None:
            self._thread.join()
            raise _refusal(self._host, self._port, self._failure)
        return self

    def __exit__(self, *_: object) -> None:
        if self._loop is not None:
            self._loop.call_soon_threadsafe(self._stop.set)
        self._thread.join()

    async def _run(self) -> None:
        self._loop = asyncio.get_running_loop()
        try:
            self._server = await serve(
                self._talk,
                self._host,
                self._port,
                process_request=self._receive_request,
                compression=None,
                max_size=_LONGEST_REQUEST,
                max_queue=16,
                ping_interval=_SILENT_S,
                ping_timeout=_SILENT_S,
                close_timeout=_CLOSE_S,
                server_header=None,
                logger=_QUIET,
                subprotocols=SUBPROTOCOLS if self._viewers else None,
                create_connection=self._visitor,  # type: ignore[arg-type]
            )
        except OSError as error:
            self._failure = error
            self._ready.set()
            return
        self._port = next(iter(self._server.sockets)).getsockname()[1]
        self._session.on_news = self._there_is_news
        self._ready.set()
        await self._stop.wait()
        self._session.on_news = None
        self._server.close()
        try:
            async with asyncio.timeout(2 * _CLOSE_S):
                await self._server.wait_closed()
        except TimeoutError:
            # Who has only knocked, and said nothing yet, is not waited for.
            for visitor in self._visitors:
                visitor.transport.abort()
            with suppress(TimeoutError):
                async with asyncio.timeout(_CLOSE_S):
                    await self._server.wait_closed()

    def _visitor(self, *given: Any, **named: Any) -> ServerConnection:
        visitor = ServerConnection(*given, **named)
        self._visitors.add(visitor)
        return visitor

    def _there_is_news(self) -> None:
        """Wake whoever waits for news; called in another thread."""
        if self._waiting and self._loop is not None:
            # A server that is being closed has no loop any more.
            with suppress(RuntimeError):
                self._loop.call_soon_threadsafe(self._wake_all)

    def _wake_all(self) -> None:
        for wake in self._waiting:
            wake.set()
        self._waiting.clear()

    def _receive_request(self, connection: ServerConnection, request: Request) -> Response | None:
        headers, path = request.headers, request.path.partition("?")[0]
        hosts, origins = headers.get_all("Host"), headers.get_all("Origin")
        if len(hosts) != 1 or len(origins) > 1:
            return connection.respond(400, "one Host and at most one Origin\n")
        viewer = self._viewers and path == "/" and headers.get("Upgrade", "").lower() == "websocket"
        refusal = self._door.refusal(hosts[0], origins[0] if origins else None, viewer=viewer)
        if refusal is not None:
            return connection.respond(403, f"{refusal}\n")
        if path == "/ws" or viewer:
            full = self._server is not None and len(self._server.connections) >= _MOST_BROWSERS
            return connection.respond(503, f"{_MOST_BROWSERS} pages are open already\n") if full else None
        return _page(hosts[0]) if path == "/" else connection.respond(404, "the page is at /\n")

    async def _talk(self, socket: ServerConnection) -> None:
        if socket.request is not None and socket.request.path.partition("?")[0] != "/ws":
            await self._show(socket)
            return
        browser, wake = Browser(self._offer), asyncio.Event()
        listening = asyncio.create_task(self._listen(socket, browser, wake))
        try:
            while True:
                for message in browser.due():
                    await socket.send(message)
                wake.clear()
                if browser.wants_news:
                    self._waiting.add(wake)
                try:
                    async with asyncio.timeout(browser.wait_s()):
                        await wake.wait()
                except TimeoutError:
                    continue
        except ConnectionClosed:
            return
        finally:
            self._waiting.discard(wake)
            listening.cancel()

    async def _show(self, socket: ServerConnection) -> None:
        """Tell a viewer every reading, as long as it keeps up with them."""
        viewer = Viewer(self._session)
        hearing = asyncio.create_task(self._hear(socket, viewer))
        try:
            for message in viewer.greeting():
                await socket.send(message)
            while not hearing.done():
                for content in viewer.due():
                    await socket.send(content)
                await asyncio.sleep(_VIEWER_S)
        except ConnectionClosed:
            return
        finally:
            hearing.cancel()

    async def _hear(self, socket: ServerConnection, viewer: Viewer) -> None:
        try:
            async for message in socket:
                if (answer := viewer.hear(message)) is not None:
                    await socket.send(answer)
        except ConnectionClosed:
            return

    async def _listen(self, socket: ServerConnection, browser: Browser, wake: asyncio.Event) -> None:
        """Take what a page says: how many pictures it has shown, or what it asks for."""
        try:
            async for message in socket:
                if isinstance(message, str) and _COUNT.fullmatch(message):
                    # Who waits for a picture's time knows it already.
                    if not browser.has_shown(int(message)):
                        continue
                else:
                    browser.answers.append(asked(self._session, message))
                wake.set()
        except ConnectionClosed:
            return


def _refusal(host: str, port: int, failure: OSError) -> InputError:
    """Return what to tell where nobody can listen: why, and whether the host or the port is to be another."""
    why, parameter = (failure.strerror or str(failure)).lower().rpartition(": ")[2], "port"
    if failure.errno == errno.EADDRINUSE:
        why = "another program listens there; end it, or name another port"
    elif isinstance(failure, gaierror) or failure.errno == errno.EADDRNOTAVAIL:
        why, parameter = f"{why}; name an address of this machine", "host"
    return InputError(f"cannot listen at {host}, port {port}: {why}", parameter=parameter)


def _page(host: str) -> Response:
    body = page_text().encode()
    told = {
        "Content-Type": "text/html; charset=utf-8",
        "Content-Length": str(len(body)),
        "Cache-Control": "no-store",
        "Content-Security-Policy": page_security(host),
        "X-Content-Type-Options": "nosniff",
        "Referrer-Policy": "no-referrer",
        "Connection": "close",
    }
    return Response(200, "OK", Headers(told), body)
