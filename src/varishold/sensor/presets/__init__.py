"""Sensors that are known by name: one TOML file each, holding only what is known of it."""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path
from types import MappingProxyType

from varishold.errors import InputError
from varishold.sensor.file import read_sensor
from varishold.sensor.model import Sensor

__all__ = ["PRESETS", "sensor_of"]

_FOLDER = Path(__file__).parent

#: The file of every preset, by its name.
PRESETS: Mapping[str, Path] = MappingProxyType({path.stem: path for path in sorted(_FOLDER.glob("*.toml"))})


def sensor_of(name: str | os.PathLike[str]) -> Sensor:
    """Return the sensor of a preset's name or of a sensor file.

    Parameters
    ----------
    name : str or path-like
        A name of `PRESETS`, or a file. A file of the same name goes first.

    Raises
    ------
    InputError
        If it is neither, or the file cannot be read.

    Examples
    --------
    >>> sensor_of("weiss-dsa").shape
    (13, 6)
    """
    text = os.fspath(name)
    if text in PRESETS and not Path(text).is_file():
        return read_sensor(PRESETS[text])
    # An empty path is the folder that one is in.
    if not text or (not text.endswith(".toml") and not Path(text).exists()):
        raise InputError(
            f"{text or repr(text)}: is no sensor file (TOML) and no preset; presets are "
            f"{', '.join(PRESETS)} (varishold sensor list)"
        )
    return read_sensor(text)
