"""Grasp rows: what a hand's switches, joints and force sensors said, one row a grasp or a step of one."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fnmatch import fnmatchcase
from itertools import accumulate
from types import MappingProxyType
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from varishold._remade import remade
from varishold.errors import InputError, require_a
from varishold.frame.checks import as_given

__all__ = ["GraspTable", "cell_text", "columns_told", "is_number", "listed", "matching"]


@dataclass(frozen=True)
class GraspTable:
    """Rows of a grasp table, column by column.

    Parameters
    ----------
    cells : mapping of str to ndarray of shape (n_rows,)
        Columns in the file's order: bool for ``switch.NAME`` and ``held``; float64 for ``angle_rad.NAME``
        (radians), ``force_n.NAME`` (newtons), ``size_m``, ``seed``, ``step`` and every other column of
        numbers, and for switches of which some are unknown, NaN where a cell is empty; str for ``object``, labels and
        every other column of text.
    source : str
        The file the rows come from, for messages.
    first_line : int
        Line of the first row in that file, counted from 1.
    origins : tuple of (int, str, int)
        Of rows from several places, in order: after how many rows each ends, its file, and the line of its first row.

    Examples
    --------
    >>> import numpy as np
    >>> table = GraspTable({"object": np.array(["cone", "cube"]), "switch.v1": np.array([True, False])})
    >>> table.names("switch.*")
    ('switch.v1',)
    >>> table.matrix("switch.*")
    array([[ True],
           [False]])
    >>> table.labels("object").tolist()
    ['cone', 'cube']
    """

    cells: Mapping[str, NDArray[Any]]
    source: str = "table"
    first_line: int = 2
    origins: tuple[tuple[int, str, int], ...] = ()

    @classmethod
    def joined(cls, tables: Sequence[Self]) -> Self:
        """Return the rows of one table or several, one after the other.

        Raises
        ------
        InputError
            If they have other columns than the first, or a column is text in one and a number in another.
        """
        first = tables[0]
        for table in tables[1:]:
            _require_like(first, table)
        if len(tables) == 1:
            return first
        cells = {name: np.concatenate([table.cells[name] for table in tables]) for name in first.columns}
        sources = dict.fromkeys(table.source for table in tables)
        return cls(
            cells,
            first.source if len(sources) == 1 else f"{first.source} and {len(sources) - 1} more",
            first.first_line,
            tuple(
                (begin + end, source, line)
                for begin, table in zip(accumulate(map(len, tables), initial=0), tables, strict=False)
                for end, source, line in table.origins or ((len(table), table.source, table.first_line),)
            ),
        )

    def __post_init__(self) -> None:
        require_a(Mapping, self.cells, "cells of a table", "columns by name")
        told = f"{self.source}: columns must be of one length and one dimension"
        cells = {name: as_given(column, told) for name, column in self.cells.items()}
        lengths = {name: column.shape for name, column in cells.items()}
        if len(set(lengths.values())) > 1 or any(len(shape) != 1 for shape in lengths.values()):
            raise InputError(f"{told}, got {lengths}")
        object.__setattr__(self, "cells", MappingProxyType(cells))

    __reduce__ = remade

    def __len__(self) -> int:
        return next((len(column) for column in self.cells.values()), 0)

    @property
    def columns(self) -> tuple[str, ...]:
        """Names of the columns, in the file's order."""
        return tuple(self.cells)

    def where(self, row: int) -> str:
        """Return the file and the line of a row, as a message says them."""
        begin = 0
        for end, source, first_line in self.origins:
            if row < end:
                return f"{source}: line {first_line + row - begin}"
            begin = end
        return f"{self.source}: line {self.first_line + row}"

    def names(self, pattern: str | Sequence[str]) -> tuple[str, ...]:
        """Return the columns that a glob (or one of several) matches, in the file's order.

        Raises
        ------
        InputError
            If none does.
        """
        patterns = (pattern,) if isinstance(pattern, str) else tuple(pattern)
        found = matching(self.columns, patterns)
        if not found:
            raise InputError(f"{self.source}: no column matches {listed(patterns)}; {columns_told(self.columns)}")
        return found

    def matrix(self, pattern: str | Sequence[str]) -> NDArray[np.bool_] | NDArray[np.float64]:
        """Return the columns that a glob (or one of several) matches as one array.

        Returns
        -------
        ndarray of shape (n_rows, n_columns), bool or float64
            bool where every column is on-off.

        Raises
        ------
        InputError
            If no column matches, or one holds text or an empty cell, which is named.
        """
        return np.column_stack([self.numbers(name) for name in self.names(pattern)])

    def numbers(self, column: str, *, unknown: bool = False) -> NDArray[Any]:
        """Return a column of numbers, shape (n_rows,), bool or float64.

        Parameters
        ----------
        column : str
        unknown : bool, default False
            Whether cells may be empty: they are NaN.

        Raises
        ------
        InputError
            If it holds text or an empty cell, which is named.
        """
        cells = self.cells[column]
        if cells.dtype.kind in "iu":
            return cells.astype(np.float64)
        if cells.dtype.kind not in "bf":
            row = next((i for i, cell in enumerate(cells) if not is_number(str(cell))), 0)
            got = str(cells[row]) if len(cells) else "text"
            raise InputError(f"{self.where(row)}, column {column!r} must be a number, got {got!r}")
        empty = np.flatnonzero(np.isnan(cells))
        if empty.size and not unknown:
            raise InputError(
                f"{self.where(int(empty[0]))}, column {column!r} is empty; fill it or leave the column out"
            )
        return cells

    def labels(self, column: str) -> NDArray[np.str_]:
        """Return a column as text, shape (n_rows,), str.

        Raises
        ------
        InputError
            If there is no such column or a cell is empty.
        """
        if column not in self.cells:
            raise InputError(f"{self.source}: there is no column {column!r}; {columns_told(self.columns)}")
        cells = self.cells[column]
        text = cells if cells.dtype.kind == "U" else np.array([cell_text(cell) for cell in cells], dtype=np.str_)
        empty = np.flatnonzero(text == "")
        if empty.size:
            raise InputError(f"{self.where(int(empty[0]))}, column {column!r} is empty; every row needs a label")
        return text


def is_number(cell: str) -> bool:
    """Tell whether a cell of a table holds a number, or nothing."""
    if "_" in cell:
        return False
    try:
        float(cell or "nan")
    except ValueError:
        return False
    return True


def _require_like(first: GraspTable, table: GraspTable) -> None:
    for name in sorted({*first.columns} ^ {*table.columns}):
        has, lacks = (first, table) if name in first.cells else (table, first)
        raise InputError(f"{lacks.source}: there is no column {name!r}, which {has.source} has", parameter="columns")
    for name in first.columns:
        text, numbers = (first, table) if first.cells[name].dtype.kind == "U" else (table, first)
        if text.cells[name].dtype.kind == "U" != numbers.cells[name].dtype.kind:
            raise InputError(f"{text.source}: column {name!r} is text, and numbers in {numbers.source}")


def matching(names: Sequence[str], patterns: Sequence[str]) -> tuple[str, ...]:
    """Return the names that at least one of the globs matches."""
    return tuple(name for name in names if any(fnmatchcase(name, pattern) for pattern in patterns))


def listed(patterns: Sequence[str]) -> str:
    """Return globs as a message shows them."""
    return " or ".join(repr(pattern) for pattern in patterns)


def columns_told(names: Sequence[str]) -> str:
    """Return what columns there are, as a message tells it."""
    shown = ", ".join(names[:12])
    return f"its columns are {shown}" + (f" and {len(names) - 12} more" if len(names) > 12 else "")


def cell_text(cell: Any) -> str:
    """Return a cell as it stands in a file: 0 or 1, the shortest exact number, nothing for NaN."""
    if isinstance(cell, bool | np.bool_):
        return str(int(cell))
    if isinstance(cell, float | np.floating):
        return "" if np.isnan(cell) else repr(float(cell)).removesuffix(".0")
    return str(cell)
