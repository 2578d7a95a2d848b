"""Where in a network something is: ``HOST:PORT/PATH``."""

from __future__ import annotations

import re
from dataclasses import dataclass

from varishold.errors import InputError
from varishold.live.address import Address

__all__ = ["Endpoint", "endpoint_of", "untrusted"]

_PLACE = re.compile(r"(?P<host>\[[0-9a-fA-F:.%]+\]|[^\s/:\[\]@]*)(:(?P<port>\d{1,5}))?(/(?P<path>\S*))?")


@dataclass(frozen=True)
class Endpoint:
    """Where in a network something is.

    Parameters
    ----------
    host : str
        Name or number; an IPv6 number without its brackets. Empty where none was written.
    port : int
    path : str
        What stands behind the first slash.
    """

    host: str
    port: int
    path: str

    @property
    def host_and_port(self) -> str:
        """As it stands in a URI."""
        return f"[{self.host}]:{self.port}" if ":" in self.host else f"{self.host}:{self.port}"


def endpoint_of(address: Address, *, port: int, host: str = "", form: str = "{kind}://HOST:PORT/NAME") -> Endpoint:
    """Return the parts of an address's place; `port` and `host` where none are written; `form` is how it is written.

    Raises
    ------
    InputError
        If it is no such place, or there is neither a host nor a default.

    Examples
    --------
    >>> from varishold.live.address import parse_address
    >>> endpoint_of(parse_address("mqtt://broker/skin/left"), port=1883)
    Endpoint(host='broker', port=1883, path='skin/left')
    """
    match = _PLACE.fullmatch(address.place)
    number = int(match["port"] or port) if match else 0
    if match is None or not 0 < number < 65536:
        asked = form.format(kind=address.kind)
        ports = "" if match is None else "; a port is a number from 1 to 65535"
        raise InputError(f"{address.text}: must be as {asked}, got {address.place!r}{ports}")
    return Endpoint((match["host"] or host).strip("[]"), number, match["path"] or "")


def untrusted(where: str, error: Exception) -> InputError | None:
    """Return what to tell where an error says that a server's certificate is not trusted; else None."""
    # A source that is not encrypted need not load it.
    import ssl

    if not isinstance(error, ssl.SSLCertVerificationError):
        return None
    return InputError(
        f"{where}: its certificate is not trusted ({error.verify_message}); name a file with its authority's in the "
        "environment variable SSL_CERT_FILE"
    )
