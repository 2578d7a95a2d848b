"""LeRobot data sets, version 3: a folder with ``meta/info.json`` and Parquet files of a row a frame.

Features with a telling name become pads, all others of numbers signals; each episode is a press, labelled by its task.
What `write` makes holds all of a recording, by the names of `named_arrays` in ``meta/varishold.json``.
"""

from __future__ import annotations

import dataclasses
import os
import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from varishold._counted import counted
from varishold.errors import FormatError
from varishold.files import damage_told, read_json
from varishold.recording.formats.format import Format, Options, read_by
from varishold.recording.formats.guessing import guessed
from varishold.recording.formats.lerobot_episodes import INDICES, Episodes, episodes_of
from varishold.recording.formats.lerobot_windows import Window, window_of
from varishold.recording.formats.lerobot_writing import INFO, OURS, write
from varishold.recording.formats.named_arrays import NAMED, SIGNALS, HeldArrays, stored_in
from varishold.recording.formats.parquet import held_as_told
from varishold.recording.formats.parquet_folder import FilesColumn, parts_of
from varishold.recording.stored import Stored

__all__ = ["FORMAT"]

_VERSION = re.compile(r"v?3\.\d+(\.\d+)?")
# What is said of a feature that is no number.
_PICTURES = ("video", "image")
_NUMBER = re.compile(r"(\d+)")
_MOST_FILES = 1 << 16
# What a message names at most.
_TOLD = 8


@dataclass(frozen=True)
class _Feature:
    """What ``info.json`` says of a column."""

    dtype: str
    shape: tuple[int, ...]
    names: tuple[str, ...]


@dataclass(frozen=True)
class _Info:
    fps: float
    features: Mapping[str, _Feature]
    n_frames: int | None
    robot: str


def _recognizes(path: Path, head: bytes) -> bool:
    return (path / INFO).is_file()


def _open(path: Path, options: Options) -> Stored:
    info = _info(path / INFO)
    files = _data_files(path)
    parts = parts_of(files)
    columns: dict[str, FilesColumn] = {}

    def close() -> None:
        for column in columns.values():
            column.close()

    try:
        for name in parts[0].names:
            columns[name] = FilesColumn(str(path), parts, name)
        numbers = {name: column for name, column in columns.items() if column.width is not None}
        if (path / OURS).is_file():
            told = read_json(path / OURS)
            with damage_told(str(path / OURS)):
                return stored_in(held_as_told(str(path / OURS), told, numbers), path, options, close=close)
        return _of_others(path, options, info, numbers, close)
    except BaseException:
        close()
        raise


def _info(path: Path) -> _Info:
    """Read what a data set says of itself.

    Raises
    ------
    FormatError
        If it is of another version, or says what cannot be.
    """
    said = read_json(path)
    with damage_told(str(path)):
        version = said["codebase_version"]
        if not isinstance(version, str) or not _VERSION.fullmatch(version):
            raise FormatError(
                f"{path}: is a data set of version {str(version)[:20]!r}; 3.0 is read (lerobot converts older ones: "
                "python -m lerobot.datasets.v30.convert_dataset_v21_to_v30)"
            )
        fps = said["fps"]
        if isinstance(fps, bool) or not isinstance(fps, int | float) or not 0 < fps < 1e9:
            raise FormatError(f"{path}: fps must be a positive number, got {str(fps)[:40]!r}")
        features = {str(name): _feature(path, str(name), each) for name, each in said["features"].items()}
        total, robot = said.get("total_frames"), said.get("robot_type")
        return _Info(float(fps), features, total if isinstance(total, int) else None, str(robot or ""))


def _feature(path: Path, name: str, said: Any) -> _Feature:
    shape = said["shape"]
    if not isinstance(shape, list) or not all(type(side) is int and 0 < side < 1 << 24 for side in shape):
        raise FormatError(f"{path}: feature {name!r} must have a shape of whole numbers, got {str(shape)[:60]!r}")
    names = said.get("names")
    if isinstance(names, dict):
        # Names by what they are names of.
        names = next(iter(names.values()), None)
    names = names if isinstance(names, list) and all(isinstance(each, str) for each in names) else []
    return _Feature(str(said["dtype"]), tuple(shape), tuple(names))


def _data_files(path: Path) -> list[Path]:
    """Return the files of frames in their order."""
    found = [file for file in (path / "data").glob("*/*.parquet") if not file.name.startswith(".")]
    if not found:
        raise FormatError(f"{path / 'data'}: holds no file */*.parquet; was the data set loaded down whole?")
    if len(found) > _MOST_FILES:
        raise FormatError(f"{path / 'data'}: holds {len(found)} files; at most {_MOST_FILES} are read")
    return sorted(found, key=lambda file: [int(p) if p.isdigit() else p for p in _NUMBER.split(os.fspath(file))])


def _of_others(path: Path, options: Options, info: _Info, columns: dict[str, FilesColumn], close: Any) -> Stored:
    """Return the recording that features of other people are."""
    notes: list[str] = []
    windows: dict[str, Window] = {}
    plain: dict[str, FilesColumn] = {}
    passed = [name for name, each in info.features.items() if each.dtype in _PICTURES or name not in columns]
    for name, column in columns.items():
        if name in INDICES:
            continue
        feature = info.features.get(name, _Feature("", column.shape[1:] or (1,), ()))
        column.typed(column.dtype, feature.shape)
        if len(feature.shape) == 1:
            plain[name] = column
        elif (window := window_of(name, column, feature.names)) is not None:
            windows[name] = window
            notes += window.notes
        else:
            passed.append(name)
    keys, told = guessed(path, {**windows, **plain}, options)
    # How often a pad is read in a row; what is read less often stays as it was.
    times = max([windows[name].times for name in keys.values() if name in windows], default=1)
    held: dict[str, Any] = {}
    for name in keys.values():
        window = windows[name] if name in windows else Window(plain[name])
        held[f"{NAMED}{_short(name)}"] = window.spread(times)
    names: dict[str, NDArray[Any]] = {}
    for name in [name for name in plain if name not in keys.values()]:
        held[f"{SIGNALS}{_short(name)}"] = Window(plain[name]).spread(times)
        if len(info.features[name].names if name in info.features else ()) == plain[name].shape[1]:
            names[f"names.{SIGNALS}{_short(name)}"] = np.array(info.features[name].names)
    passed += [name for name in windows if name not in keys.values()]
    episodes = episodes_of(path, columns, info.fps, times)
    notes = [told[0], *notes, *episodes.notes]
    if passed:
        notes.append(f"passed over: {', '.join(passed[:_TOLD])}" + (", ..." if len(passed) > _TOLD else ""))
    if times > 1:
        notes.append(f"{times} readings stand in a row; the last is taken to be of the row's time")
    n_rows = next(iter(columns.values())).shape[0]
    if info.n_frames not in (None, n_rows):
        notes.append(f"{counted(n_rows, 'frame is', 'frames are')} there, info.json promises {info.n_frames}")
    stored = stored_in(HeldArrays(held, names), path, options, notes=tuple(notes), close=close)
    return _with_episodes(stored, episodes, info.robot)


def _with_episodes(stored: Stored, episodes: Episodes, robot: str) -> Stored:
    return dataclasses.replace(
        stored, time_s=episodes.time_s, press=episodes.press, press_columns=episodes.columns, sensor=robot
    )


def _short(name: str) -> str:
    """Return a feature's name without what all features have before it."""
    return name.removeprefix("observation.").removeprefix("tactile.") or name


FORMAT = Format("LeRobot data set (folder)", (".lerobot",), _recognizes, read_by(_open), write, open=_open, folder=True)
