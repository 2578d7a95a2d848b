"""Presses as notes: where each begins and ends, and what is known of it."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from varishold.errors import FormatError
from varishold.recording.mcap.topics import PRESSES

if TYPE_CHECKING:
    from varishold.recording.mcap.gathering import Gathered

__all__ = ["COLUMNS", "column_types", "press_notes", "presses_of", "typed_column"]

#: The record that tells the types of the columns of presses.
COLUMNS = "varishold.press"
_TYPE = re.compile(r"[<>|=]?([biufU])(\d{1,9})")
# A column of text takes no more memory than for so many signs, whatever its type says.
_MOST_SIGNS = 1 << 24


def column_types(columns: Mapping[str, NDArray[Any]]) -> dict[str, str]:
    """Return the record that tells the types of the columns of presses."""
    return {name: column.dtype.str for name, column in columns.items()}


def press_notes(numbers: NDArray[np.int64], columns: Mapping[str, NDArray[Any]]) -> Iterator[dict[str, Any]]:
    """Yield where each press begins and ends, with what is known of it; none before those of lower numbers are told.

    Parameters
    ----------
    numbers : ndarray of shape (n_frames,), int64
        The press of each frame, -1 for none.
    columns : mapping of str to ndarray of shape (n_presses,)
    """
    n_told = 0
    n_rows = max((len(column) for column in columns.values()), default=0)

    def row(number: int, frame: int | None) -> dict[str, Any]:
        known = {name: column[number] for name, column in columns.items() if number < len(column)}
        return {"frame": frame, "press": number, "columns": known}

    for frame in np.flatnonzero(np.diff(numbers, prepend=-1) != 0).tolist():
        number = int(numbers[frame])
        if number < n_told or number >= n_rows:
            yield {"frame": frame, "press": number}
            continue
        yield from (row(each, None) for each in range(n_told, number))
        yield row(number, frame)
        n_told = number + 1
    yield from (row(each, None) for each in range(n_told, n_rows))


def presses_of(
    held: Gathered, n_frames: int, *, where: str
) -> tuple[NDArray[np.int64] | None, dict[str, NDArray[Any]]]:
    """Return the press of each frame, and the columns of presses; None where the file names no presses.

    Raises
    ------
    FormatError
        If what it says of presses cannot be meant; `where` opens the message.
    """
    if COLUMNS not in held.records:
        return None, {}
    types = held.records[COLUMNS]
    notes = [note.told for note in held.notes if note.topic == PRESSES]
    begun: list[tuple[int, int]] = []
    cells: dict[str, dict[int, Any]] = {name: {} for name in types}
    for told in notes:
        frame, number, columns = told.get("frame"), told.get("press"), told.get("columns", {})
        if not (
            isinstance(columns, dict)
            and isinstance(frame, int | None)
            and isinstance(number, int)
            # Columns of presses are told in the order of their numbers.
            and -1 <= number < (len(notes) if columns else 2**63)
        ):
            raise FormatError(f"{where}: topic {PRESSES}: must tell frame, press and columns, got {str(told)[:80]}")
        if frame is not None:
            begun.append((min(max(frame, 0), n_frames), number))
        for name in cells.keys() & columns.keys():
            cells[name][number] = columns[name]
    press = np.full(n_frames, -1)
    starts = np.maximum.accumulate([0, *(start for start, _ in begun)])[1:].tolist()
    for (_, number), start, stop in zip(begun, starts, [*starts, n_frames][1:], strict=True):
        press[start:stop] = number
    return press, {name: typed_column(where, f"press.{name}", cells[name], types[name]) for name in types}


def typed_column(where: str, name: str, cells: dict[int, Any], told: str) -> NDArray[Any]:
    """Return a column from its cells by their numbers; where it says nothing, it is empty.

    Raises
    ------
    FormatError
        If the cells are not of the type that is told.
    """
    match = _TYPE.fullmatch(told)
    if match is None:
        raise FormatError(f"{where}: {name} must be of text or numbers, got {told[:20]!r}")
    kind = match[1]
    as_cell: Any = {"U": str, "f": float, "b": bool}.get(kind, int)
    rest: Any = {"U": "", "f": float("nan")}.get(kind, 0)
    try:
        values = [as_cell(cells.get(k, rest)) for k in range(max(cells, default=-1) + 1)]
        # A text's type says how long its longest may be; no file may ask for memory by it.
        column = np.array(values, told if kind != "U" or int(match[2]) * len(values) <= _MOST_SIGNS else np.str_)
        # NumPy before 2 takes what is too large for something else.
        if kind in "iu" and column.tolist() != values:
            raise OverflowError("it holds numbers that are too large")
    except (TypeError, ValueError, OverflowError) as error:
        raise FormatError(f"{where}: {name} must be {told}: {error}") from None
    return column
