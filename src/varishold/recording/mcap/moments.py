"""A file of this program's read as it was written: one moment after the other, in bounded memory."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping
from contextlib import ExitStack
from typing import Any, NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from varishold.recording.mcap.clock import seconds
from varishold.recording.mcap.container import opened_mcap
from varishold.recording.mcap.gathering import described_pads
from varishold.recording.mcap.readings import Readings, TopicReader
from varishold.recording.mcap.topics import PadFacts

__all__ = ["Moment", "Moments"]


class Moment(NamedTuple):
    """One reading of all pads that came together.

    Parameters
    ----------
    device_time_s : float or None
        By the sensor's clock; None where it sends none.
    host_time_s : float
        By the clock of the machine that wrote it, seconds since 1970.
    sequence : int or None
        The sensor's own number.
    pads : mapping of str to ndarray
    """

    device_time_s: float | None
    host_time_s: float
    sequence: int | None
    pads: Mapping[str, NDArray[Any]]


class Moments:
    """The moments of a file, in the order in which they were written.

    Pads of topics that nobody described, as other programs', are left out.

    Parameters
    ----------
    path : str or path-like

    Raises
    ------
    InputError
        If it cannot be opened, or is damaged before its first reading.
    """

    def __init__(self, path: str | os.PathLike[str]) -> None:
        self._stack = ExitStack()
        self._contents = self._stack.enter_context(opened_mcap(path))
        self._reader = TopicReader(self._contents)
        try:
            self._batches = self._contents.batches()
            self._first = next(self._batches, None)
        except BaseException:
            self.close()
            raise

    @property
    def facts(self) -> dict[str, PadFacts]:
        """What is said of each pad, by its name, as far as the file has been read."""
        return {facts.name: facts for facts in described_pads(self._contents).values()}

    @property
    def early(self) -> str:
        """How the file breaks off, told when that is met; empty where it has its end."""
        return self._contents.early

    def close(self) -> None:
        """Let the file go. May be called again."""
        self._stack.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def __iter__(self) -> Iterator[Moment]:
        """Yield the moments, once.

        Raises
        ------
        FormatError
            If the file has its end and is damaged before it.
        """
        batch, self._first = self._first, None
        while batch is not None:
            described = described_pads(self._contents)
            read = [(described[each.topic].name, each) for each in self._reader.read(batch) if each.topic in described]
            yield from _moments(read)
            batch = next(self._batches, None)


def _moments(read: list[tuple[str, Readings]]) -> Iterator[Moment]:
    """Put together what was written together; a moment never reaches from one batch into the next."""
    if not read:
        return
    order = np.argsort(np.concatenate([each.at for _, each in read]), kind="stable")
    owner = np.repeat(np.arange(len(read)), [len(each.at) for _, each in read])[order]
    place = np.concatenate([np.arange(len(each.at)) for _, each in read])[order]
    log_s, stamp_s = ([seconds(getattr(each, name)) for _, each in read] for name in ("log_ns", "stamp_ns"))
    pads: dict[str, NDArray[Any]] = {}
    moment, number = None, -1
    for k, n in zip(owner.tolist(), place.tolist(), strict=True):
        name, each = read[k]
        device_s = float(stamp_s[k][n]) if each.stamp == "device" else None
        sequence = None if each.sequence is None else int(each.sequence[n])
        its = Moment(device_s, float(log_s[k][n]), sequence, pads)
        if moment is not None and (each.number[n] != number or its[:3] != moment[:3] or name in pads):
            yield moment
            pads = {}
        pads[name] = each.values[n]
        moment, number = its._replace(pads=pads), each.number[n]
    if moment is not None:
        yield moment
