"""Bytes that were packed by usual packers, unpacked to no more than is said beforehand."""

from __future__ import annotations

import struct
import zlib

from varishold._lazy import missing_extra

__all__ = ["from_gzip", "from_lz4", "from_sized_lz4", "from_zlib", "from_zstd"]

_GZIP = 16 + zlib.MAX_WBITS
# Bytes of the window that a packer may look back in.
_WINDOW = 1 << 27


def from_zlib(data: bytes, most: int) -> bytes:
    """Return what zlib packed; ValueError where that is more than `most` bytes."""
    return _inflated(data, most, zlib.MAX_WBITS)


def from_gzip(data: bytes, most: int) -> bytes:
    """Return what gzip packed; ValueError where that is more than `most` bytes."""
    return _inflated(data, most, _GZIP)


def _inflated(data: bytes, most: int, kind: int) -> bytes:
    unpacking = zlib.decompressobj(kind)
    unpacked = unpacking.decompress(data, most + 1)
    if len(unpacked) > most or not unpacking.eof:
        raise ValueError(f"does not unpack to {most} bytes")
    return unpacked


def from_zstd(data: bytes, most: int) -> bytes:
    """Return what zstd packed; ValueError where that is more than `most` bytes.

    Raises
    ------
    MissingExtraError
        If zstandard is not installed.
    """
    try:
        import zstandard
    except ModuleNotFoundError as error:
        raise missing_extra(error) from None
    try:
        with zstandard.ZstdDecompressor(max_window_size=_WINDOW).stream_reader(data) as reader:
            unpacked: bytes = reader.read(most + 1)
    except zstandard.ZstdError as error:
        raise ValueError(str(error)) from error
    if len(unpacked) > most:
        raise ValueError(f"does not unpack to {most} bytes")
    return unpacked


def from_lz4(data: bytes, most: int) -> bytes:
    """Return what lz4 packed as a block; ValueError where that is more than `most` bytes.

    Raises
    ------
    MissingExtraError
        If lz4 is not installed.
    """
    try:
        from lz4 import block
    except ModuleNotFoundError as error:
        raise missing_extra(error) from None
    try:
        unpacked: bytes = block.decompress(data, uncompressed_size=most)
    except block.LZ4BlockError as error:
        raise ValueError(str(error)) from error
    return unpacked


def from_sized_lz4(data: bytes, most: int) -> bytes:
    """Return what lz4 packed behind the number of its bytes; errors as of `from_lz4`."""
    (size,) = struct.unpack_from("<I", data)
    if size > most:
        raise ValueError(f"says {size} bytes; {most} are the most")
    return from_lz4(data[4:], size)
