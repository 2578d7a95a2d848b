"""Bags of ROS 1 (`.bag`, version 2.0), read from beginning to end; of one that breaks off, all that is whole."""

from __future__ import annotations

import bz2
import os
import struct
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, BinaryIO

import numpy as np

import varishold.recording.mcap as mapping
from varishold.errors import FormatError, InputError
from varishold.files import open_file
from varishold.recording.formats.format import Format, Options
from varishold.recording.formats.mcap import recording_of
from varishold.recording.messages.decoding import ros_type_name
from varishold.recording.recording import Recording
from varishold.recording.stored import Stored

if TYPE_CHECKING:
    from varishold.recording.mcap.chunk import Batch
    from varishold.recording.mcap.container import Channel

__all__ = ["FORMAT", "Bag"]

_MAGIC = b"#ROSBAG V"
_VERSION = b"#ROSBAG V2.0\n"
_HEAD, _CHUNK, _CONNECTION, _MESSAGE = 3, 5, 7, 2
_LENGTH, _TIME = struct.Struct("<I"), struct.Struct("<II")
# Bytes of a record's head and of a record, and to how much all chunks may unpack, at least or by the file's size.
_LONGEST_HEAD, _LONGEST, _MOST_UNPACKED, _BOMB_RATIO = 1 << 20, 1 << 28, 1 << 28, 300
_DAMAGED = (ValueError, EOFError, OSError, struct.error, KeyError, RuntimeError, MemoryError)


class Bag:
    """An open bag.

    Parameters
    ----------
    path : str
    file : binary file
    """

    def __init__(self, path: str, file: BinaryIO) -> None:
        self.path = path
        self.channels: dict[int, Channel] = {}
        self.metadata: list[tuple[str, Mapping[str, str]]] = []
        self.attachments: dict[str, bytes] = {}
        self.early = ""
        self._file = file
        self._size = file.seek(0, os.SEEK_END)
        self._unpacked = 0
        self._indexed = False

    def batches(self, place: int | None = None) -> Iterator[Batch]:
        """Yield the messages of each chunk, in the order in which they were written.

        Raises
        ------
        FormatError
            If the bag has its index and is damaged before it, or unpacks to far more than anything measured.
        """
        self._file.seek(0)
        if self._file.read(len(_VERSION)) != _VERSION:
            raise FormatError(f"{self.path}: is a bag of another version than 2.0; rosbag fix makes one of it")
        self._unpacked = 0
        self._file.seek(place or len(_VERSION))
        while (at := self._file.tell()) < self._size:
            try:
                head, length = self._next()
                kind = head["op"][0]
                if kind == _CHUNK:
                    batch = self._messages(self._chunk(head, self._bytes(length)))
                elif kind == _HEAD:
                    # A bag that was not closed has no index.
                    self._indexed = struct.unpack("<Q", head["index_pos"])[0] != 0
                    self._file.seek(length, os.SEEK_CUR)
                    continue
                elif kind == _CONNECTION:
                    self._connect(head, self._bytes(length))
                    continue
                else:
                    self._file.seek(length, os.SEEK_CUR)
                    continue
            except _DAMAGED as error:
                if isinstance(error, InputError):
                    raise
                self._break_off(at, " ".join(str(error).split()) or type(error).__name__)
                return
            yield batch._replace(place=at)

    def _next(self) -> tuple[dict[str, bytes], int]:
        """Return the head of the next record, and the length of its data, which follows."""
        (length,) = _LENGTH.unpack(self._bytes(4))
        if length > _LONGEST_HEAD:
            raise ValueError(f"a record's head of {length} bytes is announced")
        head = _fields(self._bytes(length))
        (length,) = _LENGTH.unpack(self._bytes(4))
        left = self._size - self._file.tell()
        if length > left:
            raise EOFError(f"{length} bytes are announced where {left} are left")
        return head, length

    def _bytes(self, length: int) -> bytes:
        if length > _LONGEST:
            raise ValueError(f"a record of {length} bytes is announced")
        data = self._file.read(length)
        if len(data) < length:
            raise EOFError(f"{length} bytes are wanted where {len(data)} are left")
        return data

    def _chunk(self, head: Mapping[str, bytes], data: bytes) -> bytes:
        from varishold.recording.mcap.chunk import check_growth, lz4_unpacked

        (size,) = _LENGTH.unpack(head["size"])
        packing = head["compression"].decode("ascii", "replace")
        check_growth(len(data), size)
        self._unpacked += size
        if self._unpacked > max(_MOST_UNPACKED, _BOMB_RATIO * self._size):
            raise FormatError(f"{self.path}: would unpack to {self._unpacked} bytes; nothing measured is so empty")
        if packing == "bz2":
            content = bz2.BZ2Decompressor().decompress(data, max_length=size + 1)
        elif packing == "lz4":
            content = lz4_unpacked(data, size)
        elif packing == "none":
            content = data
        else:
            raise ValueError(f"a chunk is packed with {packing[:20]!r}; known are bz2 and lz4")
        if len(content) != size:
            raise ValueError(f"{size} bytes are announced in a chunk, {len(content)} are there")
        return content

    def _messages(self, content: bytes) -> Batch:
        from varishold.recording.mcap.chunk import HEAD, Batch

        starts, stops, channels, times = [], [], [], []
        at, end = 0, len(content)
        while at < end:
            (length,) = _LENGTH.unpack_from(content, at)
            begun, at = at + 4, at + 4 + length
            (size,) = _LENGTH.unpack_from(content, at)
            at += 4
            if size > end - at:
                raise ValueError(f"{size} bytes are announced where {end - at} of a chunk are left")
            head = _fields(content[begun : begun + length])
            kind = head["op"][0]
            if kind == _CONNECTION:
                self._connect(head, content[at : at + size])
            elif kind == _MESSAGE:
                (channel,) = _LENGTH.unpack(head["conn"])
                if channel not in self.channels:
                    raise ValueError(f"a message is of connection {channel}, which was not described before")
                seconds, part = _TIME.unpack(head["time"])
                starts.append(at)
                stops.append(at + size)
                channels.append(channel)
                times.append(seconds * 10**9 + part)
            at += size
        heads = np.zeros(len(starts), HEAD)
        heads["channel"], heads["log_ns"] = channels, times
        heads["sent_ns"] = times
        return Batch(content, heads, starts, stops, [])

    def _connect(self, head: Mapping[str, bytes], data: bytes) -> None:
        from varishold.recording.mcap.container import Channel

        (number,) = _LENGTH.unpack(head["conn"])
        if number >= 1 << 16:
            raise ValueError(f"a connection has the number {number}")
        told = {name: value.decode("utf-8", "replace") for name, value in _fields(data).items()}
        kind = told["type"]
        try:
            kind = ros_type_name(kind)
        except InputError as error:
            raise ValueError(str(error)) from None
        topic = head["topic"].decode("utf-8", "replace")
        self.channels[number] = Channel(topic, kind, "ros1", told["message_definition"], "ros1msg", {})

    def _break_off(self, at: int, reason: str) -> None:
        if self._indexed:
            raise FormatError(f"{self.path}: is damaged at byte {at} of {self._size}: {reason}")
        self.early = (
            f"the bag has no index, as when its writer is killed: all is read that stands whole before byte {at} of "
            f"{self._size}"
        )


def _fields(data: bytes) -> dict[str, bytes]:
    """Return the fields of a record's head."""
    fields = {}
    at, end = 0, len(data)
    while at < end:
        (length,) = _LENGTH.unpack_from(data, at)
        stop = at + 4 + length
        split = data.find(b"=", at + 4, stop)
        if split < 0 or stop > end:
            raise ValueError(f"a field of {length} bytes stands in a head of {end}")
        fields[data[at + 4 : split].decode("ascii", "replace")] = data[split + 1 : stop]
        at = stop
    return fields


def _recognizes(path: Path, head: bytes) -> bool:
    return head.startswith(_MAGIC)


def _read(path: Path, options: Options) -> Recording:
    with open_file(path) as file:
        return recording_of(mapping.gathered(str(path), [Bag(str(path), file)]), path, options)


def _open(path: Path, options: Options) -> Stored:
    from varishold.recording.formats.mcap_stored import stored_topics

    file = open_file(path)
    try:
        return stored_topics(path, [Bag(str(path), file)], options, file.close)
    except BaseException:
        file.close()
        raise


FORMAT = Format("bag of ROS 1", (".bag",), _recognizes, _read, open=_open)
