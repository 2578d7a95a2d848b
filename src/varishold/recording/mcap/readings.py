"""The readings of each topic, taken out of messages many at a time."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from varishold.errors import FormatError
from varishold.recording.mcap.cdr import ImageLayout, NumbersLayout, image_layout, images, numbers_layout
from varishold.recording.mcap.chunk import Batch
from varishold.recording.mcap.container import Channel, Contents
from varishold.recording.mcap.notes import note_of
from varishold.recording.mcap.topics import COUNTED, IMAGE, NOTES, NUMBERS, STAMP, STRING, TYPE

__all__ = ["Note", "Readings", "TopicReader", "joined"]

_TYPE = re.compile(r"[<>|][iuf][1248]")
_NUMBERS = dict(NUMBERS.values())


class Readings(NamedTuple):
    """Some readings of one topic, in the order in which they were written.

    Parameters
    ----------
    topic : str
    at : ndarray of shape (n,), int64
        The place of each among all messages of the file.
    log_ns : ndarray of shape (n,), int64
        When each came, by the clock of the machine that wrote them.
    stamp : {"device", "host", "none"}
        Whose time the stamps are; "none" where neither clock was ever read.
    stamp_ns : ndarray of shape (n,), int64
    sequence : ndarray of shape (n,), int64, or None
        The sensor's own number of each; None where it sends none.
    values : ndarray of shape (n, rows, cols); of signals (n, ...)
    """

    topic: str
    at: NDArray[np.int64]
    log_ns: NDArray[np.int64]
    stamp: str
    stamp_ns: NDArray[np.int64]
    sequence: NDArray[np.int64] | None
    values: NDArray[Any]


class Note(NamedTuple):
    """What was said beside the readings: in which topic, when in nanoseconds since 1970, and what."""

    topic: str
    log_ns: int
    told: Mapping[str, Any]


class TopicReader:
    """Reads the messages of every topic that is understood; of the others it keeps the names.

    Attributes
    ----------
    notes : list of Note
        Presses, marks and zeros that were met so far.
    passed : dict of str to str
        The type of each topic that is not understood.
    """

    def __init__(self, contents: Contents) -> None:
        self.notes: list[Note] = []
        self.passed: dict[str, str] = {}
        self._contents = contents
        self._decoders: dict[int, _Decoder | None] = {}
        self._n_seen = 0

    def read(self, batch: Batch) -> Iterator[Readings]:
        """Yield what a batch holds of each channel.

        Raises
        ------
        FormatError
            If a message is not what its type says, or of another shape than those before.
        """
        channels, first = batch.heads["channel"], self._n_seen
        self._n_seen += len(channels)
        for number in np.unique(channels).tolist():
            channel = self._contents.channels[number]
            if channel.topic in NOTES and channel.type == STRING:
                self._take_notes(channel, batch, np.flatnonzero(channels == number))
                continue
            if number not in self._decoders:
                self._decoders[number] = _decoder_of(channel)
            decoder = self._decoders[number]
            if decoder is None:
                self.passed[channel.topic] = channel.type or channel.encoding
            else:
                read = self._readings(channel, decoder, batch, np.flatnonzero(channels == number))
                yield read._replace(at=read.at + first)

    def _take_notes(self, channel: Channel, batch: Batch, at: NDArray[np.int64]) -> None:
        for k in at.tolist():
            log_ns = int(batch.heads["log_ns"][k])
            where = f"{self._contents.path}: topic {channel.topic}: message of {log_ns / 1e9:.6f} s"
            told = note_of(batch.content[batch.starts[k] : batch.stops[k]], where=where)
            self.notes.append(Note(channel.topic, log_ns, told))

    def _readings(self, channel: Channel, decoder: _Decoder, batch: Batch, at: NDArray[np.int64]) -> Readings:
        heads = batch.heads[at]
        log_ns, sent_ns, sequence = (heads[name].astype(np.int64) for name in ("log_ns", "sent_ns", "sequence"))
        coded = [batch.content[batch.starts[k] : batch.stops[k]] for k in at.tolist()]
        parts, begun = [], 0
        for k, message in enumerate(coded):
            if not decoder.fits(message):
                if k > begun:
                    parts.append(decoder.take(coded[begun:k]))
                begun = k
                try:
                    decoder.learn(message)
                except ValueError as error:
                    place = f"{self._contents.path}: topic {channel.topic}: message of {log_ns[k] / 1e9:.6f} s"
                    raise FormatError(f"{place}: {error}") from None
        parts.append(decoder.take(coded[begun:]))
        stamps = [part[0] for part in parts if part[0] is not None]
        return Readings(
            channel.topic,
            at,
            log_ns,
            channel.metadata.get(STAMP, "device"),
            np.concatenate(stamps) if stamps else sent_ns,
            sequence if channel.metadata.get(COUNTED) == "yes" else None,
            joined([part[1] for part in parts]),
        )


def joined(parts: list[NDArray[Any]]) -> NDArray[Any]:
    """Return arrays as one; what is of one type stays so, the order of its bytes included."""
    types = {part.dtype for part in parts}
    return parts[0] if len(parts) == 1 else np.concatenate(parts, dtype=types.pop() if len(types) == 1 else None)


class _Decoder(Protocol):
    """Takes values out of messages of a channel that are laid out alike."""

    def fits(self, message: bytes) -> bool:
        """Tell whether a message is laid out as the one that was learned last."""
        ...

    def learn(self, message: bytes) -> None:
        """Learn how a message is laid out; raises ValueError where it is not what its type says."""
        ...

    def take(self, messages: list[bytes]) -> tuple[NDArray[np.int64] | None, NDArray[Any]]:
        """Return the stamps, if they have any, and the values of messages that fit."""
        ...


def _decoder_of(channel: Channel) -> _Decoder | None:
    if channel.encoding != "cdr":
        return None
    told = channel.metadata.get(TYPE, "")
    dtype = np.dtype(told) if _TYPE.fullmatch(told) else None
    if channel.type == IMAGE:
        return _Images(dtype)
    if channel.type in _NUMBERS:
        return _Numbers(np.dtype(_NUMBERS[channel.type]), dtype)
    return None


class _Images:
    """Images of one shape, in whichever encoding each of them is."""

    def __init__(self, dtype: np.dtype[Any] | None) -> None:
        self._dtype = dtype
        self._layout: ImageLayout | None = None

    def fits(self, message: bytes) -> bool:
        return self._layout is not None and self._layout.fits(message)

    def learn(self, message: bytes) -> None:
        layout, before = image_layout(message), self._layout
        # Numbers that no float holds are written as their bytes.
        packed = self._dtype is not None and layout.channels == self._dtype.itemsize and layout.dtype.itemsize == 1
        if layout.channels != 1 and not packed:
            raise ValueError(f"has {layout.channels} numbers a pixel; pressure has one")
        if before is not None and (layout.rows, layout.cols) != (before.rows, before.cols):
            raise ValueError(
                f"has {layout.rows} x {layout.cols} pixels, those before have {before.rows} x {before.cols}"
            )
        if self._dtype is None:
            self._dtype = layout.dtype.newbyteorder("=")
        self._layout = layout

    def take(self, messages: list[bytes]) -> tuple[NDArray[np.int64] | None, NDArray[Any]]:
        assert self._layout is not None
        stamps, values = images(messages, self._layout)
        if self._dtype is not None and self._layout.channels > 1:
            # Bytes as channels are put together again.
            values = values.view(self._dtype.newbyteorder("<"))
        return stamps, _typed(values[..., 0], self._dtype)


class _Numbers:
    """Multi-arrays of one shape."""

    def __init__(self, coded: np.dtype[Any], dtype: np.dtype[Any] | None) -> None:
        self._coded = coded
        self._dtype = dtype or coded.newbyteorder("=")
        self._layout: NumbersLayout | None = None

    def fits(self, message: bytes) -> bool:
        return self._layout is not None and self._layout.fits(message)

    def learn(self, message: bytes) -> None:
        layout, before = numbers_layout(message, self._coded), self._layout
        if before is not None and layout.shape != before.shape:
            raise ValueError(f"has numbers of shape {layout.shape}, those before have {before.shape}")
        self._layout = layout

    def take(self, messages: list[bytes]) -> tuple[NDArray[np.int64] | None, NDArray[Any]]:
        assert self._layout is not None
        data = b"".join([message[len(self._layout.head) :] for message in messages])
        values = np.frombuffer(data, self._layout.dtype).reshape(len(messages), *self._layout.shape)
        return None, _typed(values, self._dtype)


def _typed(values: NDArray[Any], dtype: np.dtype[Any] | None) -> NDArray[Any]:
    """Return values in the type in which they were given."""
    if dtype is None:
        return values
    with np.errstate(invalid="ignore", over="ignore"):
        return values.astype(dtype, copy=False)
