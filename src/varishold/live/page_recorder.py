"""Recordings that are begun and ended at the page."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from contextlib import suppress
from itertools import chain, count
from pathlib import Path
from threading import Lock, Thread
from typing import Any

from varishold._counted import counted
from varishold.errors import InputError, VarisholdError
from varishold.live.recorder import Recorder
from varishold.live.stream import Stream

__all__ = ["PageRecorder", "free_path"]


class PageRecorder:
    """Writes what a stream brings into a folder, one file from each beginning to its end.

    Parameters
    ----------
    stream : Stream
    folder : str or path-like
        Where the files are written; they are named after the time.
    tell : callable
        Called with whether it went well, and words.
    sensor : str
        What the sensor is called.
    files : mapping of str to str, optional
        The texts of the sensor file and its maps, by name.
    """

    def __init__(
        self,
        stream: Stream,
        folder: str | Path,
        tell: Callable[[bool, str], object],
        *,
        sensor: str = "",
        files: Mapping[str, str] | None = None,
    ) -> None:
        self._stream, self._folder, self._tell = stream, Path(folder), tell
        self._sensor, self._files = sensor, files
        self._lock = Lock()
        self._recorder: Recorder | None = None
        self._path = Path()
        self._ending: Thread | None = None

    def begin(self, label: str | None) -> Path:
        """Begin a file with what comes from now on; return its path.

        Raises
        ------
        InputError
            If one is being written.
        """
        with self._lock:
            if self._recorder is not None:
                raise InputError(f"{self._path.name} is being written; end it first")
            self._path = free_path(self._folder, ".mcap")
            recorder = Recorder(self._stream, self._path, sensor=self._sensor, files=self._files, from_now=True)
            if label is not None:
                recorder.mark(label)
            self._recorder = recorder.start()
            return self._path

    def end(self) -> None:
        """End the file; what became of it is told when all is written.

        Raises
        ------
        InputError
            If none is being written.
        """
        with self._lock:
            if self._recorder is None:
                raise InputError("nothing is being written")
            recorder, self._recorder = self._recorder, None
            self._ending = Thread(target=self._end, args=(recorder, self._path), name="varishold ends a recording")
            self._ending.start()

    def mark(self, label: str | None) -> None:
        """Say what is felt from now on; None for nothing of a name."""
        with self._lock:
            if self._recorder is not None:
                self._recorder.mark(label or "")

    def zeroed(self, entry: Mapping[str, Any]) -> None:
        """Say that a zero was taken or refused."""
        with self._lock:
            if self._recorder is not None:
                self._recorder.zeroed(entry)

    def to_dict(self) -> dict[str, Any] | None:
        """Return what is being written; None where nothing is."""
        with self._lock:
            recorder = self._recorder
            if recorder is None:
                return None
            tally = recorder.tally
            return {"file": self._path.name, "frames": tally.samples, "missed": recorder.missed}

    def look(self) -> None:
        """End a file that can no longer be written, as on a full disk; to be called now and then."""
        with self._lock:
            over = self._recorder is not None and self._recorder.wait(0.0)
        if over:
            # Somebody else may have ended it meanwhile.
            with suppress(InputError):
                self.end()

    def close(self) -> None:
        """End what is being written, and wait for it."""
        with self._lock:
            writes = self._recorder is not None
        if writes:
            with suppress(InputError):
                self.end()
        if self._ending is not None:
            self._ending.join()

    def _end(self, recorder: Recorder, path: Path) -> None:
        try:
            recorder.close()
        except VarisholdError as error:
            self._tell(False, f"recording failed: {error}")
            return
        tally = recorder.tally
        if not tally.samples:
            self._tell(False, "recording ended: nothing came")
            return
        missed = f", {recorder.missed} came too fast" if recorder.missed else ""
        lost = f", {tally.lost} never came" if tally.lost else ""
        self._tell(True, f"{path}: {counted(tally.samples, 'reading')} in {tally.seconds:.1f}\u202fs{missed}{lost}")


def free_path(folder: Path, ending: str) -> Path:
    """Return a path in a folder that is named after the time, where nothing is yet."""
    stem = time.strftime("varishold-%Y%m%d-%H%M%S")
    paths = chain([folder / f"{stem}{ending}"], (folder / f"{stem}-{k}{ending}" for k in count(2)))
    return next(path for path in paths if not path.exists())
