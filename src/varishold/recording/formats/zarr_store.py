"""Where the pieces of a Zarr data set stand: in the files of a folder, or as the members of a ZIP archive."""

from __future__ import annotations

import os
import zipfile
from collections.abc import Iterator
from functools import cached_property
from pathlib import Path
from typing import Protocol

from varishold.errors import FormatError, InputError, reason_of
from varishold.files import damage_told, open_file

__all__ = ["FolderStore", "Store", "ZipStore"]

# Members of an archive; one that unpacks to so many times its bytes, if they are more than this, is no data set.
_MOST_MEMBERS, _LARGE, _BOMB_RATIO = 1 << 20, 1 << 28, 300


class Store(Protocol):
    """Bytes by keys, whose parts are parted by slashes."""

    source: str

    def groups(self, key: str) -> Iterator[str]:
        """Yield the names of what stands under a key and has something under it."""
        ...

    def size(self, key: str) -> int | None:
        """Return how many bytes stand there; None where there is nothing."""
        ...

    def read(self, key: str, most: int) -> bytes:
        """Return the bytes that stand there; raises FormatError where they are more than `most`."""
        ...

    def part(self, key: str, start: int, n_bytes: int) -> bytes:
        """Return so many of the bytes that stand there, or as many as there are."""
        ...

    def place(self, key: str) -> str:
        """Return what a message calls a key."""
        ...

    def close(self) -> None:
        """Let it go. May be called again."""
        ...


class FolderStore:
    """The files of a folder.

    Parameters
    ----------
    path : Path
    """

    def __init__(self, path: Path) -> None:
        self.source = str(path)
        self._path = path

    def groups(self, key: str) -> Iterator[str]:
        try:
            with os.scandir(self._path / key) as entries:
                # Links lead elsewhere, and maybe back.
                yield from sorted(entry.name for entry in entries if entry.is_dir(follow_symlinks=False))
        except OSError as error:
            raise InputError(f"{self.place(key)}: cannot be read: {reason_of(error)}") from error

    def size(self, key: str) -> int | None:
        try:
            return os.stat(self._path / key).st_size
        except OSError:
            return None

    def read(self, key: str, most: int) -> bytes:
        with open_file(self._path / key) as file:
            content = file.read(most + 1)
        return _bounded(self.place(key), content, most)

    def part(self, key: str, start: int, n_bytes: int) -> bytes:
        with open_file(self._path / key) as file:
            file.seek(start)
            return file.read(n_bytes)

    def place(self, key: str) -> str:
        return str(self._path / key)

    def close(self) -> None:
        """There is nothing to let go."""


class ZipStore:
    """The members of an archive.

    Parameters
    ----------
    path : Path

    Raises
    ------
    InputError
        If it cannot be opened.
    FormatError
        If it is damaged, or holds a name twice.
    """

    def __init__(self, path: Path) -> None:
        self.source = str(path)
        self._file = open_file(path)
        try:
            with damage_told(self.source):
                self._archive = zipfile.ZipFile(self._file)
                members = [each for each in self._archive.infolist() if not each.is_dir()]
                if len(members) > _MOST_MEMBERS:
                    raise FormatError(f"{path}: holds {len(members)} members; at most {_MOST_MEMBERS} are read")
                self._members = {each.filename: each for each in members}
                if len(self._members) < len(members):
                    raise FormatError(f"{path}: holds a name twice, and nobody can know which is meant")
                self._check()
        except BaseException:
            self._file.close()
            raise

    @cached_property
    def _under(self) -> dict[str, set[str]]:
        found: dict[str, set[str]] = {}
        for name in self._members:
            parts = name.split("/")
            for k in range(1, len(parts)):
                found.setdefault("/".join(parts[: k - 1]), set()).add(parts[k - 1])
        return found

    def groups(self, key: str) -> Iterator[str]:
        yield from sorted(self._under.get(key, ()))

    def size(self, key: str) -> int | None:
        return self._members[key].file_size if key in self._members else None

    def read(self, key: str, most: int) -> bytes:
        with damage_told(self.place(key)), self._archive.open(self._member(key)) as opened:
            return _bounded(self.place(key), opened.read(most + 1), most)

    def part(self, key: str, start: int, n_bytes: int) -> bytes:
        with damage_told(self.place(key)), self._archive.open(self._member(key)) as opened:
            opened.seek(start)
            return opened.read(n_bytes)

    def _member(self, key: str) -> zipfile.ZipInfo:
        if key not in self._members:
            raise InputError(f"{self.place(key)}: there is no such member")
        member = self._members[key]
        if member.compress_type not in (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED):
            raise FormatError(f"{self.place(key)}: is packed by way {member.compress_type}, which is not read")
        return member

    def place(self, key: str) -> str:
        return f"{self.source}: {key}"

    def _check(self) -> None:
        """Check every member, whether anybody will ask for it or not."""
        total = sum(member.file_size for member in self._members.values())
        if total > max(_LARGE, _BOMB_RATIO * self._file.seek(0, os.SEEK_END)):
            raise FormatError(f"{self.source}: would unpack to {total} bytes; nothing measured is so empty")
        bad = self._archive.testzip()
        if bad is not None:
            raise FormatError(f"{self.source}: is damaged: the member {bad!r}")

    def close(self) -> None:
        self._archive.close()
        self._file.close()


def _bounded(place: str, content: bytes, most: int) -> bytes:
    if len(content) > most:
        raise FormatError(f"{place}: is larger than {most} bytes; such a piece never is")
    return content
