"""Plain CSV: one frame a line, or one row a line with a blank line between frames."""

from __future__ import annotations

import os
import re
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from varishold._counted import counted
from varishold.errors import FormatError, InputError
from varishold.files import encoding_notes, head_lines, open_file, text_chunks
from varishold.recording.formats.csv_dates import date_at
from varishold.recording.formats.csv_titles import (
    COUNTERS,
    check_order,
    counts_frames,
    names_time,
    only_counts,
    refuse_hidden_column,
    seconds_of,
    unit_of,
)
from varishold.recording.formats.format import Format, Options
from varishold.recording.formats.numbers import NO_NUMBER, Rows, as_number, separator_of
from varishold.recording.formats.taxel_columns import header_names
from varishold.recording.grasp_csv import SEPARATOR_SAID
from varishold.recording.pad import UNNAMED_PAD, Pad
from varishold.recording.recording import Recording

__all__ = ["FORMAT", "read_rows"]

# What a line of JSON begins with.
_JSON = ("{", "[")
# A clock without a title that goes back in a larger share of frames is none, nor is one that stands in more frames.
_BACK, _FEW = 0.25, 2
# So many whole numbers so far apart are rather milliseconds than seconds.
_FEWEST_TIMES, _ODD_STEP_S = 4, 2.0
# Bytes, in any encoding.
_LARGEST_CHARACTER = 4
# A quoted cell without a sign that could separate: with a comma in it nobody knows what the comma is.
_QUOTED = re.compile(r'"([^",;\t]*)"')


@dataclass(frozen=True)
class _Table:
    """The numbers of a file as they stand in it."""

    rows: NDArray[Any]
    frame_starts: list[tuple[int, int]]
    title: str | None
    """The first column's title in lower case; None where there is no header."""
    titles: tuple[str, ...] = ()
    """Those of all columns, where each has one."""
    dates: int | None = None
    """Which of the first two columns was dates, and is seconds here."""
    notes: tuple[str, ...] = ()


def _recognizes(path: Path, head: bytes) -> bool:
    return not any("\0" in line for line in head_lines(head))


def _read(path: Path, options: Options) -> Recording:
    table = _table(path, gaps=True, dates=True)
    if len(table.frame_starts) > 1 and not _are_whole(table, options):
        time, frames = _from_rows(path, table, options)
    else:
        table = _without_counts(table, options)
        time, frames = _from_lines(path, table, options)
    frames, valid, said = _without_gaps(path, frames)
    if time is not None and table.dates is None:
        said = (*said, *_doubted_clock(table, time))
    try:
        pad = Pad(frames, valid=valid, pitch_m=options.pitch_m, polarity=options.polarity)
        return Recording(
            {UNNAMED_PAD: pad}, time_s=time, source=str(path), notes=(*table.notes, *said, *encoding_notes(path))
        )
    except InputError as error:
        raise FormatError(f"{path}: {error}") from error


def _are_whole(table: _Table, options: Options) -> bool:
    """Tell whether there is a blank line between all lines, each a frame: ends of line that were written twice."""
    if options.shape is None or options.shape[0] == 1 or len(table.frame_starts) != len(table.rows):
        return False
    return bool(table.rows.shape[1] >= options.shape[0] * options.shape[1])


def _without_counts(table: _Table, options: Options) -> _Table:
    """Return a table of one frame a line without a first line that only counts its columns, as data frames write it."""
    rows = table.rows
    taxels = options.shape[0] * options.shape[1] if options.shape else 0
    if table.title is not None or len(rows) < 2 or rows.shape[1] - taxels not in (0, 1) or not only_counts(rows[0]):
        return table
    said = f"line {table.frame_starts[0][1]} counts its columns, {rows[0, 0]:g} to {rows[0, -1]:g}: taken for a header"
    return replace(table, rows=rows[1:], notes=(*table.notes, said))


def _without_gaps(path: Path, frames: NDArray[Any]) -> tuple[NDArray[Any], NDArray[np.bool_] | None, tuple[str, ...]]:
    """Return frames in which every number is one, which taxels work, and what there is to say about it.

    A taxel that never says a number is broken; one that does now and then is an error.
    """
    none = np.isnan(frames) if frames.dtype.kind == "f" else np.zeros(frames.shape, np.bool_)
    if not none.any():
        return frames, None, ()
    dead = none.all(axis=0)
    now_and_then = np.argwhere(none & ~dead)
    if not dead.any() or dead.all():
        # It is told with its line, as if no cell could be empty.
        _table(path, dates=True)
    if now_and_then.size:
        frame, row, col = now_and_then[0].tolist()
        raise FormatError(
            f"{path}: frame {frame} has no number for the taxel at (row, col) = ({row}, {col}), which others have; "
            "fill it in, or leave its line out"
        )
    n, works = int(np.count_nonzero(dead)), np.asarray(~dead, np.bool_)
    which = counted(n, "taxel is never a number", "taxels are never a number")
    return np.where(none, 0.0, frames), works, (f"{which}: taken as broken",)


def _cut_off(path: Path) -> bool:
    """Tell whether a file ends in the middle of a line."""
    with open_file(path) as file:
        file.seek(max(file.seek(0, os.SEEK_END) - _LARGEST_CHARACTER, 0))
        # In UTF-16 and UTF-32 an end of line has zeros beside it; no text has any elsewhere.
        return file.read().strip(b"\0")[-1:] not in b"\r\n"


def _table(path: Path, unknown: tuple[str, ...] = (), *, gaps: bool = False, dates: bool = False) -> _Table:
    first, title, header = _first_line(path)
    dated = _dated(path, first, header) if dates else None
    # A first row without a fraction cannot tell what a comma is.
    separator = separator_of("\n".join(line.strip() for _, line in chunk) for chunk in _lines(path, first, dated))
    titles = len(separator.cells(separator.plain(header))) if header and gaps else 0
    rows = Rows(path, separator, blanks=unknown, gaps=gaps, titles=titles)
    frame_starts: list[tuple[int, int]] = []
    after_blank, cut_off = True, gaps and _cut_off(path)
    lines: list[str] = []
    numbers: list[int] = []
    for chunk in _lines(path, first, dated):
        for number, line in chunk:
            if not line.strip():
                after_blank = True
                continue
            if after_blank:
                frame_starts.append((rows.n + len(lines), number))
                after_blank = False
            lines.append(line)
            numbers.append(number)
        # The last line of all may be none that is whole.
        kept = len(lines) - cut_off
        rows.add(lines[:kept], numbers[:kept])
        lines, numbers = lines[max(kept, 0) :], numbers[max(kept, 0) :]
    notes: tuple[str, ...] = ()
    if lines and len(frame_starts) == 1 and rows.n:
        there = len(separator.cells(separator.plain(lines[0], titles)))
        # An empty cell at the end is a taxel only where the line before it has none there either.
        there -= there == titles and not rows.ends_empty and lines[0].strip().endswith(separator.mark or "\n")
        if there < rows.width:
            notes = (
                f"line {numbers[0]} is cut off in the middle, and left out: "
                f"it has {there} of {counted(rows.width, 'number')}",
            )
    if not notes:
        rows.add(lines, numbers)
    if not rows.n:
        raise FormatError(f"{path}: there is no line of numbers behind {header.strip()[:40]!r}")
    names = header_names(header) if gaps else []
    return _Table(rows.values(), frame_starts, title, tuple(names) if len(names) == rows.width else (), dated, notes)


def read_rows(path: str | os.PathLike[str], *, unknown: tuple[str, ...] = ()) -> NDArray[Any]:
    """Return the rows of numbers that a text file holds, a header line and blank lines left out.

    Cells of the words `unknown` become NaN.
    """
    return _table(Path(path), unknown).rows


def _lines(path: Path, first: int = 1, dated: int | None = None) -> Iterator[list[tuple[int, str]]]:
    """Yield chunks of lines with their numbers, comments and quotes around a cell left out, from line `first` on.

    Dates in the column `dated` are seconds.
    """
    for start, chunk in text_chunks(path):
        lines = [
            (number, _QUOTED.sub(r"\1", line) if '"' in line else line)
            for number, line in enumerate(chunk, start)
            if number >= first and not line.lstrip().startswith("#") and not SEPARATOR_SAID.fullmatch(line)
        ]
        yield lines if dated is None else [(number, _in_seconds(path, number, line, dated)) for number, line in lines]


def _dated(path: Path, first: int, header: str) -> int | None:
    """Return which of the first two columns holds dates, by the first line of numbers; None where neither does.

    The second does where it is called a time.
    """
    line = next((line for chunk in _lines(path, first) for _, line in chunk if line.strip()), "")
    called = [name.lower() for name in header_names(header)]
    if date_at(line, 0):
        return 0
    return 1 if len(called) > 1 and names_time(called[1]) and date_at(line, 1) else None


def _in_seconds(path: Path, number: int, line: str, dated: int) -> str:
    """Return a line with its date as seconds; what is neither is told where cells are read."""
    at = date_at(line, dated)
    if at is not None:
        return line[: at[0]] + at[1] + line[at[2] :]
    cells = separator_of([line.strip()]).cells(line.strip())
    if len(cells) > dated + 1 and as_number(cells[dated]) is not None:
        raise FormatError(
            f"{path}: line {number}, column {dated + 1} must be a date, as in the lines before it, got "
            f"{cells[dated][:40]!r}"
        )
    return line


def _first_line(path: Path) -> tuple[int, str | None, str]:
    """Return the number of the first line of numbers, the first title of a header line before it, and that line."""
    for chunk in _lines(path):
        for number, line in chunk:
            if line.strip():
                title = _header_title(path, number, line)
                return number + (title is not None), title, "" if title is None else line
    raise FormatError(f"{path}: is empty: there is no line of numbers")


def _header_title(path: Path, number: int, line: str) -> str | None:
    """Return the first title of a header line, or None where the line holds numbers."""
    if line.lstrip().startswith(_JSON):
        raise FormatError(
            f"{path}: line {number} is JSON, and no row of numbers; where every line is a frame: "
            f"varishold record stdin: -o FILE.mcap < {path.name}"
        )
    separator = separator_of([line.strip()])
    cells = [cell.strip("\"'") for cell in separator.cells(separator.plain(line))]
    values = [as_number(cell) for cell in cells]
    if values[0] is not None or date_at(line, 0):
        return None
    rest = values[1:]
    counted = [list(range(first, first + len(rest))) for first in (0, 1)]
    numbers = [value for value, cell in zip(rest, cells[1:], strict=True) if cell.lower() not in NO_NUMBER]
    if numbers and all(value is not None for value in numbers) and rest not in counted:
        if cells[0].lower() in NO_NUMBER:
            return None
        raise FormatError(f"{path}: line {number}, column 1 must be a number, got {cells[0][:40]!r}")
    return cells[0].lower()


def _from_rows(path: Path, table: _Table, options: Options) -> tuple[NDArray[Any] | None, NDArray[Any]]:
    """One row a line: split off the time, and check that frames have equally many rows."""
    starts = [row for row, _ in table.frame_starts] + [len(table.rows)]
    height = options.shape[0] if options.shape else starts[1]
    for frame, (row, line) in enumerate(table.frame_starts):
        if starts[frame + 1] - row != height:
            what = "the given shape has" if options.shape else "frame 0 has"
            raise FormatError(
                f"{path}: frame {frame} (line {line}) has "
                f"{counted(starts[frame + 1] - row, 'row')} where {what} {height}"
            )
    width = table.rows.shape[1]
    ahead = _leading_columns(path, table, width, options.shape[1] if options.shape else None)
    frames = table.rows[:, ahead:].reshape(len(table.frame_starts), height, width - ahead)
    if options.shape is None:
        refuse_hidden_column(path, frames)
    return _time(path, table, ahead, height), frames


def _from_lines(path: Path, table: _Table, options: Options) -> tuple[NDArray[Any] | None, NDArray[Any]]:
    """One frame a line; or one row a line without blank lines, which only a shape can tell."""
    n, width = table.rows.shape
    if options.shape is None:
        raise FormatError(
            f"{path}: {counted(n, 'line')} of {counted(width, 'number')} and no blank line between frames: "
            "say the shape of a frame, (rows, columns)",
            parameter="shape",
        )
    rows, cols = options.shape
    if rows > 1 and width in (cols, cols + 1) and width != rows * cols:
        if n % rows:
            raise FormatError(
                f"{path}: {counted(n, 'line of one row is', 'lines of one row each are')} "
                f"no whole number of frames of {rows} rows"
            )
        height = rows
        ahead = _leading_columns(path, table, width, cols)
    else:
        height = 1
        ahead = _leading_columns(path, table, width, rows * cols)
        check_order(path, table.titles[ahead:], options.shape)
    return _time(path, table, ahead, height), table.rows[:, ahead:].reshape(-1, rows, cols)


def _leading_columns(path: Path, table: _Table, width: int, wanted: int | None) -> int:
    """Return how many columns stand before the taxels: a time or a counter, or both where they are called so."""
    titled = names_time(table.title) or table.title in COUNTERS or table.dates == 0
    ahead = int(titled) if wanted is None else width - wanted
    if table.dates is not None and ahead == table.dates:
        told = f"{path}: column {ahead + 1} is dates"
        if wanted is None:
            raise FormatError(f"{told}, and stands where taxels begin; leave it out, or put it first")
        raise FormatError(
            f"{told}, and a line must hold {wanted} numbers of taxels beside it for this shape, "
            f"got {width - 1 - ahead}",
            parameter="shape",
        )
    called = [title.lower() for title in table.titles[:2]]
    both = ahead == len(called) == 2 and sorted(map(names_time, called)) == [False, True]
    if both and any(title in COUNTERS for title in called):
        return ahead
    if ahead not in (0, 1) or width == ahead:
        raise FormatError(
            f"{path}: a line must hold {counted(wanted, 'number')}, or one more with the time ahead, for this shape; "
            f"got {width}" + _remedy(table, width, wanted)
            if wanted is not None
            else f"{path}: holds no taxels beside the column {table.title!r}"
        )
    return ahead


def _remedy(table: _Table, width: int, wanted: int) -> str:
    """Return what may be wrong with lines of so many numbers."""
    if width in (3 * wanted, 3 * wanted + 1):
        return f"; three for each of {counted(wanted, 'taxel')}, as x, y, z? keep the one that is normal to the pad"
    if table.dates == 0 and width == wanted + 2:
        return "; if the first of them are fractions of the dates, write these with points, or in quotes"
    return ""


def _time(path: Path, table: _Table, ahead: int, height: int) -> NDArray[np.float64] | None:
    if table.dates is not None:
        return np.ascontiguousarray(table.rows[::height, table.dates])
    if ahead == 2:
        called = [title.lower() for title in table.titles[:2]]
        clock = next(k for k in (0, 1) if names_time(called[k]))
        return table.rows[::height, clock] * seconds_of(called[clock])
    if not ahead or table.title in COUNTERS:
        return None
    time = table.rows[::height, 0] * seconds_of(table.title or "")
    if not names_time(table.title):
        _check_runs(path, table, time)
    return time


def _doubted_clock(table: _Table, time: NDArray[np.float64]) -> list[str]:
    """Say what was assumed of a time that its title does not tell."""
    title = table.title or ""
    if title in COUNTERS and len(table.titles) > 1:
        title = table.titles[1].lower()
    if unit_of(title) is not None:
        return []
    if not names_time(title):
        if counts_frames(time):
            return [
                f"the first column counts {time[0]:g} to {time[-1]:g}: taken for seconds; if these are numbers of "
                "frames, call it frame"
            ]
        if title:
            return [f"the first column, {title[:40]!r}, is taken for a time in seconds"]
    step = float(np.median(np.diff(time))) if len(time) >= _FEWEST_TIMES else 0.0
    if step >= _ODD_STEP_S and np.array_equal(time, np.trunc(time)):
        return [
            f"times are whole numbers {step:g} apart, taken for seconds; if they are milliseconds, call them time_ms"
        ]
    return []


def _check_runs(path: Path, table: _Table, time: NDArray[np.float64]) -> None:
    """Refuse a first column that nothing calls a time and that does not run as one: another one is too much."""
    back = int(np.count_nonzero(time[1:] < time[:-1]))
    stands = len(time) > _FEW and np.ptp(time) == 0
    if back > (0 if table.title else _BACK * len(time)) or stands:
        called = f" {table.title[:40]!r}" if table.title else ""
        how = "never changes" if stands else f"goes back {counted(back, 'time')}"
        raise FormatError(
            f"{path}: holds one column more than taxels, and the first one{called} {how}, so that it is no time; leave "
            "out the column that is no taxel"
        )


FORMAT = Format("plain CSV", (".csv", ".txt", ".tsv", ".dat"), _recognizes, _read)
