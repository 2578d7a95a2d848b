"""A rendered picture as a PNG data URI: every line as its difference from the line above, which packs small."""

from __future__ import annotations

import base64
import struct
import zlib
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from varishold.errors import InputError

__all__ = ["Photo", "photo_data_uri"]

#: A picture of shape (height, width, 3): red, green, blue.
Photo: TypeAlias = NDArray[np.uint8]

# PNG's filter "up".
_UP = 2


def photo_data_uri(picture: Photo) -> str:
    """Encode a picture; the same picture gives the same text.

    Parameters
    ----------
    picture : ndarray of shape (height, width, 3), uint8

    Raises
    ------
    InputError
        If it is no such picture.
    """
    if picture.ndim != 3 or picture.shape[2] != 3 or picture.size == 0 or picture.dtype != np.uint8:
        raise InputError(
            f"a picture must be uint8 of shape (height, width, 3), got {picture.dtype} of shape {picture.shape}"
        )
    height, width = picture.shape[:2]
    lines = picture.reshape(height, 3 * width)
    above = np.vstack([np.zeros((1, 3 * width), np.uint8), lines[:-1]])
    # Differences wrap round at 256, as the format wants.
    filtered = np.column_stack([np.full(height, _UP, np.uint8), lines - above])
    chunks = (
        (b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)),
        (b"IDAT", zlib.compress(filtered.tobytes(), 9)),
        (b"IEND", b""),
    )
    png = b"\x89PNG\r\n\x1a\n" + b"".join(
        struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body)) for kind, body in chunks
    )
    return "data:image/png;base64," + base64.b64encode(png).decode("ascii")
