"""The kinds of sources: one file each, and the registry in which each is listed."""

from __future__ import annotations

from collections.abc import Mapping
from importlib import import_module
from types import MappingProxyType

from varishold._lazy import missing_extra
from varishold.errors import InputError
from varishold.live.address import parse_address
from varishold.live.source import Source
from varishold.live.sources.kind import SourceKind

__all__ = ["KINDS", "SourceKind", "source_at", "source_kind"]


#: The file of each kind by what stands before the colon; it offers ``KIND``, and is loaded when it is asked for.
KINDS: Mapping[str, str] = MappingProxyType(
    {
        "serial": "serial_port",
        "udp": "datagrams",
        "stdin": "standard_input",
        "replay": "replayed",
        "sim": "simulated",
        "ws": "web_socket",
        "wss": "web_socket",
        "foxglove": "foxglove",
        "zenoh": "zenoh_topic",
        "lsl": "lab_stream",
        "mqtt": "mqtt_topic",
        "mqtts": "mqtt_topic",
    }
)


def source_kind(kind: str) -> SourceKind:
    """Return a kind by what stands before the colon."""
    found: SourceKind = import_module(f"varishold.live.sources.{KINDS[kind]}").KIND
    return found


def source_at(text: str) -> Source:
    """Return the source at an address, not yet opened.

    Raises
    ------
    InputError
        If nothing is known of such an address, or it says what cannot be.
    MissingExtraError
        If the library that reads it is not installed.
    """
    address = parse_address(text)
    if address.kind not in KINDS:
        raise InputError(f"{text}: no source is called {address.kind!r}; known are {', '.join(KINDS)}")
    try:
        return source_kind(address.kind).make(address)
    except ModuleNotFoundError as error:
        raise missing_extra(error) from None
