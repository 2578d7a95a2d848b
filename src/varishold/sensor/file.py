"""The sensor file: a sensor written down, and where it is looked for."""

from __future__ import annotations

import dataclasses
import json
import math
import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from varishold.errors import FormatError, InputError
from varishold.files import atomic_write, read_toml
from varishold.frame.checks import as_array
from varishold.sensor.cover import skin_of_table
from varishold.sensor.maps import map_text, read_map
from varishold.sensor.model import Sensor
from varishold.sensor.responses import RESPONSES, Linear, Response
from varishold.sensor.toml import checked_keys

__all__ = ["SENSOR_FILE", "find_sensor_file", "map_files", "named_files", "read_sensor", "sensor_texts", "write_sensor"]

#: What a sensor file is called that is to be found beside every recording of its folder.
SENSOR_FILE = "sensor.toml"

# Keys whose value is a field of `Sensor` as it stands.
_PLAIN = (
    "name",
    "shape",
    "pitch_m",
    "polarity",
    "span",
    "full_scale",
    "unit",
    "dead_band",
    "saturation",
    "crosstalk",
    "blur_taxels",
    "third_party",
    "notes",
)
# Keys whose value is one number a taxel: written out, or the name of a file beside the sensor file.
_MAPS = {"rest": "rest", "gain_map": "gains", "field": "field", "positions_m": "positions_m"}
# Those that stand in files of their own.
_BESIDE = ("gains", "rest")
_TABLES = ("response", "skin", "calibration")
_KEYS = (*_PLAIN, *_MAPS, *_TABLES)
_TEXTS = ("name", "unit", "notes", "polarity")


def find_sensor_file(recording: str | os.PathLike[str]) -> Path | None:
    """Return the sensor file that stands beside a recording, or None.

    Looked for are, in the recording's folder, its name with ``.sensor.toml`` after or in place of its ending,
    then ``sensor.toml``; before that ``sensor.toml`` within a recording that is a folder.

    Parameters
    ----------
    recording : str or path-like
        The recording's file or folder.
    """
    path = Path(recording)
    names = (f"{path.name}.{SENSOR_FILE}", f"{path.stem}.{SENSOR_FILE}", SENSOR_FILE)
    for beside in (path / SENSOR_FILE, *(path.parent / name for name in names)):
        try:
            if beside.is_file():
                return beside
        except (OSError, ValueError):
            return None
    return None


def read_sensor(path: str | os.PathLike[str]) -> Sensor:
    """Read a sensor file.

    Parameters
    ----------
    path : str or path-like
        A TOML file; its keys are those of `Sensor`, but for `gain_map` (gains), the tables ``[response]`` (`kind` and
        its constants), ``[skin]`` (the cover) and ``[calibration]`` (anything). `gain_map`, `rest`, `field`
        and `positions_m` hold rows of numbers, or the name of a CSV, NPY or NPZ file, from the sensor
        file's folder.

    Returns
    -------
    Sensor

    Raises
    ------
    InputError
        If the file, or one that it names, cannot be opened.
    FormatError
        If an entry is unknown or impossible.
    """
    content = read_toml(path)
    checked_keys(path, content, _KEYS, "the file")
    values: dict[str, Any] = {key: content[key] for key in _PLAIN if key in content}
    for key in _TEXTS:
        if key in values and not isinstance(values[key], str):
            raise FormatError(f"{path}: {key} must be a text, got {values[key]!r}")
    if not isinstance(values.get("third_party", False), bool):
        raise FormatError(f"{path}: third_party must be true or false, got {values['third_party']!r}")
    for key in _TABLES:
        if key in content and not isinstance(content[key], Mapping):
            raise FormatError(f"{path}: {key} must be a table, [{key}], got {content[key]!r}")
    for key, field in _MAPS.items():
        if key in content:
            values[field] = _map(path, key, field, content[key])
    if "skin" in content:
        values["cover"] = skin_of_table(path, content["skin"])
    if "calibration" in content:
        values["calibration"] = content["calibration"]
    try:
        if "response" in content:
            values["response"] = _response(path, content["response"])
        return Sensor(**values, source=os.fspath(path))
    except FormatError:
        raise
    except InputError as error:
        raise FormatError(f"{path}: {error}") from error


def named_files(path: str | os.PathLike[str]) -> tuple[Path, ...]:
    """Return the files that a sensor file names; none where it cannot be read, which its reader will tell."""
    try:
        content = read_toml(path)
    except InputError:
        return ()
    return tuple(Path(path).parent / content[key] for key in _MAPS if isinstance(content.get(key), str))


def _map(path: str | os.PathLike[str], key: str, name: str, value: Any) -> Any:
    if isinstance(value, str):
        try:
            return read_map(Path(path).parent / value, name)
        except InputError as error:
            raise FormatError(f"{path}: {key}: {error}") from error
    if key == "rest" and not isinstance(value, list):
        return value
    array = as_array(value)
    if array.ndim not in (1, 2) or array.size == 0:
        raise FormatError(f"{path}: {key} must be rows of numbers, equally many in each, or the name of a file")
    return array


def _response(path: str | os.PathLike[str], table: Mapping[str, Any]) -> Response:
    kind = table.get("kind")
    if not isinstance(kind, str) or kind not in RESPONSES:
        raise FormatError(f"{path}: [response] needs kind, one of {', '.join(RESPONSES)}, got {kind!r}")
    made = RESPONSES[kind]
    known = [field.name for field in dataclasses.fields(made) if field.init]  # type: ignore[arg-type]
    checked_keys(path, table, ("kind", *known), "[response]")
    missing = [name for name in known if name not in table]
    if missing:
        raise FormatError(f"{path}: [response] of kind {kind!r} needs {' and '.join(missing)}")
    return made(**{name: table[name] for name in known})


def write_sensor(sensor: Sensor, path: str | os.PathLike[str]) -> tuple[Path, ...]:
    """Write a sensor file, and its gains and rest, where they differ by taxel, as CSV files beside it.

    Reading the file gives the same sensor.

    Parameters
    ----------
    sensor : Sensor
        What to write.
    path : str or path-like
        The file; ``mat.toml`` has its gains in ``mat.gains.csv``.

    Returns
    -------
    tuple of Path
        The files written, the sensor file last.

    Raises
    ------
    InputError
        If a file cannot be written.
    """
    target = Path(path)
    # The sensor file last: it names the others.
    files = {target.with_name(name): text for name, text in sensor_texts(sensor, stem=target.stem).items()}
    last = files.popitem()[1]
    for beside, text in (*files.items(), (target, last)):
        with atomic_write(beside, "w") as file:
            file.write(text)
    return (*files, target)


def sensor_texts(sensor: Sensor, *, stem: str = "sensor") -> dict[str, str]:
    """Return the texts of a sensor file and its maps by their names, the sensor file last.

    Parameters
    ----------
    sensor : Sensor
    stem : str
        The sensor file's name without ``.toml``.
    """
    plain = Sensor()
    lines, texts = ["# A sensor file, written by varishold."], dict[str, str]()
    for key in _PLAIN:
        value = getattr(sensor, key)
        if value is not None and value != getattr(plain, key):
            lines.append(f"{key} = {_toml(value)}")
    if np.ndim(sensor.rest) == 0 and sensor.rest != 0:
        lines.append(f"rest = {_toml(sensor.rest)}")
    for key, field in _MAPS.items():
        value = getattr(sensor, field)
        if value is None or np.ndim(value) == 0:
            continue
        if field in _BESIDE:
            beside = _map_name(stem, field)
            texts[beside] = map_text(value)
            lines.append(f"{key} = {_toml(beside)}")
        else:
            lines.append(f"{key} = {_toml(value.tolist())}")
    if not isinstance(sensor.response, Linear):
        lines += ["", "[response]", *_table({"kind": sensor.response.kind, **sensor.response.entries()})]
    if sensor.cover is not None:
        cover = {key: value for key, value in dataclasses.asdict(sensor.cover).items() if value is not None}
        lines += ["", "[skin]", *_table(cover)]
    if sensor.calibration:
        lines += ["", "[calibration]", *_table(sensor.calibration)]
    return {**texts, f"{stem}.toml": "\n".join(lines) + "\n"}


def map_files(path: str | os.PathLike[str]) -> tuple[Path, ...]:
    """Return the CSV files that `write_sensor` may write beside a sensor file."""
    target = Path(path)
    return tuple(target.with_name(_map_name(target.stem, field)) for field in _BESIDE)


def _map_name(stem: str, field: str) -> str:
    return f"{stem}.{field}.csv"


def _table(entries: Mapping[str, Any]) -> list[str]:
    return [f"{key} = {_toml(value)}" for key, value in entries.items()]


def _toml(value: Any) -> str:
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        # A JSON text is a TOML text, but for the one control character that JSON leaves as it is.
        return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
    if isinstance(value, int):
        return str(value)
    if isinstance(value, float):
        # A float of numpy's shows itself otherwise.
        return repr(float(value)) if math.isfinite(value) else str(float(value))
    return f"[{', '.join(_toml(each) for each in value)}]"
