"""Digests: what a recording holds, what is asked of it, and which program answers."""

from __future__ import annotations

import dataclasses
import hashlib
from collections.abc import Iterator, Mapping
from functools import cache
from importlib import resources
from importlib.resources.abc import Traversable
from pathlib import Path
from typing import Any

import numpy as np

from varishold.errors import InputError, reason_of
from varishold.files import open_file

__all__ = ["content_digest", "digest_of", "files_of", "program_digest"]

_BYTES = 16
_BLOCK = 1 << 22
# What of the package an answer depends on.
_CODE = (".py", ".so", ".dll", ".dylib", ".npz", ".toml")


def content_digest(path: str) -> str:
    """Return a digest of all bytes of a file, or of the files of a folder, and of the ending of its name.

    Raises
    ------
    InputError
        If it cannot be read.
    """
    file = Path(path)
    digest = hashlib.blake2b(file.suffix.lower().encode("utf-8", "replace"), digest_size=_BYTES)
    for each in files_of(file):
        if each != file:
            digest.update(digest_of(str(each.relative_to(file))).encode())
        with open_file(each) as opened:
            try:
                while block := opened.read(_BLOCK):
                    digest.update(block)
            except OSError as error:
                raise InputError(f"{each}: cannot be read: {reason_of(error)}") from error
    return digest.hexdigest()


def files_of(path: Path) -> list[Path]:
    """Return the files of a recording: those of a folder and of the folders in it, or the one."""
    return sorted(each for each in path.rglob("*") if each.is_file()) if path.is_dir() else [path]


def digest_of(*values: Any) -> str:
    """Return a digest of plain values, arrays, and dataclasses of such.

    Examples
    --------
    >>> digest_of(1.0, "a") == digest_of(1.0, "a"), digest_of(1.0) == digest_of(1)
    (True, False)
    """
    digest = hashlib.blake2b(digest_size=_BYTES)
    for piece in _pieces(values):
        digest.update(len(piece).to_bytes(8, "little") + piece)
    return digest.hexdigest()


@cache
def program_digest() -> str:
    """Return a digest of the package's own code and parameters: another version may answer otherwise."""
    digest = hashlib.blake2b(digest_size=_BYTES)
    for name, file in sorted(_code(resources.files("varishold"), "")):
        digest.update(digest_of(name, file.read_bytes()).encode())
    return digest.hexdigest()


def _code(folder: Traversable, within: str) -> Iterator[tuple[str, Traversable]]:
    for each in folder.iterdir():
        name = f"{within}/{each.name}"
        if each.is_dir():
            yield from _code(each, name)
        elif each.name.endswith(_CODE):
            yield name, each


def _pieces(value: Any) -> Iterator[bytes]:
    """Yield the bytes of a value, so that no two values yield the same."""
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        yield type(value).__qualname__.encode()
        for field in dataclasses.fields(value):
            yield from _pieces((field.name, getattr(value, field.name)))
    elif isinstance(value, np.ndarray):
        yield f"{value.dtype.str}{value.shape}".encode()
        yield np.ascontiguousarray(value).tobytes()
    elif isinstance(value, Mapping):
        yield from _pieces(tuple(value.items()))
    elif isinstance(value, (tuple, list)):
        yield f"{len(value)} values".encode()
        for each in value:
            yield from _pieces(each)
    elif isinstance(value, bytes):
        yield value
    else:
        yield f"{type(value).__name__} {value!r}".encode()
