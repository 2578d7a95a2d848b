"""Columns of numbers of a stranger's Parquet file, each read a part at a time and within bounds."""

from __future__ import annotations

import math
import os
from abc import ABC, abstractmethod
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from varishold._lazy import missing_extra
from varishold.errors import FormatError
from varishold.files import damage_told, open_file

if TYPE_CHECKING:
    import pyarrow

__all__ = ["GROUP", "GROUP_BYTES", "NumbersColumn", "ParquetColumn", "opened_parquet", "rows_together"]

#: Rows of a group as they are written, and their bytes, at most: a head that tells of thousands of groups is large.
GROUP, GROUP_BYTES = 4096, 1 << 25
# Bytes of rows that are read together.
_TOGETHER = 1 << 21
# A column of so many times the bytes of its file holds nothing measured, if it is larger than this.
_LARGE, _BOMB_RATIO = 1 << 28, 300
# What numpy calls the floating types; integers are called alike.
_FLOATS = {"halffloat": "f2", "float": "f4", "double": "f8"}
# Lists within lists, the longest list, bytes of text in the file's head, and of what is read at a time.
_DEEPEST, _LONGEST, _MOST_TEXT, _BUFFER = 3, 1 << 24, 1 << 26, 1 << 20
# Rows among which one has a list, if any has.
_FIRST_ROWS = 64
# A file of so many bytes need not be read in pieces.
_AT_ONCE = 1 << 25


def opened_parquet(path: Path) -> tuple[Any, Any]:
    """Open a Parquet file within bounds; return pyarrow's file, and the one that it reads, to be closed.

    Raises
    ------
    InputError
        If it cannot be opened.
    FormatError
        If it is damaged.
    MissingExtraError
        If pyarrow is not installed.
    """
    try:
        from pyarrow import parquet
    except ModuleNotFoundError as error:
        raise missing_extra(error) from None
    binary = open_file(path)
    try:
        with damage_told(str(path)):
            limits = {"thrift_string_size_limit": _MOST_TEXT, "thrift_container_size_limit": 1 << 20}
            file = parquet.ParquetFile(binary, pre_buffer=False, **limits)
            # What is small is read at once, whatever the head of a page says of its size. Looked at is the whole file:
            # pyarrow ends the process where the facts of a column contradict each other.
            if binary.seek(0, os.SEEK_END) > _AT_ONCE:
                file = parquet.ParquetFile(
                    binary, metadata=file.metadata, buffer_size=_BUFFER, pre_buffer=False, **limits
                )
            said, held = file.metadata.num_rows, sum(rows_of_groups(file))
            if said != held:
                raise FormatError(f"{path}: says that it has {said} rows, its groups have {held}")
            return file, binary
    except BaseException:
        binary.close()
        raise


def rows_together(row_bytes: int, most_bytes: int) -> int:
    """Return how many rows of so many bytes are written or read together."""
    return max(1, min(GROUP, most_bytes // max(row_bytes, 1)))


def rows_of_groups(file: Any) -> list[int]:
    """Return the rows of each group of pyarrow's file."""
    return [file.metadata.row_group(k).num_rows for k in range(file.metadata.num_row_groups)]


class NumbersColumn(ABC):
    """A column of numbers or of lists of numbers of one length: of one file, or of several."""

    #: What a message calls it.
    place: str
    #: The numbers of an entry; None where it has none.
    width: int | None
    shape: tuple[int, ...]
    dtype: np.dtype[Any]

    def typed(self, dtype: np.dtype[Any], tail: tuple[int, ...]) -> None:
        """Say of which type and shape the entries are; raises FormatError where they have other sizes."""
        if math.prod(tail) != self.width or dtype.kind not in "biuf" or min(tail, default=1) < 1:
            raise FormatError(f"{self.place}: has {self.width} numbers a row, {tail} of {dtype} are announced")
        self.dtype, self.shape = dtype, (self.shape[0], *tail)

    @abstractmethod
    def check(self) -> None:
        """Raise FormatError where a file holds so little that nobody can have measured it."""

    def small(self) -> NDArray[Any]:
        """Read all of it."""
        self.check()
        return self[:]

    @abstractmethod
    def __getitem__(self, wanted: slice, /) -> NDArray[Any]:
        """Read some rows; raises FormatError where they cannot be."""


class ParquetColumn(NumbersColumn):
    """A column of numbers or of lists of numbers of one length; read onward it costs nothing to go on.

    Parameters
    ----------
    source : str
        The file, for messages.
    file : pyarrow.parquet.ParquetFile
    name : str
    n_bytes : int
        Of the file.
    """

    def __init__(self, source: str, file: Any, name: str, n_bytes: int) -> None:
        self._file, self.name, self._n_bytes = file, name, n_bytes
        self.place = f"{source}: column {name}"
        self._starts = np.cumsum([0, *rows_of_groups(file)])
        # The rows that were read last, from which one to go on, and the batches after them.
        self._at, self._rest = -1, np.empty(0)
        self._batches: Iterator[Any] = iter(())
        tail, self.dtype = self._tail(file.schema_arrow.field(name).type)
        self._sides = tail or ()
        self.width = None if tail is None else math.prod(tail)
        self.shape = (int(self._starts[-1]), *(tail or ()))
        #: Rows that are read together; pyarrow takes one number for all columns of a file, that of who began last.
        self.together = rows_together((self.width or 1) * self.dtype.itemsize, _TOGETHER)

    def _tail(self, kind: Any) -> tuple[tuple[int, ...] | None, np.dtype[Any]]:
        """Return the shape of an entry and the type of its numbers; None where it has none."""
        from pyarrow import types

        tail: list[int] = []
        lists = 0
        unknown = False
        while types.is_fixed_size_list(kind) or types.is_list(kind) or types.is_large_list(kind):
            fixed = types.is_fixed_size_list(kind)
            tail.append(kind.list_size if fixed else 0)
            unknown |= not fixed
            kind, lists = kind.value_type, lists + 1
        number = types.is_integer(kind) or types.is_floating(kind) or types.is_boolean(kind)
        if not number or lists > _DEEPEST:
            return None, np.dtype("u1")
        dtype = np.dtype("u1") if types.is_boolean(kind) else np.dtype(_FLOATS.get(str(kind), str(kind)))
        if unknown and self._starts[-1]:
            # Lists of any length: the first tells that of all.
            first = next(self._file.iter_batches(_FIRST_ROWS, columns=[self.name])).column(0).drop_null()
            tail = []
            for _ in range(lists):
                tail.append(len(first[0]) if len(first) and first[0].is_valid else 0)
                first = first.flatten()
        return (tuple(tail) if math.prod(tail) <= _LONGEST and 0 not in tail else None), dtype

    def check(self) -> None:
        n_bytes = math.prod(self.shape) * self.dtype.itemsize
        if n_bytes > max(_LARGE, _BOMB_RATIO * self._n_bytes):
            raise FormatError(f"{self.place}: holds {n_bytes} bytes in a file of {self._n_bytes}; nothing is so empty")

    def __getitem__(self, wanted: slice, /) -> NDArray[Any]:
        """Read some rows.

        Raises
        ------
        FormatError
            If the file is damaged, a row has none or another number of numbers, or one of them is missing.
        """
        first, last, _ = wanted.indices(self.shape[0])
        with damage_told(self.place):
            if not 0 <= self._at <= first:
                self._begin(first)
            # Copied, for what is kept of a batch keeps several times as many bytes.
            read = np.empty((max(last - first, 0), self.width or 1), self.dtype)
            done = self._copied(read, first, 0)
            while done < len(read):
                self._at += len(self._rest)
                batch = next(self._batches, None)
                if batch is None or not len(batch):
                    raise EOFError(f"{self.shape[0]} rows are announced, {self._at} are there")
                self._rest = self._numbers(batch.column(0), self._at)
                done = self._copied(read, first, done)
            return read.reshape(-1, *self.shape[1:])

    def _copied(self, read: NDArray[Any], first: int, done: int) -> int:
        """Copy what was read last to where it is wanted; return how many rows are there now."""
        some = self._rest[max(first + done - self._at, 0) :][: len(read) - done]
        read[done : done + len(some)] = some
        return done + len(some)

    def _begin(self, first: int) -> None:
        group = int(np.searchsorted(self._starts, first, side="right")) - 1
        rows = range(group, len(self._starts) - 1)
        self._at, self._rest = int(self._starts[group]), np.empty((0, self.width or 1), self.dtype)
        self._batches = self._file.iter_batches(self.together, row_groups=list(rows), columns=[self.name])

    def _numbers(self, batch: pyarrow.Array, first: int) -> NDArray[Any]:
        n_rows = len(batch)
        for side in self._sides:
            if batch.null_count:
                raise FormatError(f"{self.place}: says nothing in rows {first} to {first + n_rows - 1}")
            lengths = batch.value_lengths().to_numpy(zero_copy_only=False)
            if (lengths != side).any():
                other = int(lengths[lengths != side][0])
                raise FormatError(f"{self.place}: has lists of {side} and of {other} from row {first} on")
            batch = batch.flatten()
        if batch.null_count and self.dtype.kind != "f":
            raise FormatError(f"{self.place}: lacks numbers in rows {first} to {first + n_rows - 1}")
        return np.asarray(batch.to_numpy(zero_copy_only=False)).reshape(n_rows, -1)
