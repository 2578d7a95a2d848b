"""Plain CDR, the coding of ROS 2's messages: the order of bytes, texts, filling."""

from __future__ import annotations

import struct
from collections.abc import Mapping
from types import MappingProxyType
from typing import Literal

__all__ = ["LITTLE", "cdr_order", "cdr_text", "filled", "string_message", "string_of", "text_end"]

#: What stands before every message that is written: the lowest byte of a number comes first.
LITTLE = b"\x00\x01\x00\x00"
_ORDERS: Mapping[bytes, Literal["<", ">"]] = MappingProxyType({b"\x00\x00": ">", b"\x00\x01": "<"})


def cdr_order(message: bytes) -> Literal["<", ">"]:
    """Return the byte order of a message's numbers, as numpy writes it.

    Raises
    ------
    ValueError
        If it is no plain CDR.
    """
    order = _ORDERS.get(bytes(message[:2]))
    if order is None:
        raise ValueError(f"begins with {bytes(message[:4]).hex(' ')}, which is no plain CDR")
    return order


def cdr_text(text: str) -> bytes:
    """Return a text with its length and its closing zero byte."""
    coded = text.encode("utf-8", "replace") + b"\0"
    return struct.pack("<I", len(coded)) + coded


def filled(head: bytes) -> bytes:
    """Fill up to a multiple of four bytes."""
    return head + bytes(-len(head) % 4)


def text_end(message: bytes, at: int, order: str) -> int:
    """Return where a text ends that begins with its length; raises ValueError where that is beyond the message."""
    (length,) = struct.unpack_from(f"{order}I", message, at)
    if length > len(message) - at - 4:
        raise ValueError(f"a text of {length} bytes is announced, {len(message) - at - 4} are there")
    return at + 4 + int(length)


def string_message(text: str) -> bytes:
    """Return a message that is one text."""
    return LITTLE + cdr_text(text)


def string_of(message: bytes) -> str:
    """Return the text of a message that is one.

    Raises
    ------
    ValueError
        If it is no such message.
    """
    order = cdr_order(message)
    try:
        ends = text_end(message, 4, order)
    except struct.error:
        raise ValueError(f"its {len(message)} bytes hold no text") from None
    return message[8:ends].rstrip(b"\0").decode("utf-8", "replace")
