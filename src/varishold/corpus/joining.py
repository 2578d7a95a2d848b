"""Parts joined to one table, in the order of the recordings: the same rows give the same bytes."""

from __future__ import annotations

import json
import os
from collections.abc import Iterable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from queue import SimpleQueue
from typing import TYPE_CHECKING, Any, Self

from varishold.corpus.columns import FILE, Column, schema_of
from varishold.corpus.part import parquet_options, read_part
from varishold.errors import FormatError
from varishold.files import atomic_write

if TYPE_CHECKING:
    import pyarrow

__all__ = ["TOLD", "Joining", "join_parts"]

#: The entry of the table's metadata that says what asked it.
TOLD = "varishold table"
# Rows of a row group: queries skip whole ones, and each takes memory while it is written.
_ROWS = 1 << 16


def join_parts(
    output: str | os.PathLike[str],
    parts: Iterable[tuple[str, Path]],
    columns: Sequence[Column],
    *,
    title: str,
) -> int:
    """Write a table, whole or not at all; return its number of rows.

    Parameters
    ----------
    output : path-like
    parts : iterable of (str, Path)
        The recording that each part belongs to, and the part, in order.
    columns : sequence of Column
        Of the parts.
    title : str
        The command that asks.

    Raises
    ------
    InputError
        If the table cannot be written there.
    FormatError
        If a part is damaged; it is removed, so that the next run makes it anew.
    """
    from pyarrow import parquet

    every = (FILE, *columns)
    schema = schema_of(every)
    n_rows = 0
    with atomic_write(output) as file, parquet.ParquetWriter(file, schema, **parquet_options(every)) as writer:
        waiting = _Waiting(writer, schema)
        for name, path in parts:
            waiting.add(_named(name, _whole(path, columns), schema))
        n_rows = waiting.end()
        writer.add_key_value_metadata({TOLD: json.dumps({"command": title})})
    return n_rows


class _GivenUp(Exception):
    """There is nothing to be joined."""


class Joining:
    """Parts that are joined in a thread of their own while others are still made: the same table as of `join_parts`.

    As a context manager; the table is there when `end` was called within, and untouched otherwise.

    Parameters
    ----------
    output, columns, title
        As in `join_parts`.
    """

    def __init__(self, output: str | os.PathLike[str], columns: Sequence[Column], *, title: str) -> None:
        self._coming: SimpleQueue[tuple[str, Path] | None] = SimpleQueue()
        self._given_up = False
        self._thread = ThreadPoolExecutor(1)
        self._joined = self._thread.submit(join_parts, output, self._parts(), columns, title=title)

    def add(self, name: str, part: Path) -> None:
        """Give the next part."""
        self._coming.put((name, part))

    def end(self) -> int:
        """Return the number of rows when all are joined; raises as `join_parts`."""
        self._coming.put(None)
        return self._joined.result()

    def _parts(self) -> Iterator[tuple[str, Path]]:
        while (part := self._coming.get()) is not None and not self._given_up:
            yield part
        if self._given_up:
            raise _GivenUp

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        # Whoever has ended it no longer listens.
        self._given_up = True
        self._coming.put(None)
        self._thread.shutdown(wait=True)


class _Waiting:
    """Rows that wait until there are enough of them for a row group."""

    def __init__(self, writer: Any, schema: pyarrow.Schema) -> None:
        self._writer = writer
        self._rows = schema.empty_table()
        self._n_rows = 0

    def add(self, rows: pyarrow.Table) -> None:
        import pyarrow

        self._rows = pyarrow.concat_tables([self._rows, rows])
        while self._rows.num_rows >= _ROWS:
            self._write(self._rows.slice(0, _ROWS))
            self._rows = self._rows.slice(_ROWS)

    def end(self) -> int:
        """Write the rest; return how many rows there were."""
        if self._rows.num_rows:
            self._write(self._rows)
        return self._n_rows

    def _write(self, rows: pyarrow.Table) -> None:
        # In one piece, so that it does not show in the bytes how the rows came.
        self._writer.write_table(rows.combine_chunks(), row_group_size=_ROWS)
        self._n_rows += rows.num_rows


def _whole(path: Path, columns: Sequence[Column]) -> pyarrow.Table:
    try:
        return read_part(path, columns)
    except FormatError as error:
        path.unlink(missing_ok=True)
        raise FormatError(f"{error}; it was removed: run again, and it is made anew") from error


def _named(name: str, rows: pyarrow.Table, schema: pyarrow.Schema) -> pyarrow.Table:
    import pyarrow

    # Half a surrogate pair, as Python makes of a name that is no text, cannot stand in a table.
    shown = name.encode("utf-8", "backslashreplace").decode()
    named = pyarrow.repeat(pyarrow.scalar(shown), rows.num_rows)
    return pyarrow.Table.from_arrays([named, *rows.columns], schema=schema)
