"""Many grasps: spread over processes, written as they come, carried on where a run was stopped."""

from __future__ import annotations

import multiprocessing
import os
import signal
import threading
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from varishold.errors import InputError
from varishold.hand.grasping import HandSetting, grasp
from varishold.hand.model import require_mujoco
from varishold.hand.objects import graspable
from varishold.hand.rows import Row, grasp_rows, grasp_table, require_layout
from varishold.recording import GraspTable, read_grasp_table, write_grasp_table

__all__ = ["Job", "collect", "run_jobs"]

#: The table on disk is renewed so often while grasps come in. Seconds.
_SAVE_S = 10.0


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
    if count == 1 or len(jobs) < 4:
        yield from map(work, jobs)
        return
    context = multiprocessing.get_context("spawn")
    # A stopped run must end without a traceback of each process: while they start they ignore Ctrl-C,
    # afterwards it ends them at once.
    end_at_once = (signal.SIGINT, signal.SIG_DFL)
    with ProcessPoolExecutor(
        min(count, len(jobs)), mp_context=context, initializer=signal.signal, initargs=end_at_once
    ) as pool:
        with _ignoring_interrupts():
            results = pool.map(work, jobs, chunksize=max(1, min(16, len(jobs) // (4 * count))))
        yield from results


@contextmanager
def _ignoring_interrupts() -> Iterator[None]:
    """Ignore Ctrl-C, as processes that are started meanwhile then do too; only the main thread may."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)


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

    Returns
    -------
    GraspTable
        All rows, in the jobs' order.

    Raises
    ------
    InputError
        If an object does not fit the hand, or the table that is there was collected with another setting.
    MissingExtraError
        If MuJoCo is not installed.
    """
    require_mujoco()
    setting = setting or HandSetting()
    wanted = list(dict.fromkeys(jobs))
    if not wanted:
        raise InputError("nothing to collect: the list of objects or the number of grasps is empty")
    for name, size_m in dict.fromkeys((job.name, job.size_m) for job in wanted):
        graspable(name, size_m)
    if any(job.seed < 0 for job in wanted):
        raise InputError(f"seed must be a whole number from 0 on, got {min(job.seed for job in wanted)}")
    if not steps or not set(steps) <= {1, 2, 3, 4, 5}:
        raise InputError(f"steps must be among 1 .. 5, got {list(steps)}")
    path = Path(path)
    if not path.parent.is_dir():
        raise InputError(f"{path}: cannot write here: there is no folder {path.parent}; make it first")
    rows: dict[Job, list[Row]] = _already(path, setting, tuple(steps)) if path.exists() else {}
    missing = [job for job in wanted if job not in rows]
    extra = [job for job in rows if job not in set(wanted)]
    order = [*wanted, *extra]

    def save() -> GraspTable:
        table = grasp_table([row for job in order if job in rows for row in rows[job]], source=str(path))
        write_grasp_table(table, path)
        return table

    saved = time.monotonic()
    work = _Work(setting, tuple(steps))
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
    for column, value in (("finger_scale", setting.design.finger_scale), ("searched", float(setting.search))):
        if column not in table.columns or np.any(table.cells[column] != value):
            raise InputError(
                f"{path}: was collected with another {column} than {value:g}; name another file for the output"
            )
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
