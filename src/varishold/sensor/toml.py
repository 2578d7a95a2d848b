"""Tables of a TOML file: what should not be in them."""

from __future__ import annotations

import os
from collections.abc import Iterable, Sequence

from varishold.errors import FormatError

__all__ = ["checked_keys"]


def checked_keys(path: str | os.PathLike[str], table: Iterable[str], known: Sequence[str], where: str) -> None:
    """Raise where a table holds a key that nobody knows.

    Raises
    ------
    FormatError
        Naming the keys, where they stand and what is known there.
    """
    unknown = sorted(set(table) - set(known))
    if unknown:
        raise FormatError(f"{path}: unknown key {', '.join(unknown)} in {where}; known are {', '.join(known)}")
