"""A message as plain fields: whoever made it, and however its names are written."""

from __future__ import annotations

import array
import dataclasses
import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

__all__ = [
    "Fields",
    "fields_of",
    "is_empty_list",
    "messages_in",
    "number_at",
    "numbers_in",
    "odd_row",
    "reading_at",
    "value_at",
]

#: Fields by their names in small letters.
Fields = Mapping[str, Any]


def fields_of(message: object) -> Fields | None:
    """Return the fields of a message by their names in small letters; None of what is no message.

    Messages are dicts (of JSON), objects of rosbags (dataclasses) or of rclpy.
    """
    if isinstance(message, Mapping):
        return {str(name).lower(): value for name, value in message.items()}
    names: Sequence[str]
    if dataclasses.is_dataclass(message) and not isinstance(message, type):
        names = [field.name for field in dataclasses.fields(message) if not field.name.startswith("__")]
    elif hasattr(message, "get_fields_and_field_types"):
        names = list(message.get_fields_and_field_types())
    else:
        return None
    # A name that Python keeps for itself has an underscore put behind it.
    return {name.lower().rstrip("_"): getattr(message, name) for name in names}


def messages_in(value: object) -> list[Fields]:
    """Return the fields of each message in a list; an empty list of what is no list of messages."""
    if not isinstance(value, list | tuple):
        return []
    found = [fields_of(item) for item in value]
    return [fields for fields in found if fields is not None] if None not in found else []


def is_empty_list(value: object) -> bool:
    """Tell a list of nothing, which a message has where nothing was measured this time."""
    return isinstance(value, list | tuple) and not value


def numbers_in(value: object) -> NDArray[Any] | None:
    """Return numbers as an array of any dimensions, NaN for None in a list; None of what is no array of numbers."""
    if isinstance(value, bytes | bytearray | memoryview):
        return np.frombuffer(value, np.uint8)
    if isinstance(value, array.array):
        return np.array(value)
    if isinstance(value, list | tuple):
        value = _as_array(value)
    if isinstance(value, np.ndarray) and value.dtype.kind in "iufb" and value.ndim:
        return value.view(np.uint8) if value.dtype.kind == "b" else value
    return None


def odd_row(value: object) -> str:
    """Return which of a field's rows of numbers has another length than the first, in words; empty where none has."""
    if not (isinstance(value, list | tuple) and value and all(isinstance(row, list | tuple) for row in value)):
        return ""
    lengths = [len(row) for row in value]
    odd = next((number for number, length in enumerate(lengths) if length != lengths[0]), None)
    return "" if odd is None else f"row {odd} has {lengths[odd]} values, row 0 has {lengths[0]}"


def value_at(fields: Fields, path: str) -> Any:
    """Return what stands at a path of fields in fields, with dots between; None where nothing does.

    A list stands for its first item.
    """
    value: Any = None
    for at, name in enumerate(path.lower().split(".")):
        if at:
            within = fields_of(value[0] if isinstance(value, list | tuple) and value else value)
            if within is None:
                return None
            fields = within
        value = fields.get(name)
    return value


def number_at(fields: Fields, path: str) -> float | None:
    """Return a finite number at a path as in `value_at`; None where there is none."""
    value = value_at(fields, path)
    if not isinstance(value, int | float | np.integer | np.floating):
        return None
    return float(value) if -(2**63) < value < 2**63 else None


def reading_at(fields: Fields, name: str) -> float | None:
    """Return a taxel's number, NaN where it is null, NaN or infinite; None where there is none of that name."""
    value = fields.get(name)
    if value is None:
        return math.nan if name in fields else None
    if isinstance(value, float | np.floating) and not math.isfinite(value):
        return math.nan
    return number_at(fields, name)


def _as_array(value: Sequence[Any]) -> object:
    """Return a list of numbers, or of lists of numbers, as an array; anything else as it is."""
    if not value:
        return np.empty(0)
    if not all(leaf is None or isinstance(leaf, int | float | np.number) for leaf in _first_leaves(value)):
        return value
    value = _with_whole_rows(value)
    try:
        return _with_nan(np.array(value))
    except (ValueError, OverflowError):
        return value


def _with_whole_rows(value: Sequence[Any]) -> Sequence[Any]:
    """Return rows with a None for each number of a row that is None itself; anything else as it is."""
    ends = value[0], value[-1]
    if not all(end is None or isinstance(end, list | tuple) for end in ends):
        return value
    lengths = {len(row) for row in value if isinstance(row, list | tuple)}
    are_rows = all(row is None or isinstance(row, list | tuple) for row in value)
    if not are_rows or len(lengths) != 1 or not any(row is None for row in value):
        return value
    (length,) = lengths
    return [[None] * length if row is None else row for row in value]


def _with_nan(values: NDArray[Any]) -> NDArray[Any]:
    """Return numbers with NaN where there is none, which is null in JSON; anything else as it is."""
    if values.dtype.kind != "O":
        return values
    items = list(values.flat)
    numbers = all(item is None or isinstance(item, int | float) for item in items)
    return values.astype(np.float64) if numbers and None in items else values


def _first_leaves(value: Sequence[Any]) -> Iterator[Any]:
    """Yield the first and the last item, and in turn theirs where they are lists: enough to tell a list of messages."""
    for item in (value[0], value[-1]):
        if isinstance(item, list | tuple) and item:
            yield from _first_leaves(item)
        else:
            yield item
