"""Many grasps: spread over processes, written as they come, carried on where a run was stopped."""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from varishold.errors import InputError
from varishold.files import only_writer, spread
from varishold.hand.grasping import HandSetting, grasp
from varishold.hand.hand import FIVE_STEPS
from varishold.hand.model import require_mujoco
from varishold.hand.objects import graspable
from varishold.hand.rows import Row, grasp_rows, grasp_table, made_with, require_layout
from varishold.recording import GraspTable, read_grasp_table, write_grasp_table
from varishold.recording.grasp_table import cell_text

__all__ = ["Job", "collect", "run_jobs"]

#: The table on disk is renewed so often while grasps come in. Seconds.
_SAVE_S = 10.0
#: Its numbers are doubles, of which larger ones are not all whole numbers.
_LARGEST_SEED = 1 << 53


@dataclass(frozen=True)
class Job:
    """One grasp to make.

    Parameters
    ----------
    name : str
        The object's name in `OBJECTS`.
    size_m : float
        Metres.
    seed : int
    """

    name: str
    size_m: float
    seed: int


def run_jobs(
    jobs: Sequence[Job],
    work: Callable[[Job], Any],
    *,
    processes: int | None = None,
) -> Iterator[Any]:
    """Yield ``work(job)`` for every job, in the jobs' order, from several processes.

    Parameters
    ----------
    jobs : sequence of Job
    work : callable
        Defined at the top of a module, so that other processes can find it.
    processes : int, optional
        Default: one a processor. 1 works in this process.

    Raises
    ------
    InputError
        If `processes` is less than 1.
    """
    count = processes if processes is not None else len(os.sched_getaffinity(0))
    if count < 1:
        raise InputError(f"processes must be at least 1, got {count}")
    if len(jobs) < 4:
        count = 1
    chunk = max(1, min(16, len(jobs) // (4 * count)))
    yield from spread(work, jobs, processes=min(count, len(jobs)), chunk=chunk)


@dataclass(frozen=True)
class _Work:
    """What a process does with a job."""

    setting: HandSetting
    steps: tuple[int, ...]

    def __call__(self, job: Job) -> list[Row]:
        done = grasp(job.name, job.size_m, seed=job.seed, setting=self.setting)
        return grasp_rows(done, self.setting, steps=self.steps)


def collect(
    jobs: Iterable[Job],
    path: str | os.PathLike[str],
    *,
    setting: HandSetting | None = None,
    steps: Sequence[int] = (5,),
    processes: int | None = None,
    progress: Callable[[int, int], None] | None = None,
    anew: bool = False,
) -> GraspTable:
    """Make grasps and write them to a table; a table that is already there is carried on.

    Whatever the number of processes, and however often it was stopped, the same jobs give the same file.

    Parameters
    ----------
    jobs : iterable of Job
    path : str or path-like
        The table (CSV).
    setting : HandSetting, optional
    steps : sequence of int
        The steps of each grasp that get a row.
    processes : int, optional
        Default: one a processor.
    progress : callable, optional
        Called with the numbers of grasps done and wanted.
    anew : bool
        Replace whatever is there instead of carrying it on.

    Returns
    -------
    GraspTable
        All rows, in the jobs' order.

    Raises
    ------
    InputError
        If an object does not fit the hand, the table that is there was collected in another way, or another
        process is writing it.
    MissingExtraError
        If MuJoCo is not installed.
    """
    require_mujoco()
    setting = setting or HandSetting()
    wanted = list(dict.fromkeys(jobs))
    if not wanted:
        raise InputError("nothing to collect: the list of objects or the number of grasps is empty")
    for name, size_m in dict.fromkeys((job.name, job.size_m) for job in wanted):
        graspable(name, size_m, setting.design.sizes_m)
    if any(job.seed < 0 for job in wanted):
        raise InputError(f"seed must be a whole number from 0 on, got {min(job.seed for job in wanted)}")
    if any(job.seed > _LARGEST_SEED for job in wanted):
        raise InputError(f"seed must be at most {_LARGEST_SEED} in a table, got {max(job.seed for job in wanted)}")
    can = setting.design.steps
    if not steps or not set(steps) <= set(can):
        known = "1 .. 5" if len(can) == len(FIVE_STEPS) else ", ".join(map(str, can))
        raise InputError(f"steps must be among {known}, got {list(steps)}")
    path = Path(path)
    with only_writer(path):
        begun = not anew and path.exists() and path.stat().st_size > 0
        rows = _already(path, setting, tuple(steps)) if begun else {}
        return _carry_on(rows, wanted, path, _Work(setting, tuple(steps)), processes, progress)


def _carry_on(
    rows: dict[Job, list[Row]],
    wanted: list[Job],
    path: Path,
    work: _Work,
    processes: int | None,
    progress: Callable[[int, int], None] | None,
) -> GraspTable:
    missing = [job for job in wanted if job not in rows]
    extra = [job for job in rows if job not in set(wanted)]
    order = [*wanted, *extra]

    def save() -> GraspTable:
        table = grasp_table([row for job in order if job in rows for row in rows[job]], source=str(path))
        write_grasp_table(table, path)
        return table

    saved = time.monotonic()
    try:
        for job, new in zip(missing, run_jobs(missing, work, processes=processes), strict=True):
            rows[job] = new
            if progress is not None:
                progress(len(rows) - len(extra), len(wanted))
            if time.monotonic() - saved > _SAVE_S:
                save()
                saved = time.monotonic()
    except BaseException:
        # Whoever stops a run keeps what it has made.
        if rows:
            save()
        raise
    return save()


def _already(path: Path, setting: HandSetting, steps: tuple[int, ...]) -> dict[Job, list[Row]]:
    """Rows of a table that an earlier run left, by job."""
    table = read_grasp_table(path)
    require_layout(table, setting.layout)
    same = made_with(setting)
    for column in ("object", "size_m", "seed", "step", "held", *same):
        if column not in table.columns:
            raise InputError(
                f"{path}: has no column {column!r}, so that it cannot be carried on; name another file for the output"
            )
    for column, value in same.items():
        other = np.flatnonzero(table.cells[column] != value)
        if other.size:
            raise InputError(
                f"{path}: was collected with another {column} than {cell_text(value)} "
                f"(line {table.first_line + int(other[0])}); name another file for the output"
            )
    for column in ("size_m", "seed", "step"):
        if not np.isfinite(table.cells[column]).all():
            raise InputError(f"{path}: column {column!r} has an empty cell; name another file for the output")
    rows: dict[Job, list[Row]] = {}
    for k in range(len(table)):
        row = {name: column[k].item() for name, column in table.cells.items()}
        rows.setdefault(Job(row["object"], row["size_m"], int(row["seed"])), []).append(row)
    for job, got in rows.items():
        numbers = {int(row["step"]) for row in got}
        if not (numbers == set(steps) or (numbers <= {0, *range(1, 6)} and not got[-1]["held"])):
            raise InputError(
                f"{path}: holds steps {sorted(numbers)} of {job.name}, not {sorted(steps)}; "
                "name another file for the output"
            )
    return rows
