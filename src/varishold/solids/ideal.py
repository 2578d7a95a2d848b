"""Ideal frames: what a pad would report if its pressure had exactly the object's form."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from varishold.errors import InputError, require_a
from varishold.frame.checks import as_array, as_pitch, as_whole
from varishold.frame.readings import as_shape
from varishold.solids.solid import Pose, Solid

__all__ = ["ideal_frame", "pad_points"]


def pad_points(
    shape: tuple[int, int], pitch_m: float | tuple[float, float], *, per_taxel: int = 1
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the points of a pad, `per_taxel` x `per_taxel` evenly spaced in every taxel.

    Parameters
    ----------
    shape : (int, int)
        Rows and columns of the pad.
    pitch_m : float or (float, float)
        Taxel spacing in metres, one for both ways or (row spacing, column spacing).
    per_taxel : int
        Points along each side of a taxel.

    Returns
    -------
    x, y : ndarray of shape (rows * per_taxel, cols * per_taxel), float64
        Metres from the pad's centre; x grows with the column, y with the row.
    """
    rows, cols = as_shape(shape)
    per_taxel = as_whole(per_taxel, "per_taxel")
    row_pitch, col_pitch = as_pitch(pitch_m)
    y = ((np.arange(rows * per_taxel) + 0.5) / per_taxel - rows / 2) * row_pitch
    x = ((np.arange(cols * per_taxel) + 0.5) / per_taxel - cols / 2) * col_pitch
    grid_x, grid_y = np.meshgrid(x, y)
    return grid_x, grid_y


def ideal_frame(
    solid: Solid,
    shape: tuple[int, int],
    pitch_m: float | tuple[float, float],
    *,
    depth_m: float | None = None,
    pose: Pose | None = None,
    per_taxel: int = 8,
) -> NDArray[np.float64]:
    """Return the height map V of a solid's face over a pad, averaged over each taxel.

    Parameters
    ----------
    solid : Solid
        The solid.
    shape, pitch_m
        The pad, as in `pad_points`.
    depth_m : float, optional
        How much of the solid stands above the standard plane, from its highest point down, metres;
        default: all of it. May not exceed `solid.top_m`.
    pose : Pose, optional
        Default: centred.
    per_taxel : int
        Samples along each side of a taxel for the average.

    Returns
    -------
    ndarray of shape `shape`, float64
        Metres above the standard plane.

    Raises
    ------
    InputError
        If a value is impossible, or the depth is not within (0, solid.top_m].
    """
    require_a(Solid, solid, "solid", "as Sphere(0.02) is")
    given = as_array(solid.top_m if depth_m is None else depth_m)
    if given.shape != () or not 0 < given <= solid.top_m * (1 + 1e-12):
        raise InputError(f"depth_m must lie in (0, {solid.top_m:g}], the height of the {solid.name}, got {depth_m!r}")
    depth = float(given)
    x, y = pad_points(shape, pitch_m, per_taxel=per_taxel)
    above = np.maximum(solid.placed(x, y, pose) - (solid.top_m - depth), 0.0)
    rows, cols = shape
    mean: NDArray[np.float64] = above.reshape(rows, per_taxel, cols, per_taxel).mean(axis=(1, 3))
    return mean
