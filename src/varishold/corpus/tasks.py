"""What workers do: look once through a recording, then answer its blocks, each into a part of its own."""

from __future__ import annotations

import threading
from dataclasses import dataclass
from pathlib import Path
from platform import node

from varishold.corpus.ask import Ask
from varishold.corpus.content import content_digest, digest_of, program_digest
from varishold.corpus.opened import Opened, Reading, Stamp, open_recording, stamp_of
from varishold.corpus.part import write_part
from varishold.corpus.survey import Survey, frame_bytes, health_of, read_survey
from varishold.errors import InputError

__all__ = ["BlockTask", "CannotKeep", "Job", "SurveyTask", "Surveyed", "do", "do_elsewhere"]


class CannotKeep(InputError):
    """What was found cannot be written: the whole run ends."""


@dataclass(frozen=True)
class Job:
    """What is the same in all tasks of a run.

    Parameters
    ----------
    ask : Ask
    reading : Reading
    folder : str
        Where surveys and parts are written.
    program : str
        Digest of the program that is to answer.
    """

    ask: Ask
    reading: Reading
    folder: str
    program: str

    def survey_path(self, key: str) -> Path:
        return Path(self.folder, f"{key}.survey.npz")

    def part_path(self, key: str, number: int) -> Path:
        return Path(self.folder, f"{key}-{number:06d}.parquet")


@dataclass(frozen=True)
class Surveyed:
    """What a survey tells the one who hands out tasks.

    Parameters
    ----------
    key : str
        By which the recording's survey and parts are named: of its content, the options and the program.
    stamp : Stamp
    n_frames, n_blocks : int
    """

    key: str
    stamp: Stamp
    n_frames: int
    n_blocks: int


@dataclass(frozen=True)
class SurveyTask:
    """Look once through a recording."""

    job: Job
    path: str

    def do(self) -> Surveyed:
        opened = open_recording(self.path, self.job.reading)
        try:
            key = digest_of(content_digest(self.path), opened.sensor, self.job.reading, self.job.ask, self.job.program)
            found = _survey_there(self.job.survey_path(key))
            if found is None:
                whole = opened.whole()
                looked = self.job.ask.look(whole, opened.sensor)
                found = Survey(whole.n_frames, frame_bytes(whole), looked, health_of(whole))
                _keep(found, self.job.survey_path(key))
                opened = opened.kept(whole)
        except BaseException:
            opened.close()
            raise
        if stamp_of(self.path) != opened.stamp:
            opened.close()
            raise _changed(self.path)
        _at_hand.take(self.path, self.job.reading, opened)
        return Surveyed(key, opened.stamp, found.n_frames, found.n_blocks)


@dataclass(frozen=True)
class BlockTask:
    """Answer a block of a recording that was looked through."""

    job: Job
    path: str
    key: str
    stamp: Stamp
    number: int

    def do(self) -> int:
        """Return the number of frames that were answered."""
        survey = _at_hand.survey(self.job.survey_path(self.key))
        block = survey.block(self.number)
        opened = _at_hand.opened(self.path, self.job.reading, self.stamp)
        part = opened.block(block.first, block.last)
        rows = self.job.ask.rows(part, block.first, block.groups, survey.looked, opened.sensor)
        try:
            write_part(self.job.part_path(self.key, self.number), rows, self.job.ask.columns)
        except InputError as error:
            raise CannotKeep(str(error)) from error
        return block.last - block.first


def do(task: SurveyTask | BlockTask) -> Surveyed | int:
    """Do a task, in whichever process this is.

    Raises
    ------
    InputError
        If the recording cannot be answered.
    CannotKeep
        If there is no room for what was found.
    """
    return task.do()


def do_elsewhere(task: SurveyTask | BlockTask) -> Surveyed | int:
    """Do a task in a process that somebody else has started, perhaps on another machine.

    Raises
    ------
    CannotKeep
        As `do`; or if the process runs another program, or does not see the folder.
    """
    if task.job.program != program_digest():
        raise CannotKeep(f"a worker on {node()} runs another version of varishold; install the same there")
    if not Path(task.job.folder).is_dir():
        raise CannotKeep(f"{task.job.folder}: a worker on {node()} does not see this folder; name one that all share")
    return do(task)


def _survey_there(path: Path) -> Survey | None:
    if not path.exists():
        return None
    try:
        return read_survey(path)
    except InputError:
        # It is made again.
        return None


def _keep(survey: Survey, path: Path) -> None:
    try:
        survey.write(path)
    except InputError as error:
        raise CannotKeep(str(error)) from error


def _changed(path: str) -> InputError:
    return InputError(f"{path}: was changed while it was being read; run again")


class _AtHand(threading.local):
    """The recording that this thread has open: workers of a cluster may have several."""

    def __init__(self) -> None:
        self._path, self._reading = "", Reading()
        self._opened: Opened | None = None
        self._survey_path = Path()
        self._survey: Survey | None = None

    def survey(self, path: Path) -> Survey:
        """Return what a survey found, read once."""
        if self._survey is None or self._survey_path != path:
            self._survey_path, self._survey = path, read_survey(path)
        return self._survey

    def take(self, path: str, reading: Reading, opened: Opened) -> None:
        """Keep an open recording, and close the one before."""
        self.close()
        self._path, self._reading, self._opened = path, reading, opened

    def opened(self, path: str, reading: Reading, stamp: Stamp) -> Opened:
        """Return a recording, open.

        Raises
        ------
        InputError
            If it cannot be opened, or is another than the one that was looked through.
        """
        if stamp_of(path) != stamp:
            raise _changed(path)
        if self._opened is None or (path, reading, stamp) != (self._path, self._reading, self._opened.stamp):
            self.close()
            self.take(path, reading, open_recording(path, reading, checked=True))
        assert self._opened is not None
        return self._opened

    def close(self) -> None:
        if self._opened is not None:
            self._opened.close()
        self._opened = None


_at_hand = _AtHand()
