"""The columns of a table: what each is called, of which type it is, and what it means."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

if TYPE_CHECKING:
    import pyarrow

__all__ = ["FILE", "Column", "Kind", "schema_of"]

Kind = Literal["text", "whole", "number", "truth", "texts", "shares"]


@dataclass(frozen=True)
class Column:
    """A column of a table.

    Parameters
    ----------
    name : str
        With the unit at its end, where it has one.
    kind : {"text", "whole", "number", "truth", "texts", "shares"}
        A text, a whole number, a number, true or false, a list of texts, or a list of names with a probability each.
    meaning : str
        What stands in it.
    """

    name: str
    kind: Kind
    meaning: str

    @property
    def said_as(self) -> str:
        """Its type, as Parquet and SQL call it."""
        return {
            "text": "string",
            "whole": "int64",
            "number": "double",
            "truth": "boolean",
            "texts": "list of string",
            "shares": "list of (name string, probability double)",
        }[self.kind]


#: The first column of every table.
FILE = Column("file", "text", "the recording, as it was named")


def schema_of(columns: Iterable[Column]) -> pyarrow.Schema:
    """Return the schema of a Parquet file with some columns."""
    import pyarrow

    text = pyarrow.string()
    share = pyarrow.struct([("name", text), ("probability", pyarrow.float64())])
    kinds = {
        "text": text,
        "whole": pyarrow.int64(),
        "number": pyarrow.float64(),
        "truth": pyarrow.bool_(),
        # What Parquet itself calls the entries of a list.
        "texts": pyarrow.list_(pyarrow.field("element", text)),
        "shares": pyarrow.list_(pyarrow.field("element", share)),
    }
    return pyarrow.schema([(column.name, kinds[column.kind]) for column in columns])
