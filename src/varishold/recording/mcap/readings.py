"""The readings of each topic, taken out of messages many at a time."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from varishold.errors import FormatError, InputError
from varishold.recording.mcap.chunk import Batch
from varishold.recording.mcap.container import Channel, Container
from varishold.recording.mcap.decoders import decoder_of
from varishold.recording.mcap.notes import note_of
from varishold.recording.mcap.parts import Decoder, MessageError, Part
from varishold.recording.mcap.topics import COUNTED, NOTES, STAMP, STRING, PadFacts

__all__ = ["Note", "Readings", "TopicReader"]


class Readings(NamedTuple):
    """Some readings of one topic, in the order in which they were written.

    Parameters
    ----------
    topic : str
    pad : str
        The pad's name within the message; empty where each message is one pad.
    at : ndarray of shape (n,), int64
        The place of each among all messages of the file.
    log_ns : ndarray of shape (n,), int64
        When each came, by the clock of the machine that wrote them.
    stamp : {"device", "host", "none"}
        Whose time the stamps are; "none" where neither clock was ever read.
    stamp_ns : ndarray of shape (n,), int64
    sequence : ndarray of shape (n,), int64, or None
        The sensor's own number of each; None where it sends none.
    number : ndarray of shape (n,), int64
        The number with which each was written: what was read together has the same.
    values : ndarray of shape (n, rows, cols); of signals (n, ...)
    facts : PadFacts or None
        What the messages say of the pad; None where that stands elsewhere.
    """

    topic: str
    pad: str
    at: NDArray[np.int64]
    log_ns: NDArray[np.int64]
    stamp: str
    stamp_ns: NDArray[np.int64]
    sequence: NDArray[np.int64] | None
    number: NDArray[np.int64]
    values: NDArray[Any]
    facts: PadFacts | None


class Note(NamedTuple):
    """What was said beside the readings: in which topic, when in nanoseconds since 1970, and what."""

    topic: str
    log_ns: int
    told: Mapping[str, Any]


class TopicReader:
    """Reads the messages of every topic that is understood; of the others it keeps the names.

    Parameters
    ----------
    contents : Container
    first : int
        The place of its first message among all.

    Attributes
    ----------
    notes : list of Note
        Presses, marks and zeros that were met so far.
    passed : dict of str to str
        The type of each topic that is not understood.
    reasons : dict of str to str
        What was wrong with each of them.
    """

    def __init__(self, contents: Container, *, first: int = 0) -> None:
        self.notes: list[Note] = []
        self.passed: dict[str, str] = {}
        self.reasons: dict[str, str] = {}
        self._contents = contents
        self._decoders: dict[int, Decoder] = {}
        self._n_seen = first

    def read(self, batch: Batch) -> Iterator[Readings]:
        """Yield what a batch holds of each pad.

        A topic of another program's that turns out not to be understood is passed over from there on.

        Raises
        ------
        FormatError
            If a message that was written here is not what its type says, or of another shape than those before.
        """
        channels, first = batch.heads["channel"], self._n_seen
        self._n_seen += len(channels)
        for number in np.unique(channels).tolist():
            channel, at = self._contents.channels[number], np.flatnonzero(channels == number)
            if channel.topic in NOTES and channel.type == STRING:
                self._take_notes(channel, batch, at)
            elif channel.topic not in self.passed:
                for read in self._readings(number, channel, batch, at):
                    yield read._replace(at=read.at + first)

    def _take_notes(self, channel: Channel, batch: Batch, at: NDArray[np.int64]) -> None:
        for k in at.tolist():
            log_ns = int(batch.heads["log_ns"][k])
            told = note_of(batch.content[batch.starts[k] : batch.stops[k]], where=self._place(channel, log_ns))
            self.notes.append(Note(channel.topic, log_ns, told))

    def _readings(self, number: int, channel: Channel, batch: Batch, at: NDArray[np.int64]) -> list[Readings]:
        coded = [batch.content[batch.starts[k] : batch.stops[k]] for k in at.tolist()]
        try:
            if number not in self._decoders:
                self._decoders[number] = decoder_of(channel)
            parts = self._decoders[number].read(coded)
        except (InputError, MessageError) as error:
            if STAMP in channel.metadata and isinstance(error, MessageError):
                place = self._place(channel, int(batch.heads["log_ns"][at[error.at]]))
                raise FormatError(f"{place}: {error}") from None
            self.passed[channel.topic] = channel.type or channel.encoding
            self.reasons[channel.topic] = str(error)
            return []
        return [_of_part(channel, part, batch.heads[at[part.at]], at[part.at]) for part in parts]

    def _place(self, channel: Channel, log_ns: int) -> str:
        return f"{self._contents.path}: topic {channel.topic}: message of {log_ns / 1e9:.6f} s"


def _of_part(channel: Channel, part: Part, heads: NDArray[Any], at: NDArray[np.int64]) -> Readings:
    log_ns, sent_ns, sequence = (heads[name].astype(np.int64) for name in ("log_ns", "sent_ns", "sequence"))
    # Of what others wrote only the message itself tells a time, and 0 is none.
    stamped = part.stamps_ns is not None and part.stamps_ns.any()
    stamp = channel.metadata.get(STAMP, "device" if stamped else "host")
    return Readings(
        channel.topic,
        part.pad,
        at,
        log_ns,
        stamp,
        sent_ns if part.stamps_ns is None else part.stamps_ns,
        sequence if channel.metadata.get(COUNTED) == "yes" else part.sequence,
        sequence,
        part.values,
        part.facts,
    )
