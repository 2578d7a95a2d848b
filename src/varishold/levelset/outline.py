"""Outlines X_Bi: the polygons around a section."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from varishold.errors import InputError
from varishold.files.compiling import njit
from varishold.frame.checks import as_floats, as_pitch
from varishold.levelset.cells import OUTLINE_SEGMENTS
from varishold.levelset.padding import positions

__all__ = ["outlines", "outlines_in"]


@njit(cache=True, nogil=True, error_model="numpy")
def _segments(v, keep, level, xs, ys):  # type: ignore[no-untyped-def]
    """Return the outline's segments: starts and ends (x, y) and the grid sides on which they lie.

    A side's number is 2 p for the one from taxel p to the right, 2 p + 1 for the one downward.
    """
    height, width = v.shape
    most = 2 * height * width
    start, stop = np.empty((most, 2)), np.empty((most, 2))
    side_in, side_out = np.empty(most, np.int64), np.empty(most, np.int64)
    n = 0
    corner_row, corner_col = (0, 0, 1, 1), (0, 1, 1, 0)
    inside = np.empty(4, np.bool_)
    for r in range(height - 1):
        for c in range(width - 1):
            pattern, lowest = 0, np.inf
            for j in range(4):
                row, col = r + corner_row[j], c + corner_col[j]
                lowest = min(lowest, v[row, col])
                inside[j] = v[row, col] > level and keep[row, col]
                pattern |= int(inside[j]) << j
            if pattern == 0 or pattern == 15 or lowest == -np.inf:
                continue
            total = (v[r, c] + v[r, c + 1]) + (v[r + 1, c] + v[r + 1, c + 1])
            saddle = pattern in (5, 10)
            joined = int(saddle and 4.0 * level < total)
            for segment in range(2 if saddle else 1):
                for end in range(2):
                    a = OUTLINE_SEGMENTS[joined, pattern, segment, end]
                    b = (a + 1) & 3
                    ra, ca, rb, cb = r + corner_row[a], c + corner_col[a], r + corner_row[b], c + corner_col[b]
                    f = (v[ra, ca] - level) / (v[ra, ca] - v[rb, cb])
                    x, y = xs[ca] + f * (xs[cb] - xs[ca]), ys[ra] + f * (ys[rb] - ys[ra])
                    side = 2 * (min(ra, rb) * width + min(ca, cb)) + (ra != rb)
                    if end == 0:
                        start[n, 0], start[n, 1], side_out[n] = x, y, side
                    else:
                        stop[n, 0], stop[n, 1], side_in[n] = x, y, side
                n += 1
    return start[:n], stop[:n], side_out[:n], side_in[:n]


def outlines_in(
    padded: NDArray[np.float64],
    keep: NDArray[np.bool_],
    level: float,
    xs: NDArray[np.float64],
    ys: NDArray[np.float64],
) -> list[NDArray[np.float64]]:
    """Return the outlines of {V > level} around the taxels in `keep` of a padded frame.

    Parameters
    ----------
    padded : ndarray of shape (rows + 2, cols + 2), float64
        -inf where there is no taxel; the rim half a taxel outside.
    keep : ndarray of shape (rows + 2, cols + 2), bool
        Taxels that may be in the section.
    level : float
        The threshold.
    xs, ys : ndarray, float64
        Positions of the padded frame's columns and rows.
    """
    start, stop, side_out, side_in = _segments(padded, keep, level, xs, ys)
    following = dict(zip(side_out.tolist(), range(side_out.size), strict=True))
    came_from = set(side_in.tolist())
    done = np.zeros(side_out.size, np.bool_)
    # Open outlines begin on a side where none arrives; the rest are closed.
    first = [i for i, side in enumerate(side_out.tolist()) if side not in came_from]
    found = []
    for i in [*first, *range(side_out.size)]:
        if done[i]:
            continue
        points = [start[i]]
        j: int | None = i
        while j is not None and not done[j]:
            done[j] = True
            points.append(stop[j])
            j = following.get(int(side_in[j]))
        if j == i:
            # Closed to the last bit: both ends are one crossing of one side.
            points[-1] = points[0]
        found.append(np.array(points))
    return found


def outlines(
    frame: ArrayLike, level: float, *, pitch: float | tuple[float, float] | None = None
) -> list[NDArray[np.float64]]:
    """Return the outlines X_B of a frame's section {V > level}.

    Parameters
    ----------
    frame : array_like of shape (rows, cols), float or integer
        The frame; NaN is no taxel.
    level : float
        The threshold.
    pitch : float or (float, float), optional
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
    row_pitch, col_pitch = (1.0, 1.0) if pitch is None else as_pitch(pitch, "pitch")
    values = np.where(np.isnan(values), -np.inf, values)
    padded = np.pad(values, 1, mode="edge")
    return outlines_in(
        padded,
        np.ones(padded.shape, np.bool_),
        float(level),
        positions(values.shape[1], col_pitch),
        positions(values.shape[0], row_pitch),
    )
