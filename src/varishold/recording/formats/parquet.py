"""Parquet: a row a frame, each pad a column of lists of one length, as robots' data sets have it.

``timestamp``, ``press``, ``observation.tactile.NAME`` and ``observation.signals.NAME``; all else is JSON in the file's
metadata, by the names of `named_arrays`.
"""

from __future__ import annotations

import math
import os
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from varishold._lazy import missing_extra
from varishold.errors import FormatError
from varishold.files import atomic_write, damage_told, open_file, parse_json
from varishold.recording.formats.format import Format, Options, read_by
from varishold.recording.formats.guessing import guessed
from varishold.recording.formats.named_arrays import NAMED, SIGNALS, SINGLE, HeldArrays, arrays_of, stored_in
from varishold.recording.mcap.notes import note_text
from varishold.recording.mcap.press_notes import typed_column
from varishold.recording.recording import UNNAMED_PAD, Recording
from varishold.recording.stored import Stored

if TYPE_CHECKING:
    import pyarrow

__all__ = ["FORMAT", "ParquetColumn", "opened_parquet", "write"]

_MAGIC = b"PAR1"
# The entry of the file's metadata that says what the columns are, and the frames of a row group.
_TOLD, _GROUP = b"varishold recording", 4096
_PADS, _SIGNALS, _TIME = "observation.tactile.", "observation.signals.", "timestamp"
# A column of so many times the bytes of its file holds nothing measured, if it is larger than this.
_LARGE, _BOMB_RATIO = 1 << 28, 300
# What numpy calls the floating types; integers are called alike.
_FLOATS = {"halffloat": "f2", "float": "f4", "double": "f8"}
# Lists within lists, the longest list, bytes of text in the file's head, and of what is read at a time.
_DEEPEST, _LONGEST, _MOST_TEXT, _BUFFER = 3, 1 << 24, 1 << 26, 1 << 20


def _recognizes(path: Path, head: bytes) -> bool:
    return head.startswith(_MAGIC)


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
            return parquet.ParquetFile(binary, buffer_size=_BUFFER, pre_buffer=False, **limits), binary
    except BaseException:
        binary.close()
        raise


def _open(path: Path, options: Options) -> Stored:
    file, binary = opened_parquet(path)
    try:
        with damage_told(str(path)):
            size = binary.seek(0, os.SEEK_END)
            columns = {}
            for field in file.schema_arrow:
                column = ParquetColumn(str(path), file, field.name, size)
                if column.width is not None:
                    columns[field.name] = column
            told = (file.schema_arrow.metadata or {}).get(_TOLD)
            if told is None:
                keys, notes = guessed(path, columns, options)
                arrays = HeldArrays({key: columns[name] for key, name in keys.items()}, {})
            else:
                arrays, notes = _told(path, parse_json(told.decode("utf-8", "replace"), where=str(path)), columns), ()
            return stored_in(arrays, path, options, notes=notes, close=binary.close)
    except BaseException:
        binary.close()
        raise


def _told(path: Path, told: Any, columns: dict[str, ParquetColumn]) -> HeldArrays:
    """Return what the columns and the metadata of a file of this program hold."""
    held, said = {}, {}
    for name, facts in told["columns"].items():
        column = columns[str(facts["column"])]
        column.typed(_dtype(path, facts["type"]), tuple(int(side) for side in facts["shape"]))
        held[name] = column
    for name, facts in told["arrays"].items():
        cells = dict(enumerate(facts["values"]))
        shape = tuple(int(side) for side in facts["shape"])
        said[name] = typed_column(str(path), name, cells, facts["type"]).reshape(shape)
    return HeldArrays(held, said)


def _dtype(path: Path, told: str) -> np.dtype[Any]:
    return typed_column(str(path), "the type of a column", {}, told).dtype


class ParquetColumn:
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
        groups = [file.metadata.row_group(k).num_rows for k in range(file.metadata.num_row_groups)]
        self._starts = np.cumsum([0, *groups])
        # The rows that were read last, from which one to go on, and the batches after them.
        self._at, self._rest = -1, np.empty(0)
        self._batches: Iterator[Any] = iter(())
        tail, self.dtype = self._tail(file.schema_arrow.field(name).type)
        self._sides = tail or ()
        #: The numbers of an entry; None where it has none.
        self.width = None if tail is None else math.prod(tail)
        self.shape: tuple[int, ...] = (int(self._starts[-1]), *(tail or ()))

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
            first = next(self._file.iter_batches(1, columns=[self.name])).column(0)
            tail = []
            for _ in range(lists):
                tail.append(len(first[0]) if len(first) and first[0].is_valid else 0)
                first = first.flatten()
        return (tuple(tail) if math.prod(tail) <= _LONGEST and 0 not in tail else None), dtype

    def typed(self, dtype: np.dtype[Any], tail: tuple[int, ...]) -> None:
        """Say of which type and shape the entries are; raises FormatError where they have other sizes."""
        if math.prod(tail) != self.width or dtype.kind not in "biuf" or min(tail, default=1) < 1:
            raise FormatError(f"{self.place}: has {self.width} numbers a row, {tail} of {dtype} are announced")
        self.dtype, self.shape = dtype, (self.shape[0], *tail)

    def check(self) -> None:
        n_bytes = math.prod(self.shape) * self.dtype.itemsize
        if n_bytes > max(_LARGE, _BOMB_RATIO * self._n_bytes):
            raise FormatError(f"{self.place}: holds {n_bytes} bytes in a file of {self._n_bytes}; nothing is so empty")

    def small(self) -> NDArray[Any]:
        self.check()
        return self[:]

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
            parts = [self._rest[first - self._at :]]
            while self._at + len(self._rest) < last:
                self._at += len(self._rest)
                batch = next(self._batches, None)
                if batch is None or not len(batch):
                    raise EOFError(f"{self.shape[0]} rows are announced, {self._at} are there")
                self._rest = self._numbers(batch.column(0), self._at)
                parts.append(self._rest[max(0, first - self._at) :])
            return np.concatenate(parts)[: last - first].reshape(-1, *self.shape[1:]).astype(self.dtype, copy=False)

    def _begin(self, first: int) -> None:
        group = int(np.searchsorted(self._starts, first, side="right")) - 1
        rows = range(group, len(self._starts) - 1)
        self._at, self._rest = int(self._starts[group]), np.empty((0, self.width or 1), self.dtype)
        self._batches = self._file.iter_batches(_GROUP, row_groups=list(rows), columns=[self.name])

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


def write(recording: Recording, path: str | os.PathLike[str]) -> None:
    """Write a recording as Parquet, whole or not at all; reading it gives the same recording.

    Parameters
    ----------
    recording : Recording
    path : str or path-like
        The file; its name should end in ``.parquet``.

    Raises
    ------
    InputError
        If it cannot be written there.
    MissingExtraError
        If pyarrow is not installed.
    """
    try:
        import pyarrow
        from pyarrow import parquet
    except ModuleNotFoundError as error:
        raise missing_extra(error) from None
    columns: dict[str, NDArray[Any]] = {}
    told: dict[str, dict[str, Any]] = {"columns": {}, "arrays": {}}
    for name, array in arrays_of(recording).items():
        column = _column_of(name)
        facts = {"type": array.dtype.str, "shape": list(array.shape[1:] if column else array.shape)}
        if column:
            columns[column] = array
            told["columns"][name] = {"column": column, **facts}
        else:
            told["arrays"][name] = {**facts, "values": array.ravel()}
    native = {name: array.dtype.newbyteorder("=") for name, array in columns.items()}
    fields = [pyarrow.field(name, _kind(array, native[name])) for name, array in columns.items()]
    schema = pyarrow.schema(fields, metadata={_TOLD: note_text(told).encode()})
    with atomic_write(path) as binary, parquet.ParquetWriter(binary, schema, compression="zstd") as writer:
        for begun in range(0, recording.n_frames, _GROUP):
            some = {name: array[begun : begun + _GROUP].astype(native[name]) for name, array in columns.items()}
            arrays = [_rows(block, field.type) for block, field in zip(some.values(), fields, strict=True)]
            writer.write_table(pyarrow.table(arrays, schema))


def _column_of(name: str) -> str:
    """Return the column that holds an array with an entry a frame; "" for any other."""
    if name == SINGLE:
        return f"{_PADS}{UNNAMED_PAD}"
    if name.startswith(NAMED):
        return f"{_PADS}{name.removeprefix(NAMED)}"
    if name.startswith(SIGNALS):
        return f"{_SIGNALS}{name.removeprefix(SIGNALS)}"
    return {"time_s": _TIME, "press": "press"}.get(name, "")


def _kind(array: NDArray[Any], dtype: np.dtype[Any]) -> pyarrow.DataType:
    import pyarrow

    number = pyarrow.from_numpy_dtype(dtype)
    return pyarrow.list_(number, math.prod(array.shape[1:])) if array.ndim > 1 else number


def _rows(block: NDArray[Any], kind: pyarrow.DataType) -> pyarrow.Array:
    import pyarrow

    if block.ndim == 1:
        return pyarrow.array(block)
    return pyarrow.FixedSizeListArray.from_arrays(pyarrow.array(block.ravel()), type=kind)


FORMAT = Format("Parquet", (".parquet",), _recognizes, read_by(_open), write, _open)
