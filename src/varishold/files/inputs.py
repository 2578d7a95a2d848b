"""The files that a person names: one, several, those of a folder, those of a pattern, or standard input."""

from __future__ import annotations

import fnmatch
import glob
import os
from collections import Counter
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path

from varishold.errors import InputError

__all__ = ["each_once", "input_files"]

# Endings that a message names at most.
_TOLD = 4


def input_files(
    names: Iterable[str | os.PathLike[str]],
    *,
    endings: Iterable[str] = (),
    whole: Callable[[str], bool] = lambda folder: False,
    wanted: Callable[[Path], bool] = lambda file: True,
) -> list[str]:
    """Return the files that some names stand for, each once, in the order of the names.

    Parameters
    ----------
    names : iterable of str or path-like
        Files; ``-`` for standard input; folders, for the files in them and below; patterns as a shell knows them,
        ``**`` included.
    endings : iterable of str
        Endings, in lower case, of the files that are taken from folders. Default: all.
    whole : callable
        Tells of a folder that is found whether it is taken as one, and not looked into. Default: none is.
    wanted : callable
        Tells of a file that is found in a folder whether it is taken. Default: each is.

    Raises
    ------
    InputError
        If a folder holds no such file, or a pattern matches none.
    """
    known = tuple(endings)
    found: dict[str, None] = {}
    for given in names:
        name = os.fspath(given)
        if os.path.isdir(name):
            folder = Path(name)
            shown = (path for path in sorted(_within(folder, known, whole)) if _shown(path.relative_to(folder)))
            here = [str(path) for path in shown if path.is_dir() or wanted(path)]
            if not here:
                raise InputError(
                    f"{name}: is a folder without a file to read ({', '.join(known) or 'it is empty'}){_held(folder)}"
                )
        elif glob.has_magic(name) and not os.path.lexists(name):
            matched = {str(path) for path in _matching(Path(name))}
            here = sorted(path for path in matched if os.path.isfile(path) or (os.path.isdir(path) and whole(path)))
            if not here:
                raise InputError(f"{name}: no file matches")
        else:
            here = [name]
        found.update(dict.fromkeys(here))
    return list(found)


def each_once(paths: Iterable[str]) -> tuple[list[str], list[str]]:
    """Return paths, of a file that has several names the first alone, and those that are left out.

    Links, and other ways to the same folder, are other names. What is no file keeps its name.
    """
    kept: dict[object, str] = {}
    left = []
    for path in dict.fromkeys(paths):
        if kept.setdefault(_identity(path), path) != path:
            left.append(path)
    return list(kept.values()), left


def _identity(path: str) -> object:
    """Return what all names of a file have in common."""
    try:
        found = os.stat(path)
    except (OSError, ValueError):
        return path
    # Some file systems number no files.
    return (found.st_dev, found.st_ino) if found.st_ino else os.path.realpath(path)


def _matching(pattern: Path) -> Iterator[Path]:
    """Yield what matches a pattern, as `glob.glob` does; but no way leads by links to a folder that it has been in.

    Through three links that lead round there are more ways than can be walked, and what is found so is found without.
    """
    anchor = Path(pattern.anchor)
    return _below(anchor, pattern.relative_to(anchor).parts, frozenset([os.path.realpath(anchor)]))


def _below(folder: Path, parts: tuple[str, ...], been: frozenset[str]) -> Iterator[Path]:
    """Yield what matches the parts of a pattern from a folder on; `been`: the folders on the way to it."""
    part, rest = parts[0], parts[1:]
    if not glob.has_magic(part):
        entries = [folder / part] if os.path.lexists(folder / part) else []
    elif part == "**":
        if rest:
            yield from _below(folder, rest, been)
        entries = [entry for entry in _entries(folder) if not entry.name.startswith(".")]
    else:
        hidden = part.startswith(".")
        entries = [e for e in _entries(folder) if hidden or not e.name.startswith(".")]
        entries = [entry for entry in entries if fnmatch.fnmatch(entry.name, part)]
    for entry in entries:
        if not rest:
            yield entry
        further = parts if part == "**" else rest
        if further and entry.is_dir():
            real = os.path.realpath(entry)
            if real not in been or not glob.has_magic(part):
                yield from _below(entry, further, been | {real})


def _entries(folder: Path) -> list[Path]:
    try:
        return [folder / name for name in os.listdir(folder)]
    except OSError:
        return []


def _within(folder: Path, endings: tuple[str, ...], whole: Callable[[str], bool]) -> Iterator[Path]:
    """Yield the files in a folder and below, and the folders that are taken as one."""
    for top, folders, files in os.walk(folder):
        taken = [name for name in folders if whole(os.path.join(top, name))]
        yield from (Path(top, name) for name in taken)
        folders[:] = [name for name in folders if name not in taken and not name.startswith(".")]
        found = (Path(top, name) for name in files)
        yield from (path for path in found if path.name.lower().endswith(endings or "") and path.is_file())


def _held(folder: Path) -> str:
    """Say how many files of which endings a folder itself holds, the most first; nothing of an empty one."""
    endings = Counter(entry.suffix.lower() or "without ending" for entry in _entries(folder) if entry.is_file())
    told = ", ".join(f"{number} {ending}" for ending, number in endings.most_common(_TOLD))
    return f"; it holds {told}" if told else ""


def _shown(path: Path) -> bool:
    """Tell whether nothing on the way from the folder that was named is hidden."""
    return not any(part.startswith(".") for part in path.parts if part not in (".", ".."))
