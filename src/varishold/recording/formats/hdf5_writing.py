"""Writing HDF5 so that what the disk refuses, or who asks to end, is an error and no crash.

HDF5 writes what it still holds when it closes a file, and again when it is let go. Where that fails the process dies.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from typing import Any, BinaryIO

from varishold._lazy import missing_extra
from varishold.files import atomic_write

__all__ = ["Pieces", "write_hdf5"]

#: Gives the slices in which so many entries are to be written, so many at once.
Pieces = Callable[[int, int], Iterator[slice]]


def write_hdf5(
    path: str | os.PathLike[str], fill: Callable[[Any, Pieces], None], *, head: bytes = b"", userblock_size: int = 0
) -> None:
    """Write an HDF5 file, whole or not at all.

    Parameters
    ----------
    path : str or path-like
    fill : callable
        Called with the h5py.File and `Pieces`; what is large it writes in these, which end where the disk is full.
    head : bytes
        What stands before all else, in the user block.
    userblock_size : int
        Bytes of the user block.

    Raises
    ------
    InputError
        If it cannot be written there.
    MissingExtraError
        If h5py is not installed.
    """
    try:
        import h5py
    except ModuleNotFoundError as error:
        raise missing_extra(error) from None

    def write(kept: _Kept) -> None:
        try:
            with h5py.File(kept, "w", userblock_size=userblock_size, track_order=True) as file:
                fill(file, kept.pieces)
        finally:
            kept.check()

    with atomic_write(path) as binary:
        kept = _Kept(binary)
        # Signals are heard by the main thread alone: none is raised inside of HDF5.
        with ThreadPoolExecutor(1) as thread:
            try:
                thread.submit(write, kept).result()
            except BaseException as error:
                kept.error = kept.error or error
                raise
        binary.seek(0)
        binary.write(head)


class _Kept:
    """A file that HDF5 never sees fail: it keeps the first error for the writer, and takes nothing from then on."""

    def __init__(self, file: BinaryIO) -> None:
        self._file = file
        self.error: BaseException | None = None

    def check(self) -> None:
        """Raise the error that was kept."""
        if self.error is not None:
            raise self.error

    def pieces(self, length: int, many: int) -> Iterator[slice]:
        """Return the slices of `Pieces`; raise the error that was kept before each."""
        for begun in range(0, length, many):
            self.check()
            yield slice(begun, begun + many)

    def _tried(self, act: Callable[..., int | None], *given: Any) -> int:
        if self.error is None:
            try:
                return act(*given) or 0
            except Exception as error:
                self.error = error
        return 0

    def seek(self, offset: int, whence: int = os.SEEK_SET) -> int:
        return self._tried(self._file.seek, offset, whence)

    def tell(self) -> int:
        return self._tried(self._file.tell)

    def read(self, size: int = -1) -> bytes:
        """By this method h5py knows a file; it calls `readinto`."""
        return self._file.read(size)

    def readinto(self, buffer: Any) -> int:
        n = self._tried(self._file.readinto, buffer)  # type: ignore[attr-defined]
        # What was not written is read as zeros.
        memoryview(buffer)[n:] = bytes(len(buffer) - n)
        return len(buffer)

    def write(self, data: Any) -> int:
        self._tried(self._file.write, data)
        return len(data)

    def truncate(self, size: int) -> int:
        return self._tried(self._file.truncate, size)

    def flush(self) -> None:
        self._tried(self._file.flush)
