"""The recognizer of touch as source for a controller.

`WRITERS` is the registry: a writer takes an `Export` and returns the files by name.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path
from typing import Final

from varishold.errors import InputError
from varishold.files import atomic_write
from varishold.touch.writers.c99 import c99_files
from varishold.touch.writers.pad import Export

__all__ = ["WRITERS", "Export", "c99_files", "export"]

WRITERS: Final[dict[str, Callable[[Export], dict[str, str]]]] = {"c": c99_files}


def export(
    wanted: Export, to: str, directory: str | os.PathLike[str], *, check: Callable[[Path], None] | None = None
) -> list[Path]:
    """Write a recognizer's source files into a folder, which is made where it is missing.

    Parameters
    ----------
    wanted : Export
    to : str
        A key of `WRITERS`.
    directory : path-like
    check : callable, optional
        Called with the path of every file before the first is written; it may refuse.

    Returns
    -------
    list of Path
        The files written.

    Raises
    ------
    InputError
        Where there is no such writer, or the folder cannot be written.
    """
    if to not in WRITERS:
        raise InputError(f"no writer called {to!r}; known are {', '.join(WRITERS)}")
    files = WRITERS[to](wanted)
    folder = Path(directory)
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"{folder}: cannot be made a folder: {error.strerror or error}") from None
    paths = {folder / name: text for name, text in files.items()}
    if check is not None:
        for path in paths:
            check(path)
    for path, text in paths.items():
        with atomic_write(path, "w") as handle:
            handle.write(text)
    return list(paths)
