"""How likely a pattern is under each class, and how strange it is to all of them.

The circuit answers; this says how sure one may be. A class's likelihood of a pattern v is the mean over its
training grasps of exp(-beta d(v, v_i)), d the number of switches that differ: a switch flips with odds
exp(-beta) to one. beta is the value under which each training grasp is best told by the others, where groups are known
by those of other groups. How strange a pattern is, is minus the logarithm of its likelihood under all classes alike.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from varishold.grasp.held_out import HeldOut, hold_out
from varishold.grasp.training import TrainingGrasps
from varishold.trust import conformal_p_value

__all__ = ["GraspLikelihood", "hamming", "learn_likelihood", "nearest_pattern"]

Floats = NDArray[np.float64]

_BETAS = np.geomspace(0.02, 4.0, 24)
_CHUNK_ENTRIES = 4_000_000
#: Sums in another order differ by less.
_ROUNDING = 1e-9


@dataclass(frozen=True, eq=False)
class GraspLikelihood:
    """Training grasps as a likelihood.

    Parameters
    ----------
    patterns : ndarray of shape (n, n_switches), bool
        One stands there once for each class that it was seen of.
    labels : ndarray of shape (n,), int64
        Class of each pattern.
    weights : ndarray of shape (n,), int64
        How many grasps of that class gave the pattern.
    n_classes : int
    beta : float
        Log odds of a switch reading right.
    held : HeldOut or None
        What known grasps are like; None where there is one only.
    """

    patterns: NDArray[np.bool_]
    labels: NDArray[np.int64]
    weights: NDArray[np.int64]
    n_classes: int
    beta: float
    held: HeldOut | None = None

    @property
    def flip_rate(self) -> float:
        """How often a switch reads wrongly, by beta."""
        return float(1 / (1 + np.exp(self.beta)))

    @property
    def n_known(self) -> int:
        """How many training grasps were held out."""
        return 0 if self.held is None else len(self.held.patterns)

    @property
    def learned(self) -> bool:
        """Whether grasps of one class were seen in two groups, so that beta is learned and not assumed."""
        return self.held is not None and self.held.fellows

    def judge(self, X: NDArray[np.bool_], beyond: ArrayLike = 0.0) -> tuple[Floats, Floats]:
        """Judge patterns.

        Parameters
        ----------
        X : ndarray of shape (n_patterns, n_switches), bool
        beyond : array-like of shape (n_patterns,), default 0
            How far each lies beyond the range of the readings learned, in switches.

        Returns
        -------
        posterior : ndarray of shape (n_patterns, n_classes), float64
            P(class) under equal priors.
        p_values : ndarray of shape (n_patterns,), float64
            How rare it is that a training grasp is as strange to the others: as unlikely under all classes alike.
        """
        posterior = np.full((len(X), self.n_classes), 1.0 / self.n_classes)
        strangeness = self.beta * np.asarray(beyond, dtype=np.float64) + np.zeros(len(X))
        for rows in _chunks(len(X), len(self.patterns)):
            distance = hamming(X[rows], self.patterns)
            posterior[rows], likelihood = _posterior(distance, self.labels, self.weights, self.n_classes, self.beta)
            strangeness[rows] -= likelihood
        return posterior, conformal_p_value(strangeness - _ROUNDING, self.known) if self.n_known else np.ones(len(X))

    @cached_property
    def known(self) -> Floats:
        """How strange known grasps are, shape (n_known,)."""
        if self.held is None:
            return np.zeros(0)
        _, likelihood = self._to_others(hamming(self.patterns[self.held.patterns], self.patterns), self.held, self.beta)
        return self.beta * self.held.beyond - likelihood

    def _to_others(self, distance: NDArray[np.float32], held: HeldOut, beta: float) -> tuple[Floats, Floats]:
        """Return `_posterior` of training grasps by what is left when they are held out."""
        return _posterior(np.where(held.left > 0, distance, np.inf), self.labels, held.left, self.n_classes, beta)


def learn_likelihood(
    grasps: TrainingGrasps, groups: NDArray[np.int64] | None = None, beyond: Floats | float = 0.0
) -> GraspLikelihood:
    """Find beta on training grasps that are held out, contradictory ones too; arguments as of `hold_out`."""
    seen = grasps.seen
    held = hold_out(seen, groups, beyond)
    assumed = GraspLikelihood(seen.patterns, seen.labels, seen.weights, grasps.n_classes, 1.0, held)
    if held is None or not held.fellows:
        return assumed
    distance, truth = hamming(seen.patterns[held.patterns], seen.patterns), seen.labels[held.patterns]
    loss = []
    for beta in _BETAS.tolist():
        p, _ = assumed._to_others(distance, held, beta)
        loss.append(-np.log(np.maximum(p[np.arange(len(p)), truth], 1e-12)).mean())
    return replace(assumed, beta=float(_BETAS[int(np.argmin(loss))]))


def nearest_pattern(X: NDArray[np.bool_], patterns: NDArray[np.bool_]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Index of the nearest pattern (the first of equals) and its distance in switches; 0 and 0 where there is none."""
    index, distance = np.zeros((2, len(X)), dtype=np.int64)
    for rows in _chunks(len(X), len(patterns)):
        all_of_them = hamming(X[rows], patterns)
        index[rows] = all_of_them.argmin(axis=1)
        distance[rows] = all_of_them.min(axis=1)
    return index, distance


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
    distance: NDArray[np.floating], labels: NDArray[np.int64], weights: NDArray[np.int64], n_classes: int, beta: float
) -> tuple[Floats, Floats]:
    """Return P(class) of patterns, and their log-likelihood under all classes alike.

    `distance` of shape (n, n_patterns) is infinite where a pattern has no weight; `weights` are of that shape or
    (n_patterns,).
    """
    nearest = distance.min(axis=1, keepdims=True)
    kernel = np.exp(-beta * (distance - nearest).astype(np.float64)) * weights
    member = (labels[:, None] == np.arange(n_classes)).astype(np.float64)
    mass = kernel @ member / np.maximum(weights @ member, 1)
    total = mass.sum(axis=1, keepdims=True)
    posterior = (mass + 1e-12) / (total + n_classes * 1e-12)
    return posterior, np.log(total[:, 0] / n_classes) - beta * nearest[:, 0]


def _chunks(n: int, width: int) -> list[slice]:
    """Rows that are compared at once with so many patterns; none where there is nothing to compare with."""
    step = max(1, _CHUNK_ENTRIES // max(1, width))
    return [slice(start, start + step) for start in range(0, n if width else 0, step)]
