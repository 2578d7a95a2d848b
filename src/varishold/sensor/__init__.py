"""The sensor: what it makes of pressure, written down once, forward and back.

A `Sensor` says where the taxels are, how their readings follow the stress on them, and what covers them.
`Sensor.forward` makes readings of stresses, `Sensor.undo` makes stresses of readings and says what was lost.
`read_sensor` and `write_sensor` are its file; `PRESETS` holds the sensors that are known by name.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from varishold._lazy import lazy_names

__all__ = [
    "PRESETS",
    "RESPONSES",
    "SKIN_KINDS",
    "Linear",
    "Logarithmic",
    "Power",
    "Resampling",
    "Response",
    "Sensor",
    "Skin",
    "SkinKind",
    "Table",
    "Undone",
    "find_sensor_file",
    "map_files",
    "named_files",
    "read_sensor",
    "read_skin",
    "resampling_of",
    "sensor_inside",
    "sensor_of",
    "sensor_texts",
    "upright_recording",
    "write_sensor",
]

if TYPE_CHECKING:
    from varishold.sensor.cover import SKIN_KINDS, Skin, SkinKind, read_skin
    from varishold.sensor.file import find_sensor_file, map_files, named_files, read_sensor, sensor_texts, write_sensor
    from varishold.sensor.inside import sensor_inside
    from varishold.sensor.model import Sensor, Undone
    from varishold.sensor.positions import Resampling, resampling_of
    from varishold.sensor.presets import PRESETS, sensor_of
    from varishold.sensor.recordings import upright_recording
    from varishold.sensor.responses import RESPONSES, Linear, Logarithmic, Power, Response, Table
else:
    __getattr__, __dir__ = lazy_names(__name__, __all__)
