"""What is measured of a contact at every threshold."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from varishold.levelset.columns import (
    AREA,
    CENTROID,
    COVARIANCE,
    EXTENT,
    HOLES,
    N_COLUMNS,
    PARTS,
    PERIMETER,
    THRESHOLD,
)
from varishold.levelset.widths import N_DIRECTIONS

__all__ = ["Profile", "Sections"]


class Sections:
    """What is measured of sections at falling thresholds, of one contact or, with an axis in front, of many.

    Lengths are metres where the pitch is known, taxels otherwise; positions count from the pad's centre, x
    with the column, y with the row. Every property is a view into `measures` or `counts`.
    """

    __slots__ = ()

    measures: NDArray[np.float64]
    counts: NDArray[np.int64]

    def _columns(self, first: int, stop: int) -> NDArray[np.float64]:
        n = self.counts.shape[-1]
        return self.measures[..., first * n : stop * n]

    def _rows(self, first: int, stop: int, *each: int) -> NDArray[np.float64]:
        *contacts, _, n = self.counts.shape
        return self._columns(first, stop).reshape(*contacts, n, *each)

    @property
    def threshold(self) -> NDArray[np.float64]:
        """Thresholds theta_i, falling, in the unit of the frame; shape (..., n_levels)."""
        return self._columns(THRESHOLD, AREA)

    @property
    def area(self) -> NDArray[np.float64]:
        """Areas of the sections {V > theta_i}; shape (..., n_levels). 0 above the peak."""
        return self._columns(AREA, PERIMETER)

    @property
    def perimeter(self) -> NDArray[np.float64]:
        """Lengths of the outlines, holes' too, but not along the pad's border; shape (..., n_levels)."""
        return self._columns(PERIMETER, CENTROID)

    @property
    def centroid(self) -> NDArray[np.float64]:
        """Centroids (x, y); shape (..., n_levels, 2). NaN above the peak."""
        return self._rows(CENTROID, COVARIANCE, 2)

    @property
    def covariance(self) -> NDArray[np.float64]:
        """Second central moments over the area, [[xx, xy], [yx, yy]]; shape (..., n_levels, 2, 2)."""
        return self._rows(COVARIANCE, EXTENT, 2, 2)

    @property
    def extent(self) -> NDArray[np.float64]:
        """Widths between the two supporting lines, in the 16 `DIRECTIONS`; shape (..., n_levels, 16)."""
        return self._rows(EXTENT, N_COLUMNS, N_DIRECTIONS)

    @property
    def parts(self) -> NDArray[np.int64]:
        """Numbers of connected parts; shape (..., n_levels)."""
        parts: NDArray[np.int64] = self.counts[..., PARTS, :]
        return parts

    @property
    def holes(self) -> NDArray[np.int64]:
        """Numbers of holes; shape (..., n_levels). A gap of the field alone is no hole."""
        holes: NDArray[np.int64] = self.counts[..., HOLES, :]
        return holes

    @property
    def measured(self) -> NDArray[np.bool_]:
        """Where the threshold is not below the contact's floor; shape (..., n_levels)."""
        return ~np.isnan(self.area)


@dataclass(frozen=True, slots=True, eq=False)
class Profile(Sections):
    """A contact's sections X_1 ... X_n, measured; entry 0 is nearest the top.

    Parameters
    ----------
    measures : ndarray of shape (25 * n_levels,), float64
        As `varishold.levelset.columns` names the places; NaN where the threshold lies below the contact's
        floor, because there the contact has ended or merged with another.
    counts : ndarray of shape (2, n_levels), int64
        Parts and holes; 0 where not measured.
    """

    measures: NDArray[np.float64]
    counts: NDArray[np.int64]

    def __len__(self) -> int:
        return int(self.counts.shape[1])
