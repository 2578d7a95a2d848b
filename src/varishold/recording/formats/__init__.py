"""The file formats: one file each, and the registry in which each is listed."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping
from importlib import import_module
from pathlib import Path
from typing import Literal

from numpy.typing import ArrayLike

from varishold.errors import FormatError, InputError, reason_of, require_a
from varishold.files import open_file
from varishold.files.outputs import kind_made
from varishold.frame import as_pitch
from varishold.recording.formats.format import Format, Options, read_by
from varishold.recording.formats.npz import write as write_npz
from varishold.recording.recording import Recording
from varishold.recording.stored import Stored, stored_of

__all__ = ["FORMATS", "Format", "Options", "format_of", "is_folder", "open_stored", "read", "write"]


class _Registry(Mapping[str, Format]):
    """Formats by name, each loaded when it is first asked for."""

    def __init__(self, places: Mapping[str, str]) -> None:
        self._places = places

    def __getitem__(self, name: str) -> Format:
        module, _, what = self._places[name].partition(":")
        found: Format = getattr(import_module(f"{__name__}.{module}"), what or "FORMAT")
        return found

    def __iter__(self) -> Iterator[str]:
        return iter(self._places)

    def __len__(self) -> int:
        return len(self._places)


#: Every format by its short name, and the module that has it. The first that recognizes a file's content reads it, so
#: a special one stands before a general one.
FORMATS: Mapping[str, Format] = _Registry(
    {
        "weiss-dsa": "weiss_dsa",
        "capcontact": "capcontact",
        "zarr-zip": "zarr",
        "zarr": "zarr:FOLDER",
        "npz": "npz",
        "npy": "npy",
        "mcap": "mcap",
        "rosbag1": "rosbag1",
        "rosbag2": "rosbag2",
        "rosbag2-folder": "rosbag2:FOLDER",
        "lerobot": "lerobot",
        "matlab-7.3": "mat73",
        "matlab": "mat5",
        "hdf5": "hdf5",
        "parquet": "parquet",
        "picture": "pictures",
        "picture-folder": "pictures:FOLDER",
        "tekscan": "tekscan",
        "xsensor": "xsensor",
        "icub-grasp": "icub_grasp",
        "press-rows": "press_rows",
        "csv": "plain_csv",
    }
)
# Formats whose files must begin as they do, by the ending that promises them.
_PROMISED = {".npz": "npz", ".npy": "npy", ".mcap": "mcap", ".h5": "hdf5", ".hdf5": "hdf5", ".parquet": "parquet"}

_SPOILT = "whose 8 bits and packing spoil depth; save its frames as PNG of 16 bits, TIFF or NPZ"
_WORKBOOK = "a workbook, which is no known format; save its sheet as CSV"
# First bytes of files that hold recordings only inside something else, and what to do about them.
_WRAPPED = {
    b"\x1f\x8b": "is compressed with gzip; unpack it first (gunzip)",
    b"BZh": "is compressed with bzip2; unpack it first (bunzip2)",
    b"\xfd7zXZ": "is compressed with xz; unpack it first (unxz)",
    b"\x28\xb5\x2f\xfd": "is compressed with zstd; unpack it first (unzstd)",
    b"\x80": "looks like a pickle, which is never loaded; save the frames with numpy.save",
    b"\xd0\xcf\x11\xe0": f"is {_WORKBOOK}",
    b"%PDF": "is a PDF, which is no known format; save the numbers themselves as CSV or NPZ",
    b"\xff\xd8\xff": "is a JPEG picture, whose packing spoils depth; save PNG of 16 bits, TIFF or NPZ",
    b"\x1a\x45\xdf\xa3": f"is a video, {_SPOILT}",
    b"RIFF": f"is a video, {_SPOILT}",
}
# A video's mark stands behind the length of its first part.
_VIDEO = (b"ftyp", slice(4, 8))
# What stands in the first parts of a workbook, which is an archive.
_ARCHIVE, _OF_WORKBOOKS = b"PK\x03\x04", (b"xl/work", b"application/vnd.oasis.opendocument.spreadsheet")
_HEAD = 1 << 16
# Bytes of a file that is not read at once where it need not be.
_LARGE = 1 << 26


def read(
    path: str | os.PathLike[str],
    *,
    shape: tuple[int, int] | None = None,
    pitch_m: ArrayLike | None = None,
    polarity: Literal["up", "down"] = "up",
) -> Recording:
    """Read a recording from a file of any known format, which its content tells.

    Parameters
    ----------
    path : str or path-like
        The file.
    shape : (int, int), optional
        Rows and columns of a frame, for formats that do not hold them.
    pitch_m : float or (float, float), optional
        Taxel spacing, metres: one number, or row spacing and column spacing. It goes before what the file says.
    polarity : {"up", "down"}
        Whether larger or smaller readings mean more pressure. "down" only lets them pass: a sensor file turns them.

    Returns
    -------
    Recording

    Raises
    ------
    InputError
        If the file cannot be opened, or `shape` or `pitch_m` is impossible.
    FormatError
        If it cannot be read; the message names file, place and remedy.

    Examples
    --------
    >>> import tempfile
    >>> from pathlib import Path
    >>> from varishold.recording import read
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     _ = Path(folder, "two.csv").write_text("0,1\\n2,3\\n\\n4,5\\n6,9\\n")
    ...     read(Path(folder, "two.csv"), pitch_m=0.004).pads["pad"].frames.tolist()
    [[[0, 1], [2, 3]], [[4, 5], [6, 9]]]
    """
    known, file, options = _known(path, shape, pitch_m, polarity)
    if known.open is not None and not known.folder and file.name != "-" and file.stat().st_size > _LARGE:
        # In bounded memory, whatever it holds.
        return read_by(known.open)(file, options)
    return known.read(file, options)


def open_stored(
    path: str | os.PathLike[str],
    *,
    shape: tuple[int, int] | None = None,
    pitch_m: ArrayLike | None = None,
    polarity: Literal["up", "down"] = "up",
) -> Stored:
    """Open a recording whose frames stay in the file as far as its format allows; arguments and errors as in `read`."""
    known, file, options = _known(path, shape, pitch_m, polarity)
    return stored_of(known.read(file, options)) if known.open is None else known.open(file, options)


def _known(
    path: str | os.PathLike[str],
    shape: tuple[int, int] | None,
    pitch_m: ArrayLike | None,
    polarity: Literal["up", "down"],
) -> tuple[Format, Path, Options]:
    """Return a file's format, its path, and what was said about it."""
    options = Options(_checked_shape(shape), None if pitch_m is None else as_pitch(pitch_m), polarity)
    return format_of(path), Path(path), options


def format_of(path: str | os.PathLike[str]) -> Format:
    """Return the format of a file or folder, which its content tells.

    Raises
    ------
    InputError
        If it cannot be opened.
    FormatError
        If it is of no known format.
    """
    file = _path(path)
    if is_folder(file):
        return next(known for known in FORMATS.values() if known.folder and known.recognizes(file, b""))
    with open_file(file) as opened:
        try:
            head = opened.read(_HEAD)
        except OSError as error:
            raise InputError(f"{file}: cannot be read: {reason_of(error)}") from error
    if not head.strip():
        raise FormatError(f"{file}: is empty")
    if head[_VIDEO[1]] == _VIDEO[0]:
        raise FormatError(f"{file}: is a video, {_SPOILT}")
    for start, advice in _WRAPPED.items():
        if head.startswith(start):
            raise FormatError(f"{file}: {advice}")
    if head.startswith(_ARCHIVE) and any(mark in head for mark in _OF_WORKBOOKS):
        raise FormatError(f"{file}: is {_WORKBOOK}")
    made = kind_made(file) if file.name != "-" else None
    if made is not None:
        raise FormatError(f"{file}: is a {made.title}, and no recording")
    promised = FORMATS.get(_PROMISED.get(file.suffix.lower(), ""))
    if promised is not None and not promised.recognizes(file, head):
        raise FormatError(f"{file}: does not start like {promised.title}; is it damaged, or something else?")
    for known in FORMATS.values():
        if not known.folder and known.recognizes(file, head):
            return known
    text, tail, _ = head.partition(b"\0")
    if tail and b"\n" in text and _is_text(text):
        lines = text.count(b"\n")
        raise FormatError(
            f"{file}: is text to line {lines}, then NUL bytes, as an interrupted write leaves; cut them off"
        )
    titles = ", ".join(known.title for known in FORMATS.values())
    raise FormatError(f"{file}: is of no known format; known are {titles}")


def _path(path: object) -> Path:
    if not isinstance(path, str | os.PathLike) or not isinstance(os.fspath(path), str):
        raise InputError(f"path must be the name of a file, got {path!r}", parameter="path")
    return Path(path)


def _is_text(data: bytes) -> bool:
    try:
        return all(each.isprintable() or each in "\t\r\n\ufeff" for each in data.decode())
    except UnicodeDecodeError:
        return False


def is_folder(path: str | os.PathLike[str], *, marked: bool = False) -> bool:
    """Tell whether a folder is a recording.

    Parameters
    ----------
    path : str or path-like
    marked : bool
        Only where something in it says so: pictures alone may be anything.
    """
    folder = Path(path)
    if not os.path.isdir(folder):
        return False
    known = [each for name, each in FORMATS.items() if each.folder and not (marked and name == "picture-folder")]
    return any(each.recognizes(folder, b"") for each in known)


def write(recording: Recording, path: str | os.PathLike[str]) -> None:
    """Write a recording, whole or not at all; reading it gives the same recording.

    Parameters
    ----------
    recording : Recording
        Values and their types, masks, pitch, time, unit, sensor and presses are kept; `source` and `notes` are not.
    path : str or path-like
        The file; its ending says the format. NPZ where it says none.

    Raises
    ------
    InputError
        If it cannot be written there.
    MissingExtraError
        If the library that writes it is not installed.

    Examples
    --------
    >>> import tempfile
    >>> from pathlib import Path
    >>> import numpy as np
    >>> from varishold.recording import Pad, Recording, read, write
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     write(Recording({"pad": Pad(np.eye(3)[None])}), Path(folder, "one.npz"))
    ...     read(Path(folder, "one.npz")).pads["pad"].shape
    (3, 3)
    """
    require_a(Recording, recording, "recording", "as read(path) gives it")
    ending = _path(path).suffix.lower()
    writers = (known.write for known in FORMATS.values() if known.write is not None and ending in known.suffixes)
    (next(writers, None) or write_npz)(recording, path)


def _checked_shape(shape: tuple[int, int] | None) -> tuple[int, int] | None:
    if shape is None:
        return None
    try:
        rows, cols = (int(side) for side in shape)
    except (TypeError, ValueError) as error:
        raise InputError(f"shape must be (rows, columns), got {shape!r}") from error
    if rows < 1 or cols < 1:
        raise InputError(f"shape must be at least 1 x 1, got {rows} x {cols}")
    return rows, cols
