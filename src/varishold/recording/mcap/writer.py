"""Readings of pads written to an MCAP file as they come."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, BinaryIO, Protocol, cast

from numpy.typing import NDArray

from varishold._lazy import missing_extra
from varishold.recording.mcap.cdr import string_message
from varishold.recording.mcap.coding import MessageCoder
from varishold.recording.mcap.notes import note_text
from varishold.recording.mcap.topics import (
    COUNTED,
    PAD,
    SCHEMAS,
    STAMP,
    STRING,
    TYPE,
    PadFacts,
    topic_of,
)

try:
    from mcap.writer import Writer
except ModuleNotFoundError as _missing:
    raise missing_extra(_missing) from None

__all__ = ["TopicWriter"]

# Chunks end where readings end, so that none is torn; this is larger than any.
_NO_CHUNK = 1 << 60
# A chunk is ended, at the latest, when it holds so many bytes.
_CHUNK = 1 << 20
_LATEST_NS = 2**63 - 1


class Output(Protocol):
    """What is written to: a binary file, or what does the same."""

    def write(self, data: bytes, /) -> int: ...
    def tell(self) -> int: ...
    def flush(self) -> None: ...


class TopicWriter:
    """Writes readings, and what is said of them, to an open file.

    Parameters
    ----------
    file : binary file
    kind : str
        What the file is, by which it is known again: ``recording``, which can be made again, or ``measurement``.
    """

    def __init__(self, file: Output, kind: str = "recording") -> None:
        self._file = file
        self._writer = Writer(cast("BinaryIO", file), chunk_size=_NO_CHUNK, enable_data_crcs=True)
        self._writer.start("ros2", f"varishold {kind}")
        self._facts: dict[str, PadFacts] = {}
        self._schemas: dict[str, int] = {}
        self._channels: dict[tuple[str, ...], int] = {}
        self._coder = MessageCoder()
        self._waiting = 0
        self._n_readings = 0

    def describe(self, facts: PadFacts) -> None:
        """Say what a pad is, before its first reading."""
        self._facts[facts.name] = facts
        self.record(PAD, facts.record())

    def record(self, name: str, told: Mapping[str, str]) -> None:
        """Say something of the whole file."""
        self._writer.add_metadata(name, {key: _possible(value) for key, value in told.items()})

    def attach(self, name: str, content: bytes, kind: str = "application/octet-stream") -> None:
        """Put a file into the file."""
        self._writer.add_attachment(0, 0, name, kind, content)

    def tell(self, topic: str, told: Mapping[str, Any], *, log_ns: int) -> None:
        """Write what happened as a message of JSON text."""
        self._message(topic, STRING, {}, string_message(note_text(told)), log_ns, log_ns, 0)

    def reading(
        self,
        pads: Mapping[str, NDArray[Any]],
        *,
        log_ns: int,
        device_ns: int | None = None,
        sequence: int | None = None,
        timed: bool = True,
    ) -> None:
        """Write one reading of some pads.

        Parameters
        ----------
        pads : mapping of str to ndarray
            (rows, cols), or (n,) of taxels on no grid; of signals one to three axes.
        log_ns : int
            When it came, nanoseconds since 1970.
        device_ns : int, optional
            The sensor's own time, nanoseconds.
        sequence : int, optional
            The sensor's own number; 32 bits of it are kept. Default: readings are counted.
        timed : bool
            False where `log_ns` was read from no clock.
        """
        notes = {STAMP: "device" if device_ns is not None else "host" if timed else "none"}
        if sequence is not None:
            notes[COUNTED] = "yes"
        number = (self._n_readings if sequence is None else sequence) % 2**32
        self._n_readings += 1
        stamp_ns = log_ns if device_ns is None else device_ns
        for name, values in pads.items():
            if name not in self._facts:
                self.describe(PadFacts(name))
            kind, message = self._coder.coded(self._facts[name], values, stamp_ns)
            told = {**notes, TYPE: values.dtype.str}
            self._message(topic_of(name), kind, told, message, log_ns, stamp_ns, number)
        if self._waiting > _CHUNK:
            self.flush()

    def _message(
        self, topic: str, kind: str, told: dict[str, str], content: bytes, log_ns: int, sent_ns: int, sequence: int
    ) -> None:
        key = (topic, kind, *told.values())
        channel = self._channels.get(key)
        if channel is None:
            if kind not in self._schemas:
                self._schemas[kind] = self._writer.register_schema(kind, "ros2msg", SCHEMAS[kind].encode())
            channel = self._writer.register_channel(topic, "cdr", self._schemas[kind], told)
            self._channels[key] = channel
        log_ns = min(max(log_ns, 0), _LATEST_NS)
        sent_ns = sent_ns if 0 <= sent_ns <= _LATEST_NS else log_ns
        self._writer.add_message(channel, log_ns, content, sent_ns, sequence)
        self._waiting += len(content)

    def flush(self) -> None:
        """Hand over all that was written so far: whoever opens the file now finds it."""
        self._writer.flush()  # type: ignore[no-untyped-call]
        self._waiting = 0

    def finish(self) -> None:
        """Write the file's end."""
        self._writer.finish()  # type: ignore[no-untyped-call]
        self._file.flush()


def _possible(text: str) -> str:
    """Return a text that can be coded: halves of surrogate pairs cannot."""
    return text.encode("utf-8", "replace").decode()
