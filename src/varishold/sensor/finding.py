"""Which sensor made a recording: the one that was named, the one beside it, or the one inside."""

from __future__ import annotations

from varishold.sensor.file import find_sensor_file, read_sensor
from varishold.sensor.inside import sensor_inside
from varishold.sensor.model import Sensor
from varishold.sensor.presets import sensor_of

__all__ = ["sensor_beside", "sensor_for"]


def sensor_for(file: str, named: str | None) -> Sensor | None:
    """Return the sensor that was named, a file's or a preset's; else the one beside the recording, or inside it.

    Raises
    ------
    InputError
        If its file cannot be read.
    """
    return sensor_beside(file, named) or sensor_inside(file)


def sensor_beside(file: str, named: str | None) -> Sensor | None:
    """Return the sensor that was named; else the one that stands beside a recording, which need not be there yet."""
    if named is not None:
        return sensor_of(named)
    beside = find_sensor_file(file)
    return None if beside is None else read_sensor(beside)
