"""Writing a file so that a reader finds the old one or the new one, never half of one."""

from __future__ import annotations

import errno
import os
import stat
from collections.abc import Callable, Iterator, Mapping
from contextlib import AbstractContextManager, ExitStack, contextmanager, suppress
from functools import cache
from pathlib import Path
from shutil import rmtree
from typing import IO, Any, BinaryIO, Literal, TextIO, overload

from varishold.errors import FULL_DISK, InputError, reason_of
from varishold.files.locking import lock

__all__ = [
    "atomic_write",
    "cannot_write",
    "folder_beside",
    "no_folder",
    "part_beside",
    "try_to_write",
    "writable_target",
    "write_texts",
]

# Names of files that are not complete yet.
_PREFIX, _ENDING = ".varishold-", ".part"

# A full or failing disk shows inside the caller's own writes; every other OSError there is the caller's.
_DISK_ERRORS = (*FULL_DISK, errno.EIO)


@overload
def atomic_write(path: str | os.PathLike[str], mode: Literal["wb"] = "wb") -> AbstractContextManager[BinaryIO]: ...
@overload
def atomic_write(path: str | os.PathLike[str], mode: Literal["w"]) -> AbstractContextManager[TextIO]: ...
def atomic_write(path: str | os.PathLike[str], mode: Literal["w", "wb"] = "wb") -> AbstractContextManager[Any]:
    """Open a file for writing that takes the place of `path` only when all of it is written.

    The bytes go to a new file beside `path`, which replaces `path` when the block ends; if the block
    raises, the new file is removed and `path` stays as it was. A link is followed, the permissions of a
    file that is replaced are kept, and what is no regular file (a pipe, /dev/stdout) is written directly.

    Parameters
    ----------
    path : str or path-like
        The file to write. Its folder must exist.
    mode : {"wb", "w"}
        Bytes, or UTF-8 text without newline translation.

    Returns
    -------
    context manager of a file object
        Its ``name`` is the path of the temporary file.

    Raises
    ------
    InputError
        If the file cannot be written there.

    Examples
    --------
    >>> import tempfile
    >>> from pathlib import Path
    >>> from varishold.files import atomic_write
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     with atomic_write(Path(folder, "note.txt"), "w") as file:
    ...         _ = file.write("pressed")
    ...     Path(folder, "note.txt").read_text()
    'pressed'
    """
    return _atomic_write(Path(path), mode)


@contextmanager
def _atomic_write(path: Path, mode: Literal["w", "wb"]) -> Iterator[IO[Any]]:
    target, special = writable_target(path)
    permissions = _permissions(target)
    try:
        handle, written = (_open(target, mode, "w"), target) if special else part_beside(target, mode)
    except (OSError, ValueError) as error:
        raise cannot_write(path, error) from error
    try:
        with handle:
            yield handle
            handle.flush()
            if not special:
                os.fsync(handle.fileno())
        if not special:
            if permissions is not None:
                os.chmod(written, permissions)
            os.replace(written, target)
    except BaseException as error:
        if not special:
            with suppress(OSError):
                written.unlink(missing_ok=True)
        if isinstance(error, OSError) and (error.errno in _DISK_ERRORS or error.filename == str(written)):
            raise cannot_write(path, error) from error
        raise


def writable_target(path: Path) -> tuple[Path, bool]:
    """Return the file that a path leads to, and whether it is there and no regular file.

    Raises
    ------
    InputError
        If it is a folder, or in none.
    """
    try:
        target = path.resolve()
        _permissions(target)
    except NotADirectoryError:
        raise no_folder(path, path.absolute().parent) from None
    except (OSError, RuntimeError, ValueError) as error:
        raise cannot_write(path, error) from error
    if target.is_dir():
        raise InputError(f"{path}: cannot write here: it is a folder; name a file")
    if not target.parent.is_dir():
        raise no_folder(path, target.parent)
    return target, target.exists() and not target.is_file()


def no_folder(path: str | os.PathLike[str], folder: Path) -> InputError:
    """Return what is said of a file that would stand in a folder which is none."""
    for each in (folder, *folder.parents):
        if os.path.exists(each) and not os.path.isdir(each):
            return InputError(f"{path}: cannot write here: {each} is a file and no folder; name another")
    return InputError(f"{path}: cannot write here: there is no folder {folder}; make it first")


def _permissions(target: Path) -> int | None:
    try:
        return stat.S_IMODE(target.stat().st_mode)
    except FileNotFoundError:
        return None


def part_beside(target: Path, mode: Literal["w", "wb"]) -> tuple[IO[Any], Path]:
    """Open a new file beside the target, locked as long as it is written."""
    _sweep(target.parent)
    while True:
        # A name of its own length: the target's may already be as long as the file system allows.
        written = target.with_name(f"{_PREFIX}{os.urandom(8).hex()}{_ENDING}")
        handle = _open(written, mode, "x")
        with suppress(OSError):  # a file system without locks: nothing is swept there
            lock(handle.fileno(), wait=True)
        if os.fstat(handle.fileno()).st_nlink:
            return handle, written
        handle.close()  # swept before it was locked


def try_to_write(path: Path) -> None:
    """Begin a file where `path` leads, and remove it: who may write there is known to the system alone.

    Raises
    ------
    InputError
        If none can be made there.
    """
    target, _ = writable_target(path)
    try:
        handle, written = part_beside(target, "wb")
        handle.close()
        written.unlink(missing_ok=True)
    except OSError as error:
        raise cannot_write(path, error) from error


@contextmanager
def folder_beside(target: Path) -> Iterator[Path]:
    """Make an empty folder beside the target, which goes with the block, or with the next writer where this one dies.

    Raises
    ------
    OSError
        If nothing can be made there.
    """
    handle, mark = part_beside(target, "wb")
    folder = mark.with_suffix("")
    try:
        with handle:
            folder.mkdir()
            yield folder
    finally:
        rmtree(folder, ignore_errors=True)
        mark.unlink(missing_ok=True)


@cache
def _sweep(folder: Path) -> None:
    """Remove, once in a process, what writers that were killed have left in a folder."""
    with suppress(OSError), os.scandir(folder) as entries:
        for entry in entries:
            if entry.name.startswith(_PREFIX) and entry.name.endswith(_ENDING):
                with suppress(OSError), open(entry.path, "rb") as left:
                    lock(left.fileno(), wait=False)
                    # The folder that it marks, if any.
                    rmtree(entry.path.removesuffix(_ENDING), ignore_errors=True)
                    os.unlink(entry.path)


def _open(path: Path, mode: Literal["w", "wb"], how: Literal["w", "x"]) -> IO[Any]:
    if mode == "wb":
        # HDF5 reads again what it wrote, once a file has more parts than it keeps in mind; a pipe cannot be read.
        return open(path, f"{how}+b" if how == "x" else f"{how}b")
    # Half a surrogate pair, which no file can hold, is written as its code.
    return open(path, how, encoding="utf-8", errors="backslashreplace", newline="")


def cannot_write(path: Path, error: Exception) -> InputError:
    """Return the error to raise where a system's error keeps a file from being written."""
    return InputError(f"{path}: cannot write here: {reason_of(error)}")


def write_texts(
    directory: str | os.PathLike[str], texts: Mapping[str, str], *, check: Callable[[Path], None] | None = None
) -> list[Path]:
    """Write texts that belong together into a folder, which is made where it is missing; return the files written.

    All are written beside their places first. What stood in their places goes before the first one comes there, so that
    what a stop leaves is the old ones, or some of the new ones alone, and never some of both.

    Parameters
    ----------
    directory : path-like
    texts : mapping of str to str
        By file name.
    check : callable, optional
        Called with the path of every file before the first is written; it may refuse.

    Raises
    ------
    InputError
        Where the folder cannot be made, or a file not be written.
    """
    folder = Path(directory)
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        why = "it is a file; name a folder" if folder.is_file() else reason_of(error)
        raise InputError(f"{folder}: cannot be made a folder: {why}") from None
    files = {folder / name: text for name, text in texts.items()}
    if check is not None:
        for path in files:
            check(path)
    with ExitStack() as parts:
        for path, text in files.items():
            handle = parts.enter_context(atomic_write(path, "w"))
            handle.write(text)
            # A full disk shows here.
            handle.flush()
        for path in files:
            target, special = writable_target(path)
            try:
                if not special:
                    target.unlink(missing_ok=True)
            except OSError as error:
                raise cannot_write(path, error) from error
    return list(files)
