"""What an MCAP file holds, chunk by chunk; of one whose writer was killed, all that is whole.

A file that has its end must be right: whatever contradicts itself, a checksum included, is an error that names the
place. A file without an end was being written when its writer or its machine stopped: it is read up to what is
broken, and `Contents.early` says so.
"""

from __future__ import annotations

import os
import struct
import zlib
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from io import BytesIO
from typing import BinaryIO, Protocol

import numpy as np

from varishold._lazy import missing_extra
from varishold.errors import FormatError, InputError
from varishold.files import open_file
from varishold.recording.mcap.chunk import RECORD, Batch, messages_of, read_chunk
from varishold.recording.mcap.magic import MAGIC

try:
    from mcap import records
    from mcap.data_stream import ReadDataStream
    from mcap.exceptions import McapError
    from mcap.opcode import Opcode
    from zstandard import ZstdError
except ModuleNotFoundError as _missing:
    raise missing_extra(_missing) from None

__all__ = ["Channel", "Container", "Contents", "attachments_of", "opened_mcap"]

_FOOTER, _DATA_END = struct.Struct("<BQQQI"), struct.Struct("<BQI")
# All chunks may unpack to so much, or to so many times the file's size.
_MOST_UNPACKED, _BOMB_RATIO = 1 << 28, 300
# Bytes that are passed over at a time, messages outside of chunks that are given together, and the longest attachment
# that is kept: a sensor file or its maps.
_BLOCK, _TOGETHER, _ATTACHED = 1 << 20, 4096, 1 << 26
# What is said again elsewhere, or to others.
_PASSED = (Opcode.HEADER, Opcode.MESSAGE_INDEX)
_ENDS = (Opcode.DATA_END, Opcode.FOOTER)
# What is raised where damaged records are taken apart.
_DAMAGED = (McapError, ZstdError, struct.error, ValueError, RuntimeError, EOFError, OverflowError, MemoryError)


@dataclass(frozen=True)
class Channel:
    """What is known of the messages of a channel.

    Parameters
    ----------
    topic, type : str
        The type is its schema's name, as in ``sensor_msgs/msg/Image``; empty where there is none.
    encoding : str
        How messages are coded, as in ``cdr``.
    schema, schema_encoding : str
        What the type is, and in which language that is written.
    metadata : mapping of str to str
    """

    topic: str
    type: str
    encoding: str
    schema: str
    schema_encoding: str
    metadata: Mapping[str, str]


class Container(Protocol):
    """An open file of messages, and what was met in it so far: MCAP, or a bag of ROS."""

    path: str
    channels: dict[int, Channel]
    metadata: list[tuple[str, Mapping[str, str]]]
    attachments: dict[str, bytes]
    early: str

    def batches(self, place: int | None = None) -> Iterator[Batch]:
        """Yield the messages, some together, in the order in which they were written; from a batch's place on."""
        ...


class Contents:
    """An open MCAP file, and what was met in it so far.

    Attributes
    ----------
    channels : dict of int to Channel
    metadata : list of (str, mapping of str to str)
    attachments : dict of str to bytes
        The small ones.
    early : str
        How the file breaks off, told when that is met; empty where it has its end.
    """

    def __init__(self, path: str, file: BinaryIO) -> None:
        self.path = path
        self.channels: dict[int, Channel] = {}
        self.metadata: list[tuple[str, Mapping[str, str]]] = []
        self.attachments: dict[str, bytes] = {}
        self.early = ""
        self._schemas: dict[int, records.Schema] = {}
        self._file = file
        self._size = file.seek(0, os.SEEK_END)
        self._finished, self._told_crc = _end_of(file, self._size)
        self._crc: int | None = None
        self._unpacked = 0

    def batches(self, place: int | None = None) -> Iterator[Batch]:
        """Yield the messages of each chunk, in the order in which they were written.

        Parameters
        ----------
        place : int, optional
            Of a batch that was given before: it is the first. Default: all, and the file's checksum is compared.

        Raises
        ------
        FormatError
            If the file has its end and is damaged before it, or unpacks to far more than anything measured.
        """
        self._file.seek(place or 0)
        self._crc = 0 if self._told_crc and place is None else None
        self._unpacked = 0
        loose: list[bytes] = []
        begun = 0
        opcode = int(Opcode.HEADER)
        while opcode not in _ENDS:
            at, batch = self._file.tell(), None
            try:
                opcode, body = self._next() if at else self._begin()
                if opcode == Opcode.MESSAGE:
                    begun = begun if loose else at
                    loose.append(RECORD.pack(opcode, len(body)) + body)
                elif opcode == Opcode.CHUNK:
                    batch = self._chunk(body)
                else:
                    self._take(opcode, body)
            except _DAMAGED as error:
                self._break_off(at, error)
                opcode = Opcode.FOOTER
            if loose and (opcode != Opcode.MESSAGE or len(loose) == _TOGETHER):
                try:
                    yield self._checked(messages_of(b"".join(loose)))._replace(place=begun)
                except _DAMAGED as error:
                    self._break_off(begun, error)
                    opcode, batch = Opcode.FOOTER, None
                loose = []
            if batch is not None:
                yield batch._replace(place=at)

    def _begin(self) -> tuple[int, bytes]:
        if self._bytes(len(MAGIC)) != MAGIC:
            raise ValueError("it does not begin like MCAP")
        return Opcode.HEADER, b""

    def _next(self) -> tuple[int, bytes]:
        """Read the next record; what nobody asks for is passed over."""
        crc = self._crc
        opcode, length = RECORD.unpack(self._bytes(RECORD.size))
        left = self._size - self._file.tell()
        if opcode == 0 or length > left:
            raise EOFError(f"a record of kind {opcode} and {length} bytes begins where {left} are left")
        if opcode == Opcode.DATA_END and crc is not None and crc != self._told_crc:
            raise ValueError("the checksum of all before is not that of its bytes")
        if opcode in _PASSED or (opcode == Opcode.ATTACHMENT and length > _ATTACHED):
            self._pass(length)
            return Opcode.HEADER, b""
        return opcode, self._bytes(length)

    def _bytes(self, length: int) -> bytes:
        data = self._file.read(length)
        if len(data) < length:
            raise EOFError(f"{length} bytes are wanted where {len(data)} are left")
        if self._crc is not None:
            self._crc = zlib.crc32(data, self._crc)
        return data

    def _pass(self, length: int) -> None:
        if self._crc is None:
            self._file.seek(length, os.SEEK_CUR)
        else:
            for begun in range(0, length, _BLOCK):
                self._bytes(min(_BLOCK, length - begun))

    def _chunk(self, body: bytes) -> Batch:
        content = read_chunk(body)
        self._unpacked += len(content)
        if self._unpacked > max(_MOST_UNPACKED, _BOMB_RATIO * self._size):
            raise FormatError(
                f"{self.path}: would unpack to more than {self._unpacked} bytes; nothing measured is so empty"
            )
        batch = messages_of(content)
        for opcode, told in batch.told:
            self._take(opcode, told)
        return self._checked(batch)

    def _checked(self, batch: Batch) -> Batch:
        for channel in np.unique(batch.heads["channel"]).tolist():
            if channel not in self.channels:
                raise ValueError(f"a message is of channel {channel}, which was not described before")
        return batch

    def _take(self, opcode: int, body: bytes) -> None:
        """Keep what a record tells of all messages."""
        stream = ReadDataStream(BytesIO(body))
        if opcode == Opcode.SCHEMA:
            schema = records.Schema.read(stream)
            self._schemas[schema.id] = schema
        elif opcode == Opcode.CHANNEL:
            self._take_channel(records.Channel.read(stream))
        elif opcode == Opcode.METADATA:
            told = records.Metadata.read(stream)
            self.metadata.append((told.name, told.metadata))
        elif opcode == Opcode.ATTACHMENT:
            held = records.Attachment.read(stream)
            (crc,) = struct.unpack("<I", body[-4:])
            if crc and crc != zlib.crc32(body[:-4]):
                raise ValueError(f"the checksum of the file {held.name[:60]!r} in it is not that of its bytes")
            self.attachments[held.name] = held.data

    def _take_channel(self, told: records.Channel) -> None:
        schema = self._schemas.get(told.schema_id)
        if schema is None and told.schema_id:
            raise ValueError(f"channel {told.id} is of schema {told.schema_id}, which was not described before")
        name, text, language = (schema.name, schema.data, schema.encoding) if schema else ("", b"", "")
        self.channels[told.id] = Channel(
            told.topic, name, told.message_encoding, text.decode("utf-8", "replace"), language, told.metadata
        )

    def _break_off(self, at: int, error: Exception) -> None:
        if isinstance(error, InputError):
            raise error
        if self._finished:
            reason = " ".join(str(error).split()) or type(error).__name__
            raise FormatError(f"{self.path}: is damaged at byte {at} of {self._size}: {reason}")
        self.early = (
            f"the file has no end, as when its writer is killed: all is read that stands whole before byte {at} of "
            f"{self._size}"
        )


def _end_of(file: BinaryIO, size: int) -> tuple[bool, int]:
    """Tell whether a file has its end, and the checksum that it tells of its data; 0 where it tells none."""
    tail = _FOOTER.size + len(MAGIC)
    if size < len(MAGIC) + _DATA_END.size + tail:
        return False, 0
    file.seek(size - tail)
    end = file.read()
    opcode, length, summary, _, _ = _FOOTER.unpack_from(end)
    if end[_FOOTER.size :] != MAGIC or (opcode, length) != (Opcode.FOOTER, _FOOTER.size - RECORD.size):
        return False, 0
    before = (summary or size - tail) - _DATA_END.size
    if not len(MAGIC) <= before <= size - tail - _DATA_END.size:
        return True, 0
    file.seek(before)
    opcode, length, crc = _DATA_END.unpack(file.read(_DATA_END.size))
    return True, crc if (opcode, length) == (Opcode.DATA_END, 4) else 0


@contextmanager
def opened_mcap(path: str | os.PathLike[str]) -> Iterator[Contents]:
    """Open an MCAP file; nothing of it is read before `Contents.batches` is gone through.

    Raises
    ------
    InputError
        If it cannot be opened.
    """
    with open_file(path) as file:
        yield Contents(os.fspath(path), file)


def attachments_of(path: str | os.PathLike[str]) -> dict[str, bytes]:
    """Return the small files in an MCAP file that stand before its first message, by their names.

    Raises
    ------
    InputError
        If it cannot be opened, or is damaged before its first message.
    """
    with opened_mcap(path) as contents:
        next(contents.batches(), None)
        return contents.attachments
