"""The presses of a recording as a table: where each is, and what its columns say of it."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from varishold._counted import counted
from varishold._remade import remade
from varishold.errors import InputError
from varishold.frame.checks import as_given
from varishold.recording.framed import Framed
from varishold.recording.selection import presses

__all__ = ["COLUMN_HEADS", "Mark", "PressTable", "checked_marks", "checked_press", "press_remarks", "press_table"]

#: Columns of presses that are numbers to learn from begin so.
COLUMN_HEADS = ("angle_rad.", "switch.", "force_n.")

# Up to it every reader of a file tells numbers from each other.
_LARGEST_PRESS = 2**53
# Frames before a press that show its rest.
_REST_FRAMES = 8


class Mark(NamedTuple):
    """What somebody said was felt from a frame on; an empty label ends it."""

    frame: int
    label: str


@dataclass(frozen=True, eq=False)
class PressTable:
    """The presses of a recording, in the order of their numbers.

    Parameters
    ----------
    frames : tuple of range
        The frames of each press.
    spans : tuple of range
        The same with the press's rest: of one that was found by its load, a few frames before it.
    columns : mapping of str to ndarray of shape (n_presses,)
        What is known of each press, text or numbers: labels, sessions, ``angle_rad.NAME``, ``switch.NAME``.
    """

    frames: tuple[range, ...]
    spans: tuple[range, ...]
    columns: Mapping[str, NDArray[Any]]

    __reduce__ = remade

    def __len__(self) -> int:
        return len(self.frames)


class Pressed(Framed, Protocol):
    """What presses are looked for in: a `Recording`."""

    @property
    def press(self) -> NDArray[np.int64] | None: ...
    @property
    def press_columns(self) -> Mapping[str, NDArray[Any]]: ...
    @property
    def marks(self) -> tuple[Mark, ...]: ...


def press_table(recording: Pressed) -> PressTable:
    """Return the presses that a recording names, or else its runs of loaded frames, labelled by its marks."""
    if recording.press is None:
        found = tuple(presses(recording))
        ends = (0, *(frames.stop for frames in found))
        spans = (range(max(end, run.start - _REST_FRAMES), run.stop) for run, end in zip(found, ends, strict=False))
        return PressTable(found, tuple(spans), MappingProxyType(_marked(recording.marks, found)))
    numbers = recording.press
    starts = np.flatnonzero(np.diff(numbers, prepend=-1) != 0)
    stops = np.append(starts[1:], len(numbers))
    held = numbers[starts] >= 0
    order = np.argsort(numbers[starts][held])
    frames = tuple(range(int(starts[held][k]), int(stops[held][k])) for k in order)
    present = numbers[starts][held][order]
    return PressTable(
        frames, frames, MappingProxyType({name: of[present] for name, of in recording.press_columns.items()})
    )


def _marked(marks: tuple[Mark, ...], frames: tuple[range, ...]) -> dict[str, NDArray[Any]]:
    """Return the label of each press: that of the newest mark when it begins."""
    if not marks:
        return {}
    newest = np.searchsorted([mark.frame for mark in marks], [run.start for run in frames], side="right")
    return {"label": np.array(["", *(mark.label for mark in marks)])[newest]}


def checked_marks(marks: Any, n_frames: int) -> tuple[Mark, ...]:
    """Return marks as they are kept.

    Raises
    ------
    InputError
        If one is at no frame, or before the one before it.
    """
    kept: list[Mark] = []
    pairs = [*marks] if isinstance(marks, Iterable) and not isinstance(marks, str) else [marks]
    for pair in pairs:
        if not isinstance(pair, tuple | list) or len(pair) != 2:
            raise InputError(f"marks must be pairs of a frame and a label, got {str(pair)[:60]!r}")
        frame, label = pair
        if not isinstance(frame, int | np.integer) or not (kept[-1].frame if kept else 0) <= frame < n_frames:
            raise InputError(
                f"marks must be at frames 0 to {n_frames - 1}, rising, got {frame!r} for {str(label)[:60]!r}"
            )
        kept.append(Mark(int(frame), str(label)))
    return tuple(kept)


def checked_press(
    press: NDArray[Any] | None, columns: Mapping[str, NDArray[Any]], n_frames: int
) -> tuple[NDArray[np.int64] | None, Mapping[str, NDArray[Any]]]:
    """Return the press of each frame and the columns of presses, read-only.

    Raises
    ------
    InputError
        If they do not fit together, or a press is not in one piece.
    """
    if press is None:
        if columns:
            raise InputError(f"columns of presses ({', '.join(columns)}) need press, the press of each frame")
        return None, MappingProxyType({})
    must = f"press must be one whole number a frame, shape ({n_frames},)"
    given = as_given(press, must)
    if given.dtype.kind not in "iu" or given.shape != (n_frames,):
        raise InputError(f"{must}, got {given.dtype} of shape {given.shape}")
    wrong = np.flatnonzero((given < -1) | (given > _LARGEST_PRESS))
    if wrong.size:
        at = int(wrong[0])
        right = "0 or more" if given[at] < 0 else f"at most {_LARGEST_PRESS}"
        raise InputError(f"press must be {right}, or -1 for none, got {int(given[at])} at frame {at}")
    numbers = given.astype(np.int64)
    begun = numbers[np.flatnonzero(np.diff(numbers, prepend=-1) != 0)]
    begun = begun[begun >= 0]
    found, times = np.unique(begun, return_counts=True)
    if (times > 1).any():
        raise InputError(f"press {int(found[times > 1][0])} must be in one piece: it ends and begins again")
    kept: dict[str, NDArray[Any]] = {}
    n_presses = int(found[-1]) + 1 if found.size else 0
    for name, given_column in columns.items():
        must = f"press.{name} must be one text or number a press, {n_presses} of them"
        column = as_given(given_column, must).copy()
        if column.ndim != 1 or column.dtype.kind not in "biufU" or len(column) < n_presses:
            raise InputError(f"{must}, got {column.dtype} of shape {column.shape}")
        column.flags.writeable = False
        kept[name] = column
    numbers.flags.writeable = False
    return numbers, MappingProxyType(kept)


def press_remarks(press: NDArray[np.int64] | None, columns: Mapping[str, NDArray[Any]]) -> list[str]:
    """Say which columns of presses have entries of no press, and which are text where numbers are learned from.

    Parameters
    ----------
    press : ndarray of shape (n_frames,), optional
        The press of each frame, -1 for none.
    columns : mapping of str to ndarray of shape (n_presses or more,)

    Examples
    --------
    >>> press_remarks(np.array([0, 1]), {"label": np.array(["cup", "can", "jar"])})
    ['press.label has 3 entries, and presses are numbered to 1: the others are passed over']
    """
    if press is None:
        return []
    last = int(press.max(initial=-1))
    numbered = f"presses are numbered to {last}" if last >= 0 else "no frame is of a press"
    return [
        *(
            f"press.{name} has {counted(len(column), 'entry', 'entries')}, and {numbered}: the others are passed over"
            for name, column in columns.items()
            if len(column) > last + 1
        ),
        *(
            f"press.{name} is text, and not learned from: write numbers, nan where one is not known"
            for name, column in columns.items()
            if name.startswith(COLUMN_HEADS) and column.dtype.kind == "U"
        ),
    ]
