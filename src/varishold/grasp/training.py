"""Training grasps: equal ones merged, contradictory ones settled, in an order that nothing else decides."""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

__all__ = ["SeenGrasps", "TrainingGrasps", "distinct_rows", "enemy_pairs", "training_grasps"]


@dataclass(frozen=True, eq=False)
class SeenGrasps:
    """Every pattern with every class that it was seen of: what probabilities are learned from.

    Parameters
    ----------
    patterns : ndarray of shape (n, n_switches), bool
        Lexicographically sorted; one stands there once for each of its classes.
    labels : ndarray of shape (n,), int64
        Class of each, an index into `TrainingGrasps.classes`.
    weights : ndarray of shape (n,), int64
        How many training grasps of that class gave the pattern.
    owners : ndarray of shape (n_rows,), int64
        Which of them each training row is.
    """

    patterns: NDArray[np.bool_]
    labels: NDArray[np.int64]
    weights: NDArray[np.int64]
    owners: NDArray[np.int64]

    def __len__(self) -> int:
        return len(self.patterns)


@dataclass(frozen=True, eq=False)
class TrainingGrasps:
    """The distinct patterns of a training set and the class of each.

    Patterns stand in lexicographic order and classes in the order of their patterns, so that neither the
    order of the rows nor the classes' names can change what is learned.

    Parameters
    ----------
    patterns : ndarray of shape (n, n_switches), bool
        Distinct patterns, lexicographically sorted.
    labels : ndarray of shape (n,), int64
        Class of each pattern, an index into `classes`.
    weights : ndarray of shape (n,), int64
        How many training grasps of that class gave the pattern.
    numbers : ndarray of shape (n,), int64
        Row of the first such grasp in the training set, counted from one: the paper's j of v_j.
    classes : tuple
        Class labels: fewest patterns first, then by their patterns.
    duplicates : tuple of tuple of int
        Groups of training rows (from one) that repeat a pattern of the same class.
    contradictions : tuple of tuple of int
        Groups of training rows (from one) with one pattern and several classes. The pattern is learned for
        the class with most of its grasps; where no class has most, it is not learned.
    owners : ndarray of shape (n_rows,), int64
        Which pattern each training row has taught; -1 where it contradicts the one that was learned.
    seen : SeenGrasps
        All training grasps, contradictory ones too.
    """

    patterns: NDArray[np.bool_]
    labels: NDArray[np.int64]
    weights: NDArray[np.int64]
    numbers: NDArray[np.int64]
    classes: tuple[Hashable, ...]
    seen: SeenGrasps
    duplicates: tuple[tuple[int, ...], ...] = ()
    contradictions: tuple[tuple[int, ...], ...] = ()
    owners: NDArray[np.int64] = field(default_factory=lambda: np.zeros(0, dtype=np.int64))

    def __len__(self) -> int:
        return len(self.patterns)

    @property
    def n_switches(self) -> int:
        """How many switches a pattern has."""
        return int(self.patterns.shape[1])

    @property
    def n_classes(self) -> int:
        """How many classes were seen, learned patterns or not."""
        return len(self.classes)


def enemy_pairs(labels: NDArray[np.int64]) -> NDArray[np.int64]:
    """Index pairs (i, j), i < j, of patterns of different classes, shape (n_pairs, 2)."""
    i, j = np.triu_indices(len(labels), 1)
    different = labels[i] != labels[j]
    return np.column_stack([i[different], j[different]])


def distinct_rows(
    patterns: NDArray[np.bool_],
) -> tuple[NDArray[np.bool_], NDArray[np.int64], NDArray[np.int64]]:
    """Distinct rows in lexicographic order, the first row of each, and which of them every row is."""
    if not patterns.size:
        return patterns[:1], np.zeros(len(patterns[:1]), dtype=np.int64), np.zeros(len(patterns), dtype=np.int64)
    packed = np.ascontiguousarray(np.packbits(patterns, axis=1))
    keys = packed.view(np.dtype((np.void, packed.shape[1]))).ravel()
    _, first, inverse = np.unique(keys, return_index=True, return_inverse=True)
    return patterns[first], first.astype(np.int64), inverse.ravel().astype(np.int64)


def training_grasps(patterns: NDArray[np.bool_], labels: Sequence[Hashable]) -> TrainingGrasps:
    """Merge equal grasps, settle contradictory ones and bring all into canonical order.

    Examples
    --------
    >>> grasps = training_grasps(np.array([[1, 0], [0, 1], [1, 0], [0, 1]], dtype=bool), ["a", "b", "a", "a"])
    >>> grasps.patterns.astype(int), grasps.labels, grasps.duplicates, grasps.contradictions
    (array([[1, 0]]), array([0]), ((1, 3),), ((2, 4),))
    """
    names = sorted(set(labels), key=lambda name: (str(type(name)), name))
    code_of = {name: k for k, name in enumerate(names)}
    codes = np.array([code_of[name] for name in labels], dtype=np.int64)
    distinct, first, inverse = distinct_rows(patterns)
    votes = np.zeros((len(distinct), len(names)), dtype=np.int64)
    np.add.at(votes, (inverse, codes), 1)
    most = votes.max(axis=1)
    settled = (votes == most[:, None]).sum(axis=1) == 1
    winner = votes.argmax(axis=1)
    duplicates: list[tuple[int, ...]] = []
    contradictions: list[tuple[int, ...]] = []
    for k in np.flatnonzero(votes.sum(axis=1) > 1):
        rows = tuple(int(row) + 1 for row in np.flatnonzero(inverse == k))
        (duplicates if (votes[k] > 0).sum() == 1 else contradictions).append(rows)
    numbers = np.array(
        [first[k] if settled[k] and votes[k].sum() == most[k] else _first(inverse, codes, k, winner[k])
         for k in range(len(distinct))],
        dtype=np.int64,
    )  # fmt: skip
    order = _canonical_classes(names, winner, settled)
    rank = np.argsort(order)
    return TrainingGrasps(
        patterns=distinct[settled],
        labels=rank[winner[settled]],
        weights=most[settled],
        numbers=numbers[settled] + 1,
        classes=tuple(names[k] for k in order),
        seen=_seen(distinct, inverse, rank[codes]),
        duplicates=tuple(sorted(duplicates)),
        contradictions=tuple(sorted(contradictions)),
        owners=np.where(settled[inverse] & (winner[inverse] == codes), np.cumsum(settled)[inverse] - 1, -1),
    )


def _seen(distinct: NDArray[np.bool_], inverse: NDArray[np.int64], labels: NDArray[np.int64]) -> SeenGrasps:
    """Return what was seen; `inverse` and `labels` are each row's pattern and class."""
    pairs, owners, weights = np.unique(
        np.column_stack([inverse, labels]), axis=0, return_inverse=True, return_counts=True
    )
    return SeenGrasps(distinct[pairs[:, 0]], pairs[:, 1], weights.astype(np.int64), owners.ravel().astype(np.int64))


def _first(inverse: NDArray[np.int64], codes: NDArray[np.int64], k: int, code: int) -> int:
    return int(np.flatnonzero((inverse == k) & (codes == code))[0])


def _canonical_classes(names: Sequence[Hashable], winner: NDArray[np.int64], settled: NDArray[np.bool_]) -> list[int]:
    """Order classes by how many patterns they have, then by the positions of these; those without come last."""
    keys = []
    for k in range(len(names)):
        own = np.flatnonzero(settled & (winner == k))
        keys.append((len(own) == 0, len(own), tuple(own.tolist()), k))
    return [key[-1] for key in sorted(keys)]
