"""Sections of all contacts of a frame, taken together."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from varishold.levelset.second_moments import principal_moments

__all__ = ["join_sections"]

Floats = NDArray[np.float64]


def join_sections(
    frame: NDArray[np.integer], n_frames: int, area: Floats, perimeter: Floats, centroid: Floats, covariance: Floats
) -> dict[str, Floats]:
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

    Returns
    -------
    dict of str to ndarray of shape (n_frames, n_levels), float64
        ``area`` and ``perimeter``, sums over the contacts; ``x`` and ``y``, the common centroid; ``xx``, ``xy`` and
        ``yy``, second central moments over the area; ``length`` and ``breadth``, axes of the ellipse that has these.
        0 where nothing is touched.
    """
    levels = np.arange(area.shape[1])
    last = np.where(np.isnan(area), -1, levels).max(axis=1, initial=-1)
    kept = np.minimum(levels, np.maximum(last, 0)[:, None])
    row = np.arange(len(area))[:, None]
    area, perimeter, centroid, covariance = (_known(of[row, kept]) for of in (area, perimeter, centroid, covariance))

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
    return {
        "area": total,
        "perimeter": together(perimeter),
        "x": x,
        "y": y,
        "xx": xx,
        "xy": xy,
        "yy": yy,
        "length": length,
        "breadth": breadth,
    }


def _known(measures: Floats) -> Floats:
    measures[np.isnan(measures)] = 0.0
    return measures
