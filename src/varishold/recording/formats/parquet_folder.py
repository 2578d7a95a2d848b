"""Columns that go through several Parquet files, one after another, of which one is open at a time."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
from numpy.typing import NDArray

from varishold.errors import FormatError
from varishold.files import damage_told
from varishold.recording.formats.parquet_column import NumbersColumn, ParquetColumn, opened_parquet

__all__ = ["FilesColumn", "Part", "parts_of"]


@dataclass(frozen=True)
class Part:
    """A Parquet file of several: its rows, its bytes and the names of its columns."""

    path: Path
    n_rows: int
    n_bytes: int
    names: tuple[str, ...]


def parts_of(files: Sequence[Path]) -> list[Part]:
    """Look into Parquet files.

    Raises
    ------
    InputError
        If one cannot be opened.
    FormatError
        If one is damaged.
    MissingExtraError
        If pyarrow is not installed.
    """
    parts = []
    for path in files:
        file, binary = opened_parquet(path)
        with binary, damage_told(str(path)):
            parts.append(
                Part(path, file.metadata.num_rows, binary.seek(0, os.SEEK_END), tuple(file.schema_arrow.names))
            )
    return parts


class FilesColumn(NumbersColumn):
    """A column of numbers, or of lists of numbers of one length, through several files.

    Parameters
    ----------
    place : str
        What they are together, for messages.
    parts : sequence of Part
        At least one.
    name : str

    Raises
    ------
    FormatError
        If the first file has no such column.
    """

    def __init__(self, place: str, parts: Sequence[Part], name: str) -> None:
        self.place = f"{place}: column {name}"
        self.name = name
        self._parts = parts
        self._starts = np.cumsum([0, *(part.n_rows for part in parts)])
        self._at = -1
        self._column: ParquetColumn | None = None
        self._binary: BinaryIO | None = None
        first = self._opened(0)
        self.width = first.width
        self._stored: np.dtype[Any] = first.dtype
        self.dtype = first.dtype
        self.shape = (int(self._starts[-1]), *first.shape[1:])
        self._tail = first.shape[1:]

    def close(self) -> None:
        """Let the file go that is open. May be called again."""
        if self._binary is not None:
            self._binary.close()
        self._at = -1

    def _opened(self, part: int) -> ParquetColumn:
        if self._at == part and self._column is not None:
            return self._column
        self.close()
        where = self._parts[part]
        if self.name not in where.names:
            raise FormatError(f"{where.path}: has no column {self.name}, which {self._parts[0].path.name} has")
        file, self._binary = opened_parquet(where.path)
        try:
            with damage_told(str(where.path)):
                column = ParquetColumn(str(where.path), file, self.name, where.n_bytes)
        except BaseException:
            # Who could not make this column has nothing to close.
            self.close()
            raise
        self._at, self._column = part, column
        return column

    def check(self) -> None:
        for part in range(len(self._parts)):
            self._opened(part).check()

    def __getitem__(self, wanted: slice, /) -> NDArray[Any]:
        """Read some rows.

        Raises
        ------
        InputError
            If a file is not there any more.
        FormatError
            If one is damaged, or its entries are of another size or type than those of the first.
        """
        first, last, _ = wanted.indices(self.shape[0])
        read = np.empty((max(0, last - first), *self.shape[1:]), self.dtype)
        at = first
        while at < last:
            part = int(np.searchsorted(self._starts, at, side="right")) - 1
            column = self._opened(part)
            if column.dtype != self._stored or column.shape[1:] != self._tail:
                raise FormatError(
                    f"{column.place}: has {column.dtype} of shape {column.shape[1:]} a row, that of "
                    f"{self._parts[0].path.name} {self._stored} of {self._tail}"
                )
            begun = int(self._starts[part])
            until = min(last, int(self._starts[part + 1]))
            block = column[at - begun : until - begun]
            read[at - first : until - first] = block.reshape(-1, *self.shape[1:])
            at = until
        return read
