"""Taxels that stand on no grid: a frame on a grid from them."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from varishold.errors import InputError

__all__ = ["Resampling", "resampling_of"]

Floats = NDArray[np.float64]

# A point of the grid belongs to the field if a taxel stands within so many spacings.
_REACH = 0.75
# Neighbours are weighed by a Gaussian of so many spacings, and looked at up to so many of its widths.
_WIDTH, _WIDTHS = 0.5, 4.0
# Pull of a fitted plane's slope towards level, beside the weight of the neighbours, where they lie on a line.
_LEVEL = 1e-9
# Taxels are as far apart as most are from their third neighbour, of so many and more: where they stand without order
# the first one stands close by chance.
_THIRD, _SOME = 2, 9
# A neighbour stands within so many spacings; on a hexagonal grid there are six of them, on a square one four.
_NEIGHBOUR = 1.2
# Far more points than any skin's taxels ask for.
_MOST_POINTS = 1 << 16
# No patch has so many taxels in a line; farther off, planes through taxels are lost in rounding.
_FARTHEST = 1e5


@dataclass(frozen=True, eq=False)
class Resampling:
    """From taxels at any positions to a frame.

    Each point of the grid is given the value there of the plane that fits the taxels around it best, near ones
    weighing more (moving least squares): a plane comes out as it went in.

    Parameters
    ----------
    weights : ndarray of shape (rows * cols, n_taxels), float64
        Share of each taxel in each point.
    nearness : ndarray of shape (rows * cols, n_taxels), float64
        The same without planes: not negative, each point's sum 1.
    field : ndarray of shape (rows, cols), bool
        Where the grid has taxels near.
    pitch_m : (float, float)
        Spacing of the grid.
    origin_m : (float, float)
        (x, y) of the grid's centre in the taxels' own coordinates.
    """

    weights: Floats
    nearness: Floats
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
        there[self.nearness.argmax(axis=0)] = True
        return there.reshape(self.shape)

    def frame(self, values: Floats) -> Floats:
        """Return the frame of one reading a taxel, 0 outside the field; a NaN reading is passed over."""
        flat = values.reshape(-1)
        broken = np.isnan(flat)
        if broken.any():
            flat = self.filled(flat, broken)
        return np.where(self.field, (self.weights @ flat).reshape(self.shape), 0.0)

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
        near = np.where(broken, 0.0, self.nearness)
        total = near.sum(axis=1)
        around = (np.where(broken, 0.0, values) @ near.T) / np.maximum(total, 1e-300)
        back = np.where(total > 0, around, 0.0) @ self.nearness / np.maximum(self.nearness.sum(axis=0), 1e-300)
        return np.where(broken, back, values)

    def share(self, marked: NDArray[np.bool_]) -> Floats:
        """Return the share of marked taxels in each point of the grid, shape (rows, cols)."""
        return (self.nearness @ marked.reshape(-1)).reshape(self.shape)

    def __str__(self) -> str:
        rows, cols = self.shape
        dy, dx = (1e3 * p for p in self.pitch_m)
        spacing = f"{dy:.3g}" if math.isclose(dx, dy) else f"{dy:.3g} x {dx:.3g}"
        return f"{self.weights.shape[1]} taxels on no grid are resampled to {rows} x {cols} at {spacing} mm"


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
        If the taxels do not span an area, or the grid would be enormous.
    """
    n = positions_m.shape[0]
    apart = np.linalg.norm(positions_m[:, None] - positions_m[None], axis=2)
    np.fill_diagonal(apart, np.inf)
    rank = _THIRD if n >= _SOME else 0
    spacing = float(np.median(np.partition(apart, rank, axis=1)[:, rank]))
    low, high = positions_m.min(axis=0), positions_m.max(axis=0)
    if max(high - low) > _FARTHEST * spacing:
        raise InputError(
            f"positions_m of a sensor reach over {max(high - low):g} m, and its taxels are {spacing:g} m apart: all "
            "must be in metres"
        )
    if pitch_m is None:
        # The taxels of a hexagonal grid have sqrt(3) / 2 of a square's area each.
        neighbours = np.quantile((apart < _NEIGHBOUR * spacing).sum(axis=1), 0.75)
        side = spacing * math.sqrt(math.sqrt(3) / 2) if neighbours > 4 else spacing
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
    weights, nearness, reached = np.zeros((len(points), n)), np.zeros((len(points), n)), np.zeros(len(points), np.bool_)
    for i, point in enumerate(points):
        away = positions_m - point
        distance = np.linalg.norm(away, axis=1)
        reached[i] = distance.min() <= _REACH * max(spacing, *pitch_m)
        width = _WIDTH * max(spacing, float(distance.min()))
        near = np.exp(-0.5 * (distance / width) ** 2) * (distance <= _WIDTHS * width)
        nearness[i] = near / near.sum()
        # In what the point is far from its nearest taxel, so that the plane's pull towards level counts far out too.
        weights[i] = _plane(away / max(spacing, float(distance.min())), nearness[i])
    return Resampling(weights, nearness, reached.reshape(rows, cols), (dy, dx), (float(middle[0]), float(middle[1])))


def _plane(away: Floats, near: Floats) -> Floats:
    """Return the share of each taxel in the value at 0 of the weighted best plane."""
    base = np.column_stack([np.ones(len(away)), away])
    normal = (base * near[:, None]).T @ base + np.diag([0.0, _LEVEL, _LEVEL])
    shares: Floats = np.linalg.solve(normal, (base * near[:, None]).T)[0]
    return shares
