"""Which task is next: who has a recording open goes on with it, and a recording that fails stops nobody."""

from __future__ import annotations

from collections import Counter, deque
from collections.abc import Sequence
from dataclasses import dataclass, field

from varishold.corpus.tasks import BlockTask, Job, Surveyed, SurveyTask

__all__ = ["Agenda", "Entry"]

# A task during which a worker was lost is tried so often.
_TRIES = 2


@dataclass
class Entry:
    """How far a recording has come.

    Parameters
    ----------
    path : str
    surveyed : Surveyed or None
        None before it was looked through.
    pending : deque of int
        Blocks that nobody has begun.
    n_left : int
        Blocks that are not answered yet.
    failure : str
        Why there is no answer; empty while all is well.
    """

    path: str
    surveyed: Surveyed | None = None
    pending: deque[int] = field(default_factory=deque)
    n_left: int = 0
    failure: str = ""

    @property
    def answered(self) -> bool:
        """Whether all its parts are there."""
        return not self.failure and self.surveyed is not None and self.n_left == 0


class Agenda:
    """The tasks of a run.

    Parameters
    ----------
    job : Job
    paths : sequence of str

    Attributes
    ----------
    entries : list of Entry
        In the order of the paths.
    n_frames, n_done : int
        Frames of all recordings that were looked through, and those that are answered.
    """

    def __init__(self, job: Job, paths: Sequence[str]) -> None:
        self._job = job
        self.entries = [Entry(path) for path in paths]
        self._by_path = {entry.path: entry for entry in self.entries}
        self._unseen = deque(self.entries)
        self._mine: dict[int, Entry] = {}
        self._lost: Counter[SurveyTask | BlockTask] = Counter()
        self._again: deque[SurveyTask | BlockTask] = deque()
        self.n_frames = self.n_done = 0

    def next_for(self, worker: int) -> SurveyTask | BlockTask | None:
        """Return the next task of a worker; None while there is none for it."""
        if self._again:
            return self._again.popleft()
        mine = self._mine.get(worker)
        if mine is None or not mine.pending:
            if self._unseen:
                self._mine[worker] = self._unseen.popleft()
                return SurveyTask(self._job, self._mine[worker].path)
            mine = max(self.entries, key=lambda entry: len(entry.pending), default=None)
            if mine is None or not mine.pending:
                return None
            self._mine[worker] = mine
        assert mine.surveyed is not None
        return BlockTask(self._job, mine.path, mine.surveyed.key, mine.surveyed.stamp, mine.pending.popleft())

    def done(self, task: SurveyTask | BlockTask, found: Surveyed | int) -> None:
        """Take what a task has given."""
        entry = self._by_path[task.path]
        if isinstance(found, int):
            entry.n_left -= 1
            self.n_done += found
            return
        entry.surveyed = found
        self.n_frames += found.n_frames
        missing = [k for k in range(found.n_blocks) if not self._job.part_path(found.key, k).exists()]
        if len(missing) < found.n_blocks:
            self.n_done += found.n_frames * (found.n_blocks - len(missing)) // found.n_blocks
        entry.n_left = len(missing)
        entry.pending.extend(missing)

    def failed(self, task: SurveyTask | BlockTask, reason: str) -> str:
        """Give a recording up; return why, opened by its name, and nothing where that was said before."""
        entry = self._by_path[task.path]
        entry.pending.clear()
        if entry.failure:
            return ""
        entry.failure = reason if reason.startswith(entry.path) else f"{entry.path}: {reason}"
        return entry.failure

    def lost(self, task: SurveyTask | BlockTask) -> bool:
        """Take notice that the worker of a task has died; tell whether it is tried again."""
        self._lost[task] += 1
        if self._lost[task] >= _TRIES:
            return False
        self._again.append(task)
        return True
