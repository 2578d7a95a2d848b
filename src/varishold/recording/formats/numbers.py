"""Lines of numbers into arrays, quickly where all is well and with line and column where not."""

from __future__ import annotations

import math
import re
import warnings
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from varishold._counted import counted
from varishold.errors import FormatError
from varishold.files import LARGEST_BYTES

__all__ = ["NO_NUMBER", "Rows", "Separator", "as_counts", "as_number", "separator_of"]


#: What stands where there is no number, in lower case.
NO_NUMBER = ("", "nan", "na", "n/a", "null", "none", "-nan")
# What a list begins with.
_LIST = ("[", "(")
# What no text has in which a point parts thousands: a fraction of other than three digits, or below 1; 1000 unparted.
_NO_THOUSANDS = re.compile(r"\d{4}|\.(?!\d{3}(?!\d))|(?<!\d)0*\.|[eE]")
_NO_DIGITS = str.maketrans("", "", "+-0123456789")
# A day or a time of day.
_DATE = re.compile(r"\d{1,4}[-/.]\d{1,2}[-/.]\d{1,4}|\d{1,2}:\d\d")


@dataclass(frozen=True)
class Separator:
    """What stands between the numbers of a line, and whether their decimal sign is a comma.

    `mark` is "" where spaces of any number separate.
    """

    mark: str
    decimal_comma: bool = False

    def plain(self, line: str, titles: int = 0) -> str:
        """Return a line with decimal points and without a separator at its end; of as many cells as titles, with it."""
        line = line.strip(" ") if self.mark == "\t" else line.strip()
        if self.decimal_comma:
            # Quotes that were left because of the comma are no more needed.
            line = line.replace(",", ".").replace('"', "")
        if not self.mark or line.count(self.mark) + 1 == titles:
            return line
        return line.removesuffix(self.mark).rstrip()

    def cells(self, line: str) -> list[str]:
        return [cell.strip() for cell in (line.split(self.mark) if self.mark else line.split())]


def separator_of(texts: Iterable[str]) -> Separator:
    """Tell what separates the cells of lines of numbers, from all of them; each text is a line or several.

    Semicolons and tabs separate where there are any; commas beside them are decimal signs if no decimal point is
    there.
    """
    found: set[str] = set()
    for text in texts:
        found.update(sign for sign in ";\t,." if sign in text)
    for mark in (";", "\t"):
        if mark in found:
            return Separator(mark, "," in found and "." not in found)
    return Separator("," if "," in found else "")


def as_number(cell: str) -> float | None:
    """Return a cell's number, NaN and infinity included; None if it is none."""
    if "_" in cell:
        return None
    try:
        return float(cell)
    except ValueError:
        return None


def as_counts(values: NDArray[Any]) -> NDArray[Any]:
    """Return whole numbers as integers: a count of a converter, not a measured fraction."""
    if values.size and np.abs(values).max() < 2**31 and np.array_equal(values, np.trunc(values)):
        return values.astype(np.int32)
    return values


class Rows:
    """Rows of equally many numbers, collected from a text file line by line.

    Parameters
    ----------
    path : Path
        The file, for messages.
    separator : Separator
        What separates the cells.
    blanks : tuple of str
        Cells that stand for no value and become NaN.
    gaps : bool
        Whether cells may be empty, or say that there is no number, and become NaN: seldom, so that reading stays quick.
    titles : int
        How many titles stand above the cells, where any do: an empty cell at a line's end is one of these.
    """

    def __init__(
        self, path: Path, separator: Separator, *, blanks: tuple[str, ...] = (), gaps: bool = False, titles: int = 0
    ) -> None:
        self._path = path
        self._separator = separator
        self._blanks, self._gaps, self._titles = blanks, gaps, titles
        self._values: NDArray[Any] = np.empty((0, 0))
        self._first_line = 0
        self._whole = True
        # Columns of cells with a point before three digits, and of whole numbers, as long as all may be thousands.
        self._thousands: tuple[set[int], set[int]] | None = (set(), set())
        self.n = 0
        self.width = 0

    def add(self, lines: list[str], numbers: list[int]) -> None:
        """Append one row a line; `numbers` are the lines' numbers in the file."""
        if not lines:
            return
        plain = [self._separator.plain(line, self._titles) for line in lines]
        if not self.width:
            self.width = len(self._separator.cells(plain[0]))
            self._first_line = numbers[0]
            self._values = np.empty((max(len(lines), 64), self.width))
        values = self._quickly(plain)
        if values is None:
            values = self._slowly(plain, numbers)
        self._whole = self._whole and not any("." in line or "e" in line or "E" in line for line in plain)
        # Where points stand in the same cells of all lines, they are columns of fractions.
        if not self._whole and self._thousands is not None and len({line.translate(_NO_DIGITS) for line in plain}) > 1:
            self._look_for_thousands(plain)
        self._grow(self.n + len(values))
        self._values[self.n : self.n + len(values)] = values
        self.n += len(values)

    @property
    def ends_empty(self) -> bool:
        """Whether the last row so far has no number at its end."""
        return bool(self.n and self.width and math.isnan(self._values[self.n - 1, -1]))

    def values(self) -> NDArray[Any]:
        """Return all rows, shape (n, width): int32 where no cell had a fraction, float64 otherwise."""
        if self._thousands is not None and (both := sorted(set.intersection(*self._thousands))):
            raise FormatError(
                f"{self._path}: column {both[0] + 1} has numbers with a mark before just three digits, and others "
                "without: write numbers without a mark between thousands, or all with as many digits behind the point"
            )
        values = self._values[: self.n]
        if self._whole and not self._blanks and values.size and np.abs(values).max() < 2**31:
            return values.astype(np.int32)
        self._values = np.empty((0, 0))
        return values

    def _look_for_thousands(self, lines: list[str]) -> None:
        """Note where a point may part thousands, as in 999 and 1.002: with one it is no fraction."""
        pointed, whole = self._thousands or (set(), set())
        for line in lines:
            if _NO_THOUSANDS.search(line):
                self._thousands = None
                return
            for column, cell in enumerate(self._separator.cells(line)):
                if "." in cell:
                    pointed.add(column)
                elif cell.strip("+-0"):
                    whole.add(column)

    def _grow(self, needed: int) -> None:
        if needed * self.width * 8 > LARGEST_BYTES:
            raise FormatError(f"{self._path}: has more than {LARGEST_BYTES} bytes of numbers; store it as NPY")
        if needed > len(self._values):
            many = max(needed, len(self._values) + len(self._values) // 2)
            # Grown in place: a copy would need the memory of both.
            self._values.resize((many, self.width), refcheck=False)

    def _quickly(self, lines: list[str]) -> NDArray[np.float64] | None:
        mark = self._separator.mark
        # One cell for several lines would pass for a row of its own.
        if mark and any(line.count(mark) != self.width - 1 for line in lines):
            return None
        if self._blanks:
            lines = [",".join("nan" if c in self._blanks else c for c in self._separator.cells(line)) for line in lines]
            mark = ","
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("error")
                values = np.loadtxt(lines, delimiter=mark or None, comments=None, ndmin=2)
        except (ValueError, UserWarning):
            return None
        if values.shape != (len(lines), self.width):
            return None
        fit = ~np.isinf(values) if self._blanks else np.isfinite(values)
        return values if fit.all() else None

    def _slowly(self, lines: list[str], numbers: list[int]) -> NDArray[np.float64]:
        rows = []
        for line, number in zip(lines, numbers, strict=True):
            cells = self._separator.cells(line)
            if len(cells) != self.width:
                remedy = "; write numbers without commas in them" if '"' in line else ""
                raise FormatError(
                    f"{self._path}: line {number} must have {counted(self.width, 'number')} "
                    f"like line {self._first_line}, "
                    f"got {len(cells)}{remedy}"
                )
            rows.append([self._number(cells, number, column) for column in range(1, len(cells) + 1)])
        return np.array(rows)

    def _number(self, cells: list[str], line: int, column: int) -> float:
        cell = cells[column - 1]
        if cell in self._blanks or (self._gaps and cell.strip("\"'").lower() in NO_NUMBER):
            return math.nan
        value = as_number(cell)
        if value is None:
            remedy, bare = "", cell.strip("\"'")
            if bare.startswith(_LIST):
                remedy = "; a list in one cell: write a column for each of its numbers"
            elif _DATE.match(bare):
                remedy = "; a date or a time of day: write seconds, or leave the column out"
            elif bare[:1].isalpha() and not any(as_number(each) is not None for each in cells):
                remedy = "; no number stands in this line: leave it out"
            elif self._titles and bare[:1].isalpha():
                remedy = "; where each row is a press, call the columns of taxels NAME.ROW.COLUMN in line 1"
            raise FormatError(f"{self._path}: line {line}, column {column} must be a number, got {cell[:40]!r}{remedy}")
        if not math.isfinite(value):
            raise FormatError(f"{self._path}: line {line}, column {column} must be finite, got {cell[:40]!r}")
        return value
