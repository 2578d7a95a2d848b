"""What one look through a whole recording found: which blocks it has, what all of them must know, how healthy it is."""

from __future__ import annotations

import json
import math
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from varishold.corpus.ask import Looked
from varishold.errors import FormatError
from varishold.files import damage_told, open_archive, parse_json, write_archive
from varishold.recording import Recording
from varishold.recording.inspection import summarize

__all__ = ["Block", "Survey", "frame_bytes", "health_of", "read_survey"]

# Frames of a block, and the bytes that they may take.
_FRAMES, _BYTES = 4096, 1 << 25


@dataclass(frozen=True)
class Block:
    """Some frames of a recording that are answered together.

    Parameters
    ----------
    first, last : int
        Its first frame, and the one after its last.
    groups : sequence of range
        Each with answers of its own.
    """

    first: int
    last: int
    groups: Sequence[range]


@dataclass(frozen=True, eq=False)
class Survey:
    """What is known of a recording before its blocks are answered.

    Parameters
    ----------
    n_frames : int
    frame_bytes : int
        Bytes of a frame, all pads together.
    looked : Looked
    health : mapping of str to plain values
        As `health_of`.
    """

    n_frames: int
    frame_bytes: int
    looked: Looked
    health: Mapping[str, Any]

    @property
    def n_blocks(self) -> int:
        return -(-self.n_frames // self._most) if self.looked.groups is None else len(self._cuts) - 1

    def block(self, number: int) -> Block:
        """Return a block by its number; they follow one another as their answers do."""
        if self.looked.groups is None:
            first = number * self._most
            last = min(first + self._most, self.n_frames)
            return Block(first, last, [range(i, i + 1) for i in range(first, last)])
        chosen = self.looked.groups[self._cuts[number] : self._cuts[number + 1]].tolist()
        return Block(chosen[0][0], chosen[-1][1], [range(start, stop) for start, stop in chosen])

    @property
    def _most(self) -> int:
        return max(1, min(_FRAMES, _BYTES // max(1, self.frame_bytes)))

    @cached_property
    def _cuts(self) -> list[int]:
        """The first group of each block, and the number of groups."""
        assert self.looked.groups is not None
        groups, cuts = self.looked.groups.tolist(), [0]
        for number in range(1, len(groups)):
            # A block is one stretch of the file, in which groups follow one another.
            if groups[number][0] < groups[number - 1][1] or groups[number][1] - groups[cuts[-1]][0] > self._most:
                cuts.append(number)
        return [*cuts, len(groups)]

    def write(self, path: str | os.PathLike[str]) -> None:
        """Write it, whole or not at all.

        Raises
        ------
        InputError
            If it cannot be written there.
        """
        told = {
            "n_frames": self.n_frames,
            "frame_bytes": self.frame_bytes,
            "facts": dict(self.looked.facts),
            "health": dict(self.health),
        }
        # As bytes: a text would take four times as much.
        arrays: dict[str, NDArray[Any]] = {"told": np.frombuffer(json.dumps(told).encode(), np.uint8)}
        if self.looked.groups is not None:
            arrays["groups"] = self.looked.groups
        arrays |= {f"array.{name}": array for name, array in self.looked.arrays.items()}
        write_archive(arrays, path, kind="survey")


def read_survey(path: str | os.PathLike[str]) -> Survey:
    """Read what `Survey.write` has written.

    Raises
    ------
    InputError
        If it is not there.
    FormatError
        If it is damaged.
    """
    with open_archive(path) as archive:
        held = {name: archive.array(name) for name in archive.names}
    where = str(path)
    with damage_told(where):
        told = parse_json(held["told"].tobytes().decode(), where=where)
        if not isinstance(told, dict):
            raise FormatError(f"{where}: is no survey of a recording")
        arrays = {name.removeprefix("array."): array for name, array in held.items() if name.startswith("array.")}
        looked = Looked(held.get("groups"), told["facts"], arrays)
        return Survey(int(told["n_frames"]), int(told["frame_bytes"]), looked, told["health"])


def health_of(whole: Recording) -> dict[str, Any]:
    """Return how healthy a recording is: its frames, when it begins, its taxels, and what is wrong with it."""
    found = summarize(whole)
    return {
        "n_frames": found.n_frames,
        "begin_s": None if found.time is None else found.time.begin_s,
        "duration_s": None if found.time is None else found.time.duration_s,
        "n_lacking": 0 if found.time is None else found.time.n_lacking,
        "n_taxels": sum(pad.n_taxels for pad in found.pads),
        "n_broken": sum(pad.n_broken for pad in found.pads),
        "faults": list(found.faults),
        "notes": list(found.notes),
    }


def frame_bytes(whole: Recording) -> int:
    """Return the bytes of a frame of all pads."""
    return sum(math.prod(pad.shape) * pad.frames.dtype.itemsize for pad in whole.pads.values())
