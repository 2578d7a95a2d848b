"""Taxels that stand on no grid: a frame on a grid from them."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from varishold._counted import counted
from varishold.errors import InputError
from varishold.frame.taxels_apart import groups_of, spacing_of, standing_near

__all__ = ["Resampling", "resampling_of"]

Floats = NDArray[np.float64]
Indices = NDArray[np.intp]

# A point of the grid belongs to the field if a taxel stands within so many spacings.
_REACH = 0.75
# Neighbours are weighed by a Gaussian of so many spacings, and looked at up to so many of its widths.
_WIDTH, _WIDTHS = 0.5, 4.0
# Pull of a fitted plane's slope towards level, beside the weight of the neighbours, where they lie on a line.
_LEVEL = 1e-9
# A neighbour stands within so many spacings; on a hexagonal grid there are six of them, on a square one four.
_NEIGHBOUR = 1.2
# Far more points than any skin's taxels ask for.
_MOST_POINTS = 1 << 16
# No patch has so many taxels in a line; farther off, planes through taxels are lost in rounding.
_FARTHEST = 1e5
# No skin reaches farther, metres.
_FARTHEST_M = 100.0


@dataclass(frozen=True, eq=False)
class Shares:
    """The share of taxels in points, of those alone that have one: few stand near a point.

    Parameters
    ----------
    first : ndarray of shape (n_points,), intp
        Where each point's entries begin; every point has one.
    taxel : ndarray of shape (n_entries,), intp
        Whose share it is.
    weights : ndarray of shape (n_entries,), float64
        The share itself.
    nearness : ndarray of shape (n_entries,), float64
        The same without planes: not negative, each point's sum 1.
    n_taxels : int
    """

    first: Indices
    taxel: Indices
    weights: Floats
    nearness: Floats
    n_taxels: int

    @cached_property
    def point(self) -> Indices:
        """In which point each share is; shape (n_entries,)."""
        return np.repeat(np.arange(len(self.first)), np.diff(self.first, append=len(self.taxel)))

    @cached_property
    def total_nearness(self) -> Floats:
        """The sum of each taxel's nearness, shape (n_taxels,)."""
        return self._at_taxels(self.nearness)

    def sums(self, shares: Floats, values: Floats) -> Floats:
        """Return each point's sum of the taxels' values by their shares; shape (n_points,)."""
        sums: Floats = np.add.reduceat(shares * values[self.taxel], self.first)
        return sums

    def back(self, values: Floats) -> Floats:
        """Return each taxel's mean of the points' values by its nearness; shape (n_taxels,)."""
        return self._at_taxels(self.nearness * values[self.point]) / np.maximum(self.total_nearness, 1e-300)

    def nearest(self) -> Indices:
        """Return the point to which each taxel is nearest, the first of several."""
        order = np.lexsort((self.point, -self.nearness, self.taxel))
        taxels, first = np.unique(self.taxel[order], return_index=True)
        nearest = np.zeros(self.n_taxels, np.intp)
        nearest[taxels] = self.point[order[first]]
        return nearest

    def _at_taxels(self, values: Floats) -> Floats:
        sums: Floats = np.bincount(self.taxel, values, self.n_taxels).astype(np.float64, copy=False)
        return sums


@dataclass(frozen=True, eq=False)
class Resampling:
    """From taxels at any positions to a frame.

    Each point of the grid is given the value there of the plane that fits the taxels around it best, near ones
    weighing more (moving least squares): a plane comes out as it went in.

    Parameters
    ----------
    shares : Shares
        Of the taxels in the grid's points, row after row.
    field : ndarray of shape (rows, cols), bool
        Where the grid has taxels near.
    pitch_m : (float, float)
        Spacing of the grid.
    origin_m : (float, float)
        (x, y) of the grid's centre in the taxels' own coordinates.
    """

    shares: Shares
    field: NDArray[np.bool_]
    pitch_m: tuple[float, float]
    origin_m: tuple[float, float]

    @property
    def shape(self) -> tuple[int, int]:
        return int(self.field.shape[0]), int(self.field.shape[1])

    @cached_property
    def stands(self) -> NDArray[np.bool_]:
        """At which points a taxel stands, or nearest; shape (rows, cols)."""
        there = np.zeros(self.field.size, np.bool_)
        there[self.shares.nearest()] = True
        return there.reshape(self.shape)

    def frame(self, values: Floats) -> Floats:
        """Return the frame of one reading a taxel, 0 outside the field; a NaN reading is passed over."""
        flat = values.reshape(-1)
        broken = np.isnan(flat)
        if broken.any():
            flat = self.filled(flat, broken)
        return np.where(self.field, self.shares.sums(self.shares.weights, flat).reshape(self.shape), 0.0)

    def filled(self, values: Floats, broken: NDArray[np.bool_]) -> Floats:
        """Return readings whose broken taxels read what the grid has around them.

        Parameters
        ----------
        values : ndarray of shape (..., n_taxels), float64
        broken : ndarray of shape (n_taxels,), bool

        Raises
        ------
        InputError
            If every taxel is broken.
        """
        if broken.all():
            raise InputError(f"all {broken.size} taxels are broken: nothing to resample from")
        total = self.shares.sums(self.shares.nearness, (~broken).astype(np.float64))
        back = np.empty(values.shape)
        for at in np.ndindex(values.shape[:-1]):
            around = self.shares.sums(self.shares.nearness, np.where(broken, 0.0, values[at]))
            back[at] = self.shares.back(np.where(total > 0, around / np.maximum(total, 1e-300), 0.0))
        return np.where(broken, back, values)

    def share(self, marked: NDArray[np.bool_]) -> Floats:
        """Return the share of marked taxels in each point of the grid, shape (rows, cols)."""
        return self.shares.sums(self.shares.nearness, marked.reshape(-1).astype(np.float64)).reshape(self.shape)

    def __str__(self) -> str:
        rows, cols = self.shape
        dy, dx = (1e3 * p for p in self.pitch_m)
        spacing = f"{dy:.3g}" if math.isclose(dx, dy) else f"{dy:.3g} x {dx:.3g}"
        there = counted(self.shares.n_taxels, "taxel on no grid is", "taxels on no grid are")
        return f"{there} resampled to {rows} x {cols} at {spacing} mm"


def resampling_of(positions_m: Floats, pitch_m: tuple[float, float] | None = None) -> Resampling:
    """Return the resampling of taxels at given positions.

    Parameters
    ----------
    positions_m : ndarray of shape (n_taxels, 2), float64
        (x, y) of each taxel, metres.
    pitch_m : (float, float), optional
        Spacing of the grid. Default: one that has about as many points as there are taxels.

    Raises
    ------
    InputError
        If the taxels do not span an area, or reach farther than any skin, or the grid would be enormous.
    """
    spacing = spacing_of(positions_m)
    low, high = positions_m.min(axis=0), positions_m.max(axis=0)
    reach = float(max(high - low))
    if reach > _FARTHEST * spacing:
        raise InputError(
            f"positions_m of a sensor reach over {reach:g} m, and its taxels are {spacing:g} m apart: all "
            "must be in metres"
        )
    if reach > _FARTHEST_M:
        raise InputError(
            f"positions_m of a sensor reach over {reach:.3g} m, and no skin over more than {_FARTHEST_M:g}: are they "
            "in millimetres? give them in metres"
        )
    if pitch_m is None:
        # The taxels of a hexagonal grid have sqrt(3) / 2 of a square's area each.
        side = spacing * math.sqrt(math.sqrt(3) / 2) if _are_hexagonal(positions_m, spacing) else spacing
        pitch_m = (side, side)
    along = np.linalg.svd(positions_m - positions_m.mean(axis=0), full_matrices=False)[2]
    if np.ptp(positions_m @ along[-1]) < 0.5 * spacing:
        raise InputError("positions_m of a sensor stand on one line: give a shape of one row instead")
    dy, dx = pitch_m
    cols, rows = (math.floor(length / step + 1e-6) + 1 for length, step in zip(high - low, (dx, dy), strict=True))
    if rows * cols > _MOST_POINTS:
        raise InputError(f"positions_m on a grid of {dy:g} m would be {rows} x {cols} points; give a larger pitch_m")
    middle = (low + high) / 2
    x = middle[0] + (np.arange(cols) - (cols - 1) / 2) * dx
    y = middle[1] + (np.arange(rows) - (rows - 1) / 2) * dy
    points = np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)
    shares, nearest = _shares(points, positions_m, spacing)
    field = (nearest <= _REACH * max(spacing, *pitch_m)).reshape(rows, cols)
    return Resampling(shares, field, (dy, dx), (float(middle[0]), float(middle[1])))


def _are_hexagonal(positions: Floats, spacing: float) -> bool:
    """Tell whether a good part of the taxels has more than four neighbours."""
    neighbours = np.empty(len(positions))
    for group in groups_of(positions):
        near = standing_near(positions, positions[group], _NEIGHBOUR * spacing)
        apart = np.linalg.norm(positions[group][:, None] - positions[near], axis=2)
        neighbours[group] = (apart < _NEIGHBOUR * spacing).sum(axis=1) - 1  # itself
    return bool(np.quantile(neighbours, 0.75) > 4)


def _shares(points: Floats, positions: Floats, spacing: float) -> tuple[Shares, Floats]:
    """Return the shares of taxels in points, and how far each point is from its nearest taxel."""
    nearest = np.empty(len(points))
    parts: list[tuple[Indices, Indices, Floats, Floats]] = []
    for group in groups_of(points):
        here = points[group]
        # No point of the group is farther from its nearest taxel than from the one that is nearest to the first.
        one = positions[np.linalg.norm(positions - here[0], axis=1).argmin()]
        bound = float(np.linalg.norm(here - one, axis=1).max())
        around = positions[standing_near(positions, here, bound)]
        nearest[group] = np.linalg.norm(here[:, None] - around, axis=2).min(axis=1)
        width = _WIDTH * np.maximum(spacing, nearest[group])
        near = standing_near(positions, here, _WIDTHS * float(width.max()))
        away = positions[near] - here[:, None]
        distance = np.linalg.norm(away, axis=2)
        share = np.exp(-0.5 * (distance / width[:, None]) ** 2) * (distance <= _WIDTHS * width[:, None])
        share /= share.sum(axis=1, keepdims=True)
        # In what a point is far from its nearest taxel, so that the plane's pull towards level counts far out too.
        plane = _planes(away / np.maximum(spacing, nearest[group])[:, None, None], share)
        point, taxel = np.nonzero(share)
        parts.append((group[point], near[taxel], plane[point, taxel], share[point, taxel]))
    point, taxel, weights, nearness = (np.concatenate(columns) for columns in zip(*parts, strict=True))
    order = np.argsort(point, kind="stable")
    first = np.searchsorted(point[order], np.arange(len(points)))
    return Shares(first, taxel[order], weights[order], nearness[order], len(positions)), nearest


def _planes(away: Floats, near: Floats) -> Floats:
    """Return the share of each taxel in the value at 0 of the weighted best plane, for each point.

    Parameters
    ----------
    away : ndarray of shape (n_points, n_taxels, 2), float64
        From each point to each taxel.
    near : ndarray of shape (n_points, n_taxels), float64
        How much each taxel weighs.
    """
    base = np.concatenate([np.ones((*near.shape, 1)), away], axis=2)
    weighed = base * near[:, :, None]
    normal = weighed.transpose(0, 2, 1) @ base + np.diag([0.0, _LEVEL, _LEVEL])
    shares: Floats = np.linalg.solve(normal, weighed.transpose(0, 2, 1))[:, 0]
    return shares
