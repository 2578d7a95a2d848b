"""A small PNG of colour indices, as a data URI: a frame of 32 x 32 taxels takes about a kilobyte."""

from __future__ import annotations

import base64

import numpy as np
from numpy.typing import NDArray

from varishold.errors import InputError
from varishold.files.png import png_bytes

__all__ = ["data_uri", "png_data_uri"]


def data_uri(png: bytes) -> str:
    """Return a PNG as an address that holds it."""
    return "data:image/png;base64," + base64.b64encode(png).decode("ascii")


def png_data_uri(index: NDArray[np.uint8], palette: bytes, *, transparent: int | None = None) -> str:
    """Encode an image of palette indices.

    Parameters
    ----------
    index : ndarray of shape (rows, cols), uint8
        Place of each pixel's colour in the palette.
    palette : bytes
        Red, green, blue of each colour.
    transparent : int, optional
        A colour that is not drawn.

    Returns
    -------
    str
        ``data:image/png;base64,...``

    Raises
    ------
    InputError
        If the image is empty or points past its palette.
    """
    if index.ndim != 2 or index.size == 0:
        raise InputError(f"index must be a picture of (rows, cols), got shape {index.shape}")
    if 3 * int(index.max()) >= len(palette):
        raise InputError(f"index must lie below {len(palette) // 3}, the palette's length, got {index.max()}")
    opacity = None if transparent is None else bytes(0 if i == transparent else 255 for i in range(transparent + 1))
    return data_uri(png_bytes(index, palette=palette, transparency=opacity))
