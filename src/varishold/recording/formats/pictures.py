"""Depth pictures: one file, whose pages are frames, or a folder of numbered ones, or a folder with one a pad.

What a number in them is in metres, and which number is rest, a sensor file says.
"""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from varishold._counted import counted
from varishold.errors import FormatError
from varishold.recording.formats.format import Format, Options, read_by, shape_error
from varishold.recording.formats.picture_file import opened_picture, picture
from varishold.recording.pad import UNNAMED_PAD
from varishold.recording.stored import Column, Stored, StoredPad

__all__ = ["FOLDER", "FORMAT", "Pictures"]

_MAGIC = (b"\x89PNG", b"II*\0", b"MM\0*", b"II+\0", b"MM\0+")
_ENDINGS = (".png", ".tif", ".tiff")
# What may stand beside pictures: sensor files, and what Windows leaves in folders that somebody looks into.
_BESIDE = ".toml"
_LEFT_BEHIND = ("thumbs.db", "desktop.ini")
_NUMBER = re.compile(r"(\d+)")


class Pictures:
    """The pictures of a folder in their order: a column of frames, each read when it is asked for.

    Parameters
    ----------
    files : sequence of Path
        At least one; the first tells the size and type of all.
    """

    def __init__(self, files: list[Path]) -> None:
        self.files = files
        first = opened_picture(files[0])
        first.close()
        if first.shape[0] != 1:
            raise FormatError(f"{files[0]}: has {first.shape[0]} pages; in a folder each picture is a frame")
        self._entry = first.shape[1], first.shape[2]
        self.dtype: np.dtype[Any] = first.dtype

    @property
    def shape(self) -> tuple[int, ...]:
        return (len(self.files), *self._entry)

    def __getitem__(self, wanted: slice, /) -> NDArray[Any]:
        """Read some pictures.

        Raises
        ------
        InputError
            If one is not there any more.
        FormatError
            If one is damaged, or of another size or type.
        """
        chosen = self.files[wanted]
        read = np.empty((len(chosen), *self._entry), self.dtype)
        for row, path in zip(read, chosen, strict=True):
            row[:] = picture(path, self._entry, self.dtype, self.files[0])
        return read


def _recognizes(path: Path, head: bytes) -> bool:
    return head.startswith(_MAGIC)


def _recognizes_folder(path: Path, head: bytes) -> bool:
    """Tell whether a folder holds pictures and nothing else that is read, or only such folders."""
    files, folders = _within(path)
    if files:
        return _are_pictures(files)
    return bool(folders) and all(_are_pictures(_within(folder)[0]) for folder in folders)


def _are_pictures(files: list[Path]) -> bool:
    return bool(files) and all(file.suffix.lower() in _ENDINGS for file in files)


def _within(path: Path) -> tuple[list[Path], list[Path]]:
    """Return what a folder shows: its files but for sensor files, and its folders."""
    files, folders = list[Path](), list[Path]()
    try:
        with os.scandir(path) as entries:
            for entry in entries:
                name = entry.name.lower()
                if not name.startswith(".") and not name.endswith(_BESIDE) and name not in _LEFT_BEHIND:
                    (folders if entry.is_dir() else files).append(Path(entry.path))
    except OSError:
        return [], []
    return files, folders


def _open(path: Path, options: Options) -> Stored:
    pages = opened_picture(path)
    try:
        return _stored(path, options, {UNNAMED_PAD: pages}, pages.notes, pages.close)
    except BaseException:
        pages.close()
        raise


def _open_folder(path: Path, options: Options) -> Stored:
    files, folders = _within(path)
    notes = list[str]()
    if files:
        named = {UNNAMED_PAD: _in_order(files)}
        notes += [f"passed over: {', '.join(sorted(folder.name for folder in folders)[:8])}"] if folders else []
    else:
        named = {folder.name: _in_order(_within(folder)[0]) for folder in sorted(folders)}
    _check_alike(path, named)
    notes += [note for files in named.values() for note in _called(files)]
    notes += _jumps(next(iter(named.values())))
    pads = {pad: Pictures(files) for pad, files in named.items()}
    for pictures in pads.values():
        try:
            _ = pictures[-1:]
        except FormatError as error:
            # What was being written when a recorder was stopped.
            if len(pictures.files) == 1:
                raise
            notes.append(f"the last pictures are left out: {error}")
            pads = {pad: Pictures(files[:-1]) for pad, files in named.items()}
            break
    return _stored(path, options, pads, tuple(notes), lambda: None)


def _in_order(files: list[Path]) -> list[Path]:
    """Return pictures in the order of the numbers in their names."""
    return sorted(files, key=lambda file: ([int(n) for n in _NUMBER.findall(file.stem)], file.name))


def _numbers(files: list[Path]) -> list[int]:
    """Return the number of each picture: the last in its name; nothing where one has none."""
    found = [_NUMBER.findall(file.stem) for file in files]
    return [int(each[-1][-18:]) for each in found] if all(found) else []


def _check_alike(path: Path, named: Mapping[str, list[Path]]) -> None:
    """Refuse pads that have not the same pictures: nobody knows which belong together."""
    (first, files), *rest = named.items()
    for pad, others in rest:
        if len(files) != len(others) or _numbers(files) != _numbers(others):
            odd = set(_numbers(files)) ^ set(_numbers(others))
            which = f"; picture {min(odd)} has no other" if odd else ""
            raise FormatError(f"{path}: {first} has {counted(len(files), 'picture')}, {pad} {len(others)}{which}")


def _called(files: list[Path]) -> list[str]:
    """Return a remark where pictures of one pad are called in several ways, as those of two cameras are."""
    words = sorted({_NUMBER.sub("#", file.stem) for file in files})
    if len(words) == 1:
        return []
    told = ", ".join(words[:4]) + (", ..." if len(words) > 4 else "")
    return [f"pictures are called {told}, and are taken for one pad; where they are of several, give each its folder"]


def _jumps(files: list[Path]) -> list[str]:
    """Return a remark where the numbers of pictures are not evenly spaced."""
    numbers = np.array(_numbers(files))
    steps = np.diff(numbers)
    odd = np.flatnonzero(steps != np.median(steps)) if steps.size else steps
    if not odd.size:
        return []
    more = f" and {counted(odd.size - 1, 'time')} more" if odd.size > 1 else ""
    return [f"the pictures' numbers jump from {numbers[odd[0]]} to {numbers[odd[0] + 1]}{more}"]


def _stored(
    path: Path, options: Options, pads: Mapping[str, Column], notes: tuple[str, ...], close: Callable[[], object]
) -> Stored:
    for column in pads.values():
        if error := shape_error(path, (column.shape[1], column.shape[2]), options):
            raise error
    held = {
        name: StoredPad(column, pitch_m=options.pitch_m, polarity=options.polarity) for name, column in pads.items()
    }
    return Stored(held, source=str(path), notes=notes, close=close)


FORMAT = Format("depth picture (PNG, TIFF)", (), _recognizes, read_by(_open), open=_open)
FOLDER = Format(
    "folder of depth pictures", (), _recognizes_folder, read_by(_open_folder), open=_open_folder, folder=True
)
