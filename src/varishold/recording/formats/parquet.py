"""Parquet: a row a frame, each pad a column of lists of one length, as robots' data sets have it.

``timestamp``, ``press``, ``observation.tactile.NAME`` and ``observation.signals.NAME``; all else is JSON in the file's
metadata, by the names of `named_arrays`.
"""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np
from numpy.typing import NDArray

from varishold._lazy import missing_extra
from varishold.files import atomic_write, damage_told, parse_json
from varishold.recording.formats.format import Format, Options, read_by
from varishold.recording.formats.guessing import guessed
from varishold.recording.formats.named_arrays import NAMED, SIGNALS, SINGLE, Dataset, HeldArrays, arrays_of, stored_in
from varishold.recording.formats.parquet_column import GROUP_BYTES, ParquetColumn, opened_parquet, rows_together
from varishold.recording.mcap.notes import note_text
from varishold.recording.mcap.press_notes import typed_column
from varishold.recording.pad import UNNAMED_PAD
from varishold.recording.recording import Recording
from varishold.recording.stored import Stored

if TYPE_CHECKING:
    import pyarrow

__all__ = ["FORMAT", "TypedColumn", "held_as_told", "told_columns", "write"]

_MAGIC = b"PAR1"
# The entry of the file's metadata that says what the columns are.
_TOLD = b"varishold recording"
_PADS, _SIGNALS, _TIME = "observation.tactile.", "observation.signals.", "timestamp"


class TypedColumn(Dataset, Protocol):
    """A column that can be told of which type and shape its entries are."""

    def typed(self, dtype: np.dtype[Any], tail: tuple[int, ...]) -> None:
        """Raise FormatError where they have other sizes."""
        ...


def _recognizes(path: Path, head: bytes) -> bool:
    return head.startswith(_MAGIC)


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
            together = min((column.together for column in columns.values()), default=1)
            for column in columns.values():
                column.together = together
            told = (file.schema_arrow.metadata or {}).get(_TOLD)
            if told is None:
                keys, notes = guessed(path, columns, options)
                notes += _dates_passed(file.schema_arrow) if "time_s" not in keys else ()
                arrays = HeldArrays({key: columns[name] for key, name in keys.items()}, {})
            else:
                said = parse_json(told.decode("utf-8", "replace"), where=str(path))
                arrays, notes = held_as_told(str(path), said, columns), ()
            return stored_in(arrays, path, options, notes=notes, close=binary.close)
    except BaseException:
        binary.close()
        raise


def _dates_passed(schema: Any) -> tuple[str, ...]:
    """Say which columns hold the time of each frame as dates, which are not read."""
    from pyarrow import types

    passed = [f"{field.name} ({field.type})" for field in schema if types.is_temporal(field.type)]
    return (f"no time is read: {', '.join(passed[:8])}: write seconds, as timestamp",) if passed else ()


def held_as_told(place: str, told: Any, columns: Mapping[str, TypedColumn]) -> HeldArrays:
    """Return what columns and what is said beside them hold, as `told_columns` gave it.

    Parameters
    ----------
    place : str
        The file that says it, for messages.
    told : Any
        What it says; whatever it is of a damaged file.
    columns : mapping of str to TypedColumn
        By what they are called there.
    """
    held: dict[str, Dataset] = {}
    said = {}
    for name, facts in told["columns"].items():
        column = columns[str(facts["column"])]
        dtype = typed_column(place, "the type of a column", {}, facts["type"]).dtype
        column.typed(dtype, tuple(int(side) for side in facts["shape"]))
        held[name] = column
    for name, facts in told["arrays"].items():
        cells = dict(enumerate(facts["values"]))
        shape = tuple(int(side) for side in facts["shape"])
        said[name] = typed_column(place, name, cells, facts["type"]).reshape(shape)
    return HeldArrays(held, said)


def told_columns(
    recording: Recording, column_of: Callable[[str], str]
) -> tuple[dict[str, NDArray[Any]], dict[str, dict[str, Any]]]:
    """Return a recording's columns, and what is to be said beside them so that `held_as_told` gives it back.

    Parameters
    ----------
    recording : Recording
    column_of : callable
        Takes the name of an array as of `arrays_of`; returns what its column is called, "" of what has no entry a
        frame.
    """
    columns: dict[str, NDArray[Any]] = {}
    told: dict[str, dict[str, Any]] = {"columns": {}, "arrays": {}}
    for name, array in arrays_of(recording).items():
        column = column_of(name)
        facts = {"type": array.dtype.str, "shape": list(array.shape[1:] if column else array.shape)}
        if column:
            columns[column] = array
            told["columns"][name] = {"column": column, **facts}
        else:
            told["arrays"][name] = {**facts, "values": array.ravel()}
    return columns, told


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
    columns, told = told_columns(recording, _column_of)
    native = {name: array.dtype.newbyteorder("=") for name, array in columns.items()}
    fields = [pyarrow.field(name, _kind(array, native[name])) for name, array in columns.items()]
    schema = pyarrow.schema(fields, metadata={_TOLD: note_text(told).encode()})
    group = rows_together(sum(array[:1].nbytes for array in columns.values()), GROUP_BYTES)
    with atomic_write(path) as binary, parquet.ParquetWriter(binary, schema, compression="zstd") as writer:
        for begun in range(0, recording.n_frames, group):
            some = {name: array[begun : begun + group].astype(native[name]) for name, array in columns.items()}
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
