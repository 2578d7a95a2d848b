"""What a file format has to offer, and what a person may say about a file."""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from varishold.errors import FormatError
from varishold.recording.recording import Recording
from varishold.recording.stored import Stored

__all__ = ["Format", "Options", "read_by", "shape_error"]


@dataclass(frozen=True)
class Options:
    """What a file may leave unsaid.

    Parameters
    ----------
    shape : (int, int), optional
        Rows and columns of a frame.
    pitch_m : (float, float), optional
        Row and column spacing in metres; it goes before what the file says.
    polarity : {"up", "down"}
        Whether larger or smaller readings mean more pressure.
    """

    shape: tuple[int, int] | None = None
    pitch_m: tuple[float, float] | None = None
    polarity: Literal["up", "down"] = "up"


@dataclass(frozen=True)
class Format:
    """One file format.

    Parameters
    ----------
    title : str
        What a person calls it.
    suffixes : tuple of str
        Endings of file names, in lower case, that promise this format; may be empty.
    recognizes : callable
        Takes the path and the file's first bytes (up to 64 KiB) and tells whether the file is of this format.
        It must be quick and may not raise.
    read : callable
        Takes the path and the options and returns the recording; raises FormatError where it cannot.
    write : callable, optional
        Takes a recording and a path; for formats that lose nothing.
    open : callable, optional
        As `read`, but what it returns is still in the file; for formats of which parts can be read.
    folder : bool
        Whether a recording is a folder: `recognizes` is then asked about folders, with no bytes.
    """

    title: str
    suffixes: tuple[str, ...]
    recognizes: Callable[[Path, bytes], bool]
    read: Callable[[Path, Options], Recording]
    write: Callable[[Recording, str | os.PathLike[str]], None] | None = None
    open: Callable[[Path, Options], Stored] | None = None
    folder: bool = False


def read_by(open_it: Callable[[Path, Options], Stored]) -> Callable[[Path, Options], Recording]:
    """Return the `read` of a format that has `open`."""

    def read(path: Path, options: Options) -> Recording:
        stored = open_it(path, options)
        try:
            return stored.whole()
        finally:
            stored.close()

    return read


def shape_error(path: Path, found: tuple[int, int], options: Options) -> FormatError | None:
    """Return the error to raise where a file has another shape than the person says."""
    if options.shape is None or options.shape == found:
        return None
    return FormatError(
        f"{path}: has frames of {found[0]} x {found[1]}, not {options.shape[0]} x {options.shape[1]}; "
        "leave the shape out",
        parameter="shape",
    )
