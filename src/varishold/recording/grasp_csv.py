"""Grasp tables as CSV files of any length."""

from __future__ import annotations

import csv
import os
import re
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import chain
from typing import Any

import numpy as np
from numpy.typing import NDArray

from varishold._counted import counted
from varishold.errors import FormatError, InputError
from varishold.files import atomic_write, text_chunks
from varishold.recording.grasp_table import GraspTable, cell_text, columns_told, is_number, listed, matching

__all__ = ["SEPARATOR_SAID", "iter_grasp_table", "read_grasp_table", "table_header", "write_grasp_table"]

#: A first line that only says what stands between cells, as spreadsheets write and read it.
SEPARATOR_SAID = re.compile(r'\s*"?sep=([,;\t])"?[\s,;]*', re.IGNORECASE)

# On-off columns; every other is a number, but for the object's name and what is asked for as text.
_ON_OFF = ("switch.*", "held")
_NUMBERS = ("angle_rad.*", "force_n.*", "size_m", "seed", "step")
_TEXT = ("object",)
# How a text begins that a spreadsheet computes, or one that was kept from it.
_FORMULA = re.compile(r"'*[=+\-@\t\r]")
_WORDS = frozenset(("false", "true", ""))
_TRUTH = {"0": False, "1": True, "false": False, "true": True, "0.0": False, "1.0": True}


def read_grasp_table(
    path: str | os.PathLike[str], *, label: str | None = None, columns: str | Sequence[str] | None = None
) -> GraspTable:
    """Read a whole grasp table; arguments and errors as in `iter_grasp_table`."""
    return GraspTable.joined(list(iter_grasp_table(path, label=label, columns=columns)))


def iter_grasp_table(
    path: str | os.PathLike[str],
    *,
    label: str | None = None,
    columns: str | Sequence[str] | None = None,
    block: int = 1 << 22,
) -> Iterator[GraspTable]:
    """Read a grasp table of any length in bounded memory, some rows at a time.

    The file is CSV (comma, semicolon or tab; decimal points) with a header line, before which there may be blank lines,
    lines that begin with ``#`` and one like ``sep=;``. Below it lines that begin with ``#`` are passed over, but for
    those that have as many cells as a row. Columns whose names are not those of a grasp table are numbers if every cell
    of the first rows is one, text otherwise. A first column without a name is passed over.

    Parameters
    ----------
    path : str or path-like
        The file.
    label : str, optional
        A column to be read as text, whatever it holds.
    columns : str or sequence of str, optional
        Globs; only columns that one of them matches, and `label`, are read. Default: all.
    block : int
        Bytes of text read at a time.

    Yields
    ------
    GraspTable
        Consecutive rows, all with the same columns of the same kinds.

    Raises
    ------
    InputError
        If the file cannot be opened, or `label` or `columns` name nothing in it.
    FormatError
        If it is no such table; the message names line and column.
    """
    source = os.fspath(path)
    chunks = text_chunks(path, block=block)
    header, separator, rest = table_header(source, chunks)
    layout = _layout(source, header, separator, label, columns)
    kinds: tuple[str, ...] = ()
    blank = 0
    for start, chunk in chain([rest], chunks):
        pieces = list(_between_comments(layout, start, chunk))
        kinds = kinds or _kinds(layout, pieces)
        parts = []
        for first, lines in pieces:
            body = _without_blank_end(lines)
            if body and blank:
                raise FormatError(f"{source}: line {blank} is blank, and rows follow; remove it")
            if len(body) < len(lines):
                blank = blank or first + len(body)
            if body:
                parts.append(GraspTable(_parse(layout, kinds, first, body), source, first))
        if parts:
            yield GraspTable.joined(parts)
    if not kinds:
        raise FormatError(f"{source}: has a line of column names but no rows")


def table_header(
    source: str, chunks: Iterable[tuple[int, list[str]]]
) -> tuple[tuple[int, str], str | None, tuple[int, list[str]]]:
    """Return a table's line of column names, what separates cells where a line before it says so, and what follows.

    Parameters
    ----------
    source : str
        The file, for messages.
    chunks : iterable of (int, list of str)
        Lines, with the number of the first of each chunk.

    Returns
    -------
    (int, str)
        The line's number and text.
    str or None
        What separates.
    (int, list of str)
        The rest of the chunk, with its first line's number.

    Raises
    ------
    FormatError
        If there is no such line.
    """
    separator, marked = None, None
    for start, lines in chunks:
        for number, line in enumerate(lines, start):
            said = SEPARATOR_SAID.fullmatch(line)
            if said and separator is None:
                separator = said[1]
            elif line.lstrip().startswith("#"):
                marked = number, line
            elif line.strip():
                if marked is not None and _names(marked[1], line):
                    return marked, separator, (number, lines[number - start :])
                return (number, line), separator, (number + 1, lines[number + 1 - start :])
    if marked is not None:
        return marked, separator, (marked[0] + 1, [])
    raise FormatError(f"{source}: is empty; a grasp table starts with a line of column names")


def _names(marked: str, line: str) -> bool:
    """Tell whether a line that begins with # is column names: as many as there are cells below, some of numbers."""
    mark = max(",;\t", key=line.count)
    cells = [cell.strip() for cell in line.split(mark)]
    return marked.count(mark) + 1 == len(cells) and any(cell and is_number(cell) for cell in cells)


def _between_comments(layout: _Layout, start: int, lines: list[str]) -> Iterator[tuple[int, list[str]]]:
    """Yield the lines between comments, with the number of the first of them."""
    marked = (k for k, line in enumerate(lines) if line.lstrip().startswith("#"))
    comments = [k for k in marked if len(_split(layout.source, start + k, lines[k], layout.separator)) != layout.width]
    for begin, end in zip([0, *(k + 1 for k in comments)], [*comments, len(lines)], strict=True):
        if begin < end:
            yield start + begin, lines[begin:end]


def _without_blank_end(lines: list[str]) -> list[str]:
    end = len(lines)
    while end and not lines[end - 1].strip():
        end -= 1
    return lines[:end]


@dataclass(frozen=True)
class _Layout:
    """Where each wanted column stands in a line."""

    source: str
    line: int
    separator: str
    width: int
    names: tuple[str, ...]
    places: tuple[int, ...]
    label: str | None


def _layout(
    source: str,
    header: tuple[int, str],
    separator: str | None,
    label: str | None,
    columns: str | Sequence[str] | None,
) -> _Layout:
    line, text = header
    separator = separator or max(",;\t", key=text.count)
    names = [_plain_text(name.strip()) for name in _split(source, line, text, separator)]
    if all(is_number(name) for name in names):
        raise FormatError(f"{source}: line {line} holds numbers; a grasp table starts with a line of column names")
    for place, name in enumerate(names):
        # The first may number the rows, as data frames are written.
        if not name and place:
            raise FormatError(f"{source}: line {line}: column {place + 1} has no name")
        if name in names[:place]:
            raise FormatError(f"{source}: line {line}: column {name!r} stands there twice")
    named = [name for name in names if name]
    if label is not None and label not in named:
        raise InputError(f"{source}: there is no column {label!r}; {columns_told(named)}")
    wanted = tuple(named)
    if columns is not None:
        patterns = (columns,) if isinstance(columns, str) else tuple(columns)
        wanted = matching(named, patterns)
        if not wanted:
            raise InputError(f"{source}: no column matches {listed(patterns)}; {columns_told(named)}")
        wanted = tuple(name for name in named if name in wanted or name == label)
    places = tuple(names.index(name) for name in wanted)
    return _Layout(source, line, separator, len(names), wanted, places, label)


def _kinds(layout: _Layout, pieces: list[tuple[int, list[str]]]) -> tuple[str, ...]:
    """Return "b", "f" or "U" for each wanted column; none where there is no row yet."""
    rows = [each for start, lines in pieces for each in enumerate(lines, start) if each[1].strip()]
    if not rows:
        return ()
    kinds = []
    for name, place in zip(layout.names, layout.places, strict=True):
        if name == layout.label or name in _TEXT:
            kinds.append("U")
        elif matching((name,), _ON_OFF):
            kinds.append("b")
        elif matching((name,), _NUMBERS):
            kinds.append("f")
        else:
            cells = (
                (_split(layout.source, number, line, layout.separator) if '"' in line else line.split(layout.separator))
                for number, line in rows
            )
            told = [c[place].strip().lower() for c in cells if len(c) > place]
            kinds.append("f" if all(map(is_number, told)) else "b" if _WORDS.issuperset(told) else "U")
    return tuple(kinds)


def _parse(layout: _Layout, kinds: tuple[str, ...], start: int, lines: list[str]) -> dict[str, NDArray[Any]]:
    numeric = [p for p, kind in zip(layout.places, kinds, strict=True) if kind != "U"]
    numbers = _fast_numbers(layout, lines, numeric)
    if numbers is None:
        return _parse_slowly(layout, kinds, start, lines)
    cells: dict[str, NDArray[Any]] = {}
    for name, place, kind in zip(layout.names, layout.places, kinds, strict=True):
        if kind == "U":
            split = (line.split(layout.separator, place + 1)[place] for line in lines)
            cells[name] = np.array([_plain_text(cell.strip()) for cell in split], dtype=np.str_)
            continue
        column = numbers[:, numeric.index(place)]
        if kind == "b" and not np.all((column == 0) | (column == 1)):
            return _parse_slowly(layout, kinds, start, lines)
        cells[name] = column.astype(np.bool_) if kind == "b" else np.ascontiguousarray(column)
    return cells


def _fast_numbers(layout: _Layout, lines: list[str], places: list[int]) -> NDArray[np.float64] | None:
    """Return the numbers of plain lines, or None where cell by cell reading must find out what is wrong."""
    separators = layout.width - 1
    if any('"' in line or line.count(layout.separator) != separators for line in lines):
        return None
    if not places:
        return np.empty((len(lines), 0))
    if separators == 0 and not all(lines):
        return None
    gap = layout.separator * 2
    edges = layout.separator
    if any(gap in line or line[:1] == edges or line[-1:] == edges for line in lines):
        empty = re.compile(f"(?<={edges})(?={edges})|^(?={edges})|(?<={edges})$")
        lines = [empty.sub("nan", line) for line in lines]
    try:
        numbers = np.loadtxt(lines, delimiter=layout.separator, usecols=places, comments=None, ndmin=2)
    except ValueError:
        return None
    return numbers if len(numbers) == len(lines) and not np.isinf(numbers).any() else None


def _parse_slowly(layout: _Layout, kinds: tuple[str, ...], start: int, lines: list[str]) -> dict[str, NDArray[Any]]:
    columns: list[list[Any]] = [[] for _ in layout.names]
    for number, line in enumerate(lines, start):
        if not line.strip():
            raise FormatError(f"{layout.source}: line {number} is blank, and rows follow; remove it")
        cells = _split(layout.source, number, line, layout.separator)
        if len(cells) != layout.width:
            raise FormatError(
                f"{layout.source}: line {number} must have {counted(layout.width, 'cell')} like line {layout.line}, "
                f"got {len(cells)}"
            )
        for column, name, place, kind in zip(columns, layout.names, layout.places, kinds, strict=True):
            column.append(_cell(layout.source, number, name, cells[place].strip(), kind))
    # Of switches, some of which are unknown, numpy makes numbers by itself.
    dtypes = {"b": None, "f": np.float64, "U": np.str_}
    return {
        name: np.array(column, dtype=dtypes[kind])
        for name, column, kind in zip(layout.names, columns, kinds, strict=True)
    }


def _plain_text(cell: str) -> str:
    """Take away the apostrophe that keeps a text from being a formula."""
    return cell[1:] if cell[:1] == "'" and _FORMULA.match(cell[1:]) else cell


def _safe_text(cell: str) -> str:
    """Put an apostrophe before a text that a spreadsheet would take for a formula."""
    return f"'{cell}" if _FORMULA.match(cell) else cell


def _cell(source: str, line: int, name: str, cell: str, kind: str) -> Any:
    place = f"{source}: line {line}, column {name!r}"
    if kind == "U":
        return _plain_text(cell)
    if kind == "b":
        if cell.lower() in _TRUTH:
            return _TRUTH[cell.lower()]
        if cell or name == "held":
            raise FormatError(f"{place} must be 0 or 1, got {cell!r}")
    if cell == "" or cell.lower() == "nan":
        return np.nan
    if not is_number(cell):
        raise FormatError(f"{place} must be a number, got {cell!r}")
    value = float(cell)
    if not np.isfinite(value):
        raise FormatError(f"{place} must be finite, got {cell!r}")
    return value


def _split(source: str, number: int, line: str, separator: str) -> list[str]:
    try:
        return next(csv.reader([line], delimiter=separator, strict=True), [])
    except csv.Error as error:
        raise FormatError(
            f"{source}: line {number}: {error}; a cell must close its quotes, and hold no line break"
        ) from error


def write_grasp_table(table: GraspTable, path: str | os.PathLike[str]) -> None:
    """Write a grasp table as CSV, whole or not at all; reading it gives the same cells.

    Parameters
    ----------
    table : GraspTable
        The rows.
    path : str or path-like
        The file.

    Raises
    ------
    InputError
        If the file cannot be written, a text holds a line break or a number is infinite.
    """
    for name, column in table.cells.items():
        if column.dtype.kind == "f" and np.isinf(column).any():
            raise InputError(f"{path}: numbers must be finite, got {column[np.isinf(column)][0]} in {name!r}")
        texts = (name, *column) if column.dtype.kind == "U" else (name,)
        for text in texts:
            if "\n" in text or "\r" in text:
                raise InputError(f"{path}: a cell cannot hold a line break, got {str(text)!r} in column {name!r}")
    with atomic_write(path, "w") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow([_safe_text(name) for name in table.columns])
        for row in zip(*table.cells.values(), strict=True):
            writer.writerow([_safe_text(cell) if isinstance(cell, str) else cell_text(cell) for cell in row])
