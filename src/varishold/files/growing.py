"""A file that is written for hours, of which everything but the last moments is there whenever its writer dies."""

from __future__ import annotations

import os
import time
from collections import deque
from collections.abc import Iterator
from contextlib import contextmanager, nullcontext, suppress
from pathlib import Path
from threading import Condition, Thread
from typing import IO, Any

from varishold.errors import InputError
from varishold.files.resume import only_writer
from varishold.files.writing import cannot_write, part_beside, writable_target

__all__ = ["GrowingFile", "growing_file"]

# What was written is asked to be on the disk itself so often, for machines that lose their power; a process that is
# killed loses nothing of it anyway. Seconds.
_SYNC_S = 2.0
# So many bytes may wait for a slow disk; then whoever writes waits too.
_MOST_WAITING = 1 << 28


class GrowingFile:
    """A binary file whose writer does not wait for the disk; as `growing_file` opens it.

    A thread writes what it is given, in its order. What the disk refuses, and that the file was taken away, is told by
    the next call.
    """

    def __init__(self, path: Path, written: Path, target: Path, file: IO[Any]) -> None:
        self._path, self._written, self._target, self._file = path, written, target, file
        self._on_disk = written.is_file()
        self._given = self._n_waiting = 0
        self._waiting: deque[bytes] = deque()
        self._changed = Condition()
        self._over = False
        self._failure: OSError | InputError | None = None
        self._thread = Thread(target=self._run, name=f"varishold writes {path}", daemon=True)
        self._thread.start()

    @property
    def shown(self) -> bool:
        """Whether the file is where it was asked for."""
        return self._written == self._target

    def write(self, data: bytes) -> int:
        """Give the bytes to be written next.

        Raises
        ------
        InputError
            If the disk has refused some that were given before.
        """
        with self._changed:
            self._changed.wait_for(lambda: self._n_waiting < _MOST_WAITING or self._failure is not None)
            self._check()
            self._waiting.append(bytes(data))
            self._n_waiting += len(data)
            self._given += len(data)
            self._changed.notify_all()
        return len(data)

    def tell(self) -> int:
        """Return how many bytes were given so far."""
        return self._given

    def flush(self) -> None:
        """Do nothing: what is given is written at once."""

    def show(self) -> None:
        """Put the file where it was asked for, in place of what is there; what follows goes on growing.

        Raises
        ------
        InputError
            If the disk refuses it.
        """
        self._drain()
        try:
            os.replace(self._written, self._target)
        except OSError as error:
            raise cannot_write(self._path, error) from error
        self._written = self._target

    def close(self) -> None:
        """Write what waits, and end; remove what was never shown. Never raises, and may be called twice."""
        with self._changed:
            self._over = True
            self._changed.notify_all()
        self._thread.join()
        with suppress(OSError):
            self._file.close()
        if not self.shown:
            with suppress(OSError):
                self._written.unlink()

    def finish(self) -> None:
        """Wait until all is written; InputError where the file is not where it was asked for any more."""
        self._drain()
        self._look_there()

    def _drain(self) -> None:
        """Wait until all that was given is written."""
        with self._changed:
            self._changed.wait_for(lambda: self._n_waiting == 0 or self._failure is not None)
            self._check()

    def _check(self) -> None:
        if isinstance(self._failure, InputError):
            raise self._failure
        if self._failure is not None:
            raise cannot_write(self._path, self._failure) from self._failure

    def _look_there(self) -> None:
        """Raise InputError where what is written can be found under its name no more."""
        if not (self._on_disk and self.shown):
            return
        try:
            named, written = self._written.stat(), os.fstat(self._file.fileno())
            # Not every disk numbers its files for good.
            there = os.path.samestat(named, written) or named.st_size == written.st_size
        except OSError:
            there = False
        if not there:
            raise InputError(f"{self._path}: was moved, replaced or removed while it was written; it grows no more")

    def _run(self) -> None:
        synced_s, dirty = time.monotonic(), False
        while True:
            with self._changed:
                self._changed.wait_for(lambda: self._waiting or self._over, _SYNC_S)
                data, over = b"".join(self._waiting), self._over
                self._waiting.clear()
            try:
                self._file.write(data)
                self._file.flush()
                dirty = dirty or bool(data)
                if dirty and (over or time.monotonic() - synced_s >= _SYNC_S):
                    self._sync()
                    synced_s, dirty = time.monotonic(), False
            except (OSError, InputError) as error:
                self._failure = error
            with self._changed:
                self._n_waiting -= len(data)
                self._changed.notify_all()
                if self._failure is not None or (over and not self._waiting):
                    return

    def _sync(self) -> None:
        # What is no file on a disk cannot be asked for it.
        if self._on_disk:
            os.fsync(self._file.fileno())
            self._look_there()


@contextmanager
def growing_file(path: str | os.PathLike[str]) -> Iterator[GrowingFile]:
    """Open a file that grows, for one process alone; nothing is there before `GrowingFile.show` is called.

    Raises
    ------
    InputError
        If it cannot be written there, or another process writes it.
    """
    asked = Path(path)
    target, special = writable_target(asked)
    with nullcontext() if special else only_writer(asked):
        try:
            file, written = (target.open("wb"), target) if special else part_beside(target, "wb")
        except OSError as error:
            raise cannot_write(asked, error) from error
        growing = GrowingFile(asked, written, target, file)
        try:
            yield growing
            growing.finish()
        finally:
            growing.close()
