"""The sensor file that stands inside a recording."""

from __future__ import annotations

import os
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory

from varishold.errors import FormatError, InputError
from varishold.files import open_file
from varishold.recording.formats import is_folder
from varishold.recording.mcap.magic import MAGIC
from varishold.sensor.file import SENSOR_FILE, named_files, read_sensor
from varishold.sensor.model import Sensor

__all__ = ["sensor_inside"]


def sensor_inside(recording: str | os.PathLike[str]) -> Sensor | None:
    """Return the sensor whose file was put into a recording when it was measured, or None.

    Raises
    ------
    InputError
        If the recording cannot be opened, or its sensor file cannot be read.
    """
    path = Path(recording)
    if is_folder(path):
        return None
    with open_file(path) as file:
        if file.read(len(MAGIC)) != MAGIC:
            return None
    from varishold.recording.mcap import attachments_of

    texts = attachments_of(path)
    if SENSOR_FILE not in texts:
        return None
    with TemporaryDirectory() as folder:
        for name, content in texts.items():
            # The maps that it names stand beside it, and nothing anywhere else.
            if name == Path(name).name and name.endswith((".toml", ".csv")):
                Path(folder, name).write_bytes(content)
        for named in named_files(Path(folder, SENSOR_FILE)):
            if named.parent != Path(folder) or named.name not in texts:
                raise FormatError(f"{path}: {SENSOR_FILE}: names {named.name}, which is not in the recording")
        try:
            sensor = read_sensor(Path(folder, SENSOR_FILE))
        except InputError as error:
            raise FormatError(f"{path}: {str(error).removeprefix(f'{folder}{os.sep}')}") from None
    return replace(sensor, source=f"{path}: {SENSOR_FILE}")
