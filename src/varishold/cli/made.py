"""What this program has made of recordings, and lies in a folder with them: models, tables, the maps of sensors."""

from __future__ import annotations

import sys
from collections.abc import Callable
from functools import cache
from pathlib import Path

from varishold.cli.printing import printable
from varishold.errors import InputError

__all__ = ["Others"]

# Kinds of files, by `varishold.files.KINDS`, that are made of recordings and read as none.
_MADE = ("model", "learned", "table")
_MOST_TOLD = 4


class Others:
    """Keeps what is no recording apart from what is."""

    def __init__(self) -> None:
        self._left: list[str] = []
        self._maps: Callable[[Path], frozenset[Path]] = cache(_maps_in)

    def is_recording(self, path: Path) -> bool:
        """Tell of a file in a folder whether it may be a recording; what is none is kept in mind."""
        try:
            made = path in self._maps(path.parent) or _is_made(path)
        except (InputError, OSError):
            # Whoever reads it tells why it cannot be.
            made = False
        if made:
            self._left.append(str(path))
        return not made

    def tell(self) -> None:
        """Say what was left out."""
        if self._left:
            beyond = len(self._left) - _MOST_TOLD
            names = ", ".join(self._left[:_MOST_TOLD]) + (f" and {beyond} more" if beyond > 0 else "")
            words = f"note: {names} left out: no recordings, but what was made of them"
            print(f"varishold: {printable(words)}", file=sys.stderr)


def _maps_in(folder: Path) -> frozenset[Path]:
    """Return the files that the sensor files of a folder name."""
    from varishold.sensor import named_files

    return frozenset(file for each in folder.glob("*.toml") for file in named_files(each))


def _is_made(path: Path) -> bool:
    from varishold.files import KINDS

    return path.stat().st_size > 0 and any(KINDS[kind].recognizes(path) for kind in _MADE)
