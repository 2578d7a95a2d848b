"""Tables of one press a row: a column a taxel of each pad, and what is known of the press beside them.

Taxels are called ``NAME.ROW.COLUMN``, or ``NAME_K`` in rows where the shape is said. Where nothing is known of a row
but its time, rows are frames of a recording.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from varishold.errors import FormatError, InputError
from varishold.files import LARGEST_BYTES, encoding_notes, head_lines
from varishold.recording.formats.csv_dates import date_seconds
from varishold.recording.formats.csv_titles import COUNTERS, names_time, seconds_of
from varishold.recording.formats.format import Format, Options
from varishold.recording.formats.numbers import as_counts, as_number
from varishold.recording.formats.taxel_columns import TaxelColumns, header_names, pads_of, taxel_columns
from varishold.recording.grasp_csv import iter_grasp_table, table_header
from varishold.recording.grasp_table import GraspTable
from varishold.recording.pad import Pad
from varishold.recording.recording import Recording

__all__ = ["FORMAT"]

# The column that tells which press a row belongs to.
_PRESS = "press"


def _recognizes(path: Path, head: bytes) -> bool:
    lines = head_lines(head)
    if any("\0" in line for line in lines):
        return False
    try:
        names = header_names(table_header(str(path), [(1, lines)])[0][1])
    except FormatError:
        return False
    if any(as_number(name) is not None for name in names):
        return False
    groups = taxel_columns(names)
    taxels = {column for group in groups for column in group.columns.values()}
    others = [name for name in names if name not in taxels]
    # Of one pad, and at most a time before it, each line is a frame of plain CSV.
    alone = len(groups) == 1 and len(groups[0].sides) == 1 and len(others) <= 1
    return bool(groups) and not (alone and all(names_time(name.lower()) or name.lower() in COUNTERS for name in others))


def _read(path: Path, options: Options) -> Recording:
    frames, told = _columns(path, options)
    clock = next((name for name in told.columns if names_time(name.lower())), None)
    time_s = None if clock is None else _seconds(told, clock)
    press, known = _presses(told, {name: each for name, each in told.cells.items() if name != clock})
    shapes = ", ".join(f"{pad} {each.shape[1]} x {each.shape[2]}" for pad, each in frames.items())
    rows = [] if press is None or _PRESS in told.columns else ["each row is a press"]
    try:
        return Recording(
            {pad: Pad(each, pitch_m=options.pitch_m, polarity=options.polarity) for pad, each in frames.items()},
            time_s=time_s,
            source=str(path),
            notes=(f"pads by the names of their columns: {shapes}", *rows, *encoding_notes(path)),
            press=press,
            press_columns=known,
        )
    except InputError as error:
        raise FormatError(f"{path}: {error}") from error


def _columns(path: Path, options: Options) -> tuple[dict[str, NDArray[Any]], GraspTable]:
    """Return the frames of each pad, and the other columns."""
    pads: dict[str, tuple[TaxelColumns, tuple[int, int]]] = {}
    taxels: dict[str, list[NDArray[Any]]] = {}
    others: list[GraspTable] = []
    n_bytes = 0
    for table in iter_grasp_table(path):
        pads = pads or {group.name: (group, shape) for group, shape in pads_of(path, table.columns, options)}
        held = {column for group, _ in pads.values() for column in group.in_order}
        for pad, (group, _) in pads.items():
            taxels.setdefault(pad, []).append(np.stack([_numbers(table, name) for name in group.in_order], axis=1))
            n_bytes += taxels[pad][-1].nbytes
        if n_bytes > LARGEST_BYTES:
            raise FormatError(f"{path}: has more than {LARGEST_BYTES} bytes of numbers; store it as NPZ")
        told = {name: each for name, each in table.cells.items() if name not in held and name.lower() not in COUNTERS}
        others.append(replace(table, cells=told))
    frames = {pad: as_counts(np.concatenate(parts)).reshape(-1, *pads[pad][1]) for pad, parts in taxels.items()}
    return frames, GraspTable.joined(others)


def _numbers(table: GraspTable, name: str) -> NDArray[np.float64]:
    cells = table.cells[name]
    if cells.dtype.kind == "U":
        wrong = next(k for k, cell in enumerate(cells) if as_number(cell or "nan") is None)
        raise FormatError(f"{table.where(wrong)}, column {name!r} must be a number, got {str(cells[wrong])[:40]!r}")
    missing = np.flatnonzero(np.isnan(cells))
    if missing.size:
        place = f"{table.where(int(missing[0]))}, column {name!r}"
        raise FormatError(f"{place} must be a number, got nothing; leave the row out")
    return cells.astype(np.float64)


def _seconds(table: GraspTable, name: str) -> NDArray[np.float64]:
    cells = table.cells[name]
    if cells.dtype.kind != "U":
        return cells.astype(np.float64) * seconds_of(name.lower())
    texts = cells.tolist()
    dates = [date_seconds(cell) for cell in texts]
    if dates[0] is None:
        wrong = next(cell for cell in texts if as_number(cell) is None)
        raise FormatError(f"{table.source}: column {name!r} must be numbers, got {wrong[:40]!r}")
    if None in dates:
        at = dates.index(None)
        raise FormatError(
            f"{table.where(at)}, column {name!r} must be a date, as in the lines before it, got {texts[at][:40]!r}"
        )
    return np.array(dates, np.float64)


def _presses(
    table: GraspTable, told: dict[str, NDArray[Any]]
) -> tuple[NDArray[np.int64] | None, dict[str, NDArray[Any]]]:
    """Return the press of each row, and what is known of each press by columns that tell it; none where nothing is."""
    n_rows = len(table)
    known = {name: as_counts(each) if each.dtype.kind == "f" else each for name, each in told.items() if name != _PRESS}
    if _PRESS not in told:
        return (np.arange(n_rows), known) if known else (None, {})
    given = as_counts(told[_PRESS]) if told[_PRESS].dtype.kind == "f" else told[_PRESS]
    counts = np.array([as_number(cell) for cell in given.tolist()], float) if given.dtype.kind == "U" else given
    odd = np.flatnonzero(~((counts >= -1) & (counts < n_rows) & (counts == np.trunc(counts))))
    if odd.size:
        at = int(odd[0])
        raise FormatError(
            f"{table.where(at)}, column 'press' must be a whole number from 0 to {n_rows - 1}, -1 for none; got "
            f"{str(given[at])[:40]!r}"
        )
    press = counts.astype(np.int64)
    numbers, begun = np.unique(press, return_index=True)
    rows = np.zeros(int(press.max()) + 1, np.intp)
    rows[numbers[numbers >= 0]] = begun[numbers >= 0]
    held = press >= 0
    for name, column in known.items():
        first, each = column[rows[press[held]]], column[held]
        # Not known twice is the same.
        other = np.flatnonzero((first != each) & ((first == first) | (each == each)))
        if other.size:
            row = int(np.flatnonzero(held)[other[0]])
            raise FormatError(
                f"{table.where(row)}, column {name!r}: is {each[other[0]]}, where press {press[held][other[0]]} has "
                f"{first[other[0]]}; a press has one"
            )
    return press, {name: column[rows] for name, column in known.items()}


FORMAT = Format("table of presses (CSV)", (), _recognizes, _read)
