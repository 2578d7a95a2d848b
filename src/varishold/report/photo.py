"""A rendered picture as a PNG data URI."""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from varishold.errors import InputError
from varishold.files.png import png_bytes
from varishold.report.picture import data_uri

__all__ = ["Photo", "photo_data_uri"]

#: A picture of shape (height, width, 3): red, green, blue.
Photo: TypeAlias = NDArray[np.uint8]


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
    return data_uri(png_bytes(picture))
