"""The sensor: what it makes of pressure, written down once, forward and back.

A `Sensor` says where the taxels are, how their readings follow the stress on them, and what covers them.
`Sensor.forward` makes readings of stresses, `Sensor.undo` makes stresses of readings and says what was lost.
`read_sensor` and `write_sensor` are its file; `PRESETS` holds the sensors that are known by name.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

from varishold.sensor.cover import Skin, read_skin

if TYPE_CHECKING:
    from varishold.sensor.file import find_sensor_file, read_sensor, write_sensor
    from varishold.sensor.model import Sensor, Undone
    from varishold.sensor.positions import Resampling, resampling_of
    from varishold.sensor.presets import PRESETS, sensor_of
    from varishold.sensor.recordings import upright_recording
    from varishold.sensor.responses import RESPONSES, Linear, Logarithmic, Power, Response, Table

# Loaded when first asked for: whoever only wants the cover need not wait for compiled code.
_LAZY = {
    "PRESETS": "presets",
    "RESPONSES": "responses",
    "Linear": "responses",
    "Logarithmic": "responses",
    "Power": "responses",
    "Resampling": "positions",
    "Response": "responses",
    "Sensor": "model",
    "Table": "responses",
    "Undone": "model",
    "find_sensor_file": "file",
    "read_sensor": "file",
    "resampling_of": "positions",
    "sensor_of": "presets",
    "upright_recording": "recordings",
    "write_sensor": "file",
}

__all__ = [
    "PRESETS",
    "RESPONSES",
    "Linear",
    "Logarithmic",
    "Power",
    "Resampling",
    "Response",
    "Sensor",
    "Skin",
    "Table",
    "Undone",
    "find_sensor_file",
    "read_sensor",
    "read_skin",
    "resampling_of",
    "sensor_of",
    "upright_recording",
    "write_sensor",
]


def __getattr__(name: str) -> Any:
    if name in _LAZY:
        return getattr(importlib.import_module(f"varishold.sensor.{_LAZY[name]}"), name)
    raise AttributeError(f"module 'varishold.sensor' has no attribute {name!r}")
