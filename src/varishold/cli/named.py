"""The files that a name stands for: a file, a folder, a pattern, or standard input."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path

__all__ = ["recordings_named", "table_files"]


def recordings_named(name: str, wanted: Callable[[Path], bool]) -> list[str]:
    """Return the recordings that a name stands for; of the files in a folder those that are wanted."""
    from varishold.files import input_files
    from varishold.recording import FORMATS
    from varishold.recording.formats import is_folder

    if is_folder(name):
        return [name]
    endings = [ending for known in FORMATS.values() for ending in known.suffixes] if os.path.isdir(name) else []
    return input_files([name], endings=endings, whole=partial(is_folder, marked=True), wanted=wanted)


def table_files(names: Sequence[str]) -> list[str]:
    """Return the grasp tables that are named; of a folder, those that end in .csv."""
    from varishold.files import input_files

    return input_files(names, endings=[".csv"])
