"""What this program has made of recordings, and lies in a folder with them: models, tables, libraries, maps."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Sequence
from functools import cache
from pathlib import Path

from varishold.cli.printing import tell
from varishold.errors import InputError
from varishold.files import each_once, head_lines, open_file
from varishold.files.outputs import kind_made

__all__ = ["Others"]

_MOST_TOLD = 4
# So much of a text is looked at, and a line of numbers begins with one.
_HEAD = 1 << 16
_NUMBERS = re.compile(r"\s*[\"']?[-+]?\.?\d")


class Others:
    """Keeps what is no recording apart from what is."""

    def __init__(self) -> None:
        self._left: list[str] = []
        self._prose: list[str] = []
        self._again: list[str] = []
        self._maps: Callable[[Path], frozenset[Path]] = cache(_maps_in)

    def is_recording(self, path: Path) -> bool:
        """Tell of a file in a folder whether it may be a recording; what is none is kept in mind."""
        try:
            made = path in self._maps(path.parent) or kind_made(path) is not None
        except (InputError, OSError):
            # Whoever reads it tells why it cannot be.
            made = False
        if made:
            self._left.append(str(path))
            return False
        if _is_prose(path):
            self._prose.append(str(path))
            return False
        return True

    def each_once(self, paths: Iterable[str]) -> list[str]:
        """Return recordings, each under its first name; the others are kept in mind."""
        kept, again = each_once(paths)
        self._again += again
        return kept

    def tell(self) -> None:
        """Say what was left out."""
        _tell(self._left, "no recordings, but what was made of them")
        _tell(self._prose, "no recordings, but text without a line of numbers")
        _tell(self._again, "files that are read by another name")


def _tell(left: Sequence[str], why: str) -> None:
    if left:
        beyond = len(left) - _MOST_TOLD
        names = ", ".join(left[:_MOST_TOLD]) + (f" and {beyond} more" if beyond > 0 else "")
        tell(f"note: {names} left out: {why}")


def _maps_in(folder: Path) -> frozenset[Path]:
    """Return the files that the sensor files of a folder name."""
    from varishold.sensor import named_files

    return frozenset(file for each in folder.glob("*.toml") for file in named_files(each))


def _is_prose(path: Path) -> bool:
    """Tell of a text file whether none of its first lines begins as numbers do: a note beside recordings."""
    if path.suffix.lower() != ".txt":
        return False
    try:
        with open_file(path) as file:
            head = file.read(_HEAD)
    except (InputError, OSError):
        return False
    lines = head_lines(head)
    return any(map(str.strip, lines)) and not any("\0" in line or _NUMBERS.match(line) for line in lines)
