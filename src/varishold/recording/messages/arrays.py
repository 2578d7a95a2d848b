"""Arrays of numbers: `Float32MultiArray` and its kin with their layout, and plain ones under a telling name."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from varishold.errors import InputError
from varishold.recording.messages.fields import Fields, fields_of, messages_in, number_at, numbers_in, value_at
from varishold.recording.messages.grids import MOST_VALUES, grid_pads, normal_and_shear, signal_pad
from varishold.recording.messages.reading import Asked, MessagePad

__all__ = ["asked_pads", "grids_pads", "multi_array_pads", "plain_pads"]

# What an array of pressures is called where it stands alone, likeliest first.
_PLAIN = ("pressure", "pressures", "values", "data", "taxels", "tactile", "tactile_data", "readings", "value")
# What says beside it how many rows and columns there are.
_SIDES = (("rows", "cols"), ("rows", "columns"), ("n_rows", "n_cols"), ("height", "width"))
_CLOCKS = ("t", "time", "times", "timestamp", "timestamps")
_CHANNELS = ("channel", "channels", "axis", "axes", "xyz", "component", "components")


def multi_array_pads(fields: Fields, asked: Asked) -> dict[str, MessagePad] | None:
    """Return the pads of an array with a layout: rows and columns, pads of them, or three axes on the last place."""
    layout, data = fields_of(fields.get("layout")), numbers_in(fields.get("data"))
    if layout is None or data is None or data.ndim != 1:
        return None
    dims = messages_in(layout.get("dim"))
    offset = int(number_at(layout, "data_offset") or 0)
    if not 0 <= offset <= data.size:
        raise InputError(f"an array's data begin at {offset}, and {data.size} values came")
    data = data[offset:]
    sizes = tuple(int(number_at(dim, "size") or 0) for dim in dims)
    if not sizes or asked.shape is not None:
        return grid_pads(data, asked)
    whole = _laid_out(data, sizes, int(number_at(dims[1], "stride") or 0) if len(dims) == 2 else 0)
    label = str(dims[-1].get("label", "")).lower()
    if whole.ndim == 3 and whole.shape[2] == 3 and (label in _CHANNELS or whole.shape[0] > 1):
        return normal_and_shear(whole.reshape(-1, 3), whole.shape[:2])
    if whole.ndim == 3 and whole.shape[2] == 1:
        whole = whole[:, :, 0]
    return grid_pads(whole, asked)


def _laid_out(data: NDArray[Any], sizes: tuple[int, ...], stride: int) -> NDArray[Any]:
    """Return the values by row and column; a row may be longer than it need be."""
    if min(sizes) < 1 or (count := int(np.prod(np.array(sizes, object)))) > MOST_VALUES:
        raise InputError(f"an array's layout says {' x '.join(map(str, sizes))} values")
    if len(sizes) == 2 and stride > sizes[1] and data.size >= stride * (sizes[0] - 1) + sizes[1]:
        return np.asarray(data[stride * np.arange(sizes[0])[:, None] + np.arange(sizes[1])])
    if data.size != count:
        raise InputError(f"an array's layout says {' x '.join(map(str, sizes))} values, and {data.size} came")
    return data.reshape(sizes)


def plain_pads(fields: Fields, asked: Asked) -> dict[str, MessagePad] | None:
    """Return the pads of an array that stands alone under a telling name, and temperatures beside it."""
    if "encoding" in fields or "format" in fields:
        return None
    for name in _PLAIN:
        values = numbers_in(fields.get(name))
        if values is not None:
            _check_one_reading(fields, values)
            pads = _plain_pads(values, asked if asked.shape else replace(asked, shape=_said_shape(fields, values)))
            warmth = numbers_in(fields.get("temperature"))
            if pads and warmth is not None and warmth.ndim == 1 and warmth.size:
                pads["temperature."] = signal_pad(warmth)
            return pads
    return None


def _check_one_reading(fields: Fields, values: NDArray[Any]) -> None:
    """Refuse frames that have a time each: they are no pads."""
    for name, value in fields.items():
        times = numbers_in(value) if name.split("_")[0] in _CLOCKS and values.ndim == 3 else None
        if times is not None and times.shape == values.shape[:1] and len(times) > 1:
            raise InputError(f"{name} has {len(times)} times: write a message for each reading")


def _said_shape(fields: Fields, values: NDArray[Any]) -> tuple[int, int] | None:
    """Return the rows and columns that fields beside values say; None where the values do not fit them."""
    n_taxels = len(values) if values.ndim == 1 or values.shape[1:] == (3,) else 0
    for names in _SIDES:
        rows, cols = (int(number_at(fields, name) or 0) for name in names)
        if rows * cols == n_taxels and rows > 0:
            return rows, cols
    return None


def grids_pads(fields: Fields, asked: Asked) -> dict[str, MessagePad] | None:
    """Return a pad of each field that has rows and columns, as JSON may have."""
    grids = {name: numbers_in(value) for name, value in fields.items()}
    return {name: MessagePad(grid) for name, grid in grids.items() if grid is not None and grid.ndim == 2} or None


def asked_pads(fields: Fields, asked: Asked) -> dict[str, MessagePad] | None:
    """Return the pads of the field that was asked for; None where it is no array."""
    values = numbers_in(value_at(fields, asked.field or ""))
    return None if values is None else _plain_pads(values, asked)


def _plain_pads(values: NDArray[Any], asked: Asked) -> dict[str, MessagePad]:
    """Return the pads that values make, of which three at the last place are x, y, z of a taxel."""
    if values.ndim == 3 and values.shape[2] == 3 and len(values) > 1:
        return normal_and_shear(values.reshape(-1, 3), values.shape[:2])
    if values.ndim == 2 and values.shape[1] == 3 and asked.shape is not None and len(values) == math.prod(asked.shape):
        return normal_and_shear(values, asked.shape)
    return grid_pads(values, asked)
