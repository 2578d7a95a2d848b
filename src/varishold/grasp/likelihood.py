"""How likely a pattern is under each class, and how far from every training grasp it lies.

The circuit answers; this says how sure one may be. A class's likelihood of a pattern v is the mean over its
training grasps of exp(-beta d(v, v_i)), d the number of switches that differ: a switch flips with odds
exp(-beta) to one. beta is the value under which each training grasp is best told by the others.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

__all__ = ["GraspLikelihood", "hamming", "learn_likelihood"]

_BETAS = np.geomspace(0.02, 4.0, 24)
#: Grasps that take part in finding beta and the reach, and their distances from all others together.
_JUDGES, _JUDGED_DISTANCES = 1500, 4_000_000
#: Share of training grasps that lie no further from their nearest fellow than `reach`.
_REACH_QUANTILE = 0.98
_CHUNK_ENTRIES = 4_000_000


@dataclass(frozen=True, eq=False)
class GraspLikelihood:
    """Training grasps as a likelihood.

    Parameters
    ----------
    patterns : ndarray of shape (n, n_switches), bool
    labels : ndarray of shape (n,), int64
        Class of each pattern.
    weights : ndarray of shape (n,), int64
        How many grasps gave the pattern.
    n_classes : int
    beta : float
        Log odds of a switch reading right.
    reach : int
        Farther than this many switches from every training grasp lies no grasp that the classifier knows.
    """

    patterns: NDArray[np.bool_]
    labels: NDArray[np.int64]
    weights: NDArray[np.int64]
    n_classes: int
    beta: float
    reach: int

    @property
    def flip_rate(self) -> float:
        """How often a switch reads wrongly, by beta."""
        return float(1 / (1 + np.exp(self.beta)))

    def posterior(self, X: NDArray[np.bool_]) -> NDArray[np.float64]:
        """P(class) of every pattern under equal priors, shape (n_patterns, n_classes)."""
        out = np.full((len(X), self.n_classes), 1.0 / self.n_classes)
        if not len(self.patterns):
            return out
        for rows in _chunks(len(X), len(self.patterns)):
            distance = hamming(X[rows], self.patterns)
            out[rows] = _posterior(distance, self.labels, self.weights, self.n_classes, self.beta)
        return out

    def nearest(self, X: NDArray[np.bool_]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        """Index of the nearest training pattern (the first of equals) and its distance in switches."""
        index = np.zeros(len(X), dtype=np.int64)
        distance = np.zeros(len(X), dtype=np.int64)
        if not len(self.patterns):
            return index, distance
        for rows in _chunks(len(X), max(1, len(self.patterns))):
            all_of_them = hamming(X[rows], self.patterns)
            index[rows] = all_of_them.argmin(axis=1)
            distance[rows] = all_of_them.min(axis=1)
        return index, distance


def learn_likelihood(
    patterns: NDArray[np.bool_], labels: NDArray[np.int64], weights: NDArray[np.int64], n_classes: int
) -> GraspLikelihood:
    """Find beta and the reach from the training grasps, each left out in turn."""
    if len(patterns) < 2:
        return GraspLikelihood(patterns, labels, weights, n_classes, 1.0, patterns.shape[1])
    some = np.arange(len(patterns))
    judges = min(_JUDGES, _JUDGED_DISTANCES // len(patterns))
    if len(some) > judges:
        some = np.sort(np.random.default_rng(0).choice(some, judges, replace=False))
    distance = hamming(patterns[some], patterns)
    # A pattern that was grasped more than once still has fellows at distance zero when one is left out.
    alone = np.where(weights[some] > 1, 0.0, np.inf)
    distance[np.arange(len(some)), some] = alone
    fellow = np.where(labels[some][:, None] == labels, distance, np.inf).min(axis=1)
    known = fellow[np.isfinite(fellow)]
    reach = patterns.shape[1]
    if len(known):
        rank = min(len(known), int(np.ceil((len(known) + 1) * _REACH_QUANTILE)))
        reach = int(np.sort(known)[rank - 1])
    told = np.isfinite(fellow)
    beta = 1.0
    if told.any():
        loss = []
        for candidate in _BETAS:
            p = _posterior(distance[told], labels, weights, n_classes, float(candidate))
            loss.append(-np.log(np.maximum(p[np.arange(len(p)), labels[some][told]], 1e-12)).mean())
        beta = float(_BETAS[int(np.argmin(loss))])
    return GraspLikelihood(patterns, labels, weights, n_classes, beta, reach)


def hamming(a: NDArray[np.bool_], b: NDArray[np.bool_]) -> NDArray[np.float32]:
    """Numbers of switches in which patterns differ, shape (len(a), len(b)).

    Examples
    --------
    >>> hamming(np.array([[1, 0]], dtype=bool), np.array([[1, 1], [0, 1]], dtype=bool))
    array([[1., 2.]], dtype=float32)
    """
    x, y = a.astype(np.float32), b.astype(np.float32)
    return np.asarray(x.sum(axis=1)[:, None] + y.sum(axis=1) - 2 * (x @ y.T), dtype=np.float32)


def _posterior(
    distance: NDArray[np.float32],
    labels: NDArray[np.int64],
    weights: NDArray[np.int64],
    n_classes: int,
    beta: float,
) -> NDArray[np.float64]:
    energy = -beta * (distance - distance.min(axis=1, keepdims=True)).astype(np.float64)
    kernel = np.exp(energy) * weights
    member = labels[:, None] == np.arange(n_classes)
    counts = np.maximum((weights[:, None] * member).sum(axis=0), 1)
    mass = kernel @ (member / counts) + 1e-12
    return np.asarray(mass / mass.sum(axis=1, keepdims=True), dtype=np.float64)


def _chunks(n: int, width: int) -> list[slice]:
    step = max(1, _CHUNK_ENTRIES // width)
    return [slice(start, start + step) for start in range(0, n, step)]
