"""Which contact of a frame is which touch of the frames before."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import permutations
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from varishold.touch.tracking.felt import Felt

__all__ = ["Assignment", "Followed", "assign"]

Point = tuple[float, float]
# Contacts that hang together are paired in all ways up to so many, and beyond by the nearest first.
_MOST_PERMUTED = 5
# A touch is part of another's contact where so much of it lies under that.
_COVERED = 0.5


class Followed(Protocol):
    """What is known of a touch before a frame comes."""

    @property
    def taxels(self) -> NDArray[np.intp]:
        """Its taxels when it was last seen, as indices into the flattened frame."""
        ...

    @property
    def expected(self) -> Point:
        """Where its centre of load is expected, in taxels."""
        ...

    @property
    def reach(self) -> float:
        """How far from there it may be found if nothing overlaps it, in taxels."""
        ...


@dataclass(frozen=True)
class Assignment:
    """What became of each touch, and which contacts belong to none.

    Parameters
    ----------
    pairs : dict of int to int
        From a touch's place to the place of its contact.
    merged : dict of int to int
        From a touch's place to that of a contact which is another touch's, and covers it.
    fragments : dict of int to int
        From a contact's place to that of the touch it has fallen off from.
    new : list of int
        Places of contacts that overlap no touch and are near none.
    """

    pairs: dict[int, int] = field(default_factory=dict)
    merged: dict[int, int] = field(default_factory=dict)
    fragments: dict[int, int] = field(default_factory=dict)
    new: list[int] = field(default_factory=list)


def assign(touches: Sequence[Followed], felt: Sequence[Felt]) -> Assignment:
    """Pair touches with contacts: by overlap where there is some, by distance otherwise.

    Touches and contacts that hang together by overlaps are paired so that the sum of distances is least; of two
    touches over one contact the other is merged, of two contacts under one touch the other is a fragment.

    Parameters
    ----------
    touches : sequence of Followed
    felt : sequence of Felt

    Returns
    -------
    Assignment
    """
    if not touches or not felt:
        return Assignment(new=list(range(len(felt))))
    overlap = _overlaps(touches, felt)
    distance = [[math.dist(touch.expected, one.position) for one in felt] for touch in touches]
    result = Assignment()
    for rows, cols in _components(overlap):
        _solve(rows, cols, overlap, distance, touches, result)
    _pair_by_distance(distance, touches, overlap, result)
    taken = {*result.pairs.values(), *result.fragments}
    result.new.extend(k for k in range(len(felt)) if k not in taken)
    return result


def _overlaps(touches: Sequence[Followed], felt: Sequence[Felt]) -> list[list[int]]:
    """Return the taxels that each touch shares with each contact."""
    rows, cols = felt[0].contact.shape
    place = np.zeros(rows * cols, np.intp)
    for k, one in enumerate(felt):
        place[one.taxels] = k + 1
    n = len(felt) + 1
    return [np.bincount(place[touch.taxels], minlength=n)[1:].tolist() for touch in touches]


def _components(overlap: list[list[int]]) -> list[tuple[list[int], list[int]]]:
    """Return the groups of touches and contacts that hang together by overlaps."""
    left = list(range(len(overlap)))
    groups = []
    while left:
        rows, cols = [left.pop(0)], list[int]()
        for i in rows:
            for k, shared in enumerate(overlap[i]):
                if shared and k not in cols:
                    cols.append(k)
                    beside = [j for j in left if overlap[j][k]]
                    rows += beside
                    left = [j for j in left if j not in beside]
        if cols:
            groups.append((sorted(rows), sorted(cols)))
    return groups


def _solve(
    rows: list[int],
    cols: list[int],
    overlap: list[list[int]],
    distance: list[list[float]],
    touches: Sequence[Followed],
    result: Assignment,
) -> None:
    """Pair one group."""
    if len(cols) == 1:
        # The touch that has most of the contact; of two that are one for now, the older.
        pairs = [(max(rows, key=lambda i: (overlap[i][cols[0]], -i)), cols[0])]
    elif len(rows) == 1:
        pairs = [(rows[0], max(cols, key=lambda k: (overlap[rows[0]][k], -distance[rows[0]][k])))]
    else:
        pairs = _least_distance(rows, cols, distance)
        pairs = [(i, k) for i, k in pairs if overlap[i][k] > 0 or distance[i][k] <= touches[i].reach]
    result.pairs.update(pairs)
    paired_rows, paired_cols = {i for i, _ in pairs}, {k for _, k in pairs}
    for i in rows:
        if i not in paired_rows:
            k = max(cols, key=lambda k: overlap[i][k])
            if overlap[i][k] >= _COVERED * len(touches[i].taxels):
                result.merged[i] = k
    for k in cols:
        if k not in paired_cols:
            result.fragments[k] = max(rows, key=lambda i: (overlap[i][k], -i))


def _least_distance(rows: list[int], cols: list[int], distance: list[list[float]]) -> list[tuple[int, int]]:
    """Return the pairs of least total distance, as many as there can be."""
    if max(len(rows), len(cols)) > _MOST_PERMUTED:
        return _nearest_first(rows, cols, distance)
    if len(rows) <= len(cols):
        ways = (list(zip(rows, chosen, strict=True)) for chosen in permutations(cols, len(rows)))
    else:
        ways = (list(zip(chosen, cols, strict=True)) for chosen in permutations(rows, len(cols)))
    return min(ways, key=lambda pairs: sum(distance[i][k] for i, k in pairs))


def _nearest_first(rows: list[int], cols: list[int], distance: list[list[float]]) -> list[tuple[int, int]]:
    pairs: list[tuple[int, int]] = []
    for _, i, k in sorted((distance[i][k], i, k) for i in rows for k in cols):
        if all(i != other and k != its for other, its in pairs):
            pairs.append((i, k))
    return pairs


def _pair_by_distance(
    distance: list[list[float]], touches: Sequence[Followed], overlap: list[list[int]], result: Assignment
) -> None:
    """Pair what overlaps nothing with what is near."""
    rows = [i for i in range(len(touches)) if not any(overlap[i])]
    cols = [k for k in range(len(overlap[0])) if not any(row[k] for row in overlap)]
    for i, k in _nearest_first(rows, cols, distance):
        if distance[i][k] <= touches[i].reach:
            result.pairs[i] = k
