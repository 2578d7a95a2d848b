"""How a recording is cut into the episodes of a LeRobot data set, what is felt in each, and in which file it stands."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from varishold.recording.recording import Recording

__all__ = ["FILE_MB", "INDICES", "Plan", "plan_of"]

#: The features that count rows, and the clock; bytes of a file of frames.
INDICES = {"timestamp": "float32", **dict.fromkeys(("frame_index", "episode_index", "index", "task_index"), "int64")}
FILE_MB = 100
# Frames a second where no time is known.
_FPS = 30
# What is felt where nobody has said it.
_NO_TASK = "touch"


@dataclass(frozen=True)
class Plan:
    """Where each episode begins and ends, what is felt in each frame, and in which file it stands."""

    starts: list[int]
    stops: list[int]
    tasks: list[str]
    task_of: NDArray[np.int64]
    file_of: list[int]
    fps: int

    @property
    def n_files(self) -> int:
        return self.file_of[-1] + 1

    def indices(self, episode: int) -> dict[str, NDArray[Any]]:
        """Return what counts the rows of an episode, and its clock."""
        start, stop = self.starts[episode], self.stops[episode]
        within = np.arange(stop - start)
        return {
            "timestamp": (within / self.fps).astype(np.float32),
            "frame_index": within,
            "episode_index": np.full(stop - start, episode),
            "index": within + start,
            "task_index": self.task_of[start:stop],
        }

    def all_indices(self) -> dict[str, NDArray[Any]]:
        """Return the same of all rows."""
        every = [self.indices(episode) for episode in range(len(self.starts))]
        return {name: np.concatenate([each[name] for each in every]) for name in INDICES}


def plan_of(recording: Recording, frame_bytes: int) -> Plan:
    """Return an episode for each press and for what is between them, or one for all.

    Parameters
    ----------
    recording : Recording
    frame_bytes : int
        Bytes of a row.
    """
    n = recording.n_frames
    press = recording.press
    starts = [0] if press is None else [0, *(np.flatnonzero(np.diff(press)) + 1).tolist()]
    stops = [*starts[1:], n]
    words = np.full(n, _NO_TASK, object)
    if press is not None:
        label = next((c for k, c in recording.press_columns.items() if k == "label" or c.dtype.kind == "U"), None)
        label = recording.press_columns.get("label", label)
        if label is not None:
            felt = press >= 0
            words[felt] = [str(each) for each in label[press[felt]].tolist()]
    else:
        for mark in recording.marks:
            words[mark.frame :] = mark.label
    words[words == ""] = _NO_TASK
    tasks = list(dict.fromkeys(words.tolist()))
    numbers = {task: number for number, task in enumerate(tasks)}
    file_of, size = [], 0
    for start, stop in zip(starts, stops, strict=True):
        size += (stop - start) * frame_bytes
        file_of.append(size // (FILE_MB << 20))
    # Files are numbered without gaps, however long an episode is.
    file_of = np.unique(file_of, return_inverse=True)[1].tolist()
    return Plan(starts, stops, tasks, np.array([numbers[word] for word in words]), file_of, _fps(recording.time_s))


def _fps(time_s: NDArray[np.float64] | None) -> int:
    if time_s is None or len(time_s) < 2:
        return _FPS
    step = float(np.median(np.diff(time_s)))
    return int(np.clip(np.rint(1 / step), 1, 1_000_000)) if 0 < step < np.inf else _FPS
