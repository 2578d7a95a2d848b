"""All that a file holds: the readings of each pad, what is said of it, and the words beside."""

from __future__ import annotations

import os
from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from itertools import islice
from typing import Any

import numpy as np
from numpy.typing import NDArray

from varishold.errors import FormatError
from varishold.files import LARGEST_BYTES
from varishold.recording.mcap.container import Container, opened_mcap
from varishold.recording.mcap.parts import joined
from varishold.recording.mcap.readings import Note, Readings, TopicReader
from varishold.recording.mcap.topics import PAD, PadFacts, facts_of
from varishold.recording.pad import UNNAMED_PAD

__all__ = ["Gathered", "Series", "described_pads", "empty_words", "gather", "gathered", "pad_names"]


@dataclass(frozen=True, eq=False)
class Series:
    """All readings of a pad.

    Parameters
    ----------
    facts : PadFacts
    log_ns : ndarray of shape (n,), int64
        When each came, by the clock of the machine that wrote them.
    stamp : {"device", "host", "none"}
        Whose time `stamp_ns` is; "none" where neither clock was ever read.
    stamp_ns : ndarray of shape (n,), int64
    sequence : ndarray of shape (n,), int64, or None
        The sensor's own numbers.
    values : ndarray of shape (n, rows, cols); of signals (n, ...)
    """

    facts: PadFacts
    log_ns: NDArray[np.int64]
    stamp: str
    stamp_ns: NDArray[np.int64]
    sequence: NDArray[np.int64] | None
    values: NDArray[Any]


@dataclass(frozen=True, eq=False)
class Gathered:
    """What a file holds.

    Parameters
    ----------
    pads : mapping of str to Series
        Those that were ever read.
    notes : tuple of Note
        Presses, marks and zeros, in their order.
    records : mapping of str to mapping of str to str
        What is said of the whole file.
    attachments : mapping of str to bytes
    passed : mapping of str to str
        The type of each topic that is not understood.
    early : str
        How the file breaks off; empty where it has its end.
    """

    pads: Mapping[str, Series]
    notes: tuple[Note, ...]
    records: Mapping[str, Mapping[str, str]]
    attachments: Mapping[str, bytes]
    passed: Mapping[str, str]
    early: str


def gather(path: str | os.PathLike[str]) -> Gathered:
    """Read all of an MCAP file.

    Raises
    ------
    InputError
        If it cannot be opened.
    FormatError
        If it is damaged, or holds nothing that is understood.
    """
    with opened_mcap(path) as contents:
        return gathered(os.fspath(path), [contents])


def gathered(path: str, containers: Iterable[Container]) -> Gathered:
    """Read all of containers that follow one another.

    Raises
    ------
    FormatError
        If one is damaged, or they hold nothing that is understood.
    """
    parts: dict[tuple[str, str], list[Readings]] = {}
    readers: list[TopicReader] = []
    read: list[Container] = []
    n_bytes = n_messages = 0
    for contents in containers:
        reader = TopicReader(contents, first=n_messages)
        readers.append(reader)
        read.append(contents)
        for batch in contents.batches():
            n_messages += len(batch.heads)
            for readings in reader.read(batch):
                n_bytes += readings.values.nbytes
                if n_bytes > LARGEST_BYTES:
                    raise FormatError(
                        f"{path}: holds more than {LARGEST_BYTES} bytes of values, which are not read at once; "
                        "varishold replay plays it"
                    )
                parts.setdefault((readings.topic, readings.pad), []).append(readings)
    passed = {topic: kind for reader in readers for topic, kind in reader.passed.items()}
    parts = {key: some for key, some in parts.items() if key[0] not in passed}
    early = next((contents.early for contents in read if contents.early), "")
    if not parts:
        reasons = {topic: reason for reader in readers for topic, reason in reader.reasons.items()}
        raise FormatError(f"{path}: {empty_words(passed, reasons, early)}")
    described = {topic: facts for contents in read for topic, facts in described_pads(contents).items()}
    # In the order in which they were described; those that nobody described come as they were met.
    order = sorted(parts, key=lambda key: list(described).index(key[0]) if key[0] in described else len(described))
    names = pad_names([key for key in order if key[0] not in described])
    series = []
    for key in order:
        facts = described.get(key[0]) or replace(parts[key][0].facts or PadFacts(""), name=names[key])
        series.append(_series(path, key[0], facts, parts[key]))
    return Gathered(
        {each.facts.name: each for each in series},
        tuple(note for reader in readers for note in reader.notes),
        {name: told for contents in read for name, told in contents.metadata if name != PAD},
        {name: content for contents in read for name, content in contents.attachments.items()},
        passed,
        early,
    )


def empty_words(passed: Mapping[str, str], reasons: Mapping[str, str], early: str) -> str:
    """Say why there is no reading."""
    if passed:
        held = (f"{topic} ({kind}): {reasons[topic]}" for topic, kind in passed.items())
        return f"holds no topic with frames: {'; '.join(islice(held, 8))}"
    return f"holds no reading: {early}" if early else "holds no message"


def described_pads(contents: Container) -> dict[str, PadFacts]:
    """Return what is said of pads by the topics that they are."""
    return {
        told["topic"]: facts_of(told, where=f"{contents.path}: pad {told.get('pad', '')!r}")
        for name, told in contents.metadata
        if name == PAD and "topic" in told
    }


def pad_names(keys: list[tuple[str, str]]) -> dict[tuple[str, str], str]:
    """Return a name for each pad of other programs' topics: its own, or its topic's where it has none or shares it."""
    own = Counter(pad for _, pad in keys)
    names = {}
    for topic, pad in keys:
        called = topic.strip("/") or UNNAMED_PAD
        # What stands beside a pad without a name, as its shear, is called after it.
        beside = pad.endswith(f".{UNNAMED_PAD}")
        if beside:
            names[topic, pad] = f"{pad.removesuffix(UNNAMED_PAD)}{called}"
        else:
            names[topic, pad] = pad if pad and own[pad] == 1 else f"{called}/{pad}" if pad else called
    return names


def _series(path: str, topic: str, facts: PadFacts, parts: list[Readings]) -> Series:
    shapes = {part.values.shape[1:]: part for part in parts}
    if len(shapes) > 1:
        first, other = list(shapes.values())[:2]
        raise FormatError(
            f"{path}: topic {topic}: message of {other.log_ns[0] / 1e9:.6f} s has shape {other.values.shape[1:]}, "
            f"those before have {first.values.shape[1:]}"
        )
    stamps = {part.stamp for part in parts}
    # Where the sensor sends its time only now and then, all are by the other clock.
    stamp = stamps.pop() if len(stamps) == 1 else "host"
    at, log_ns, stamp_ns, values = (
        joined([getattr(part, name) for part in parts]) for name in ("at", "log_ns", "stamp_ns", "values")
    )
    sequences = [part.sequence for part in parts if part.sequence is not None]
    sequence = joined(sequences) if len(sequences) == len(parts) else None
    if (np.diff(at) < 0).any():
        # A topic may have several channels, as where the sensor's own number comes only now and then.
        order = np.argsort(at)
        log_ns, stamp_ns, values = log_ns[order], stamp_ns[order], values[order]
        sequence = None if sequence is None else sequence[order]
    return Series(facts, log_ns, stamp, stamp_ns if stamp == "device" else log_ns, sequence, values)
