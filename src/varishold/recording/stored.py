"""A recording that is still in its file: its frames are read when some of them are asked for."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Mapping
from contextlib import ExitStack, nullcontext
from dataclasses import dataclass, field
from tempfile import TemporaryFile, gettempdir
from typing import Any, Literal, Protocol

import numpy as np
from numpy.typing import NDArray

from varishold.errors import FormatError, InputError, reason_of
from varishold.files import damage_told
from varishold.recording.pad import Pad
from varishold.recording.press_table import Mark
from varishold.recording.recording import Recording
from varishold.recording.signals import Signals

__all__ = ["Column", "Stored", "StoredPad", "StoredSignals", "Turned", "stored_of"]


# Bytes of frames above which they are mapped, and that are read together.
_IN_MEMORY, _TOGETHER = 1 << 27, 1 << 23


class Column(Protocol):
    """Something with one entry a frame, of which a slice is read; an array is one."""

    @property
    def shape(self) -> tuple[int, ...]: ...
    @property
    def dtype(self) -> np.dtype[Any]: ...
    def __getitem__(self, wanted: slice, /) -> Any: ...


@dataclass(frozen=True)
class Turned:
    """A column of which each block is changed as it is read.

    Parameters
    ----------
    source : Column
    tail : tuple of int
        The shape of one entry afterwards.
    turn : callable
        Takes a block of the source and returns it changed.
    """

    source: Column
    tail: tuple[int, ...]
    turn: Callable[[NDArray[Any]], NDArray[Any]]

    @property
    def shape(self) -> tuple[int, ...]:
        return (self.source.shape[0], *self.tail)

    @property
    def dtype(self) -> np.dtype[Any]:
        return self.source.dtype

    def __getitem__(self, wanted: slice, /) -> NDArray[Any]:
        return self.turn(np.asarray(self.source[wanted]))


@dataclass(frozen=True, eq=False)
class StoredPad:
    """A pad whose frames, of shape (n_frames, rows, cols), are in a file; `called` so there, the rest as of `Pad`."""

    frames: Column
    called: str = ""
    field: NDArray[np.bool_] | None = None
    valid: NDArray[np.bool_] | None = None
    pitch_m: tuple[float, float] | None = None
    positions_m: NDArray[np.float64] | None = None
    polarity: Literal["up", "down"] = "up"
    notes: tuple[str, ...] = ()


@dataclass(frozen=True, eq=False)
class StoredSignals:
    """Signals whose values, of shape (n_frames, n_signals), are in a file; the rest as of `Signals`."""

    values: Column
    names: tuple[str, ...] = ()
    unit: str = "raw"


@dataclass(frozen=True, eq=False)
class Stored:
    """A recording in its file; all but what has an entry a frame is known already.

    Parameters
    ----------
    pads : mapping of str to StoredPad
    time_s, press : Column, optional
    unit, sensor, source, notes, press_columns, marks
        As of `Recording`.
    signals : mapping of str to StoredSignals
    close : callable
        Lets the file go. May be called again.
    """

    pads: Mapping[str, StoredPad]
    time_s: Column | None = None
    unit: str = "raw"
    sensor: str = ""
    source: str = ""
    notes: tuple[str, ...] = ()
    press: Column | None = None
    press_columns: Mapping[str, NDArray[Any]] = field(default_factory=dict)
    signals: Mapping[str, StoredSignals] = field(default_factory=dict)
    marks: tuple[Mark, ...] = ()
    close: Callable[[], object] = lambda: None

    @property
    def n_frames(self) -> int:
        return int(next(iter(self.pads.values())).frames.shape[0])

    @property
    def n_bytes(self) -> int:
        """Bytes that all frames would take in memory; what is there already, or mapped, takes none."""
        columns = [pad.frames for pad in self.pads.values()] + [each.values for each in self.signals.values()]
        return sum(math.prod(c.shape) * c.dtype.itemsize for c in columns if not isinstance(c, np.ndarray))

    def part(self, first: int, last: int) -> Recording:
        """Return frames first to last - 1.

        Raises
        ------
        InputError
            If they cannot be used; as a FormatError with the file's name where the file is one.
        """
        try:
            with damage_told(self.source) if self.source else nullcontext():
                return self._part(first, last)
        except FormatError:
            raise
        except InputError as error:
            if not self.source:
                raise
            raise FormatError(f"{self.source}: {error}", parameter=error.parameter) from error

    def _part(self, first: int, last: int) -> Recording:
        def some(column: Column) -> Any:
            # One of another length is looked at as a whole, so that it is refused as it is.
            return column[first:last] if column.shape[:1] == (self.n_frames,) else column[:]

        whole = (first, last) == (0, self.n_frames)
        # What was said last before the first frame still holds there.
        before = [Mark(0, mark.label) for mark in self.marks if mark.frame <= first]
        after = [Mark(mark.frame - first, mark.label) for mark in self.marks if first < mark.frame < last]
        return Recording(
            {name: _pad(pad, some(pad.frames)) for name, pad in self.pads.items()},
            None if self.time_s is None else some(self.time_s),
            self.unit,
            self.sensor,
            self.source,
            self.notes,
            None if self.press is None else some(self.press),
            self.press_columns,
            {name: Signals(some(each.values), each.names, each.unit) for name, each in self.signals.items()},
            self.marks if whole else (*before[-1:], *after),
        )

    def whole(self) -> Recording:
        """Return all of it: in memory, or, where that would take much, mapped from a file without a name.

        Raises
        ------
        FormatError
            If it cannot be used.
        InputError
            If there is no room for that file.
        """
        return (self if self.n_bytes <= _IN_MEMORY else self._mapped()).part(0, self.n_frames)

    def _mapped(self) -> Stored:
        """Return it with its columns mapped from a temporary file, which goes when nobody looks at it any more."""
        columns = {f"pads.{name}": pad.frames for name, pad in self.pads.items()}
        columns |= {f"signals.{name}": each.values for name, each in self.signals.items()}
        times: list[NDArray[Any]] = []
        made: dict[str, NDArray[Any]] = {}
        try:
            with ExitStack() as stack:
                files = {name: stack.enter_context(TemporaryFile(prefix=".varishold-")) for name in columns}
                entry = sum(math.prod(c.shape[1:]) * c.dtype.itemsize for c in columns.values())
                many = max(1, _TOGETHER // entry)
                for begun in range(0, self.n_frames, many):
                    some = slice(begun, min(begun + many, self.n_frames))
                    with damage_told(self.source):
                        blocks = {name: np.ascontiguousarray(column[some]) for name, column in columns.items()}
                        times += [] if self.time_s is None else [np.array(self.time_s[some])]
                    for name, block in blocks.items():
                        files[name].write(block.data)
                for name, column in columns.items():
                    files[name].flush()
                    made[name] = np.memmap(files[name], column.dtype, "r", shape=column.shape)
        except OSError as error:
            raise InputError(
                f"{self.source}: {self.n_bytes} bytes of temporary space are wanted in {gettempdir()}: "
                f"{reason_of(error)}; name another folder as TMPDIR"
            ) from error
        pads = {name: dataclasses.replace(pad, frames=made[f"pads.{name}"]) for name, pad in self.pads.items()}
        signals = {n: dataclasses.replace(each, values=made[f"signals.{n}"]) for n, each in self.signals.items()}
        time_s = np.concatenate(times) if times else None
        return dataclasses.replace(self, pads=pads, signals=signals, time_s=time_s)


def _pad(pad: StoredPad, frames: NDArray[Any]) -> Pad:
    try:
        return Pad(frames, pad.field, pad.valid, pad.pitch_m, pad.positions_m, pad.polarity, pad.notes)
    except InputError as error:
        if not pad.called:
            raise
        raise InputError(f"{pad.called}: {error}", parameter=error.parameter) from error


def stored_of(recording: Recording) -> Stored:
    """Return a recording that is in memory, or mapped, as one that is taken in parts."""
    same = {each.name: getattr(recording, each.name) for each in dataclasses.fields(Recording)}
    pads = {
        name: StoredPad(pad.frames, "", pad.field, pad.valid, pad.pitch_m, pad.positions_m, pad.polarity, pad.notes)
        for name, pad in recording.pads.items()
    }
    signals = {name: StoredSignals(each.values, each.names, each.unit) for name, each in recording.signals.items()}
    return Stored(**{**same, "pads": pads, "signals": signals})
