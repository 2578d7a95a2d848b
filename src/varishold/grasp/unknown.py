"""Grasps of which some switches are unknown: the others judge, and fill the circuit's inputs."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike, NDArray

from varishold.grasp.likelihood import GraspLikelihood, nearest_pattern
from varishold.grasp.training import distinct_rows

__all__ = ["fill", "judge"]

Floats = NDArray[np.float64]

#: A hand lacks the same switches grasp after grasp; so many choices of switches are kept.
_MOST_PARTS = 4


def fill(patterns: NDArray[np.bool_], unknown: NDArray[np.bool_], likelihood: GraspLikelihood) -> NDArray[np.bool_]:
    """Return patterns whose unknown switches read as in the training grasp that is nearest by the others."""
    if not unknown.any() or not len(likelihood.patterns):
        return patterns
    filled = patterns.copy()
    for known, rows in _by_choice(~unknown):
        nearest, _ = nearest_pattern(patterns[rows][:, known], likelihood.patterns[:, known])
        filled[rows] = np.where(known, patterns[rows], likelihood.patterns[nearest])
    return filled


def judge(
    patterns: NDArray[np.bool_], unknown: NDArray[np.bool_], beyond: ArrayLike, likelihood: GraspLikelihood
) -> tuple[Floats, Floats]:
    """Return probabilities and p-values as `GraspLikelihood.judge`, each pattern by its known switches."""
    posterior, p_values = np.zeros((len(patterns), likelihood.n_classes)), np.ones(len(patterns))
    off = np.broadcast_to(np.asarray(beyond, dtype=np.float64), len(patterns))
    for known, rows in _by_choice(~unknown):
        posterior[rows], p_values[rows] = _part(likelihood, known.tobytes()).judge(patterns[rows][:, known], off[rows])
    return posterior, p_values


@lru_cache(maxsize=_MOST_PARTS)
def _part(likelihood: GraspLikelihood, known: bytes) -> GraspLikelihood:
    """Return the likelihood by some of the switches alone."""
    chosen = np.frombuffer(known, dtype=np.bool_)
    return likelihood if chosen.all() else replace(likelihood, patterns=likelihood.patterns[:, chosen])


def _by_choice(known: NDArray[np.bool_]) -> Iterator[tuple[NDArray[np.bool_], NDArray[np.intp]]]:
    """Yield each choice of known switches, and the grasps that have it."""
    choices, _, of = distinct_rows(known)
    for k, choice in enumerate(choices):
        yield choice, np.flatnonzero(of == k)
