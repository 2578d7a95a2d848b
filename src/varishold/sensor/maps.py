"""Maps of one number a taxel, in files beside the sensor file."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from varishold.errors import FormatError
from varishold.files import open_archive, read_npy

__all__ = ["map_text", "read_map"]


def read_map(path: str | os.PathLike[str], name: str) -> NDArray[np.float64]:
    """Read a map from NPZ (the array called `name`, or the only one), NPY or text as of a recording.

    Returns
    -------
    ndarray, float64

    Raises
    ------
    InputError
        If the file cannot be opened.
    FormatError
        If it holds no such map.
    """
    suffix = Path(path).suffix.lower()
    if suffix == ".npz":
        with open_archive(path) as archive:
            held = archive.names
            key = name if name in held else held[0] if len(held) == 1 else None
            if key is None:
                raise FormatError(f"{path}: must hold an array {name!r}, holds {', '.join(held[:12]) or 'nothing'}")
            values = archive.array(key)
    elif suffix == ".npy":
        values = np.array(read_npy(path))
    else:
        from varishold.recording.formats.plain_csv import read_rows

        values = read_rows(path, unknown=("nan", "NaN", "NAN"))
    if values.dtype.kind not in "biuf":
        raise FormatError(f"{path}: a map must hold real numbers, got {values.dtype}")
    return values.astype(np.float64)


def map_text(values: NDArray[np.float64]) -> str:
    """Return a map as CSV, a row a line, so that reading it gives the same numbers."""
    rows = (",".join(repr(float(value)) for value in row) + "\n" for row in values)
    return "# A map of a sensor's taxels, written by varishold.\n" + "".join(rows)
