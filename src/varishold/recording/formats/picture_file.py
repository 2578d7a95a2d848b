"""Depth pictures of a stranger: grey PNG of 8 or 16 bits, and grey TIFF.

Pillow unpacks PNG, with no other of its readers loaded, when what the file says of size and colours has been looked at.
"""

from __future__ import annotations

import struct
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
from numpy.typing import NDArray

from varishold._lazy import missing_extra
from varishold.errors import FormatError
from varishold.files import damage_told, open_file
from varishold.recording.formats.tiff_file import MOST_TAXELS, TiffPages

__all__ = ["PngPicture", "opened_picture", "picture"]

_PNG = b"\x89PNG"
# How a PNG file begins: its mark, the length and name of its first part, width and height, bits and colours.
_HEAD, _GREY = struct.Struct(">8s8sIIBB"), 0
_DTYPES: dict[int, np.dtype[Any]] = {8: np.dtype("u1"), 16: np.dtype("u2")}


class PngPicture:
    """An open PNG file: a column of one frame.

    Parameters
    ----------
    place : str
        What it is called, for messages.
    file : binary file
        Is closed with it, and where it cannot be read.

    Raises
    ------
    FormatError
        If it is not grey.
    """

    #: There is never anything to say about it.
    notes: tuple[str, ...] = ()

    def __init__(self, place: str, file: BinaryIO) -> None:
        self.place, self._file = place, file
        try:
            with damage_told(self.place):
                _, _, cols, rows, bits, colours = _HEAD.unpack(self._file.read(_HEAD.size))
                if colours != _GREY or bits not in _DTYPES:
                    raise FormatError(
                        f"{self.place}: has colours, a palette or other bits than 8 or 16; depth pictures are grey"
                    )
                if not 0 < rows * cols <= MOST_TAXELS:
                    raise FormatError(f"{self.place}: is {rows} x {cols}; it may have 1 to {MOST_TAXELS} taxels")
        except BaseException:
            self._file.close()
            raise
        self.shape: tuple[int, ...] = (1, rows, cols)
        self.dtype: np.dtype[Any] = _DTYPES[bits]

    def close(self) -> None:
        """Let the file go. May be called again."""
        self._file.close()

    def __getitem__(self, wanted: slice, /) -> NDArray[Any]:
        """Read the frame, or nothing.

        Raises
        ------
        FormatError
            If it is damaged.
        MissingExtraError
            If Pillow is not installed.
        """
        try:
            from PIL import Image
        except ModuleNotFoundError as error:
            raise missing_extra(error) from None
        self._file.seek(0)
        with _told(self.place):
            frame = np.asarray(Image.open(self._file, formats=("PNG",)))
            if frame.shape != self.shape[1:] or frame.dtype.kind not in "iu":
                raise ValueError(f"it unpacks to {frame.dtype} of shape {frame.shape}")
            read: NDArray[Any] = frame.astype(self.dtype)[None][wanted]
        return read


@contextmanager
def _told(place: str) -> Iterator[None]:
    """Tell what Pillow raises or warns of as a FormatError, opened by `place`."""
    with damage_told(place), warnings.catch_warnings():
        warnings.simplefilter("error")
        try:
            yield
        except (Warning, AssertionError) as error:
            raise ValueError(str(error)) from error


def opened_picture(path: Path) -> PngPicture | TiffPages:
    """Open a picture, of which kind its first bytes tell.

    Raises
    ------
    InputError
        If it cannot be opened.
    FormatError
        If it is damaged, or not grey.
    """
    file = open_file(path)
    is_png = file.read(len(_PNG)) == _PNG
    file.seek(0)
    return PngPicture(str(path), file) if is_png else TiffPages(str(path), file)


def picture(path: Path, shape: tuple[int, int], dtype: np.dtype[Any], like: Path) -> NDArray[Any]:
    """Read a picture of one page that must be like another.

    Raises
    ------
    InputError
        If it cannot be opened.
    FormatError
        If it is damaged, or of another size or type.
    """
    pages = opened_picture(path)
    try:
        if pages.shape != (1, *shape) or pages.dtype != dtype:
            many = f"{pages.shape[0]} pages of " if pages.shape[0] > 1 else ""
            raise FormatError(
                f"{path}: is {many}{pages.shape[1]} x {pages.shape[2]} {pages.dtype.name}, {like.name} "
                f"{shape[0]} x {shape[1]} {dtype.name}; all pictures of a pad must be alike"
            )
        frame: NDArray[Any] = pages[:][0]
        return frame
    finally:
        pages.close()
