"""Columns of a table that are taxels, by what its header calls them: ``NAME.ROW.COLUMN``, or ``NAME_K`` in rows."""

from __future__ import annotations

import csv
import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from varishold._counted import counted
from varishold.errors import FormatError
from varishold.recording.formats.format import Options, shape_error

__all__ = ["TaxelColumns", "header_names", "pads_of", "taxel_columns"]

# A name with a letter in it, and one number or two.
_TAXEL = re.compile(r"(?=.*[^\W\d_])(.+?)[._\[](\d{1,5})\]?(?:[._\[](\d{1,5})\]?)?")
# How numbered columns begin that are no taxels.
_NO_PADS = ("switch", "angle", "force_n", "joint", "encoder", "motor")
# Columns of taxels that cannot be told from a few numbered joints.
_FEWEST = 4


@dataclass(frozen=True)
class TaxelColumns:
    """Columns that one pad may be.

    Parameters
    ----------
    name : str
        Of the pad.
    columns : dict of tuple of int to str
        What the column of each place is called: of a row and a column, or of a number in rows.
    """

    name: str
    columns: dict[tuple[int, ...], str]

    @property
    def sides(self) -> tuple[int, ...]:
        """The rows and columns, or the taxels, if none is missing; counted from 0 or from 1."""
        return tuple(last - first + 1 for first, last in self._spans)

    @property
    def _spans(self) -> list[tuple[int, int]]:
        return [(min(along), max(along)) for along in zip(*self.columns, strict=True)]

    @property
    def is_counted(self) -> bool:
        """Whether its places begin at 0, or all at 1."""
        first = {first for first, _ in self._spans}
        return first in ({0}, {1}) and len(self.columns) > 1

    @property
    def missing(self) -> tuple[int, ...] | None:
        """The first place that has no column."""
        places = np.ndindex(*self.sides)
        from_one = self._spans[0][0]
        return next((p for p in (tuple(k + from_one for k in q) for q in places) if p not in self.columns), None)

    @property
    def in_order(self) -> list[str]:
        """The columns, row by row."""
        return [self.columns[place] for place in sorted(self.columns)]

    @property
    def words(self) -> str:
        """What a message calls them."""
        return f"{self.in_order[0]} to {self.in_order[-1]}"


def header_names(header: str) -> list[str]:
    """Return the names that a line of column names holds; none where it cannot be one."""
    try:
        cells = next(csv.reader([header], delimiter=max(",;\t", key=header.count), strict=True), [])
    except csv.Error:
        return []
    return [cell.strip() for cell in cells]


def taxel_columns(names: Sequence[str]) -> list[TaxelColumns]:
    """Return the columns that are numbered: in rows and columns where those begin alike, else one after another."""
    grids: dict[str, dict[tuple[int, ...], str]] = {}
    for name in names:
        match = None if name.lower().startswith(_NO_PADS) else _TAXEL.fullmatch(name)
        if match and match[3] is not None:
            grids.setdefault(match[1], {})[int(match[2]), int(match[3])] = name
    found = [group for group in (TaxelColumns(*each) for each in grids.items()) if group.is_counted]
    taken = {column for group in found for column in group.columns.values()}
    flat: dict[str, dict[tuple[int, ...], str]] = {}
    for name in names:
        match = None if name in taken or name.lower().startswith(_NO_PADS) else _TAXEL.fullmatch(name)
        if match:
            pad = match[1] if match[3] is None else name[: match.start(3) - 1]
            flat.setdefault(pad, {})[(int(match[3] or match[2]),)] = name
    return found + [group for group in (TaxelColumns(*each) for each in flat.items()) if group.is_counted]


def pads_of(path: Path, names: Sequence[str], options: Options) -> list[tuple[TaxelColumns, tuple[int, int]]]:
    """Return the pads that a header names, and their shapes.

    Raises
    ------
    FormatError
        If there are none, one lacks a taxel, or the shape must be said or is another.
    """
    groups = taxel_columns(names)
    found: list[tuple[TaxelColumns, tuple[int, int]]] = []
    for group in groups:
        if len(group.sides) == 2:
            shape = (group.sides[0], group.sides[1])
            if error := shape_error(path, shape, options):
                raise error
            found.append((group, shape))
        elif options.shape is not None and group.sides == (options.shape[0] * options.shape[1],):
            found.append((group, options.shape))
    for group, _ in found:
        if (place := group.missing) is not None:
            raise FormatError(
                f"{path}: line 1: columns {group.words} are the pad {group.name}, but that of taxel "
                f"{'.'.join(map(str, place))} is missing"
            )
    if found:
        return found
    flat = [group for group in groups if len(group.sides) == 1 and len(group.columns) >= _FEWEST]
    if not flat:
        raise FormatError(f"{path}: line 1: no columns are taxels; call them NAME.ROW.COLUMN, from 0 or from 1 on")
    held = ", ".join(f"{group.words} ({len(group.columns)})" for group in flat[:4])
    if options.shape is None:
        raise FormatError(
            f"{path}: line 1: columns {held} may be pads; say the shape of a pad, (rows, columns), or call them "
            "NAME.ROW.COLUMN",
            parameter="shape",
        )
    rows, cols = options.shape
    raise FormatError(
        f"{path}: line 1: no {counted(rows * cols, 'column is', 'columns are')} "
        f"a pad of {rows} x {cols}; there are {held}"
    )
