"""The recognizer of touch as source for a controller.

`WRITERS` is the registry: a writer takes an `Export` and returns the files by name.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path
from typing import Final

from varishold.errors import InputError
from varishold.files import write_texts
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
    return write_texts(directory, WRITERS[to](wanted), check=check)
