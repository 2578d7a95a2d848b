"""Height maps: the form of a thing as rows of heights, from NPY or text."""

from __future__ import annotations

import os

import numpy as np
from numpy.typing import NDArray

from varishold.errors import FormatError
from varishold.files import open_file, read_npy
from varishold.recording.formats.plain_csv import read_rows

__all__ = ["read_height_map"]


def read_height_map(path: str | os.PathLike[str]) -> NDArray[np.float64]:
    """Read a height map from an NPY file or from rows of numbers.

    Parameters
    ----------
    path : str or path-like
        NPY, or text: one row a line; comma, semicolon, tab or spaces separate.

    Returns
    -------
    ndarray of shape (rows, cols), float64
        Heights in metres.

    Raises
    ------
    InputError
        If the file cannot be opened.
    FormatError
        If it holds no real numbers, or fewer than 2 x 2.
    """
    with open_file(path) as file:
        is_npy = file.read(6) == b"\x93NUMPY"
    height = read_npy(path) if is_npy else read_rows(path)
    if height.dtype.kind not in "biuf":
        raise FormatError(f"{path}: not a height map: must be real numbers (metres), got {height.dtype}")
    if height.ndim != 2 or min(height.shape) < 2:
        raise FormatError(f"{path}: a height map must have 2 x 2 points or more, got shape {height.shape}")
    return np.array(height, dtype=np.float64)
