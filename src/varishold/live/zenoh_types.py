"""Definitions of types, asked of the nodes of ROS 2 over zenoh: since Jazzy each node has a service that tells them."""

from __future__ import annotations

import struct
import time
from collections.abc import Iterator
from contextlib import suppress
from typing import TYPE_CHECKING, Any

from varishold.errors import InputError
from varishold.recording.messages import message_decoder

if TYPE_CHECKING:
    import zenoh

__all__ = ["asked_definition"]

# An answer may take so long. Seconds.
_ANSWER_S = 3.0
_LINE = "=" * 80
_MOST_ANSWERS, _LARGEST = 64, 1 << 20
_REPLY = """bool successful
string failure_reason
type_description_interfaces/TypeDescription type_description
type_description_interfaces/TypeSource[] type_sources
type_description_interfaces/KeyValue[] extra_information
"""


def asked_definition(session: zenoh.Session, domain: int, type_name: str, type_hash: str) -> str:
    """Return a type's text with those of all types in it, as some node tells it; empty where none does.

    Parameters
    ----------
    session : zenoh.Session
    domain : int
        Of ROS 2.
    type_name : str
        As in ``sensor_msgs/msg/Image``.
    type_hash : str
        As in keys: ``RIHS01_...``.
    """
    decode = message_decoder("cdr", "type_description_interfaces/msg/GetTypeDescription_Response", _REPLY)
    for content in _answers(session, f"{domain}/**/get_type_description/*/*", _question(type_name, type_hash)):
        with suppress(InputError):
            reply = decode(content)
            if reply.successful and (text := _joined(type_name, reply.type_sources)):
                return text
    return ""


def _question(type_name: str, type_hash: str) -> bytes:
    """Return the service's request: two texts, and whether sources are wanted."""
    told = b""
    for text in (type_name, type_hash):
        told += bytes(-len(told) % 4) + struct.pack("<I", len(text) + 1) + text.encode() + b"\0"
    return b"\x00\x01\x00\x00" + told + b"\x01"


def _answers(session: zenoh.Session, key: str, question: bytes) -> Iterator[bytes]:
    import zenoh

    # Number and time of the question, and who asks.
    attachment = struct.pack("<qqB", 1, time.time_ns(), 16) + bytes(range(16))
    replies: Any = session.get(
        key, payload=question, attachment=attachment, target=zenoh.QueryTarget.ALL, timeout=_ANSWER_S
    )
    for count, reply in enumerate(replies):
        if count == _MOST_ANSWERS:
            return
        if reply.ok is not None and len(reply.ok.payload) <= _LARGEST:
            yield reply.ok.payload.to_bytes()


def _joined(type_name: str, sources: Any) -> str:
    """Return the texts of types as one, the asked one first; empty where it is not among them."""
    texts = {source.type_name: source.raw_file_contents for source in sources if source.encoding == "msg"}
    if type_name not in texts:
        return ""
    first = texts.pop(type_name)
    return "\n".join([first, *(f"{_LINE}\nMSG: {name}\n{text}" for name, text in texts.items())]) + "\n"
