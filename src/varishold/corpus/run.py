"""A run over a corpus: every recording is looked through, its blocks are answered, the parts are joined."""

from __future__ import annotations

import os
import re
from collections import deque
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import FIRST_COMPLETED, BrokenExecutor, Future, wait
from contextlib import AbstractContextManager, contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from varishold.corpus.agenda import Agenda, Entry
from varishold.corpus.ask import Ask
from varishold.corpus.content import program_digest
from varishold.corpus.joining import Joining
from varishold.corpus.opened import Reading
from varishold.corpus.part import need_parquet
from varishold.corpus.survey import read_survey
from varishold.corpus.tasks import BlockTask, CannotKeep, Job, SurveyTask, do
from varishold.errors import InputError, VarisholdError, reason_of
from varishold.files import each_once, only_writer
from varishold.files.crew import Worker, crew_of

__all__ = ["Outcome", "run_corpus"]

# What a run leaves in its folder.
_OURS = re.compile(r"[0-9a-f]{32}(-\d{6,}\.parquet|\.survey\.npz)")


@dataclass(frozen=True)
class Outcome:
    """How a run ended.

    Parameters
    ----------
    n_rows, n_frames : int
        Of the table, and of the recordings in it.
    health : mapping of str to mapping
        What `varishold.corpus.survey.health_of` found, by recording.
    failures : mapping of str to str
        Why recordings are not in the table, each in one line that names it.
    folder : Path or None
        Where the parts are, if they were left there.
    """

    n_rows: int
    n_frames: int
    health: Mapping[str, Mapping[str, Any]]
    failures: Mapping[str, str]
    folder: Path | None


def run_corpus(
    files: Sequence[str],
    ask: Ask,
    output: str | os.PathLike[str],
    *,
    reading: Reading | None = None,
    workers: int | AbstractContextManager[Sequence[Worker]] = 1,
    work: Callable[[Any], Any] = do,
    keep_parts: bool = False,
    tell: Callable[[str], None] = lambda line: None,
    explain: Callable[[InputError], str] = str,
    tick: Callable[..., None] = lambda **_: None,
) -> Outcome:
    """Ask every recording the same, and write one table of all answers.

    Beside the table stands, while it is made, a folder of parts, named by what recordings hold, what is asked and who
    answers. A run that was interrupted is taken up where it ended; the table has the same bytes however it was made.

    Parameters
    ----------
    files : sequence of str
        Recordings; the table has them in this order, each once, whatever names it has.
    ask : Ask
    output : path-like
        The table (Parquet).
    reading : Reading, optional
        How recordings are read.
    workers : int or context manager
        So many processes, 1 for this one; or what gives workers.
    work : callable
        What a worker does with a task.
    keep_parts : bool
        Leave the parts there, so that a run over more recordings need not answer these again. Where a recording
        failed they are left in any case.
    tell : callable
        Called with a line where one of several recordings fails.
    explain : callable
        Makes a text of an error.
    tick : callable
        Called with ``completed`` and ``total`` frames.

    Returns
    -------
    Outcome

    Raises
    ------
    InputError
        If no recording could be answered, or there is no room for the answers; what is there is kept.
    MissingExtraError
        If pyarrow is not installed.

    Examples
    --------
    >>> import tempfile
    >>> import numpy as np
    >>> from varishold.corpus import AskTouch
    >>> from varishold.recording import Pad, Recording, write
    >>> y, x = np.mgrid[-8:9, -8:9]
    >>> cone = np.maximum(6.0 - np.hypot(x, y), 0.0)
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     write(Recording({"pad": Pad(cone[None])}), Path(folder, "cone.npz"))
    ...     found = run_corpus([str(Path(folder, "cone.npz"))], AskTouch(), Path(folder, "names.parquet"))
    >>> found.n_rows, found.failures
    (1, {})
    """
    need_parquet()
    table = Path(output)
    # Out of sight, so that they are not taken for recordings where the table stands among them.
    with only_writer(output), _folder(table.with_name(f".{table.name}.parts")) as folder:
        job = Job(ask, reading or Reading(), str(folder.absolute()), program_digest())
        agenda = Agenda(job, each_once(files)[0])
        several = len(agenda.entries) > 1
        with Joining(output, ask.columns, title=ask.title) as joining:
            with crew_of(workers) as hands:
                join = _Joined(job, agenda, joining).go_on
                _work_off(agenda, hands, work, tell if several else lambda line: None, explain, tick, join)
            good = [entry for entry in agenda.entries if not entry.failure]
            failures = {entry.path: entry.failure for entry in agenda.entries if entry.failure}
            if not good:
                raise InputError("no recording could be answered" if several else next(iter(failures.values())))
            n_rows = joining.end()
        health = {entry.path: read_survey(job.survey_path(_key(entry))).health for entry in good}
        if not keep_parts and not failures:
            _clear(folder)
        return Outcome(n_rows, agenda.n_frames, health, failures, folder if any(folder.iterdir()) else None)


@contextmanager
def _folder(folder: Path) -> Iterator[Path]:
    """Make a folder, which goes again if nothing is in it."""
    try:
        folder.mkdir(exist_ok=True)
    except OSError as error:
        raise InputError(f"{folder}: cannot be made a folder: {reason_of(error)}") from error
    try:
        yield folder
    finally:
        with suppress(OSError):
            folder.rmdir()


def _work_off(
    agenda: Agenda,
    hands: Sequence[Worker],
    work: Callable[[Any], Any],
    tell: Callable[[str], None],
    explain: Callable[[InputError], str],
    tick: Callable[..., None],
    join: Callable[[], None],
) -> None:
    """Hand out tasks until there are none."""
    running: dict[Future[Any], tuple[int, SurveyTask | BlockTask]] = {}
    idle = list(range(len(hands)))
    while True:
        for worker in tuple(idle):
            task = agenda.next_for(worker)
            if task is not None:
                idle.remove(worker)
                running[hands[worker].submit(work, task)] = worker, task
        if not running:
            return
        for future in wait(running, return_when=FIRST_COMPLETED).done:
            worker, task = running.pop(future)
            idle.append(worker)
            if line := _taken(agenda, task, future, explain):
                tell(line)
            tick(completed=agenda.n_done, total=agenda.n_frames)
        join()


def _taken(
    agenda: Agenda, task: SurveyTask | BlockTask, future: Future[Any], explain: Callable[[InputError], str]
) -> str:
    """Take what a task has given; return what is to be told of it."""
    try:
        agenda.done(task, future.result())
    except CannotKeep:
        raise
    except BrokenExecutor:
        if agenda.lost(task):
            return ""
        return agenda.failed(task, "a worker died twice over it, perhaps for lack of memory; ask for fewer workers")
    except InputError as error:
        return agenda.failed(task, explain(error))
    except VarisholdError as error:
        return agenda.failed(task, str(error))
    except MemoryError as error:
        return agenda.failed(task, f"not enough memory: {str(error) or 'ask for fewer workers'}")
    except Exception as error:
        # A fault of ours with one recording is no reason to lose a night's work with the others.
        return agenda.failed(task, f"{type(error).__name__}: {error}; this is a fault of the program: please tell it")
    return ""


def _key(entry: Entry) -> str:
    assert entry.surveyed is not None
    return entry.surveyed.key


class _Joined:
    """How far the recordings are joined, in their order."""

    def __init__(self, job: Job, agenda: Agenda, joining: Joining) -> None:
        self._job, self._joining = job, joining
        self._waiting = deque(agenda.entries)

    def go_on(self) -> None:
        """Join what is answered, up to the first recording that is not."""
        while self._waiting and (self._waiting[0].answered or self._waiting[0].failure):
            entry = self._waiting.popleft()
            if entry.answered and entry.surveyed is not None:
                for number in range(entry.surveyed.n_blocks):
                    self._joining.add(entry.path, self._job.part_path(entry.surveyed.key, number))


def _clear(folder: Path) -> None:
    """Remove the parts."""
    for file in folder.iterdir():
        if _OURS.fullmatch(file.name):
            with suppress(OSError):
                file.unlink()
