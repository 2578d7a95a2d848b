"""Clouds of points with a pressure each: `sensor_msgs/PointCloud2`."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from varishold.errors import InputError
from varishold.recording.messages.fields import Fields, messages_in, number_at, numbers_in
from varishold.recording.messages.grids import MOST_VALUES, grid_pads, native
from varishold.recording.messages.reading import Asked, MessagePad

__all__ = ["PRESSURE_FIELDS", "cloud_pads"]

#: What the field of a point that holds its pressure is called, likeliest first.
PRESSURE_FIELDS = ("pressure", "force", "normal_force", "force_z", "fz", "intensity", "intensities")

# As PointField numbers them.
_TYPES = {1: "i1", 2: "u1", 3: "i2", 4: "u2", 5: "i4", 6: "u4", 7: "f4", 8: "f8"}


def cloud_pads(fields: Fields, asked: Asked) -> dict[str, MessagePad] | None:
    """Return the pad that a cloud is: (height, width) where it is organized, otherwise on no grid."""
    data, parts = numbers_in(fields.get("data")), messages_in(fields.get("fields"))
    if data is None or data.dtype != np.uint8 or not parts:
        return None
    rows, cols = (int(number_at(fields, name) or 0) for name in ("height", "width"))
    if rows * cols == 0:
        return {}
    columns = _columns(fields, parts, data, rows, cols)
    name = _chosen(columns, asked)
    values = columns[name]
    if rows > 1 or asked.shape is not None:
        return grid_pads(values if rows > 1 else values[0], asked)
    positions = None
    if "x" in columns and "y" in columns:
        positions = np.stack([columns["x"][0], columns["y"][0]], axis=1).astype(np.float64)
        if not np.isfinite(positions).all():
            positions = None
    return {"": MessagePad(native(values[0]), positions_m=positions)}


def _chosen(columns: Mapping[str, Any], asked: Asked) -> str:
    wanted = PRESSURE_FIELDS if asked.field is None else (asked.field.lower(),)
    for name in wanted:
        if name in columns:
            return name
    raise InputError(
        f"a cloud of points with the fields {', '.join(columns)} came, and none of {', '.join(wanted)}; "
        "name the one that is pressure as field",
        parameter="field",
    )


def _columns(
    fields: Fields, parts: list[Fields], data: NDArray[np.uint8], rows: int, cols: int
) -> dict[str, NDArray[Any]]:
    """Return each field of all points, shape (rows, cols), by its name in small letters."""
    order = ">" if fields.get("is_bigendian") else "<"
    step = int(number_at(fields, "point_step") or 0)
    row_step = int(number_at(fields, "row_step") or 0) or step * cols
    if not (0 < rows and 0 < cols and rows * cols <= MOST_VALUES and 0 < step and step * cols <= row_step):
        raise InputError(f"a cloud of {rows} x {cols} points of {step} bytes, {row_step} a row, came")
    if data.size < row_step * (rows - 1) + step * cols:
        raise InputError(f"a cloud of {rows} x {cols} points of {step} bytes came with {data.size} bytes")
    points = np.ascontiguousarray(
        np.lib.stride_tricks.as_strided(data, (rows, cols, step), (row_step, step, 1), writeable=False)
    )
    columns = {}
    for part in parts:
        kind = _TYPES.get(int(number_at(part, "datatype") or 0))
        offset = int(number_at(part, "offset") or 0)
        if kind is None or not isinstance(part.get("name"), str):
            continue
        dtype = np.dtype(order + kind)
        if not 0 <= offset <= step - dtype.itemsize:
            raise InputError(f"a cloud's field {part['name']!r} begins at byte {offset} of a point of {step}")
        columns[part["name"].lower()] = np.ascontiguousarray(points[..., offset : offset + dtype.itemsize]).view(dtype)[
            ..., 0
        ]
    return columns
