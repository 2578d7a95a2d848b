"""A chunk unpacked within bounds, and the messages in it."""

from __future__ import annotations

import struct
import zlib
from io import BytesIO
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from varishold._counted import counted
from varishold._lazy import missing_extra

try:
    import lz4.frame
    import zstandard
    from mcap.data_stream import ReadDataStream
    from mcap.opcode import Opcode
    from mcap.records import Chunk
except ModuleNotFoundError as _missing:
    raise missing_extra(_missing) from None

__all__ = ["HEAD", "RECORD", "Batch", "check_growth", "lz4_unpacked", "messages_of", "read_chunk"]

#: What stands before every record: its kind and its length.
RECORD = struct.Struct("<BQ")
#: And before every message.
HEAD = np.dtype([("channel", "<u2"), ("sequence", "<u4"), ("log_ns", "<u8"), ("sent_ns", "<u8")])
# What describes messages.
_TELLING = (Opcode.SCHEMA, Opcode.CHANNEL)
# A chunk that unpacks to more than this, and to so many times its size, holds nothing measured; a resting sensor's
# messages reach half of that.
_LARGE, _BOMB_RATIO = 1 << 24, 300


class Batch(NamedTuple):
    """Messages that stand together.

    Parameters
    ----------
    content : bytes
        In which they stand.
    heads : structured ndarray of shape (n,)
        Of each message its channel, its sequence, and in nanoseconds since 1970 when it was written and sent.
    starts, stops : list of int
        Where each message's own bytes are.
    told : list of (int, bytes)
        The schemas and channels among them: their kind and their bytes.
    place : int
        From which the container goes on with these messages.
    """

    content: bytes
    heads: NDArray[Any]
    starts: list[int]
    stops: list[int]
    told: list[tuple[int, bytes]]
    place: int = 0


def read_chunk(record: bytes) -> bytes:
    """Return the content of a chunk.

    Raises
    ------
    ValueError
        If it would unpack to far more than anything measured, to another size than it says, or not to its checksum;
        and, as all that is read of an MCAP file, whatever the packing raises where it is damaged.
    """
    chunk = Chunk.read(ReadDataStream(BytesIO(record)))
    size = chunk.uncompressed_size
    check_growth(len(chunk.data), size)
    content = _unpacked(chunk)
    if len(content) != size:
        raise ValueError(f"{size} bytes are announced, {len(content)} there")
    if chunk.uncompressed_crc and zlib.crc32(content) != chunk.uncompressed_crc:
        raise ValueError("its checksum is not that of its bytes")
    return content


def check_growth(packed: int, size: int) -> None:
    """Raise ValueError where a chunk would unpack to far more than anything measured."""
    if size > max(_LARGE, _BOMB_RATIO * packed):
        raise ValueError(f"{counted(packed, 'byte')} would unpack to {size}; nothing measured is so empty")


def lz4_unpacked(data: bytes, size: int) -> bytes:
    """Unpack no more than `size` bytes, and one."""
    return bytes(lz4.frame.LZ4FrameDecompressor().decompress(data, max_length=size + 1))


def _unpacked(chunk: Chunk) -> bytes:
    """Unpack no more than the chunk says it holds, and one byte."""
    size = chunk.uncompressed_size
    if chunk.compression == "":
        return chunk.data
    if chunk.compression == "zstd":
        # A size that the packing announces is taken for true by it.
        if zstandard.frame_content_size(chunk.data) not in (-1, size):
            raise ValueError(f"{size} bytes are announced, its packing says otherwise")
        return zstandard.ZstdDecompressor().decompress(chunk.data, max_output_size=max(size, 1))
    if chunk.compression == "lz4":
        return lz4_unpacked(chunk.data, size)
    raise ValueError(f"it is packed with {chunk.compression[:20]!r}; known are zstd and lz4")


def messages_of(content: bytes) -> Batch:
    """Find the messages among the records of a chunk.

    Raises
    ------
    ValueError
        If a record reaches beyond the end.
    """
    starts: list[int] = []
    stops: list[int] = []
    told = []
    at, end = 0, len(content)
    record, message = RECORD.unpack_from, int(Opcode.MESSAGE)
    while at < end:
        if at + RECORD.size > end:
            raise ValueError(f"a record begins at byte {at} of {end}")
        opcode, length = record(content, at)
        at += RECORD.size
        if opcode == 0 or length > end - at or (opcode == message and length < HEAD.itemsize):
            raise ValueError(f"a record of kind {opcode} and {length} bytes stands at byte {at} of {end}")
        if opcode == message:
            starts.append(at + HEAD.itemsize)
            stops.append(at + length)
        elif opcode in _TELLING:
            told.append((opcode, content[at : at + length]))
        at += length
    places = np.array(starts, np.int64)[:, None] + np.arange(-HEAD.itemsize, 0)
    heads = np.frombuffer(content, np.uint8)[places].view(HEAD)[:, 0]
    return Batch(content, heads, starts, stops, told)
