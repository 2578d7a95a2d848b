"""The readings of topics, some at a time: gone through once as the file is opened, read again as they are wanted."""

from __future__ import annotations

from array import array
from collections import OrderedDict
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from varishold.errors import FormatError
from varishold.recording.mcap.container import Container
from varishold.recording.mcap.gathering import Gathered, described_pads, empty_words, pad_names
from varishold.recording.mcap.parts import joined
from varishold.recording.mcap.readings import Readings, TopicReader
from varishold.recording.mcap.topics import PAD, PadFacts

__all__ = ["StreamedSeries", "TopicStream"]

# Bytes of values that are kept because they may be wanted again.
_KEPT = 1 << 25
_Key = tuple[str, str]


class StreamedSeries:
    """What is known of all readings of a pad without holding them.

    Attributes
    ----------
    facts : PadFacts
    log_ns : ndarray of shape (n,), int64
        When each came. Writeable.
    stamp : {"device", "host", "none"}
        Whose time the stamps are.
    shape : tuple of int
        Of a reading.
    dtype : dtype
    finite : ndarray of that shape, bool
        Where every reading was a number.
    """

    def __init__(self, first: Readings) -> None:
        self.shape: tuple[int, ...] = first.values.shape[1:]
        self.dtype: np.dtype[Any] = first.values.dtype
        self.finite = np.ones(self.shape, bool)
        self.facts = first.facts or PadFacts("")
        self._stamps: set[str] = set()
        self._log = array("q")
        self._counts = array("q")
        self.place = 0

    def take(self, path: str, piece: int, some: Readings) -> None:
        """Learn of some readings, which a piece of the file holds."""
        if some.values.shape[1:] != self.shape:
            raise FormatError(
                f"{path}: topic {some.topic}: message of {some.log_ns[0] / 1e9:.6f} s has shape "
                f"{some.values.shape[1:]}, those before have {self.shape}"
            )
        self._counts.extend([0] * (piece + 1 - len(self._counts)))
        self._counts[piece] += len(some.log_ns)
        self._log.frombytes(some.log_ns.tobytes())
        self._stamps.add(some.stamp)
        if some.values.dtype != self.dtype:
            self.dtype = np.result_type(self.dtype, some.values.dtype)
        if self.dtype.kind == "f":
            self.finite &= np.isfinite(some.values).all(axis=0)

    def finish(self) -> None:
        """Make the arrays, when all has been learnt."""
        self.log_ns = np.frombuffer(self._log, np.int64)
        self.ends = np.cumsum(np.frombuffer(self._counts, np.int64))

    @property
    def stamp(self) -> str:
        # Where the sensor sends its time only now and then, all are by the other clock.
        return next(iter(self._stamps)) if len(self._stamps) == 1 else "host"


class TopicStream:
    """All topics of containers that follow one another.

    Parameters
    ----------
    path : str
        For messages.
    containers : iterable of Container
        They stay open as long as anything is read.

    Attributes
    ----------
    pads : dict of str to StreamedSeries
    held : Gathered
        All beside the readings.

    Raises
    ------
    FormatError
        If one is damaged, or they hold nothing that is understood.
    """

    def __init__(self, path: str, containers: Iterable[Container]) -> None:
        self._path = path
        self._containers: list[Container] = []
        self._pieces: list[tuple[int, int]] = []
        self._kept: OrderedDict[int, dict[_Key, Readings]] = OrderedDict()
        self._running: Iterator[dict[_Key, Readings]] = iter(())
        self._next = -1
        found: dict[_Key, StreamedSeries] = {}
        readers: list[TopicReader] = []
        n_messages = 0
        for number, contents in enumerate(containers):
            self._containers.append(contents)
            reader = TopicReader(contents, first=n_messages)
            readers.append(reader)
            for batch in contents.batches():
                n_messages += len(batch.heads)
                piece = len(self._pieces)
                self._pieces.append((number, batch.place))
                for key, some in _by_pad(reader.read(batch)).items():
                    if key not in found:
                        found[key] = StreamedSeries(some)
                    found[key].take(path, piece, some)
        self.held = self._held(readers)
        self.pads = self._named({key: each for key, each in found.items() if key[0] not in self.held.passed}, readers)

    def _held(self, readers: list[TopicReader]) -> Gathered:
        return Gathered(
            {},
            tuple(note for reader in readers for note in reader.notes),
            {name: told for contents in self._containers for name, told in contents.metadata if name != PAD},
            {name: content for contents in self._containers for name, content in contents.attachments.items()},
            {topic: kind for reader in readers for topic, kind in reader.passed.items()},
            next((contents.early for contents in self._containers if contents.early), ""),
        )

    def _named(self, found: Mapping[_Key, StreamedSeries], readers: list[TopicReader]) -> dict[str, StreamedSeries]:
        if not found:
            reasons = {topic: reason for reader in readers for topic, reason in reader.reasons.items()}
            raise FormatError(f"{self._path}: {empty_words(self.held.passed, reasons, self.held.early)}")
        described = {topic: facts for each in self._containers for topic, facts in described_pads(each).items()}
        order = sorted(found, key=lambda key: list(described).index(key[0]) if key[0] in described else len(described))
        names = pad_names([key for key in order if key[0] not in described])
        self._keys: dict[str, _Key] = {}
        pads = {}
        for key in order:
            series = found[key]
            series.finish()
            series.facts = described.get(key[0]) or replace(series.facts, name=names[key])
            pads[series.facts.name] = series
            self._keys[series.facts.name] = key
        return pads

    def read(self, name: str, first: int, last: int) -> tuple[NDArray[np.int64], NDArray[Any]]:
        """Return the times and the values of some readings of a pad.

        Parameters
        ----------
        name : str
        first, last : int
            Readings first to last - 1.

        Returns
        -------
        ndarray of shape (last - first,), int64
            By the sensor's clock where it is one, otherwise by that of the machine that wrote.
        ndarray of shape (last - first, ...)
        """
        series, key = self.pads[name], self._keys[name]
        begin = int(np.searchsorted(series.ends, first, side="right"))
        end = int(np.searchsorted(series.ends, last, side="left")) + 1
        parts = [some for piece in range(begin, end) if (some := self._piece(piece).get(key)) is not None]
        skip = first - (int(series.ends[begin - 1]) if begin else 0)
        stamps = joined([part.stamp_ns if series.stamp == "device" else part.log_ns for part in parts])
        values = joined([part.values for part in parts])
        wanted = slice(skip, skip + last - first)
        return stamps[wanted], values[wanted].astype(series.dtype, copy=False)

    def _piece(self, number: int) -> dict[_Key, Readings]:
        if number not in self._kept:
            if number != self._next:
                self._running = self._from(number)
            self._kept[number] = next(self._running)
            self._next = number + 1
            size = sum(some.values.nbytes for piece in self._kept.values() for some in piece.values())
            while size > _KEPT and len(self._kept) > 1:
                _, gone = self._kept.popitem(last=False)
                size -= sum(some.values.nbytes for some in gone.values())
        return self._kept[number]

    def _from(self, number: int) -> Iterator[dict[_Key, Readings]]:
        """Yield the readings of the pieces of one container from one on."""
        owner, place = self._pieces[number]
        contents = self._containers[owner]
        reader = TopicReader(contents)
        for batch in contents.batches(place):
            yield _by_pad(reader.read(batch))
        # Whoever wants a piece beyond these knows that there is one.
        yield from self._from(next(k for k in range(number, len(self._pieces)) if self._pieces[k][0] > owner))


def _by_pad(readings: Iterable[Readings]) -> dict[_Key, Readings]:
    """Return readings by topic and pad, those of each in the order in which they were written."""
    found: dict[_Key, list[Readings]] = {}
    for some in readings:
        found.setdefault((some.topic, some.pad), []).append(some)
    return {key: some[0] if len(some) == 1 else _merged(some) for key, some in found.items()}


def _merged(parts: list[Readings]) -> Readings:
    """Return what several channels of a topic say as one."""
    at = joined([part.at for part in parts])
    order = np.argsort(at)
    stamps = {part.stamp for part in parts}
    log_ns, stamp_ns = joined([part.log_ns for part in parts]), joined([part.stamp_ns for part in parts])
    values = joined([part.values for part in parts])
    stamp = stamps.pop() if len(stamps) == 1 else "host"
    return parts[0]._replace(
        at=at[order], log_ns=log_ns[order], stamp=stamp, stamp_ns=stamp_ns[order], values=values[order]
    )
