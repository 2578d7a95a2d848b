"""Messages that sensors' own drivers send; one function each, told by their fields."""

from __future__ import annotations

import re
from typing import Any

import numpy as np
from numpy.typing import NDArray

from varishold._counted import counted
from varishold.errors import InputError
from varishold.recording.messages.fields import Fields, is_empty_list, messages_in, number_at, numbers_in, reading_at
from varishold.recording.messages.grids import axis_names, grid_pads, native, normal_and_shear, signal_pad
from varishold.recording.messages.reading import Asked, MessagePad

__all__ = [
    "biotac_pads",
    "cell_pads",
    "inspire_pads",
    "magnetic_pads",
    "model_grid",
    "pillar_pads",
    "robotis_pads",
    "tac3d_pads",
    "wuji_pads",
    "xela_pads",
    "xela_words_pads",
]

Pads = dict[str, MessagePad]

# Wuji's skin: rows and columns.
_WUJI = (24, 32)
# Inspire's parts by their number of taxels: finger tip, nail or thumb's pad, pad, palm.
_INSPIRE = {9: (3, 3), 96: (12, 8), 80: (10, 8), 112: (8, 14)}
_INSPIRE_SENSORS = {9: "inspire-tip", 96: "inspire-nail", 80: "inspire-pad", 112: "inspire-palm"}


def xela_pads(fields: Fields, asked: Asked) -> Pads | None:
    """A sensor of XELA's SensStream: forces where it is calibrated, otherwise counts; row by row from the top left."""
    taxels = messages_in(fields.get("taxels"))
    forces = messages_in(fields.get("forces"))
    if not taxels and not forces:
        return {} if is_empty_list(fields.get("taxels")) else None
    model = str(fields.get("model", ""))
    grid = asked.shape or model_grid(model, len(forces or taxels))
    if forces:
        return normal_and_shear(_axes(forces, "xyz", np.float32), grid, unit="N")
    return normal_and_shear(_axes(taxels, "xyz", np.int64), grid, sensor=_xela_sensor(model))


def xela_words_pads(fields: Fields, asked: Asked) -> Pads | None:
    """A sensor of XELA's WebSocket: newtons where it is calibrated, otherwise counts in hexadecimal words."""
    words, forces = fields.get("data"), numbers_in(fields.get("calibrated"))
    if not isinstance(words, str):
        return None
    if forces is not None and forces.size:
        return _three_axes(forces, fields, asked, unit="N")
    try:
        counts = np.array([int(word, 16) for word in words.split(",") if word.strip()], np.int64)
    except (ValueError, OverflowError):
        raise InputError(f"a sensor's data came that are no hexadecimal words: {words[:40]!r}") from None
    return _three_axes(counts, fields, asked)


def _three_axes(values: NDArray[Any], fields: Fields, asked: Asked, *, unit: str = "raw") -> Pads:
    taxels = number_at(fields, "taxels")
    if values.ndim != 1 or values.size % 3 or (taxels is not None and values.size != 3 * taxels):
        raise InputError(f"a sensor of {fields.get('taxels')} taxels came with {values.size} values, three a taxel")
    model = str(fields.get("model", ""))
    grid = asked.shape or model_grid(model, values.size // 3)
    return normal_and_shear(values.reshape(-1, 3), grid, unit=unit, sensor=_xela_sensor(model) if unit == "raw" else "")


def _xela_sensor(model: str) -> str:
    return f"xela-{model.lower()}" if model.lower() in ("uspa44", "uspa46") else ""


def model_grid(model: str, n_taxels: int) -> tuple[int, int] | None:
    """Return the rows and columns that a XELA sensor's model names, where it has as many taxels.

    Examples
    --------
    >>> model_grid("uSPa46", 24), model_grid("uSCuMT", 16)
    ((4, 6), None)
    """
    digits = re.search(r"(\d)(\d)$", model)
    grid = (int(digits[1]), int(digits[2])) if digits else (0, 0)
    return grid if grid[0] * grid[1] == n_taxels else None


def pillar_pads(fields: Fields, asked: Asked) -> Pads | None:
    """Contactile's SensorState: a force in newtons on each pillar, in the order of their numbers."""
    pillars = messages_in(fields.get("pillars"))
    if not pillars:
        return {} if is_empty_list(fields.get("pillars")) else None
    pillars = sorted(pillars, key=lambda pillar: number_at(pillar, "id") or 0)
    side = round(len(pillars) ** 0.5)
    return normal_and_shear(_axes(pillars, ("fx", "fy", "fz"), np.float32), asked.shape or (side, side), unit="N")


def biotac_pads(fields: Fields, asked: Asked) -> Pads | None:
    """A BioTac: electrodes, pressures and temperatures, which are signals."""
    electrodes = numbers_in(fields.get("electrodes"))
    if electrodes is None or electrodes.ndim != 1:
        return None
    others = [name for name in ("pdc", "pac0", "pac1", "tac", "tdc") if number_at(fields, name) is not None]
    values = np.concatenate([electrodes, [int(fields[name]) for name in others]]) if others else electrodes
    names = (*(f"e{number}" for number in range(1, electrodes.size + 1)), *others)
    return {"": signal_pad(values, names)}


def cell_pads(fields: Fields, asked: Asked) -> Pads | None:
    """Schunk's TactileMatrix, in counts, and PressureArray, in pascal: cells_x columns, cells_y rows."""
    counts, pascals = numbers_in(fields.get("tactile_array")), numbers_in(fields.get("pressure"))
    values = counts if counts is not None else pascals
    if values is None:
        return None
    rows, cols = (int(number_at(fields, name) or 0) for name in ("cells_y", "cells_x"))
    if values.size != rows * cols:
        raise InputError(f"a matrix of {rows} x {cols} cells came with {counted(values.size, 'value')}")
    return grid_pads(values.reshape(rows, cols), asked, unit="raw" if counts is not None else "Pa")


def robotis_pads(fields: Fields, asked: Asked) -> Pads | None:
    """ROBOTIS' TactileSensor: 3 x 3, row by row."""
    values = numbers_in(fields.get("pressure_values"))
    if values is None or values.ndim != 1:
        return None
    if values.size == 9:
        return grid_pads(values.reshape(3, 3), asked, sensor="robotis-tactile")
    return grid_pads(values, asked)


def wuji_pads(fields: Fields, asked: Asked) -> Pads | None:
    """Wuji's TactileFrame: whole numbers go down from 2135, which is no pressure; fractions go up, nan is no taxel."""
    values = numbers_in(fields.get("pressure"))
    if values is None or values.size != _WUJI[0] * _WUJI[1]:
        return None
    grid = native(values.reshape(_WUJI))
    if grid.dtype.kind == "f":
        return {"": MessagePad(grid, sensor="wuji-float")}
    return {"": MessagePad(grid, polarity="down", sensor="wuji")}


def inspire_pads(fields: Fields, asked: Asked) -> Pads | None:
    """Inspire's hand, as its driver and others call its parts: a pad each."""
    pads: Pads = {}
    for name, value in fields.items():
        values = numbers_in(value) if name.endswith("_touch") else None
        if values is not None and values.ndim == 1 and (grid := _INSPIRE.get(values.size)):
            pad = MessagePad(native(values.reshape(grid)), sensor=_INSPIRE_SENSORS[values.size])
            pads[name.removesuffix("_touch")] = pad
    return pads or None


def tac3d_pads(fields: Fields, asked: Asked) -> Pads | None:
    """Tac3D's Frame: forces at 20 x 20 points in newtons, or its displacements where they are asked for."""
    name = "displacements" if (asked.field or "").lower() == "displacements" else "forces"
    values = numbers_in(fields.get(name))
    if values is None or values.size % 3:
        return None
    side = round((values.size / 3) ** 0.5)
    unit = "N" if name == "forces" else "raw"
    return normal_and_shear(values.reshape(-1, 3), asked.shape or (side, side), unit=unit, sensor="tac3d")


def magnetic_pads(fields: Fields, asked: Asked) -> Pads | None:
    """Shadow's MST: a magnetic field and a temperature each, which are signals."""
    points = messages_in(fields.get("magnetic_data"))
    if not points:
        return {} if is_empty_list(fields.get("magnetic_data")) else None
    axes = _axes(points, "xyz", np.float64)
    pads = {"": signal_pad(axes.ravel(), axis_names("xyz", len(axes)))}
    warmth = numbers_in(fields.get("temperature_data"))
    if warmth is not None and warmth.size:
        pads["temperature."] = signal_pad(warmth)
    return pads


def _axes(items: list[Fields], names: Any, dtype: Any) -> NDArray[Any]:
    """Return three fields of each item, shape (n, 3): fractions, with NaN, where a taxel has no number this time."""
    rows = [[reading_at(item, name) for name in names] for item in items]
    if any(value is None for row in rows for value in row):
        raise InputError(f"a taxel came without a number for one of {', '.join(names)}")
    values = np.array(rows, np.float64)
    return values if np.dtype(dtype).kind == "i" and not np.isfinite(values).all() else values.astype(dtype)
