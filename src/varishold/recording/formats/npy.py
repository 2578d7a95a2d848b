"""NPY: one array, mapped into memory and not loaded."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from varishold._counted import counted
from varishold.errors import FormatError
from varishold.files import read_npy
from varishold.recording.formats.format import Format, Options, read_by, shape_error
from varishold.recording.formats.time_axis import last_axis_words, time_axis_notes
from varishold.recording.pad import UNNAMED_PAD
from varishold.recording.stored import Stored, StoredPad

__all__ = ["FORMAT"]

# Sensors of three components give (x, y, z) with z along the pad's normal.
_COMPONENTS, _NORMAL = 3, 2


def _recognizes(path: Path, head: bytes) -> bool:
    return head.startswith(b"\x93NUMPY")


def _open(path: Path, options: Options) -> Stored:
    frames, notes = _frames(path, read_npy(path), options)
    valid, said = _without_gaps(frames)
    pad = StoredPad(frames, valid=valid, pitch_m=options.pitch_m, polarity=options.polarity)
    return Stored({UNNAMED_PAD: pad}, source=str(path), notes=(*notes, *said))


def _without_gaps(frames: NDArray[Any]) -> tuple[NDArray[np.bool_] | None, tuple[str, ...]]:
    """Return which taxels work, and what to say: one that is no number at both ends is broken, as in CSV."""
    if frames.dtype.kind != "f" or not len(frames):
        return None, ()
    none = np.isnan(frames[0]) & np.isnan(frames[-1])
    if not none.any() or none.all():
        return None, ()
    which = counted(int(np.count_nonzero(none)), "taxel is no number", "taxels are no numbers")
    return ~none, (f"{which} in the first frame and the last: taken as broken",)


def _frames(path: Path, array: NDArray[Any], options: Options) -> tuple[NDArray[Any], tuple[str, ...]]:
    """Return the array as (n, rows, cols), and what was assumed about it."""
    shape = options.shape
    taxels = shape[0] * shape[1] if shape else 0
    notes: tuple[str, ...] = ()
    normal = "component 2 of 3 (z, along the pad's normal) is taken as pressure"
    if array.ndim == 4 and array.shape[3] == _COMPONENTS:
        array, notes = array[..., _NORMAL], (normal,)
    elif array.ndim == 4 and array.shape[3] == 1:
        array = array[..., 0]
    elif array.ndim == 3 and shape and shape != array.shape[1:] and array.shape[1:] == (taxels, _COMPONENTS):
        return array[..., _NORMAL].reshape(-1, *shape), (normal,)
    elif array.ndim == 3 and shape and shape != array.shape[1:] and shape == array.shape[:2]:
        return np.moveaxis(array, -1, 0), (last_axis_words(array.shape),)
    elif array.ndim == 3:
        n, rows, cols = array.shape
        if shape is None and cols == _COMPONENTS:
            notes = (
                f"read as {rows} x 3 taxels; if the last axis holds x, y, z of {rows} taxels, give shape (rows, cols)",
            )
        elif shape is None:
            notes = time_axis_notes(path, (n, rows, cols))
    elif array.ndim == 2 and shape and array.shape == shape:
        return array[None], ()
    elif array.ndim == 2 and shape and array.shape[1] == taxels:
        return array.reshape(-1, *shape), ()
    elif array.ndim == 2 and shape is None:
        rows, cols = array.shape
        return array[None], (f"read as one frame of {rows} x {cols}; if each row is a frame, give shape (rows, cols)",)
    else:
        raise FormatError(
            f"{path}: must have shape (n, rows, cols), (rows, cols), or, where the shape of a frame is said, "
            f"(n, rows * cols) or (n, taxels, 3); got {array.shape}"
            + (f" and frames of {shape[0]} x {shape[1]}" if shape else ""),
            parameter="shape",
        )
    if error := shape_error(path, (array.shape[1], array.shape[2]), options):
        raise error
    return array, notes


FORMAT = Format("NumPy array (NPY)", (".npy",), _recognizes, read_by(_open), open=_open)
