"""What the first line of plain CSV says of the columns below it: which is a time, and in what order taxels stand."""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from varishold.errors import FormatError

__all__ = [
    "COUNTERS",
    "check_order",
    "counts_frames",
    "names_time",
    "only_counts",
    "refuse_hidden_column",
    "seconds_of",
    "unit_of",
]

# What units of time are called, in seconds; those above a second never alone, for min is the least.
_UNITS = {
    **dict.fromkeys(("s", "sec", "secs", "second", "seconds"), 1.0),
    **dict.fromkeys(("ms", "msec", "msecs", "millis", "millisecond", "milliseconds"), 1e-3),
    **dict.fromkeys(("us", "\u00b5s", "\u03bcs", "usec", "usecs", "micros", "microsecond", "microseconds"), 1e-6),
    **dict.fromkeys(("ns", "nsec", "nsecs", "nanos", "nanosecond", "nanoseconds"), 1e-9),
}
_LONG_UNITS = {**dict.fromkeys(("min", "minutes"), 60.0), **dict.fromkeys(("h", "hours"), 3600.0)}
_UNIT, _LONG_UNIT = "|".join(_UNITS), "|".join(_LONG_UNITS)
_ANY_UNIT = f"{_UNIT}|{_LONG_UNIT}"
_IN_BRACKETS = rf"\(\s*({_ANY_UNIT})\s*\)|\[\s*({_ANY_UNIT})\s*\]|/\s*({_ANY_UNIT})"
# What a time is called: a clock, a clock and its unit, or a unit.
_CLOCK = re.compile(
    rf"(?:time|t|timestamp)(?:[_ ]({_UNIT})|\s*(?:{_IN_BRACKETS}))?"
    rf"|(?:time|timestamp)(ms|us|ns)|time_({_LONG_UNIT})|({_UNIT})"
)
# A unit at the end of a title that is not known.
_UNIT_LAST = re.compile(rf"(?:[_ ]({_UNIT})|{_IN_BRACKETS})\Z")
#: Titles of columns that count lines.
COUNTERS = ("", "frame", "index", "n", "#", "no", "nr", "unnamed: 0")

_NUMBER = re.compile(r"\d+")
# What stands before the first of two numbers where it is the column's.
_COLUMN_FIRST = re.compile(r"(?:^|[\W_])(c|col|column|x)[\W_]*$", re.IGNORECASE)
# A pad of fewer taxels may well read 0, 1, 2, 3.
_FEWEST_COUNTED = 16
# Frames, and rows of one, of which a column that rises or counts is hardly one of taxels, nor a time by chance.
_FEWEST_FRAMES, _FEWEST_ROWS = 4, 3


def names_time(title: str | None) -> bool:
    """Tell whether a column is a time by its title in lower case.

    Examples
    --------
    >>> names_time("timestamp_ns"), names_time("t / min"), names_time("ms"), names_time("zeit [ms]"), names_time(None)
    (True, True, True, False, False)
    """
    return title is not None and _CLOCK.fullmatch(title) is not None


def unit_of(title: str) -> float | None:
    """Return the unit that the title of a time column says, in lower case, in seconds; None where it says none.

    Examples
    --------
    >>> unit_of("timestamp_ns"), unit_of("zeit/ms"), unit_of("elapsed_msec"), unit_of("clock")
    (1e-09, 0.001, 0.001, None)
    """
    said = _CLOCK.fullmatch(title) or _UNIT_LAST.search(title)
    if said is None or said.lastindex is None:
        return None
    return {**_UNITS, **_LONG_UNITS}[said[said.lastindex]]


def seconds_of(title: str) -> float:
    """Return the seconds in one unit of a time column, by its title in lower case; 1 where that says no unit."""
    return unit_of(title) or 1.0


def counts_frames(column: NDArray[Any]) -> bool:
    """Tell whether a column goes up by one from frame to frame."""
    return len(column) >= _FEWEST_FRAMES and bool((np.diff(column) == 1).all())


def only_counts(row: NDArray[Any]) -> bool:
    """Tell whether a row is 0, 1, 2 ... or 1, 2, 3 ...: what stands above a table whose columns have no names."""
    return row.size >= _FEWEST_COUNTED and _counts(row)


def refuse_hidden_column(path: Path, frames: NDArray[Any]) -> None:
    """Refuse frames, of a file that says nothing of its columns, in which a column or a row is none of taxels.

    Parameters
    ----------
    path : Path
        The file, for messages.
    frames : ndarray of shape (n, rows, cols)

    Raises
    ------
    FormatError
        If the first column is the same all down each frame and rises from frame to frame, or counts the rows of all;
        if the first row counts the columns of all; or if the last column or row is the sum of the others.
    """
    n, rows, cols = frames.shape
    first = frames[:, :, 0]
    if cols < 2 or n < _FEWEST_FRAMES:
        return
    if rows > 1 and bool((first == first[:, :1]).all() and (np.diff(first[:, 0]) > 0).all()):
        raise FormatError(
            f"{path}: the first column is one number all down each frame, and rises from frame to frame: if it is a "
            f"time, say the shape {rows}x{cols - 1}; if it is taxels, {rows}x{cols}",
            parameter="shape",
        )
    for what, crossed, lines in (("column", "rows", frames), ("row", "columns", frames.swapaxes(1, 2))):
        first, last = lines[:, :, 0], lines[:, :, -1]
        told = f"leave it out; if it is taxels, say the shape {rows}x{cols}"
        if len(first[0]) >= _FEWEST_ROWS and bool((first == first[0]).all()) and _counts(first[0]):
            raise FormatError(
                f"{path}: the first {what} numbers the {crossed} of each frame, {first[0, 0]:g} to {first[0, -1]:g}: "
                f"{told}",
                parameter="shape",
            )
        before = lines[:, :, :-1]
        if (np.count_nonzero(before, axis=2) > 2).any() and np.allclose(last, before.sum(axis=2), 1e-9, 0.0):
            raise FormatError(f"{path}: the last {what} is the sum of the others: {told}", parameter="shape")


def _counts(line: NDArray[Any]) -> bool:
    """Tell whether numbers are 0, 1, 2 ... or 1, 2, 3 ..."""
    return line[0] in (0, 1) and bool((np.diff(line) == 1).all())


def check_order(path: Path, titles: Sequence[str], shape: tuple[int, int]) -> None:
    """Refuse taxels whose titles number them in another order than row by row, or as a pad that lies across.

    Parameters
    ----------
    path : Path
        The file, for messages.
    titles : sequence of str
        Of the columns that are taxels, in the order of the file.
    shape : (int, int)
        Rows and columns of a frame, as somebody says.

    Raises
    ------
    FormatError
        If all are called alike but for a number, or a row and a column, and these do not rise; or if the rows and
        columns of the shape are the columns and rows of the titles.
    """
    if not titles:
        return
    alike = {_NUMBER.sub("#", title) for title in titles}
    places = [tuple(map(int, _NUMBER.findall(title))) for title in titles]
    if len(alike) != 1 or len(places[0]) not in (1, 2) or len(set(places)) < len(places):
        return
    if len(places[0]) == 2 and _COLUMN_FIRST.search(_NUMBER.split(titles[0])[0]):
        places = [(row, col) for col, row in places]
    wrong = next((k for k in range(1, len(places)) if places[k] < places[k - 1]), None)
    if wrong is not None:
        raise FormatError(
            f"{path}: columns are not in the order of their numbers: {titles[wrong][:40]!r} stands behind "
            f"{titles[wrong - 1][:40]!r}; call them NAME.ROW.COLUMN, which may stand in any order, or leave the header "
            "out where they do stand row by row"
        )
    if len(places[0]) != 2:
        return
    rows, cols = (max(along) - min(along) + 1 for along in zip(*places, strict=True))
    if rows * cols == len(places) and shape == (cols, rows) != (rows, cols) and min(shape) > 1:
        raise FormatError(
            f"{path}: the titles {titles[0][:40]!r} to {titles[-1][:40]!r} are those of {rows} x {cols} taxels, not of "
            f"{shape[0]} x {shape[1]}; say the shape {rows}x{cols}",
            parameter="shape",
        )
