"""How far apart taxels at any positions are, and which stand near a point, without looking at all pairs."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

__all__ = ["groups_of", "spacing_of", "standing_near"]

Floats = NDArray[np.float64]
Indices = NDArray[np.intp]

# Taxels are as far apart as most are from their third neighbour, of so many and more: where they stand without order
# the first one stands close by chance.
_THIRD, _SOME = 2, 9
# Points that are looked at together.
_TOGETHER = 64
# What a circle around a group may be short of by rounding.
_ROUNDING = 1e-9


def spacing_of(positions: Floats) -> float:
    """Return how far apart taxels are, as most of them are from a neighbour.

    Parameters
    ----------
    positions : ndarray of shape (n_taxels, 2), float64
        Two taxels or more.
    """
    rank = _THIRD if len(positions) >= _SOME else 0
    to_neighbour = np.empty(len(positions))
    for group in groups_of(positions):
        # What is near within the group bounds what is near of all.
        bound = float(_ranked(positions[group], group, positions, group, rank).max())
        near = standing_near(positions, positions[group], bound)
        to_neighbour[group] = _ranked(positions[group], group, positions, near, rank)
    return float(np.median(to_neighbour))


def groups_of(points: Floats) -> Iterator[Indices]:
    """Yield the points' numbers in groups of a few tens that lie close together.

    Parameters
    ----------
    points : ndarray of shape (n_points, 2), float64
    """
    waiting: list[Indices] = [np.arange(len(points))]
    while waiting:
        group = waiting.pop()
        if len(group) <= _TOGETHER:
            yield group
            continue
        along = points[group, int(np.ptp(points[group], axis=0).argmax())]
        half = len(group) // 2
        order = np.argpartition(along, half)
        waiting += [group[order[half:]], group[order[:half]]]


def standing_near(positions: Floats, group: Floats, reach: float) -> Indices:
    """Return, in their order, all taxels that stand within `reach` of a point of a group, and some more.

    Parameters
    ----------
    positions : ndarray of shape (n_taxels, 2), float64
    group : ndarray of shape (n_points, 2), float64
    reach : float
    """
    within = (1 + _ROUNDING) * reach
    low, high = group.min(axis=0) - within, group.max(axis=0) + within
    near: Indices = np.flatnonzero(((positions >= low) & (positions <= high)).all(axis=1))
    return near


def _ranked(points: Floats, numbers: Indices, positions: Floats, near: Indices, rank: int) -> Floats:
    """Return how far each point's neighbour of some rank is, among the taxels `near`, itself apart."""
    apart = np.linalg.norm(points[:, None] - positions[near], axis=2)
    apart[numbers[:, None] == near] = np.inf
    ranked: Floats = np.partition(apart, rank, axis=1)[:, rank]
    return ranked
