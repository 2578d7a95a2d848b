"""A recording as a LeRobot data set, which its library loads, and of which reading gives the same recording.

The library wants a clock that ticks evenly: ``timestamp`` does. The recording's own times and presses are features of
their own, what has no entry a frame stands in ``meta/varishold.json``.
"""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any
from urllib.parse import quote

import numpy as np
from numpy.typing import NDArray

from varishold._lazy import missing_extra
from varishold.errors import InputError, reason_of
from varishold.files import atomic_write, folder_beside
from varishold.recording.formats.lerobot_plan import FILE_MB, INDICES, Plan, plan_of
from varishold.recording.formats.named_arrays import NAMED, SIGNALS, SINGLE
from varishold.recording.formats.parquet import told_columns
from varishold.recording.formats.parquet_column import GROUP, GROUP_BYTES, rows_together
from varishold.recording.mcap.notes import note_text
from varishold.recording.pad import UNNAMED_PAD
from varishold.recording.recording import Recording

if TYPE_CHECKING:
    import pyarrow

__all__ = ["INFO", "OURS", "write"]

#: What a data set says of itself, and what it says of a recording of this program.
INFO, OURS = Path("meta", "info.json"), Path("meta", "varishold.json")
_PADS, _SIGNALS, _TIME, _PRESS = "observation.tactile.", "observation.signals.", "varishold.time_s", "varishold.press"
_PART = "chunk-{chunk_index:03d}/file-{file_index:03d}.parquet"
# Files of a folder.
_FILES = 1000


def write(recording: Recording, path: str | os.PathLike[str]) -> None:
    """Write a recording as a LeRobot data set, whole or not at all; reading it gives the same recording.

    Parameters
    ----------
    recording : Recording
    path : str or path-like
        The folder, which must not be there; its name should end in ``.lerobot``.

    Raises
    ------
    InputError
        If it is there, or cannot be written.
    MissingExtraError
        If pyarrow is not installed.
    """
    try:
        import pyarrow  # noqa: F401
    except ModuleNotFoundError as error:
        raise missing_extra(error) from None
    target = Path(path)
    if os.path.lexists(target):
        raise InputError(f"{target}: is there already; name another folder")
    columns, told = told_columns(recording, _column_of)
    # Numbers as large as they can be have a rate and a spread that no number holds.
    with np.errstate(all="ignore"):
        _write(recording, target, columns, told)


def _write(recording: Recording, target: Path, columns: Mapping[str, NDArray[Any]], told: Mapping[str, Any]) -> None:
    plan = plan_of(recording, sum(array[:1].nbytes for array in columns.values()))
    try:
        with folder_beside(target) as beside:
            made = beside / "made"
            _write_frames(made / "data", columns, plan)
            _write_meta(made / "meta", recording, columns, plan)
            _write_text(made / OURS, note_text(told))
            os.rename(made, target)
    except OSError as error:
        raise InputError(f"{target}: cannot be written: {reason_of(error)}") from error


def _column_of(name: str) -> str:
    """Return the feature that holds an array with an entry a frame; "" for any other."""
    if name == SINGLE:
        return f"{_PADS}{UNNAMED_PAD}"
    for before, feature in ((NAMED, _PADS), (SIGNALS, _SIGNALS)):
        if name.startswith(before):
            # The library allows no slash.
            return f"{feature}{quote(name.removeprefix(before), safe=' ()[],+')}"
    return {"time_s": _TIME, "press": _PRESS}.get(name, "")


def _write_frames(folder: Path, columns: Mapping[str, NDArray[Any]], plan: Plan) -> None:
    import pyarrow
    from pyarrow import parquet

    kinds = {name: _kind(array) for name, array in columns.items()}
    kinds |= {name: pyarrow.from_numpy_dtype(dtype) for name, dtype in INDICES.items()}
    schema = pyarrow.schema(list(kinds.items()))
    group = rows_together(sum(array[:1].nbytes for array in columns.values()), GROUP_BYTES)
    for file in range(plan.n_files):
        path = folder / _PART.format(chunk_index=file // _FILES, file_index=file % _FILES)
        path.parent.mkdir(parents=True, exist_ok=True)
        with parquet.ParquetWriter(path, schema, compression="zstd") as writer:
            for episode in (k for k, each in enumerate(plan.file_of) if each == file):
                start, stop, indices = plan.starts[episode], plan.stops[episode], plan.indices(episode)
                for a in range(start, stop, group):
                    b = min(a + group, stop)
                    rows = [_rows(array[a:b], kinds[name]) for name, array in columns.items()]
                    rows += [pyarrow.array(each[a - start : b - start], kinds[name]) for name, each in indices.items()]
                    writer.write_table(pyarrow.table(rows, schema))


def _kind(array: NDArray[Any]) -> pyarrow.DataType:
    """Return what the library makes of entries of a shape: numbers, lists of one length, lists in lists."""
    import pyarrow

    number = pyarrow.from_numpy_dtype(array.dtype.newbyteorder("="))
    if array.ndim == 1 or array.shape[1:] == (1,):
        return number
    if array.ndim == 2:
        return pyarrow.list_(number, array.shape[1])
    return pyarrow.list_(pyarrow.list_(number))


def _rows(block: NDArray[Any], kind: pyarrow.DataType) -> pyarrow.Array:
    import pyarrow

    values = pyarrow.array(np.ascontiguousarray(block, block.dtype.newbyteorder("=")).ravel())
    if block.ndim == 1 or block.shape[1:] == (1,):
        return values
    if block.ndim == 2:
        return pyarrow.FixedSizeListArray.from_arrays(values, type=kind)
    rows, cols = block.shape[1:]
    inner = pyarrow.ListArray.from_arrays(_steps(len(block) * rows, cols), values)
    return pyarrow.ListArray.from_arrays(_steps(len(block), rows), inner)


def _steps(many: int, each: int) -> NDArray[np.int32]:
    return np.arange(many + 1, dtype=np.int32) * np.int32(each)


def _write_meta(folder: Path, recording: Recording, columns: Mapping[str, NDArray[Any]], plan: Plan) -> None:
    import pyarrow

    shapes = {name: list(array.shape[1:]) or [1] for name, array in columns.items()}
    names = {f"{_SIGNALS}{key}": list(each.names) or None for key, each in recording.signals.items()}
    features = {
        name: {
            "dtype": array.dtype.newbyteorder("=").name,
            "shape": shapes[name],
            "names": ["rows", "cols"] if len(shapes[name]) == 2 else names.get(name),
        }
        for name, array in columns.items()
    }
    features |= {name: {"dtype": dtype, "shape": [1], "names": None} for name, dtype in INDICES.items()}
    info = {
        "codebase_version": "v3.0",
        "robot_type": recording.sensor or None,
        "total_episodes": len(plan.starts),
        "total_frames": recording.n_frames,
        "total_tasks": len(plan.tasks),
        "chunks_size": _FILES,
        "data_files_size_in_mb": FILE_MB,
        "video_files_size_in_mb": 2 * FILE_MB,
        "fps": plan.fps,
        "splits": {"train": f"0:{len(plan.starts)}"},
        "data_path": f"data/{_PART}",
        "video_path": None,
        "features": features,
    }
    _write_text(folder / "info.json", json.dumps(info, indent=4))
    stats = {name: _stats(array, shapes.get(name, [1])) for name, array in {**columns, **plan.all_indices()}.items()}
    _write_text(folder / "stats.json", json.dumps(stats, indent=4))
    # As pandas has it: the texts are the names of the rows.
    told = {
        "index_columns": ["__index_level_0__"],
        "column_indexes": [],
        "columns": [
            {"name": "task_index", "field_name": "task_index", "pandas_type": "int64", "numpy_type": "int64"},
            {"name": None, "field_name": "__index_level_0__", "pandas_type": "unicode", "numpy_type": "object"},
        ],
    }
    tasks = pyarrow.table({"task_index": np.arange(len(plan.tasks)), "__index_level_0__": plan.tasks})
    _write_table(folder / "tasks.parquet", tasks.replace_schema_metadata({"pandas": json.dumps(told)}))
    _write_table(folder / "episodes" / _PART.format(chunk_index=0, file_index=0), _episodes(plan))


def _episodes(plan: Plan) -> pyarrow.Table:
    import pyarrow

    starts, stops, files = np.array(plan.starts), np.array(plan.stops), np.array(plan.file_of)
    felt = [
        [plan.tasks[k] for k in dict.fromkeys(plan.task_of[a:b].tolist())] for a, b in zip(starts, stops, strict=True)
    ]
    return pyarrow.table(
        {
            "episode_index": np.arange(len(starts)),
            "tasks": pyarrow.array(felt, pyarrow.list_(pyarrow.string())),
            "length": stops - starts,
            "data/chunk_index": files // _FILES,
            "data/file_index": files % _FILES,
            "dataset_from_index": starts,
            "dataset_to_index": stops,
            "meta/episodes/chunk_index": np.zeros(len(starts), np.int64),
            "meta/episodes/file_index": np.zeros(len(starts), np.int64),
        }
    )


def _stats(array: NDArray[Any], shape: list[int]) -> dict[str, Any]:
    """Return what the library wants to know of a feature: a number an entry, 0 where none is known."""
    many = len(array)
    low, high = np.full(shape, np.inf), np.full(shape, -np.inf)
    total, squares = np.zeros(shape), np.zeros(shape)
    first = np.nan_to_num(array[:1].astype(np.float64).reshape(shape))
    for begun in range(0, many, GROUP):
        block = np.nan_to_num(array[begun : begun + GROUP].astype(np.float64).reshape(-1, *shape))
        low, high = np.minimum(low, block.min(axis=0)), np.maximum(high, block.max(axis=0))
        # Less the first frame, so that a high rest costs no digits.
        total += (block - first).sum(axis=0)
        squares += ((block - first) ** 2).sum(axis=0)
    spread = np.sqrt(np.maximum(squares / many - (total / many) ** 2, 0))
    found = {"min": low, "max": high, "mean": first + total / many, "std": spread}
    return {name: np.nan_to_num(each).tolist() for name, each in found.items()} | {"count": [many]}


def _write_table(path: Path, table: pyarrow.Table) -> None:
    from pyarrow import parquet

    path.parent.mkdir(parents=True, exist_ok=True)
    parquet.write_table(table, path)


def _write_text(path: Path, text: str) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    with atomic_write(path, "w") as file:
        file.write(text)
