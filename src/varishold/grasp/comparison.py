"""Comparing ways of learning on grasps held out: folds, noisy copies, and what counts as better or as good."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

__all__ = ["FEWEST_TELLING", "as_good", "clearly_best", "deal_folds", "noisy_copies"]

#: What is worse by no more than this share of held-out grasps, and one standard error, is as good.
_EQUAL = 0.01
#: Fewer grasps than this do not tell what is as good: one of them is more than that share.
FEWEST_TELLING = 100


def deal_folds(
    labels: NDArray[np.int64], groups: NDArray[np.int64], count: int, rng: np.random.Generator
) -> NDArray[np.int64]:
    """Deal the groups of every class out over folds; copies of one grasp stay together."""
    fold_of = np.zeros(len(labels), dtype=np.int64)
    for label in np.unique(labels):
        own = np.unique(groups[labels == label])
        dealt = np.arange(len(own)) + rng.integers(count)
        place = dict(zip(rng.permutation(own).tolist(), (dealt % count).tolist(), strict=True))
        at = labels == label
        fold_of[at] = [place[g] for g in groups[at].tolist()]
    return fold_of


def noisy_copies(patterns: NDArray[np.bool_], copies: int, rate: float, rng: np.random.Generator) -> NDArray[np.bool_]:
    """Copies of every pattern in which switches read wrongly at a rate; those of one pattern stand together."""
    flips = rng.random((len(patterns), copies, patterns.shape[1])) < rate
    return np.asarray((patterns[:, None] ^ flips).reshape(-1, patterns.shape[1]), dtype=np.bool_)


def clearly_best(right: NDArray[np.float64], default: int) -> int:
    """The candidate with most right answers, if it beats the default by more than two standard errors.

    Parameters
    ----------
    right : ndarray of shape (n_candidates, n_held_out)
        What each candidate earned on each held-out pattern.
    default : int
        The candidate to stay with where the data do not tell.
    """
    if not right.size:
        return default
    lead = right - right[default]
    doubt = 2 * lead.std(axis=1) * np.sqrt(right.shape[1])
    score = np.where(lead.sum(axis=1) > doubt, lead.sum(axis=1), 0.0)
    return int(score.argmax()) if score.max() > 1e-9 else default


def as_good(right: NDArray[np.float64], best: NDArray[np.float64]) -> bool:
    """Whether a candidate is as good as the best one on the same held-out patterns, as far as these tell.

    Parameters
    ----------
    right, best : ndarray of shape (n_held_out,)
        Share of right answers to each pattern and its copies.
    """
    lead = right - best
    return bool(lead.mean() - lead.std() / np.sqrt(len(lead)) >= -_EQUAL)
