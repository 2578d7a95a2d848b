"""Outlines X_Bi: the polygons around a section."""

from __future__ import annotations

import ctypes
from collections.abc import Iterable
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike, NDArray

from varishold.errors import InputError
from varishold.frame.checks import as_floats, as_pitch
from varishold.kernel import address, bind, work_space

__all__ = ["outlines", "outlines_at", "outlines_in"]

_find = bind("vh_find_outlines", "ppp", "i")
_write = bind("vh_write_outlines", "pppp")
_work = bind("vh_outlines_work", "ii", "z")


class _Cut(ctypes.Structure):
    """``vh_cut`` of ``varishold.h``."""

    _fields_ = (
        ("values", ctypes.c_void_p),
        ("label", ctypes.c_void_p),
        *((name, ctypes.c_int) for name in ("rows", "cols", "stride", "index")),
        *((name, ctypes.c_double) for name in ("level", "row_pitch", "col_pitch")),
    )


def outlines_in(
    values: NDArray[np.float64],
    label: NDArray[np.int32] | None,
    index: int,
    level: float,
    pitch: tuple[float, float],
) -> list[NDArray[np.float64]]:
    """Return the outlines of {V > level} around the taxels of one label; as `outlines_at` of one level."""
    return outlines_at(values, label, index, [level], pitch)[0]


def outlines_at(
    values: NDArray[np.float64],
    label: NDArray[np.int32] | None,
    index: int,
    levels: Iterable[float],
    pitch: tuple[float, float],
) -> list[list[NDArray[np.float64]]]:
    """Return the outlines of {V > level} around the taxels of one label, at each of some levels.

    Parameters
    ----------
    values : ndarray of shape (rows, cols), float64
        NaN or -inf where there is no taxel; its rows may be part of longer ones.
    label : ndarray of shape (rows, cols), int32, or None
        Of the same rows; taxels of others than `index` are not in the section. None: all may be.
    index : int
    levels : iterable of float
        The thresholds.
    pitch : (float, float)
        Row and column spacing.
    """
    rows, cols = values.shape
    stride = values.strides[0] // values.itemsize
    label_at = 0 if label is None else _first(label)
    section = _Cut(_first(values), label_at, rows, cols, stride, index, 0.0, *pitch)
    at, n_points = ctypes.addressof(section), ctypes.c_int()
    points_at, room = ctypes.addressof(n_points), work_space(_work(rows, cols))
    found = []
    for level in levels:
        section.level = level
        n_lines = _find(at, points_at, room)
        points, stops = np.empty((n_points.value if n_lines else 0, 2)), np.empty(n_lines, np.int32)
        if n_lines:
            _write(at, room, address(points), address(stops))
        found.append([points[start:stop] for start, stop in pairwise([0, *stops.tolist()])])
    return found


def _first(part: NDArray[np.float64] | NDArray[np.int32]) -> int:
    """Return the address of the first number of an array or of a part of one."""
    return int(part.__array_interface__["data"][0])


def outlines(
    frame: ArrayLike, level: float, *, pitch_m: float | tuple[float, float] | None = None
) -> list[NDArray[np.float64]]:
    """Return the outlines X_B of a frame's section {V > level}.

    Parameters
    ----------
    frame : array_like of shape (rows, cols), float or integer
        The frame; NaN is no taxel.
    level : float
        The threshold.
    pitch_m : float or (float, float), optional
        Taxel spacing, metres, one for both ways or (row spacing, column spacing); default: taxels.

    Returns
    -------
    list of ndarray of shape (n, 2), float64
        Polylines (x, y) from the pad's centre, with the section on the left when x is to the right and y up (so
        outer outlines turn from x to y, and holes the other way). A closed one ends at its first point; one that
        meets the pad's border is open. Around a gap of the field, where a cell lacks corners, outlines end at
        the last whole cell.

    Raises
    ------
    InputError
        If the frame is not an array of shape (rows, cols) or the level not finite.

    Examples
    --------
    >>> import numpy as np
    >>> frame = np.zeros((5, 5))
    >>> frame[2, 2] = 1.0
    >>> (outline,) = outlines(frame, 0.5)
    >>> outline.tolist()
    [[-0.5, 0.0], [0.0, -0.5], [0.5, 0.0], [0.0, 0.5], [-0.5, 0.0]]
    """
    values = as_floats(frame, 2, "a frame")
    if not np.isfinite(level):
        raise InputError(f"a level must be finite, got {level}")
    row_pitch, col_pitch = (1.0, 1.0) if pitch_m is None else as_pitch(pitch_m)
    return outlines_in(values, None, 0, float(level), (row_pitch, col_pitch))
