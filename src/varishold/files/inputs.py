"""The files that a person names: one, several, those of a folder, those of a pattern, or standard input."""

from __future__ import annotations

import glob
import os
from collections.abc import Iterable
from pathlib import Path

from varishold.errors import InputError

__all__ = ["input_files"]


def input_files(names: Iterable[str | os.PathLike[str]], *, endings: Iterable[str] = ()) -> list[str]:
    """Return the files that some names stand for, each once, in the order of the names.

    Parameters
    ----------
    names : iterable of str or path-like
        Files; ``-`` for standard input; folders, for the files in them and below; patterns as a shell knows them,
        ``**`` included.
    endings : iterable of str
        Endings, in lower case, of the files that are taken from folders. Default: all.

    Raises
    ------
    InputError
        If a folder holds no such file, or a pattern matches none.
    """
    wanted = tuple(endings)
    found: dict[str, None] = {}
    for given in names:
        name = os.fspath(given)
        if os.path.isdir(name):
            inside = (path for path in sorted(Path(name).rglob("*")) if path.is_file())
            here = [str(path) for path in inside if _shown(path) and str(path).lower().endswith(wanted or "")]
            if not here:
                raise InputError(f"{name}: is a folder without a file to read ({', '.join(wanted) or 'it is empty'})")
        elif glob.has_magic(name) and not os.path.lexists(name):
            here = sorted(path for path in glob.glob(name, recursive=True) if os.path.isfile(path))
            if not here:
                raise InputError(f"{name}: no file matches")
        else:
            here = [name]
        found.update(dict.fromkeys(here))
    return list(found)


def _shown(path: Path) -> bool:
    return not any(part.startswith(".") for part in path.parts if part not in (".", ".."))
