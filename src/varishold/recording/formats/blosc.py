"""Blosc, version 1, as arrays are packed with it: blocks of streams by lz4, zlib or zstd, bytes or bits shuffled.

Everything that a piece says of its sizes is checked before a byte of it is unpacked.
"""

from __future__ import annotations

import struct

import numpy as np
from numpy.typing import NDArray

from varishold.recording.formats.packings import from_lz4, from_zlib, from_zstd

__all__ = ["from_blosc", "unshuffled"]

# Version of the container and of the packer, flags, bytes of a number, all bytes, bytes of a block, packed bytes.
_HEAD = struct.Struct("<BBBBIII")
_SHUFFLED, _PLAIN, _BITS, _UNSPLIT = 1, 2, 4, 16
_PACKERS = {1: from_lz4, 3: from_zlib, 4: from_zstd}
_NAMES = {0: "blosclz", 2: "snappy"}


def from_blosc(data: bytes, most: int) -> bytes:
    """Return what is packed.

    Parameters
    ----------
    data : bytes
    most : int
        Bytes that may come out.

    Raises
    ------
    ValueError
        If it is damaged, would be more, or is packed in a way that is not read.
    """
    version, _, flags, width, n_bytes, block, packed = _HEAD.unpack_from(data)
    if version not in (1, 2) or packed > len(data) or n_bytes > most or width < 1:
        raise ValueError(f"Blosc of version {version} says {n_bytes} bytes in {packed} of {len(data)}")
    if flags & _PLAIN:
        return data[_HEAD.size : _HEAD.size + n_bytes]
    if n_bytes and not 0 < block <= max(n_bytes, 1):
        raise ValueError(f"blocks of {block} bytes for {n_bytes}")
    packer = _PACKERS.get(flags >> 5)
    if packer is None:
        raise ValueError(f"packed by {_NAMES.get(flags >> 5, flags >> 5)} within Blosc, which is not read")
    n_blocks = -(-n_bytes // block) if n_bytes else 0
    places = struct.unpack_from(f"<{n_blocks}I", data, _HEAD.size)
    parts = []
    for number, at in enumerate(places):
        size = min(block, n_bytes - number * block)
        split = width if not flags & _UNSPLIT and size == block else 1
        streams = []
        for _ in range(split):
            (length,) = struct.unpack_from("<i", data, at)
            stream, each = data[at + 4 : at + 4 + length], size // split
            if length < 0 or len(stream) != length:
                raise ValueError(f"a stream of {length} bytes goes beyond the end")
            streams.append(stream if length == each else packer(stream, each))
            if len(streams[-1]) != each:
                raise ValueError(f"a stream of {each} bytes holds {len(streams[-1])}")
            at += 4 + length
        parts.append(_straight(b"".join(streams), flags, width))
    return b"".join(parts)


def _straight(block: bytes, flags: int, width: int) -> bytes:
    if flags & _SHUFFLED and width > 1:
        return unshuffled(block, width)
    if flags & _BITS:
        return _bits_unshuffled(block, width)
    return block


def unshuffled(block: bytes, width: int) -> bytes:
    """Return numbers of which the first bytes stand together, then the second, as they were."""
    many = len(block) // width
    return _bytes_of(block, many * width).reshape(width, many).T.tobytes() + block[many * width :]


def _bits_unshuffled(block: bytes, width: int) -> bytes:
    many = len(block) // width
    if many % 8:
        return block
    bits = np.unpackbits(_bytes_of(block, many * width), bitorder="little").reshape(8 * width, many)
    return np.packbits(bits.T, axis=None, bitorder="little").tobytes() + block[many * width :]


def _bytes_of(block: bytes, many: int) -> NDArray[np.uint8]:
    return np.frombuffer(block, np.uint8, many)
