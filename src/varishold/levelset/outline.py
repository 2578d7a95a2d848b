"""Outlines X_Bi: the polygons around a section."""

from __future__ import annotations

import ctypes
from collections.abc import Sequence
from itertools import accumulate, pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from varishold.errors import InputError
from varishold.frame.checks import as_floats, as_pitch
from varishold.kernel import address, bind, work_space

__all__ = ["Outlines", "outlines", "outlines_at", "outlines_in"]

_write = bind("vh_outlines", "ppppqp", "q")
_work = bind("vh_outlines_work", "p", "z")
# Points that a section has at first room for.
_POINTS = 128


class _Cut(ctypes.Structure):
    """``vh_cut`` of ``varishold.h``."""

    _fields_ = (
        ("values", ctypes.c_void_p),
        ("label", ctypes.c_void_p),
        *((name, ctypes.c_int) for name in ("rows", "cols", "stride", "index", "closed", "n_levels")),
        ("levels", ctypes.c_void_p),
        *((name, ctypes.c_double) for name in ("row_pitch", "col_pitch")),
    )


class Outlines(NamedTuple):
    """The outlines of sections, one after the other.

    Attributes
    ----------
    points : ndarray of shape (n, 2), float64
        Their points (x, y) from the pad's centre, with the section on the left when x is to the right and y up.
    stops : ndarray of shape (n_lines,), int32
        How many points there are up to the end of each.
    n_lines : ndarray of shape (n_levels,), int32
        How many outlines each level has.
    """

    points: NDArray[np.float64]
    stops: NDArray[np.int32]
    n_lines: NDArray[np.int32]

    def by_level(self) -> list[list[NDArray[np.float64]]]:
        """Return each outline as an array, level by level."""
        lines = [self.points[start:stop] for start, stop in pairwise([0, *self.stops.tolist()])]
        return [lines[start:stop] for start, stop in pairwise(accumulate([0, *self.n_lines.tolist()]))]


def outlines_in(
    values: NDArray[np.float64],
    label: NDArray[np.int32] | None,
    index: int,
    level: float,
    pitch: tuple[float, float],
) -> list[NDArray[np.float64]]:
    """Return the outlines of {V > level} around the taxels of one label; as `outlines_at` of one level."""
    return outlines_at(values, label, index, [level], pitch).by_level()[0]


def outlines_at(
    values: NDArray[np.float64],
    label: NDArray[np.int32] | None,
    index: int,
    levels: Sequence[float] | NDArray[np.float64],
    pitch: tuple[float, float],
    *,
    closed: bool = False,
) -> Outlines:
    """Return the outlines of {V > level} around the taxels of one label, at each of some levels.

    Parameters
    ----------
    values : ndarray of shape (rows, cols), float64
        NaN or -inf where there is no taxel; its rows may be part of longer ones.
    label : ndarray of shape (rows, cols), int32, or None
        Of the same rows; taxels of others than `index` are not in the section. None: all may be.
    index : int
    levels : sequence of float
        The thresholds.
    pitch : (float, float)
        Row and column spacing.
    closed : bool
        Whether outlines go on along the border of the pad, and from taxel to taxel around gaps of the field, until
        they close, so that a section can be filled. Their first point does not come again then.
    """
    rows, cols = values.shape
    stride = values.strides[0] // values.itemsize
    label_at = 0 if label is None else label.ctypes.data
    thresholds = np.array(levels, np.float64)
    n_levels = len(thresholds)
    n_lines = np.empty(n_levels, np.int32)
    if not n_levels:
        return Outlines(np.empty((0, 2)), np.empty(0, np.int32), n_lines)
    cut = _Cut(values.ctypes.data, label_at, rows, cols, stride, index, closed, n_levels, address(thresholds), *pitch)
    at = ctypes.addressof(cut)
    room, wanted = 0, _POINTS * n_levels
    while wanted > room:
        room = wanted
        points, stops = np.empty((room, 2)), np.empty(room // 2, np.int32)
        wanted = _write(at, address(points), address(stops), address(n_lines), room, work_space(_work(at)))
    return Outlines(points[:wanted], stops[: n_lines.sum()], n_lines)


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
