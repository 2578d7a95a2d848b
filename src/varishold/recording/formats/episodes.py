"""Containers of many recordings, as data sets for learning are: each of their episodes is a press.

Either the arrays of all episodes follow each other and their ends are told (``meta/episode_ends``), or each episode has
a group of its own (``data/demo_0``, ``data/demo_1`` ...), whose arrays of one name are joined here.
"""

from __future__ import annotations

import dataclasses
import itertools
import re
from collections.abc import Iterator, Mapping
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from varishold._counted import counted
from varishold.recording.formats.grouped_arrays import MARK, OF_PAD, GroupedArrays, Numbers
from varishold.recording.formats.guessing import TIMES
from varishold.recording.stored import Stored

__all__ = ["CLOCK_GOES_ON", "Episodes", "in_episodes"]

#: What is said where each episode has a clock of its own.
CLOCK_GOES_ON = "the clock begins anew with each episode; time goes on from where the one before ended"

# What tells the ends of episodes, and what groups of an episode each are called, before their number.
_ENDS = "episode_ends"
_EPISODE = re.compile(r"(demo|demonstration|episode|ep|traj|trajectory|trial|rollout|take|run)[_\-. ]?(\d{1,9})", re.I)
# Signs of what is known of an episode: longer texts are files of their own.
_LONGEST = 200

Place = tuple[str, ...]


class Joined:
    """Arrays of numbers of several episodes as one column; all have entries of one shape."""

    def __init__(self, parts: tuple[Numbers, ...]) -> None:
        self.parts = parts
        self.starts = np.cumsum([0, *(part.shape[0] for part in parts)])
        self.shape = (int(self.starts[-1]), *parts[0].shape[1:])
        self.dtype = np.result_type(*(part.dtype for part in parts))
        self.is_numbers = True

    def check(self) -> None:
        """Raise FormatError where one of them cannot be read as a column."""
        for part in self.parts:
            part.check()

    def small(self) -> NDArray[Any]:
        """Read all of them; raises FormatError where one is too large for anything but a column."""
        return np.concatenate([part.small() for part in self.parts])

    def __getitem__(self, wanted: slice, /) -> NDArray[Any]:
        first, last, _ = wanted.indices(self.shape[0])
        read = [self._part(k, first, last) for k in self._within(first, last)]
        return np.concatenate(read) if read else np.empty((0, *self.shape[1:]), self.dtype)

    def _within(self, first: int, last: int) -> Iterator[int]:
        for k, (start, stop) in enumerate(zip(self.starts[:-1], self.starts[1:], strict=True)):
            if max(first, start) < min(last, stop):
                yield k

    def _part(self, k: int, first: int, last: int) -> NDArray[Any]:
        start, stop = int(self.starts[k]), int(self.starts[k + 1])
        return np.asarray(self.parts[k][max(first, start) - start : min(last, stop) - start])


class _Clock(Joined):
    """Times of several episodes: where each begins its clock anew, it goes on from where the one before ended."""

    @cached_property
    def _offsets(self) -> NDArray[np.float64]:
        spans = [_span(np.asarray(part[:], np.float64)) if part.shape[0] else None for part in self.parts]
        known = [span for span in spans if span is not None]
        offsets = np.zeros(len(spans))
        if all(before[1] < after[0] for before, after in itertools.pairwise(known)):
            return offsets
        now = known[0][0]
        for k, span in enumerate(spans):
            if span is not None:
                offsets[k] = now - span[0]
                now = offsets[k] + span[2]
        return offsets

    @property
    def begins_anew(self) -> bool:
        return bool(self._offsets.any())

    def _part(self, k: int, first: int, last: int) -> NDArray[Any]:
        times: NDArray[np.float64] = super()._part(k, first, last).astype(np.float64) + self._offsets[k]
        return times


def _span(times: NDArray[np.float64]) -> tuple[float, float, float]:
    """Return the first of some times, the last, and what would be the next."""
    first, last = float(times[0]), float(times[-1])
    return first, last, last + ((last - first) / (times.size - 1) if times.size > 1 else 1.0)


class Episodes:
    """An open file of groups in which the arrays of numbered episodes are joined, in the order of their numbers.

    Parameters
    ----------
    groups : GroupedArrays
        The file as it is.
    """

    def __init__(self, groups: GroupedArrays) -> None:
        self._groups = groups

    @property
    def passed(self) -> list[str]:
        return self._groups.passed

    def attributes(self, *path: str) -> dict[str, NDArray[Any]]:
        """Return the attributes of the file, of a group or of an array; of one that was joined, the first one's."""
        above, names = self._family
        joined = any(path == place[: len(path)] for place in self._joined) and len(path) >= len(above)
        return self._groups.attributes(*(self._in(names[0], path[len(above) :]) if joined else path))

    @cached_property
    def datasets(self) -> Mapping[Place, Numbers]:
        """Every array of numbers or text by its path, groups first; those of episodes without their groups."""
        above, names = self._family
        theirs = {self._in(name, place[len(above) :]) for place in self._joined for name in names}
        rest = {place: each for place, each in self._groups.datasets.items() if place not in theirs}
        return {**self._joined, **rest}

    @property
    def numbers(self) -> list[int]:
        """The number of each episode that has a group of its own."""
        return [_number(name) for name in self._family[1]]

    @property
    def starts(self) -> list[NDArray[np.int64]]:
        """Where each episode begins and the last one ends, in each of the joined arrays."""
        return [each.starts for each in self._joined.values()]

    @cached_property
    def columns(self) -> dict[str, NDArray[Any]]:
        """What attributes and single values say of each episode: numbers, or short text."""
        above, names = self._family
        said = {name: self._groups.attributes(*self._in(name)) for name in names}
        for place, each in self._groups.datasets.items():
            name = place[len(above)] if place[: len(above)] == above and len(place) > len(above) else None
            if name in said and each.shape == ():
                said[name]["/".join(place[len(above) + 1 :])] = each.small()
        known = list(said.values())
        told = [key for key in (known[0] if known else ()) if key not in OF_PAD and all(key in each for each in known)]
        columns = {key: [each[key] for each in known] for key in told}
        return {
            key: np.array([value.ravel()[0] for value in values])
            for key, values in columns.items()
            if all(_is_short(value) for value in values)
        }

    @cached_property
    def _family(self) -> tuple[Place, list[str]]:
        """Return where the groups of episodes stand, and what they are called: no name where there are no two."""
        found: dict[tuple[Place, str], set[str]] = {}
        for place in self._groups.datasets:
            depth = next((k for k, name in enumerate(place[:-1]) if _EPISODE.fullmatch(name)), None)
            if depth is not None:
                stem = place[depth].rstrip("0123456789")
                found.setdefault((place[:depth], stem), set()).add(place[depth])
        if not found or MARK in self._groups.attributes():
            return (), []
        (above, _), names = max(found.items(), key=lambda item: len(item[1]))
        twice = len({_number(name) for name in names}) < len(names)
        return above, [] if twice or len(names) == 1 else sorted(names, key=_number)

    def _in(self, name: str, rest: Place = ()) -> Place:
        """Return where something stands in the group of an episode."""
        return (*self._family[0], name, *rest)

    @cached_property
    def _joined(self) -> dict[Place, Joined]:
        above, names = self._family
        joined: dict[Place, Joined] = {}
        held, depth = self._groups.datasets, len(above) + 1
        for place in held if names else ():
            if place[:depth] != self._in(names[0]):
                continue
            rest = place[depth:]
            parts = [held.get(self._in(name, rest)) for name in names]
            there = tuple(part for part in parts if part is not None and part.is_numbers)
            called = (*above, *rest)
            if len(there) == len(names) and called not in held and len({part.shape[1:] for part in there}) == 1:
                is_clock = rest[-1].lower() in TIMES and len(there[0].shape) == 1
                joined[called] = (_Clock if is_clock else Joined)(there)
        return joined


def _number(name: str) -> int:
    found = _EPISODE.fullmatch(name)
    return int(found[2]) if found else -1


def _is_short(value: NDArray[Any]) -> bool:
    return value.size == 1 and (value.dtype.kind in "biuf" or (value.dtype.kind == "U" and len(str(value)) <= _LONGEST))


def in_episodes(stored: Stored, episodes: Episodes) -> Stored:
    """Take episodes for presses, where they are told and nothing else says presses."""
    if stored.press is not None:
        return stored
    columns = stored.press_columns
    starts = next((each for each in episodes.starts if each[-1] == stored.n_frames), None)
    if starts is not None:
        columns = {"episode": np.array(episodes.numbers), **episodes.columns}
    else:
        starts = _told_starts(episodes)
        if starts is None:
            return stored
        if len(starts) == 1 or (np.diff(starts) <= 0).any() or starts[-1] != stored.n_frames:
            told = f"{_ENDS} does not end with the frames: passed over"
            return dataclasses.replace(stored, notes=(*stored.notes, told))
    n = len(starts) - 1
    notes = [f"each of {counted(n, 'episode')} is a press"]
    if isinstance(stored.time_s, _Clock) and stored.time_s.begins_anew:
        notes.append(CLOCK_GOES_ON)
    press = np.repeat(np.arange(n), np.diff(starts))
    return dataclasses.replace(stored, press=press, press_columns=columns, notes=(*stored.notes, *notes))


def _told_starts(episodes: Episodes) -> NDArray[np.int64] | None:
    """Return where episodes begin and the last one ends, where an array of their ends tells it."""
    ends = next((each for name, each in episodes.datasets.items() if name and name[-1] == _ENDS), None)
    if ends is None or len(ends.shape) != 1 or ends.dtype.kind not in "iu":
        return None
    return np.concatenate([np.zeros(1, np.int64), ends.small().astype(np.int64)])
