"""Episodes of a data set: each is a press, labelled by its task; their clocks, which all begin anew, become one."""

from __future__ import annotations

import math
import os
from collections.abc import Mapping
from dataclasses import dataclass, field
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from varishold._counted import counted
from varishold.errors import FormatError
from varishold.files import damage_told, possible_text
from varishold.recording.formats.episodes import CLOCK_GOES_ON
from varishold.recording.formats.parquet_column import opened_parquet
from varishold.recording.formats.parquet_folder import FilesColumn

__all__ = ["INDICES", "Episodes", "episodes_of"]

#: Columns that count, and the clock.
INDICES = ("timestamp", "frame_index", "episode_index", "index", "task_index")
_TASKS = Path("meta", "tasks.parquet")
# Rows that are looked through together; episodes and signs of tasks at most.
_TOGETHER, _MOST_EPISODES, _MOST_SIGNS = 1 << 16, 1 << 20, 1 << 24
_MOST_TASKS = 1 << 16


@dataclass(frozen=True)
class Episodes:
    """Which press each frame belongs to, what is known of each, and one clock for all."""

    press: _Presses
    columns: Mapping[str, NDArray[Any]]
    time_s: _Clock
    notes: tuple[str, ...]


@dataclass(frozen=True)
class _Presses:
    """The number of each frame's episode, by the frames at which they begin."""

    starts: NDArray[np.int64]
    n_frames: int

    @property
    def shape(self) -> tuple[int, ...]:
        return (self.n_frames,)

    @property
    def dtype(self) -> np.dtype[Any]:
        return np.dtype(np.int64)

    def __getitem__(self, wanted: slice, /) -> NDArray[Any]:
        frames = np.arange(*wanted.indices(self.n_frames))
        found: NDArray[np.int64] = np.searchsorted(self.starts, frames, side="right") - 1
        return found


@dataclass(frozen=True)
class _Clock:
    """The times of frames: those of their rows, from where the episode before ended."""

    stamps: FilesColumn | None
    presses: _Presses
    offsets: NDArray[np.float64]
    times: int
    fps: float

    @property
    def shape(self) -> tuple[int, ...]:
        return self.presses.shape

    @property
    def dtype(self) -> np.dtype[Any]:
        return np.dtype(np.float64)

    def __getitem__(self, wanted: slice, /) -> NDArray[Any]:
        first, last, _ = wanted.indices(self.shape[0])
        rows = slice(first // self.times, math.ceil(last / self.times))
        if self.stamps is None:
            stamps = np.arange(rows.start, rows.stop) / self.fps
        else:
            stamps = self.stamps[rows].reshape(-1).astype(np.float64)
        within = (np.arange(self.times) + 1 - self.times) / (self.times * self.fps)
        begun = rows.start * self.times
        frames = (stamps[:, None] + within).ravel()[first - begun : last - begun]
        times: NDArray[np.float64] = frames + self.offsets[self.presses[first:last]]
        return times


@dataclass
class _Run:
    """Consecutive rows of one episode, as far as they were looked through."""

    start: int
    number: int
    first_s: float
    last_s: float = 0.0
    tasks: dict[int, None] = field(default_factory=dict)


def episodes_of(path: Path, columns: Mapping[str, FilesColumn], fps: float, times: int) -> Episodes:
    """Go once through what counts rows, and return the episodes.

    Parameters
    ----------
    path : Path
        The data set.
    columns : mapping of str to FilesColumn
        All its columns of numbers.
    fps : float
    times : int
        Frames of a row.

    Raises
    ------
    FormatError
        If a column is damaged, an index is no whole number, or there are more episodes than anybody records.
    """
    n_rows = next(iter(columns.values())).shape[0]
    counting = {name: columns[name] for name in INDICES if name in columns}
    for name, column in counting.items():
        column.check()
        if column.width != 1 or (name != "timestamp" and column.dtype.kind not in "iu"):
            raise FormatError(f"{column.place}: must be one {'' if name == 'timestamp' else 'whole '}number a row")
    runs = _runs(path, counting, n_rows, fps)
    offsets = np.zeros(len(runs))
    for k, (before, run) in enumerate(pairwise(runs), 1):
        offsets[k] = offsets[k - 1] + before.last_s + 1 / fps - run.first_s
    presses = _Presses(np.array([run.start for run in runs]) * times, n_rows * times)
    notes = [f"each of {counted(len(runs), 'episode')} is a press, labelled by its task"]
    if offsets.any():
        notes.append(CLOCK_GOES_ON)
    numbers, many = np.unique([run.number for run in runs], return_counts=True)
    if (many > 1).any():
        notes.append(f"episode {numbers[many > 1][0]} stands in two places, or more; each is a press")
    words, missing = _words(path, {each for run in runs for each in run.tasks})
    known = {
        "label": np.array([" | ".join(words[each] for each in run.tasks) for run in runs]),
        "episode": np.array([run.number for run in runs]),
    }
    return Episodes(presses, known, _Clock(counting.get("timestamp"), presses, offsets, times, fps), (*notes, *missing))


def _runs(path: Path, counting: Mapping[str, FilesColumn], n_rows: int, fps: float) -> list[_Run]:
    """Return the runs of rows of one episode, found some rows at a time."""
    runs: list[_Run] = []
    for begun in range(0, n_rows, _TOGETHER):
        some = slice(begun, min(begun + _TOGETHER, n_rows))
        nothing = np.zeros(some.stop - begun, np.int64)
        of_rows, of_tasks = (
            counting[name][some].reshape(-1).astype(np.int64) if name in counting else nothing
            for name in ("episode_index", "task_index")
        )
        stamps = counting.get("timestamp")
        clock = np.arange(begun, some.stop) / fps if stamps is None else stamps[some].reshape(-1).astype(np.float64)
        cuts = (np.flatnonzero(np.diff(of_rows)) + 1).tolist()
        for a, b in pairwise([0, *cuts, len(of_rows)]):
            if not runs or runs[-1].number != of_rows[a]:
                runs.append(_Run(begun + a, int(of_rows[a]), float(clock[a])))
            runs[-1].last_s = float(clock[b - 1])
            runs[-1].tasks.update(dict.fromkeys(np.unique(of_tasks[a:b]).tolist()))
        if len(runs) > _MOST_EPISODES:
            raise FormatError(f"{path}: has more than {_MOST_EPISODES} episodes")
    return runs


def _words(path: Path, wanted: set[int]) -> tuple[dict[int, str], tuple[str, ...]]:
    """Return what tasks are called, and what there is to say of those that have no name."""
    held = _tasks(path / _TASKS) if (path / _TASKS).is_file() else {}
    lacking = sorted(wanted - set(held))
    note = (f"tasks {', '.join(map(str, lacking[:8]))} have no name in {_TASKS}",) if lacking else ()
    return held | {number: f"task {number}" for number in lacking}, note


def _tasks(path: Path) -> dict[int, str]:
    file, binary = opened_parquet(path)
    with binary, damage_told(str(path)):
        from pyarrow import types

        schema = file.schema_arrow
        texts = [each.name for each in schema if types.is_string(each.type) or types.is_large_string(each.type)]
        size = binary.seek(0, os.SEEK_END)
        n_rows = file.metadata.num_rows
        if not texts or "task_index" not in schema.names or n_rows > _MOST_TASKS:
            raise FormatError(f"{path}: must hold task_index and the text of up to {_MOST_TASKS} tasks")
        found: dict[int, str] = {}
        signs = 0
        for batch in file.iter_batches(1024, columns=["task_index", texts[0]]):
            signs += batch.nbytes
            if signs > max(_MOST_SIGNS, 8 * size):
                raise FormatError(f"{path}: holds texts of {signs} bytes in a file of {size}")
            numbers = batch.column(batch.schema.get_field_index("task_index")).to_pylist()
            names = batch.column(batch.schema.get_field_index(texts[0])).to_pylist()
            found |= {int(k): str(name)[:4096] for k, name in zip(numbers, names, strict=True) if k is not None}
        clean = possible_text(np.array(list(found.values()) or [""])).tolist()
        return dict(zip(found, clean, strict=False))
