"""Is a sensor's description possible?"""

from __future__ import annotations

import math
from collections.abc import Mapping
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from varishold.errors import InputError, require_a
from varishold.frame.checks import as_array, as_pitch

if TYPE_CHECKING:
    from varishold.sensor.model import Sensor

__all__ = ["LEAST_GAIN", "check_sensor"]

#: A taxel of less than this share of the usual gain says too little to be restored: it is broken.
LEAST_GAIN = 0.02

_LARGEST = 1e100
# No taxel stands farther off, metres.
_FARTHEST_M = 1e3
# Ranges that are told to whoever leaves them.
_RANGES = MappingProxyType({"dead_band": (0.0, 0.9), "crosstalk": (0.0, 0.2), "blur_taxels": (0.0, 4.0)})


def check_sensor(sensor: Sensor) -> dict[str, Any]:
    """Return the fields of a sensor as they are kept: arrays read-only, defaults filled in.

    Raises
    ------
    InputError
        If a value is out of its range, or they do not fit together.
    """
    made: dict[str, Any] = {}
    shape = made["shape"] = _shape(sensor.shape)
    positions = made["positions_m"] = _positions(sensor.positions_m)
    if positions is not None:
        for name in ("shape", "field"):
            if getattr(sensor, name) is not None:
                raise InputError(f"a sensor with positions_m has its taxels on no grid: leave {name} out")
        for name in ("crosstalk", "blur_taxels"):
            if getattr(sensor, name):
                raise InputError(f"a sensor with positions_m has no four neighbours: leave {name} out")
        shape = (1, positions.shape[0])
    made["pitch_m"] = None if sensor.pitch_m is None else as_pitch(sensor.pitch_m)
    if not isinstance(sensor.polarity, str) or sensor.polarity not in ("up", "down"):
        raise InputError(f"polarity of a sensor must be up or down, got {sensor.polarity!r}")
    if not isinstance(getattr(sensor.response, "kind", None), str):
        what = type(sensor.response).__name__
        raise InputError(f"response of a sensor must be one of varishold.sensor.RESPONSES, got {what}")
    for name in ("dead_band", "crosstalk", "blur_taxels"):
        made[name] = number(name, getattr(sensor, name), *_RANGES[name])
    made["span"], made["full_scale"] = _scales(sensor)
    if sensor.saturation is not None:
        made["saturation"] = number("saturation", sensor.saturation, 1e-3, 2.0)
    field, made["field"] = sensor.field, None
    if field is not None:
        values = numbers("field", field, shape)
        if not np.isin(values, (0, 1)).all() or not values.any():
            raise InputError("field of a sensor must be true or false for each taxel, and true for one at least")
        made["field"] = frozen(values.astype(np.bool_))
        shape = made["shape"] = shape or (values.shape[0], values.shape[1])
    if sensor.gains is not None:
        gains = numbers("gains", sensor.gains, shape, missing=True)
        if np.nanmin(gains, initial=0.0) < 0 or not (gains >= LEAST_GAIN).any():
            raise InputError(
                f"gains of a sensor must not be negative, and one at least must be {LEAST_GAIN} or more: 1 is usual"
            )
        made["gains"] = frozen(gains)
        shape = gains.shape
        if positions is None:
            made["shape"] = shape
    rest: Any = sensor.rest
    if not isinstance(rest, list | tuple) and np.ndim(rest) == 0:
        made["rest"] = number("rest", rest, -_LARGEST, _LARGEST)
    else:
        made["rest"] = frozen(numbers("rest", rest, shape))
        if positions is None:
            made["shape"] = made["rest"].shape
    require_a(Mapping, sensor.calibration, "calibration of a sensor", "what was measured, by name")
    made["calibration"] = MappingProxyType(dict(sensor.calibration))
    return made


def number(name: str, value: Any, least: float, most: float) -> float:
    """Return a number of a sensor's description.

    Raises
    ------
    InputError
        If it is no number from `least` to `most`.
    """
    if isinstance(value, np.generic):
        value = value.item()  # one of single precision would not be compared with all limits
    is_number = not isinstance(value, bool) and isinstance(value, int | float)
    if not is_number or not least <= value <= most:
        raise InputError(f"{name} of a sensor must be a number from {least:g} to {most:g}, got {value!r}")
    return float(value)


def numbers(name: str, values: Any, shape: tuple[int, ...] | None, *, missing: bool = False) -> NDArray[np.float64]:
    """Return one number a taxel, of the sensor's shape.

    Raises
    ------
    InputError
        If they are no numbers, not finite (NaN may stand where `missing`), or of another shape.
    """
    try:
        array = np.asarray(values)
    except ValueError:
        array = np.empty(0, object)
    if array.dtype.kind not in "biuf" or array.size == 0:
        raise InputError(f"{name} of a sensor must be one number a taxel, in rows of equal length")
    array = array.astype(np.float64)
    if array.ndim == 1:
        array = array[None]
    if array.ndim != 2 or (shape is not None and array.shape != shape):
        wanted = "(rows, cols)" if shape is None else " x ".join(map(str, shape))
        got = " x ".join(map(str, array.shape))
        raise InputError(f"{name} of a sensor must have the sensor's shape, {wanted}, got {got}")
    wrong = ~np.isfinite(array) & ~(missing & np.isnan(array))
    if wrong.any() or np.nanmax(np.abs(array), initial=0.0) > _LARGEST:
        row, col = np.argwhere(wrong | (np.abs(array) > _LARGEST))[0].tolist()
        raise InputError(f"{name} of a sensor must be finite, got {array[row, col]} at (row, col) = ({row}, {col})")
    return array


def frozen(array: NDArray[Any]) -> NDArray[Any]:
    """Return a read-only copy."""
    made = np.array(array)
    made.flags.writeable = False
    return made


def _shape(shape: Any) -> tuple[int, int] | None:
    if shape is None:
        return None
    try:
        sides = [int(side) for side in shape if int(side) == side and not isinstance(side, bool)]
    except (TypeError, ValueError, OverflowError):
        sides = []
    if len(sides) != 2 or len(shape) != 2 or min(sides) < 1 or math.prod(sides) > 1 << 24:
        raise InputError(f"shape of a sensor must be [rows, columns], as in [16, 16], got {shape!r}")
    return sides[0], sides[1]


def _positions(positions: Any) -> NDArray[np.float64] | None:
    if positions is None:
        return None
    array = as_array(positions)
    if array.ndim != 2 or array.shape[1] != 2 or array.shape[0] < 3 or not np.isfinite(array).all():
        raise InputError(
            f"positions_m of a sensor must be finite (x, y) of three taxels or more, got shape {array.shape}"
        )
    far = np.argwhere(np.abs(array) > _FARTHEST_M)
    if far.size:
        taxel, axis = far[0].tolist()
        raise InputError(
            f"positions_m of a sensor must lie within {_FARTHEST_M:g} m of its origin, got {array[taxel, axis]:g} for "
            f"taxel {taxel}"
        )
    _, first, of = np.unique(array, axis=0, return_index=True, return_inverse=True)
    same = np.flatnonzero(first[of.ravel()] != np.arange(len(array)))
    if same.size:
        two = int(first[of.ravel()[same[0]]]), int(same[0])
        raise InputError(f"positions_m of a sensor must differ: taxels {two[0]} and {two[1]} stand at one place")
    return frozen(array)


def _scales(sensor: Sensor) -> tuple[float, float]:
    """Return span and full scale; where one is missing it is the other."""
    span: float | None = sensor.span
    full: float | None = sensor.full_scale
    if span is None and full is None:
        needs = [
            name
            for name, there in (
                (f"a {sensor.response.kind} response", sensor.response.kind != "linear"),
                ("a dead band", sensor.dead_band),
                ("saturation", sensor.saturation is not None),
            )
            if there
        ]
        if needs:
            raise InputError(
                f"{needs[0]} of a sensor is a share of full scale: give span, the reading there counted from rest"
            )
        return 1.0, 1.0
    checked = [
        number(name, value, 1e-12, _LARGEST)
        for name, value in (("span", span), ("full_scale", full))
        if value is not None
    ]
    return checked[0], checked[-1]
