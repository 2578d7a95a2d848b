"""Which mode: the one that answers best in a cross-validation on the training grasps."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from varishold.grasp.compiled import CompiledCircuit
from varishold.grasp.modes import MODES, ModeOptions
from varishold.grasp.modes.decoders import clearly_best, deal_folds
from varishold.grasp.training import TrainingGrasps

__all__ = ["choose_mode"]

#: Taken where the training grasps cannot tell the modes apart.
DEFAULT_MODE = "vote"
#: More patterns than this go to the default mode at once: the others make a term or a table row of each.
_TRIED_PATTERNS = 120
_FOLDS = 5


def choose_mode(grasps: TrainingGrasps, options: ModeOptions) -> str:
    """Return the name of the mode that is clearly best, or the default one."""
    counts = np.bincount(grasps.labels, minlength=grasps.n_classes)
    if len(grasps) > _TRIED_PATTERNS or (counts[counts > 0] < 2).any() or (counts > 0).sum() < 2:
        return DEFAULT_MODE
    groups = np.array(options.groups or range(len(grasps)), dtype=np.int64)
    folds = deal_folds(grasps.labels, groups, _FOLDS, np.random.default_rng([options.seed, 4]))
    names = list(MODES)
    right = np.zeros((len(names), len(grasps)))
    for fold in range(_FOLDS):
        held = folds == fold
        rest = _only(grasps, ~held)
        if not held.any() or len(np.unique(rest.labels)) < 2:
            continue
        # A greedy separating set tells as well as the smallest how this mode would answer.
        part = replace(options, groups=tuple(groups[~held].tolist()), time_limit_s=0.0)
        for k, name in enumerate(names):
            answers = CompiledCircuit(MODES[name](rest, part).netlist).evaluate(grasps.patterns[held])
            right[k, held] = (answers == grasps.labels[held]) / counts[grasps.labels[held]]
    return names[clearly_best(right, names.index(DEFAULT_MODE))]


def _only(grasps: TrainingGrasps, chosen: NDArray[np.bool_]) -> TrainingGrasps:
    return replace(
        grasps,
        patterns=grasps.patterns[chosen],
        labels=grasps.labels[chosen],
        weights=grasps.weights[chosen],
        numbers=grasps.numbers[chosen],
    )
