"""The numbers of frames' sections: at absolute thresholds, and at shares of each frame's own peak."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from varishold.levelset import find_contacts_batch
from varishold.levelset.joined import join_sections

__all__ = ["Cuts"]

Floats = NDArray[np.float64]

_PER_SECTION = (
    "area",
    "perimeter",
    "x",
    "y",
    "variance_x",
    "covariance_xy",
    "variance_y",
    "length",
    "breadth",
)
# What is measured of a section as `join_sections` calls it.
_JOINED = ("area", "perimeter", "x", "y", "xx", "xy", "yy", "length", "breadth")
_WHOLE = ("total", "peak", "touched_area", "x", "y", "contacts")


@dataclass(frozen=True, eq=False)
class Cuts:
    """Where frames are cut.

    Parameters
    ----------
    floor : float
        The standard plane, in the unit of the frames.
    levels : ndarray of shape (n_levels,), float64
        Absolute thresholds, falling.
    shares : ndarray of shape (n_shares,), float64
        Shares of the way from the floor to a frame's own peak, falling.
    """

    floor: float
    levels: Floats
    shares: Floats

    def names(self) -> list[str]:
        """Return the name of every number that `measure` gives."""
        levels = [f"level_{i + 1}" for i in range(len(self.levels))]
        shares = [f"{share:.3g}_of_peak" for share in self.shares]
        names = [f"{measure}_above_{level}" for some in (levels, shares) for measure in _PER_SECTION for level in some]
        for some in (levels, shares):
            names += [
                f"growth_from_{a.removesuffix('_of_peak')}_to_{b.removeprefix('level_')}" for a, b in pairwise(some)
            ]
        return [*names, *_WHOLE]

    def measure(self, frames: Floats, field: NDArray[np.bool_]) -> Floats:
        """Measure frames of one pad.

        Parameters
        ----------
        frames : ndarray of shape (n, rows, cols), float64
        field : ndarray of shape (rows, cols), bool
            Where there are taxels.

        Returns
        -------
        ndarray of shape (n, n_numbers), float64
            The sections of all contacts of a frame taken together; 0 of an empty one.
        """
        height = np.maximum((frames if field.all() else np.where(field, frames, self.floor)) - self.floor, 0.0)
        peaks = height.max(axis=(1, 2), keepdims=True)[:, 0]
        absolute = np.broadcast_to(self.levels, (len(frames), len(self.levels)))
        thresholds = np.concatenate([absolute, self.floor + peaks * self.shares], axis=1)
        order = np.argsort(-thresholds, axis=1, kind="stable")
        batch = find_contacts_batch(frames, thresholds, field=None if field.all() else field, floor=self.floor)
        joined = join_sections(batch.frame, len(frames), batch.area, batch.perimeter, batch.centroid, batch.covariance)
        sections = np.stack([joined[name] for name in _JOINED], axis=1)
        sections = np.take_along_axis(sections, np.argsort(order, axis=1)[:, None], axis=2)
        of_each = [sections[:, :, : len(self.levels)], sections[:, :, len(self.levels) :]]
        return np.concatenate(
            [
                *(some.reshape(len(frames), -1) for some in of_each),
                *(_growth(some[:, 0]) for some in of_each),
                _whole(height, batch.n_found),
            ],
            axis=1,
        )


def _growth(area: Floats) -> Floats:
    """Return each section's area as a share of the next lower one's, 0 where that is empty."""
    lower = area[:, 1:]
    return np.where(lower > 0, area[:, :-1] / np.where(lower > 0, lower, 1.0), 0.0)


def _whole(height: Floats, contacts: NDArray[np.integer]) -> Floats:
    rows, cols = height.shape[1:]
    total = height.sum(axis=(1, 2))
    safe = np.where(total > 0, total, np.inf)
    x = (height.sum(axis=1) @ (np.arange(cols) - 0.5 * (cols - 1))) / safe
    y = (height.sum(axis=2) @ (np.arange(rows) - 0.5 * (rows - 1))) / safe
    peak, touched = height.max(axis=(1, 2)), (height > 0).sum(axis=(1, 2))
    return np.stack([total, peak, touched, x, y, contacts], axis=1).astype(np.float64)
