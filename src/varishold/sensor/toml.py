"""TOML files of a few kilobytes: what is in them, and what should not be."""

from __future__ import annotations

import os
import tomllib
from collections.abc import Iterable, Sequence
from typing import Any

from varishold.errors import FormatError, InputError
from varishold.files import open_file

__all__ = ["checked_keys", "read_toml"]

# Far more than any sensor needs, maps of taxels included.
_LARGEST_BYTES = 1 << 24


def read_toml(path: str | os.PathLike[str]) -> dict[str, Any]:
    """Return the content of a TOML file.

    Raises
    ------
    InputError
        If the file cannot be opened.
    FormatError
        If it is not TOML, or larger than 16 MiB.
    """
    with open_file(path) as file:
        try:
            text = file.read(_LARGEST_BYTES + 1)
        except OSError as error:
            raise InputError(f"{path}: cannot be read: {(error.strerror or str(error)).lower()}") from error
    if len(text) > _LARGEST_BYTES:
        raise FormatError(
            f"{path}: is larger than {_LARGEST_BYTES >> 20} MiB; put maps of taxels into files of their own"
        )
    try:
        return tomllib.loads(text.decode("utf-8-sig"))
    except (tomllib.TOMLDecodeError, UnicodeDecodeError, RecursionError) as error:
        raise FormatError(f"{path}: not a TOML file: {error}") from error


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
