"""The paper's way: the fewest bisectors that separate all grasps, reduced to a two-level circuit."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from varishold.errors import require
from varishold.grasp.hyperplanes import Hyperplanes, bisectors, distinct
from varishold.grasp.modes.learned import Learned, ModeOptions, circuit_of, learn_constant, term_scores
from varishold.grasp.separating import separating_set
from varishold.grasp.sign_table import SignTable, minimal_table
from varishold.grasp.training import TrainingGrasps, enemy_pairs

__all__ = ["all_bisectors", "learn_paper"]

#: More distinct patterns than this make more pairs than a table, or a person, can use.
PAPER_PATTERNS = 600


def all_bisectors(grasps: TrainingGrasps) -> Hyperplanes:
    """Every different bisector between grasps of different classes, in canonical order."""
    pairs = enemy_pairs(grasps.labels)
    if not len(pairs):
        return Hyperplanes(np.zeros((0, grasps.n_switches), dtype=np.int8))
    first, second = grasps.patterns[pairs[:, 0]], grasps.patterns[pairs[:, 1]]
    return distinct(bisectors(first, second, pairs=grasps.numbers[pairs]))


def learn_paper(grasps: TrainingGrasps, options: ModeOptions) -> Learned:
    """Choose the smallest separating set of all bisectors, then minimize the sign table."""
    require(
        len(grasps) <= PAPER_PATTERNS,
        f"mode 'paper' compares every two grasps of different classes and takes up to {PAPER_PATTERNS} "
        f"different patterns, got {len(grasps)}; use mode 'vote'",
    )
    if len(np.unique(grasps.labels)) < 2:
        return learn_constant(grasps, options)
    everything = all_bisectors(grasps)
    keep = options.keep
    if keep is not None and len(keep):
        everything = distinct(keep, everything)
    kept = tuple(range(len(keep))) if keep is not None else ()
    excess = everything.excess(grasps.patterns)
    order = _widest_first(excess, len(kept))
    everything, signs = everything.take(order), (excess > 0)[:, order]
    selection = separating_set(signs, grasps.labels, keep=kept, time_limit_s=options.time_limit_s)
    chosen = everything.take(selection.columns)
    table = minimal_table(
        SignTable(
            signs[:, list(selection.columns)],
            tuple(int(label) for label in grasps.labels),
            chosen.names,
            tuple(int(v) for v in grasps.numbers),
        )
    )
    learned = sorted(set(grasps.labels.tolist()))
    terms_of = {k: table.terms(k) for k in learned}
    # The class whose circuit is largest (the last of equals) is what remains where no other term is true.
    rest = max(learned, key=lambda k: (sum(map(len, terms_of[k])), len(terms_of[k]), k))
    del terms_of[rest]
    terms, scores = term_scores(grasps, terms_of)
    return Learned(chosen, circuit_of(grasps, chosen, terms, scores), selection)


def _widest_first(excess: NDArray[np.int32], kept: int) -> NDArray[np.int64]:
    """Of equally good hyperplanes the first is taken: put first those that no training grasp comes near."""
    flips = np.maximum(excess, 1 - excess).min(axis=0)
    return np.concatenate([np.arange(kept), np.argsort(-flips[kept:], kind="stable") + kept])
