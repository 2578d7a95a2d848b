"""A part of a table: one file a task, there when it is whole."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from varishold._lazy import missing_extra
from varishold.corpus.columns import Column, schema_of
from varishold.files import atomic_write, damage_told, open_file

if TYPE_CHECKING:
    import pyarrow

__all__ = ["need_parquet", "parquet_options", "read_part", "write_part"]


def need_parquet() -> None:
    """Raise MissingExtraError where Parquet files cannot be written here."""
    try:
        import pyarrow.parquet  # noqa: F401
    except ModuleNotFoundError as error:
        raise missing_extra(error) from None


def parquet_options(columns: Sequence[Column]) -> dict[str, Any]:
    """Return how tables are written: the same rows give the same bytes, and damage shows."""
    return {
        "compression": "zstd",
        "use_dictionary": _repeated(columns),
        "store_schema": False,
        "write_page_checksum": True,
    }


def _repeated(columns: Sequence[Column]) -> list[str]:
    """Return, as Parquet names them, the columns in which the same things stand again and again."""
    inside = {"text": "", "whole": "", "texts": ".list.element", "shares": ".list.element.name"}
    return [f"{column.name}{inside[column.kind]}" for column in columns if column.kind in inside]


def write_part(path: str | os.PathLike[str], rows: Mapping[str, Any], columns: Sequence[Column]) -> None:
    """Write rows, whole or not at all.

    Raises
    ------
    InputError
        If they cannot be written there.
    """
    import pyarrow
    from pyarrow import parquet

    schema = schema_of(columns)
    # What pandas has for nothing, NaN, is null.
    arrays = [pyarrow.array(rows[field.name], field.type, from_pandas=True) for field in schema]
    table = pyarrow.Table.from_arrays(arrays, schema=schema)
    with atomic_write(path) as file:
        parquet.write_table(table, file, **parquet_options(columns))


def read_part(path: str | os.PathLike[str], columns: Sequence[Column]) -> pyarrow.Table:
    """Read what `write_part` has written.

    Raises
    ------
    InputError
        If it is not there.
    FormatError
        If it is damaged, or holds other columns.
    """
    from pyarrow import parquet

    with open_file(path) as file, damage_told(str(path)):
        rows = parquet.ParquetFile(file, page_checksum_verification=True).read(use_threads=False)
        schema = schema_of(columns)
        return rows if rows.schema.equals(schema) else rows.cast(schema)
