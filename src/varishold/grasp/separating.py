"""The smallest set of hyperplanes that separates every two grasps of different classes.

This is the minimum test collection problem: a set cover whose elements are the pairs of grasps of
different classes and whose sets are the hyperplanes. It is solved exactly by integer programming where
that fits, with a greedy cover as the upper bound; where the proof does not close, the gap is reported.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import combinations
from typing import Any

import numpy as np
from numpy.typing import NDArray

from varishold._counted import counted
from varishold.errors import require
from varishold.grasp.cover import smallest_cover
from varishold.grasp.training import distinct_rows, enemy_pairs

__all__ = ["Selection", "equal_columns", "greedy_cover", "separating_set", "smallest_sets"]

#: Largest cover matrix (pairs times hyperplanes) handed to the solver; beyond it only the greedy cover is given.
_SOLVER_ENTRIES = 4_000_000
#: Above this many elements dominated rows are not looked for: the search itself would cost more.
_REDUCTION_ROWS = 3000
#: Columns whose gains are counted at a time, so that memory stays bounded.
_COLUMNS_AT_ONCE = 4096


@dataclass(frozen=True)
class Selection:
    """A separating set of hyperplanes and what is proved about its size.

    Parameters
    ----------
    columns : tuple of int
        Chosen columns, ascending.
    lower_bound : int
        No separating set has fewer columns.
    """

    columns: tuple[int, ...]
    lower_bound: int

    @property
    def gap(self) -> int:
        """By how many columns the set may be too large; 0 where it is proved smallest."""
        return len(self.columns) - self.lower_bound

    def __str__(self) -> str:
        if self.gap == 0:
            return f"{counted(len(self.columns), 'hyperplane')}, the fewest that separate the classes"
        return (
            f"{len(self.columns)} hyperplanes; between {self.lower_bound} and {len(self.columns)} are needed "
            f"(gap {self.gap})"
        )


def equal_columns(signs: NDArray[np.bool_]) -> list[list[int]]:
    """Group columns that part the rows alike: equal ones and complements of each other.

    Examples
    --------
    >>> equal_columns(np.array([[0, 1, 0], [1, 0, 0]], dtype=bool))
    [[0, 1], [2]]
    """
    turned = signs ^ signs[:1] if len(signs) else signs
    keys = np.packbits(turned, axis=0).T
    groups: dict[bytes, list[int]] = {}
    for column, key in enumerate(keys):
        groups.setdefault(key.tobytes(), []).append(column)
    return list(groups.values())


def separating_set(
    signs: NDArray[np.bool_],
    labels: NDArray[np.int64],
    *,
    keep: tuple[int, ...] = (),
    time_limit_s: float = 10.0,
) -> Selection:
    """Find the fewest columns of a sign table that still separate every two rows of different classes.

    Parameters
    ----------
    signs : ndarray of shape (n_rows, n_columns), bool
        Sign table: a row a grasp, a column a hyperplane.
    labels : ndarray of shape (n_rows,), int
        Class of each row.
    keep : tuple of int
        Columns that are in the set whatever they cost.
    time_limit_s : float
        Seconds for the solver; the best set found by then is returned with its bound.

    Raises
    ------
    InputError
        Where two rows of different classes agree in every column.

    Examples
    --------
    >>> separating_set(np.array([[0, 1, 1], [1, 0, 0], [1, 0, 1]], dtype=bool), np.array([0, 1, 0]))
    Selection(columns=(2,), lower_bound=1)
    """
    groups = equal_columns(signs)
    kept = set(keep)
    merged = [next((c for c in group if c in kept), group[0]) for group in groups]
    table = signs[:, merged]
    forced = tuple(k for k, group in enumerate(groups) if kept.intersection(group))
    rows, row_labels = _distinct_rows(table, labels)
    chosen = greedy_cover(rows, row_labels, keep=forced)
    free = len(chosen) - len(forced)
    lower = max(1, _counting_bound(row_labels)) - len(forced) if len(np.unique(row_labels)) > 1 else 0
    lower = max(lower, 1 if free else 0)
    if free > lower:
        cover = _cover_matrix(rows, row_labels, forced)
        if cover is not None:
            better, bound = smallest_cover(cover, upper=free, lower=lower, time_limit_s=time_limit_s)
            lower = max(lower, bound)
            if better is not None:
                chosen = [*forced, *better]
    columns = tuple(sorted({merged[k] for k in chosen} | kept))
    return Selection(columns, len(columns) - (len(chosen) - len(forced) - lower))


def greedy_cover(signs: NDArray[np.bool_], labels: NDArray[np.int64], *, keep: tuple[int, ...] = ()) -> list[int]:
    """Separate the classes greedily: each next column parts the most pairs that are still together.

    Columns that turn out to be superfluous are taken out again, the `keep` ones excepted. Pairs are
    counted by cells of equal signs, so that memory grows with the rows, not with their pairs.
    """
    cells = distinct_rows(signs[:, list(keep)])[2]
    chosen = list(keep)
    while together := _together(cells, labels):
        gains = _parted(signs, cells, labels)
        best = int(gains.argmax())
        require(
            gains[best] > 0,
            f"{together} pairs of grasps of different classes have equal signs on every hyperplane; "
            "no choice of these hyperplanes separates them",
        )
        chosen.append(best)
        cells = distinct_rows(signs[:, chosen])[2]
    for column in list(reversed(chosen[len(keep) :])):
        rest = [c for c in chosen if c != column]
        if not _together(distinct_rows(signs[:, rest])[2], labels):
            chosen = rest
    return chosen


def smallest_sets(
    signs: NDArray[np.bool_], labels: NDArray[np.int64], *, size: int, limit: int = 200_000
) -> list[tuple[int, ...]] | None:
    """Every separating set of `size` columns, or None where more than `limit` sets would have to be looked at.

    Examples
    --------
    >>> smallest_sets(np.array([[0, 1, 1], [1, 0, 0], [1, 0, 1]], dtype=bool), np.array([0, 1, 0]), size=1)
    [(2,)]
    """
    m = signs.shape[1]
    if math.comb(m, size) > limit:
        return None
    pairs = enemy_pairs(labels)
    apart = signs[pairs[:, 0]] != signs[pairs[:, 1]]
    return [chosen for chosen in combinations(range(m), size) if apart[:, chosen].any(axis=1).all()]


def _distinct_rows(table: NDArray[np.bool_], labels: NDArray[np.int64]) -> tuple[NDArray[np.bool_], NDArray[np.int64]]:
    label_bits = labels[:, None] >> np.arange(32) & 1 == 1
    first = distinct_rows(np.column_stack([table, label_bits]))[1]
    return table[first], labels[first]


def _together(cells: NDArray[np.int64], labels: NDArray[np.int64]) -> int:
    """How many pairs of rows of different classes share a cell."""
    in_cell = np.unique(cells, return_counts=True)[1]
    alike = np.unique(np.column_stack([cells, labels]), axis=0, return_counts=True)[1]
    return int((in_cell**2).sum() - (alike**2).sum()) // 2


def _parted(signs: NDArray[np.bool_], cells: NDArray[np.int64], labels: NDArray[np.int64]) -> NDArray[np.int64]:
    """How many of the pairs that share a cell each column parts, shape (n_columns,)."""
    groups, group_of, sizes = np.unique(
        np.column_stack([cells, labels]), axis=0, return_inverse=True, return_counts=True
    )
    cell_of = np.unique(groups[:, 0], return_inverse=True)[1].ravel()
    out = np.empty(signs.shape[1], dtype=np.int64)
    for start in range(0, signs.shape[1], _COLUMNS_AT_ONCE):
        block = signs[:, start : start + _COLUMNS_AT_ONCE]
        on = _added_rows(block, group_of.ravel(), len(groups))
        off = sizes.astype(np.int32)[:, None] - on
        across = _added_rows(on, cell_of, int(cell_of[-1]) + 1) * _added_rows(off, cell_of, int(cell_of[-1]) + 1)
        out[start : start + _COLUMNS_AT_ONCE] = across.sum(axis=0) - (on * off).sum(axis=0)
    return out


def _added_rows(table: NDArray[Any], group_of: NDArray[np.int64], count: int) -> NDArray[np.int32]:
    """Sum the rows of every group; row by row, for `np.add.reduceat` down an axis is slower a hundred times."""
    out = np.zeros((count, table.shape[1]), dtype=np.int32)
    for row, group in zip(table, group_of.tolist(), strict=True):
        out[group] += row
    return out


def _counting_bound(labels: NDArray[np.int64]) -> int:
    """k columns make at most 2**k cells, and every class needs one of its own."""
    return math.ceil(math.log2(max(1, len(np.unique(labels)))))


def _cover_matrix(
    rows: NDArray[np.bool_], labels: NDArray[np.int64], forced: tuple[int, ...]
) -> NDArray[np.bool_] | None:
    """Elements (pairs not yet parted, dominated ones left out) by columns, or None where it would be too large."""
    pairs = enemy_pairs(labels)
    if len(pairs) * rows.shape[1] > _SOLVER_ENTRIES:
        return None
    apart = rows[pairs[:, 0]] != rows[pairs[:, 1]]
    apart = apart[~apart[:, list(forced)].any(axis=1)]
    apart = np.unique(apart, axis=0)
    if len(apart) > _REDUCTION_ROWS:
        return apart
    # A pair whose columns include all columns of another pair is parted whenever that one is.
    outside = apart.astype(np.float32) @ (~apart).astype(np.float32).T
    dominated = ((outside == 0) & ~np.eye(len(apart), dtype=np.bool_)).any(axis=0)
    return np.asarray(apart[~dominated], dtype=np.bool_)
