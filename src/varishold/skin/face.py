"""How deep each cell of a skin's surface would be pressed, if it were bare air."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from varishold.errors import InputError
from varishold.frame.checks import as_floats
from varishold.skin.media import Cells
from varishold.solids import Pose, Solid

__all__ = ["Face", "face_of_map", "face_of_solid"]

Floats = NDArray[np.float64]

# A cell whose heights differ by more than this share of the depth holds a wall, not a slope.
_WALL = 0.5
# Samples along each side of a cell that holds a wall.
_FINE = 6


@dataclass(frozen=True)
class Face:
    """A face over a grid of cells, measured down from its highest point.

    Parameters
    ----------
    below_top_m : ndarray of shape (rows, cols), float64
        How far the face lies below its highest point, mean over each cell's loaded part, metres;
        infinite where there is no face.
    loaded : ndarray of shape (rows, cols), float64
        Share of each cell that can be loaded; below 1 where a wall crosses the cell.
    top_m : float
        Height of the highest point above the base plane, metres.
    """

    below_top_m: Floats
    loaded: Floats
    top_m: float


def face_of_solid(solid: Solid, cells: Cells, pose: Pose, depth_m: float) -> Face:
    """Sample a solid's face for a press of about `depth_m`.

    Cells are averaged by Simpson's rule; a cell that a wall crosses is sampled finely and only its
    upper part counts, with the share that this part has of the cell.

    Raises
    ------
    InputError
        If no part of the solid lies over the field.
    """
    y = (np.arange(cells.rows + 1) - cells.rows / 2) * cells.row_m
    x = (np.arange(cells.cols + 1) - cells.cols / 2) * cells.col_m
    middle_y, middle_x = (y[1:] + y[:-1]) / 2, (x[1:] + x[:-1]) / 2
    corner_x, corner_y = np.meshgrid(x, y)
    corner = solid.placed(corner_x, corner_y, pose)
    cell_x, cell_y = np.meshgrid(middle_x, middle_y)
    middle = solid.placed(cell_x, cell_y, pose)
    top = max(float(corner.max()), float(middle.max()))
    if abs(pose.x_m) <= x[-1] and abs(pose.y_m) <= y[-1]:
        top = max(top, float(solid.placed(pose.x_m, pose.y_m, pose)))
    if top <= 0:
        raise InputError(
            f"the {solid.name} at ({pose.x_m:g}, {pose.y_m:g}) m lies outside the field of "
            f"{cells.rows * cells.row_m:g} x {cells.cols * cells.col_m:g} m (y, x)"
        )
    corners = np.stack([corner[:-1, :-1], corner[:-1, 1:], corner[1:, :-1], corner[1:, 1:]])
    low = np.minimum(corners.min(axis=0), middle)
    high = np.maximum(corners.max(axis=0), middle)
    height = (2 * middle + corners.mean(axis=0)) / 3
    loaded = np.where(middle > 0, 1.0, 0.0)
    walls = (high - low > _WALL * depth_m) & (high > top - 2 * depth_m)
    rows, cols = np.nonzero(walls)
    if rows.size:
        offset = (np.arange(_FINE) + 0.5) / _FINE
        fine_y, fine_x = np.broadcast_arrays(
            (y[rows, None] + offset * cells.row_m)[:, :, None],
            (x[cols, None] + offset * cells.col_m)[:, None, :],
        )
        fine = solid.placed(fine_x, fine_y, pose).reshape(rows.size, -1)
        peak = fine.max(axis=1, keepdims=True)
        upper = (fine > 0) & (fine >= peak - _WALL * depth_m)
        count = upper.sum(axis=1)
        loaded[rows, cols] = count / upper.shape[1]
        height[rows, cols] = np.where(upper, fine, 0.0).sum(axis=1) / np.maximum(count, 1)
    return Face(np.where(loaded > 0, top - height, np.inf), loaded, top)


def face_of_map(height_m: ArrayLike, cells: Cells) -> Face:
    """Take a height map over the whole field, metres; linear between its own points.

    Raises
    ------
    InputError
        If it is not a finite array of two dimensions with at least 2 x 2 points.
    """
    given = as_floats(height_m, 2, "a height map")
    if min(given.shape) < 2:
        raise InputError(f"a height map must have 2 x 2 points or more, got an array of shape {given.shape}")
    if not np.isfinite(given).all():
        row, col = np.argwhere(~np.isfinite(given))[0]
        raise InputError(f"a height map must be finite, got {given[row, col]} at (row, col) = ({row}, {col})")
    height = _resample(_resample(given, cells.rows).T, cells.cols).T
    top = float(height.max())
    return Face(top - height, np.ones(height.shape), top)


def _resample(values: Floats, rows: int) -> Floats:
    """Linear interpolation along the first axis at the middles of `rows` even cells."""
    at = np.clip((np.arange(rows) + 0.5) * values.shape[0] / rows - 0.5, 0, values.shape[0] - 1)
    low = np.minimum(at.astype(int), values.shape[0] - 2)
    share = (at - low)[:, None]
    out: Floats = (1 - share) * values[low] + share * values[low + 1]
    return out
