"""Who may come in: the page's own browser, and nobody whom another page sent."""

from __future__ import annotations

import ipaddress
import socket
from urllib.parse import urlsplit

__all__ = ["VIEWERS", "Door", "is_loopback"]

#: Where Foxglove's app is served from, for browsers.
VIEWERS = frozenset({"https://app.foxglove.dev", "https://studio.foxglove.dev"})
_LOOPBACK = frozenset({"localhost", "127.0.0.1", "::1"})


class Door:
    """Judges requests by the names that they come under.

    Any page of the web may try to open a socket to this machine: its browser says so in ``Origin``, which must be the
    name that the page itself was asked for under. And a foreign name may be made to point here: only names that are
    this machine's own are answered.

    Parameters
    ----------
    host : str
        Where the server listens.

    Examples
    --------
    >>> door = Door("127.0.0.1")
    >>> door.refusal("localhost:8765", "http://localhost:8765") is None
    True
    >>> door.refusal("localhost:8765", "https://example.com")
    'https://example.com is another page than http://localhost:8765'
    """

    def __init__(self, host: str) -> None:
        self._everywhere = not is_loopback(host)
        self._names = {*_LOOPBACK, host.strip("[]").lower()}
        if self._everywhere:
            own = socket.gethostname().lower()
            self._names |= {own, own.partition(".")[0], f"{own.partition('.')[0]}.local"}

    def refusal(self, host: str | None, origin: str | None, *, viewer: bool = False) -> str | None:
        """Return why a request is refused; None where it is welcome.

        Parameters
        ----------
        host : str or None
            Its header ``Host``.
        origin : str or None
            Its header ``Origin``; programs that are no browsers have none.
        viewer : bool
            Whether what is asked for is what viewers get, who may only look: they may be programs with a page inside,
            or one of `VIEWERS`.
        """
        name = _name(host)
        if name is None or not (name in self._names or (self._everywhere and _is_address(name))):
            return f"{(host or 'nothing')[:100]} is no name of this machine"
        if viewer and origin is not None and (origin in VIEWERS or _is_program(origin)):
            return None
        if origin is not None and _netloc(origin) != (host or "").lower():
            return f"{origin[:100]} is another page than http://{host}"
        return None


def is_loopback(host: str) -> bool:
    """Tell whether who listens there is heard by this machine only."""
    return host.strip("[]").lower() in _LOOPBACK


def _name(host: str | None) -> str | None:
    """Return the name in a header ``Host``, without the port."""
    try:
        parts = urlsplit(f"//{host or ''}")
        parts.port  # noqa: B018
        return parts.hostname if parts.netloc == host and not parts.username else None
    except ValueError:
        return None


def _netloc(origin: str) -> str | None:
    try:
        parts = urlsplit(origin)
    except ValueError:
        return None
    return parts.netloc.lower() if parts.scheme in ("http", "https") else None


def _is_program(origin: str) -> bool:
    """Tell whether a page is part of a program: those of the web have http, or hide where they are from."""
    try:
        scheme = urlsplit(origin).scheme
    except ValueError:
        return False
    return scheme not in ("", "http", "https", "blob", "data", "about")


def _is_address(name: str) -> bool:
    try:
        ipaddress.ip_address(name)
    except ValueError:
        return False
    return True
