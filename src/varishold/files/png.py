"""A picture as PNG, without a drawing library; the same picture gives the same bytes."""

from __future__ import annotations

import struct
import zlib

import numpy as np
from numpy.typing import NDArray

__all__ = ["png_bytes"]

# Filters of a line: none, and its difference from the line above, which packs small where colours change slowly.
_PLAIN, _UP = 0, 2
_INDEXED, _COLOURS = 3, 2


def png_bytes(pixels: NDArray[np.uint8], *, palette: bytes | None = None, transparency: bytes | None = None) -> bytes:
    """Encode a picture.

    Parameters
    ----------
    pixels : ndarray of shape (height, width, 3), or with a palette (height, width), uint8
        Red, green and blue, or places in the palette.
    palette : bytes, optional
        Red, green, blue of each colour.
    transparency : bytes, optional
        Opacity of the palette's first colours.
    """
    height, width = pixels.shape[:2]
    lines = pixels.reshape(height, -1)
    if palette is None:
        # Differences wrap round at 256, as the format wants.
        lines = lines - np.vstack([np.zeros_like(lines[:1]), lines[:-1]])
    coded = np.column_stack([np.full(height, _UP if palette is None else _PLAIN, np.uint8), lines])
    kind = _COLOURS if palette is None else _INDEXED
    chunks = (
        (b"IHDR", struct.pack(">IIBBBBB", width, height, 8, kind, 0, 0, 0)),
        # By this mark a picture of this program is known again.
        (b"tEXt", b"Software\0varishold" if palette is None else None),
        (b"PLTE", palette),
        (b"tRNS", transparency),
        (b"IDAT", zlib.compress(coded.tobytes(), 9)),
        (b"IEND", b""),
    )
    return b"\x89PNG\r\n\x1a\n" + b"".join(
        struct.pack(">I", len(body)) + name + body + struct.pack(">I", zlib.crc32(name + body))
        for name, body in chunks
        if body is not None
    )
