"""Bags of ROS 2: a database of messages (`.db3`), or the folder that `ros2 bag record` makes, of databases or MCAP."""

from __future__ import annotations

import os
import re
import sqlite3
import time
from collections.abc import Iterator, Mapping
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING, Any
from urllib.parse import quote

import numpy as np

import varishold.recording.mcap as mapping
from varishold.errors import FormatError, InputError
from varishold.files import open_file, read_bytes
from varishold.recording.formats.format import Format, Options
from varishold.recording.formats.mcap import recording_of
from varishold.recording.recording import Recording
from varishold.recording.stored import Stored

if TYPE_CHECKING:
    from varishold.recording.mcap.chunk import Batch
    from varishold.recording.mcap.container import Channel, Container

__all__ = ["FOLDER", "FORMAT", "Database"]

_MAGIC, _ENDINGS, _PACKED = b"SQLite format 3\0", (".db3", ".mcap"), (".db3.zstd", ".mcap.zstd")
_METADATA, _MOST_METADATA = "metadata.yaml", 1 << 24
# Messages that are given together, bytes of the longest, and topics.
_TOGETHER, _LONGEST, _MOST_TOPICS = 1024, 1 << 28, 4096
# A damaged table may lead in a circle: so many steps of the database's machine without a row, and so many seconds.
_STEPS, _WAITS_S = 100_000, 4.0
_DAMAGED = (sqlite3.Error, UnicodeError, OverflowError)
_NUMBER = re.compile(r"(\d+)")


class Database:
    """An open database of messages.

    Parameters
    ----------
    path : Path

    Raises
    ------
    InputError
        If it cannot be opened.
    FormatError
        If it is damaged, or no database of a bag.
    """

    def __init__(self, path: Path) -> None:
        self.path = str(path)
        self.channels: dict[int, Channel] = {}
        self.metadata: list[tuple[str, Mapping[str, str]]] = []
        self.attachments: dict[str, bytes] = {}
        self.early = ""
        with open_file(path) as file:
            if os.fspath(path) == "-":
                raise InputError("-: a database is read from a file; save it to one")
            if file.read(len(_MAGIC)) != _MAGIC:
                raise FormatError(f"{path}: does not start like SQLite; is it damaged, or something else?")
        self._since = time.monotonic()
        address = f"file:{quote(str(path.absolute()))}?mode=ro&immutable=1"
        try:
            self._base = sqlite3.connect(address, uri=True, check_same_thread=False)
            self._base.set_progress_handler(lambda: time.monotonic() - self._since > _WAITS_S, _STEPS)
            self._base.text_factory = lambda text: text.decode("utf-8", "replace")
            # Nothing that a file brings with it is run.
            for pragma in ("trusted_schema=OFF", "cell_size_check=ON", "mmap_size=0", "query_only=ON"):
                self._base.execute(f"PRAGMA {pragma}")
            self._base.setlimit(sqlite3.SQLITE_LIMIT_LENGTH, _LONGEST)
            self._take_topics()
        except _DAMAGED as error:
            raise self._damaged(error) from error

    def close(self) -> None:
        """Let the file go. May be called again."""
        self._base.close()

    def _damaged(self, error: Exception) -> FormatError:
        reason = "it leads in a circle" if str(error) == "interrupted" else " ".join(str(error).split())[:200]
        return FormatError(f"{self.path}: is damaged or cut off: {reason}")

    def _rows(self, query: str) -> Iterator[tuple[Any, ...]]:
        self._since = time.monotonic()
        cursor = self._base.execute(query)
        while rows := cursor.fetchmany(_TOGETHER):
            self._since = time.monotonic()
            yield from rows

    def _take_topics(self) -> None:
        from varishold.recording.mcap.container import Channel

        # A view is a program.
        tables = {
            str(name)
            for name, sql in self._rows("SELECT name, sql FROM sqlite_master WHERE type = 'table' LIMIT 1000")
            if re.match(r"\s*CREATE\s+TABLE\b", str(sql), re.IGNORECASE)
        }
        if not tables >= {"topics", "messages"}:
            raise FormatError(f"{self.path}: is a database without the tables topics and messages, and so no bag")
        texts: dict[str, tuple[str, str]] = {}
        if "message_definitions" in tables:
            asked = "SELECT topic_type, encoding, encoded_message_definition FROM message_definitions LIMIT 4096"
            texts = {str(kind): (str(coding), str(text)) for kind, coding, text in self._rows(asked)}
        asked = f"SELECT id, name, type, serialization_format FROM topics LIMIT {_MOST_TOPICS}"
        for number, name, kind, coding in self._rows(asked):
            if not isinstance(number, int) or not 0 <= number < 1 << 16:
                raise FormatError(f"{self.path}: is damaged: a topic has the number {str(number)[:40]!r}")
            language, text = texts.get(str(kind), ("", ""))
            self.channels[number] = Channel(str(name), str(kind), str(coding), text, language, {})

    def batches(self, place: int | None = None) -> Iterator[Batch]:
        """Yield the messages, some together, in the order in which they were written.

        Raises
        ------
        FormatError
            If a row is damaged.
        """
        from varishold.recording.mcap.chunk import HEAD, Batch

        try:
            self._since = time.monotonic()
            asked = "SELECT topic_id, timestamp, data, rowid FROM messages WHERE rowid >= ? ORDER BY rowid"
            cursor = self._base.execute(asked, (-(2**63) if place is None else place,))
            while rows := cursor.fetchmany(_TOGETHER):
                for topic, stamp, data, _ in rows:
                    if topic not in self.channels or not isinstance(stamp, int) or not isinstance(data, bytes):
                        raise FormatError(
                            f"{self.path}: is damaged: a message of topic {str(topic)[:20]} at {str(stamp)[:20]} ns is "
                            f"{type(data).__name__}"
                        )
                heads = np.zeros(len(rows), HEAD)
                heads["channel"] = [row[0] for row in rows]
                heads["log_ns"] = heads["sent_ns"] = [min(max(row[1], 0), 2**63 - 1) for row in rows]
                stops = np.cumsum([len(row[2]) for row in rows])
                starts = stops - [len(row[2]) for row in rows]
                yield Batch(b"".join([row[2] for row in rows]), heads, starts.tolist(), stops.tolist(), [], rows[0][3])
                self._since = time.monotonic()
        except _DAMAGED as error:
            raise self._damaged(error) from error


def _recognizes(path: Path, head: bytes) -> bool:
    return head.startswith(_MAGIC)


def _recognizes_folder(path: Path, head: bytes) -> bool:
    try:
        names = os.listdir(path)
    except OSError:
        return False
    parts = [name for name in names if name.endswith((*_ENDINGS, *_PACKED))]
    return bool(parts) and (_METADATA in names or all(name.endswith((".db3", ".db3.zstd")) for name in parts))


def _read(path: Path, options: Options) -> Recording:
    with ExitStack() as stack:
        held = mapping.gathered(str(path), _containers(path, stack))
    return recording_of(held, path, options)


def _open(path: Path, options: Options) -> Stored:
    from varishold.recording.formats.mcap_stored import stored_topics

    stack = ExitStack()
    try:
        return stored_topics(path, _containers(path, stack), options, stack.close)
    except BaseException:
        stack.close()
        raise


def _containers(path: Path, stack: ExitStack) -> Iterator[Container]:
    """Open a bag: a database, or the files of a folder, one after another, in their order."""
    if not path.is_dir():
        base = Database(path)
        stack.callback(base.close)
        yield base
        return
    if (path / _METADATA).exists():
        said = read_bytes(path / _METADATA, most=_MOST_METADATA)
        if re.search(rb"compression_mode:\s*['\"]?MESSAGE", said, re.IGNORECASE):
            raise FormatError(f"{path}: has messages that are packed one by one; convert it (ros2 bag convert) first")
    names = [name for name in os.listdir(path) if name.endswith((*_ENDINGS, *_PACKED))]
    packed = [name for name in names if name.endswith(_PACKED)]
    if packed:
        raise FormatError(f"{path / packed[0]}: is compressed with zstd; unpack it first (unzstd)")
    for name in sorted(names, key=lambda name: [int(p) if p.isdigit() else p for p in _NUMBER.split(name)]):
        if name.endswith(".mcap"):
            yield stack.enter_context(mapping.opened_mcap(path / name))
        else:
            base = Database(path / name)
            stack.callback(base.close)
            yield base


FORMAT = Format("bag of ROS 2 (database)", (".db3",), _recognizes, _read, open=_open)
FOLDER = Format("bag of ROS 2 (folder)", (), _recognizes_folder, _read, open=_open, folder=True)
