"""Sections of all contacts of a frame, taken together."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from varishold.levelset.second_moments import principal_moments

__all__ = ["JoinedSections", "join_sections"]

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class JoinedSections:
    """What is measured of the sections of each frame's contacts together; 0 where nothing is touched.

    Parameters
    ----------
    area, perimeter : ndarray of shape (n_frames, n_levels), float64
        Sums over the contacts.
    x, y : ndarray of shape (n_frames, n_levels), float64
        The common centroid.
    xx, xy, yy : ndarray of shape (n_frames, n_levels), float64
        Second central moments over the area.
    length, breadth : ndarray of shape (n_frames, n_levels), float64
        Axes of the ellipse that has these second moments.
    """

    area: Floats
    perimeter: Floats
    x: Floats
    y: Floats
    xx: Floats
    xy: Floats
    yy: Floats
    length: Floats
    breadth: Floats


def join_sections(
    frame: NDArray[np.integer], n_frames: int, area: Floats, perimeter: Floats, centroid: Floats, covariance: Floats
) -> JoinedSections:
    """Join the sections of contacts to sections of their frames.

    Below its end a contact keeps the last section that was its own.

    Parameters
    ----------
    frame : ndarray of shape (n_contacts,), int
        The frame of each contact.
    n_frames : int
    area, perimeter : ndarray of shape (n_contacts, n_levels), float64
        NaN below a contact's end.
    centroid : ndarray of shape (n_contacts, n_levels, 2), float64
    covariance : ndarray of shape (n_contacts, n_levels, 2, 2), float64
    """
    levels = np.arange(area.shape[1])
    last = np.where(np.isnan(area), -1, levels).max(axis=1, initial=-1)
    kept = np.minimum(levels, np.maximum(last, 0)[:, None])
    row = np.arange(len(area))[:, None]
    area, perimeter, centroid, covariance = (
        np.nan_to_num(of[row, kept]) for of in (area, perimeter, centroid, covariance)
    )

    def together(of: Floats) -> Floats:
        total = np.zeros((n_frames, *of.shape[1:]))
        np.add.at(total, frame, of)
        return total

    total = together(area)
    safe = np.where(total > 0, total, np.inf)
    x, y = (together(area * centroid[..., k]) / safe for k in (0, 1))
    second = area[..., None, None] * (covariance + centroid[..., :, None] * centroid[..., None, :])
    xx = together(second[..., 0, 0]) / safe - x * x
    xy = together(second[..., 0, 1]) / safe - x * y
    yy = together(second[..., 1, 1]) / safe - y * y
    length, breadth = 4 * np.sqrt(principal_moments(xx, xy, yy))
    return JoinedSections(total, together(perimeter), x, y, xx, xy, yy, length, breadth)
