"""Checksums that serial skins send."""

from __future__ import annotations

import binascii
import zlib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import reduce
from operator import xor
from types import MappingProxyType
from typing import Literal

__all__ = ["CHECKSUMS", "Checksum"]


def _crc8(data: bytes) -> int:
    value = 0
    for byte in data:
        value = _CRC8[value ^ byte]
    return value


def _crc16(data: bytes, table: Sequence[int]) -> int:
    value = 0xFFFF
    for byte in data:
        value = (value >> 8) ^ table[(value ^ byte) & 0xFF]
    return value


def _reflected(polynomial: int) -> tuple[int, ...]:
    table = []
    for value in range(256):
        for _ in range(8):
            value = (value >> 1) ^ (polynomial if value & 1 else 0)
        table.append(value)
    return tuple(table)


def _table8(polynomial: int) -> tuple[int, ...]:
    table = []
    for value in range(256):
        for _ in range(8):
            value = ((value << 1) ^ (polynomial if value & 0x80 else 0)) & 0xFF
        table.append(value)
    return tuple(table)


_CRC8 = _table8(0x07)
_MODBUS = _reflected(0xA001)
_CCITT = tuple(binascii.crc_hqx(bytes([value]), 0) for value in range(256))

#: Bytes and function of every checksum, by its name in a framing file.
CHECKSUMS: Mapping[str, tuple[int, Callable[[bytes], int]]] = MappingProxyType(
    {
        "sum8": (1, lambda data: sum(data) & 0xFF),
        "lrc8": (1, lambda data: -sum(data) & 0xFF),
        "xor8": (1, lambda data: reduce(xor, data, 0)),
        "crc8": (1, _crc8),
        "sum16": (2, lambda data: sum(data) & 0xFFFF),
        "crc16-ccitt": (2, lambda data: binascii.crc_hqx(data, 0xFFFF)),
        "crc16-xmodem": (2, lambda data: binascii.crc_hqx(data, 0)),
        "crc16-modbus": (2, lambda data: _crc16(data, _MODBUS)),
        # The table of the one direction, shifted in the other: so their controllers have it.
        "crc16-weiss": (2, lambda data: _crc16(data, _CCITT)),
        "crc32": (4, zlib.crc32),
    }
)


@dataclass(frozen=True)
class Checksum:
    """A checksum of a packet.

    Parameters
    ----------
    kind : str
        A key of `CHECKSUMS`.
    start : int
        The first byte of the packet that it counts; it counts all from there up to itself.
    endian : {"little", "big"}
        The order of its own bytes.
    """

    kind: str
    start: int = 0
    endian: Literal["little", "big"] = "little"

    @property
    def size(self) -> int:
        """How many bytes it has."""
        return CHECKSUMS[self.kind][0]

    def of(self, data: bytes) -> bytes:
        """Return the checksum of a packet's bytes before it."""
        size, function = CHECKSUMS[self.kind]
        return function(data[self.start :]).to_bytes(size, self.endian)
