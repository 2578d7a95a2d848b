"""Which mode: as good as any in a cross-validation on the training grasps, and of these the smallest circuit."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from varishold.grasp.comparison import FEWEST_TELLING, as_good, deal_folds, noisy_copies
from varishold.grasp.compiled import CompiledCircuit
from varishold.grasp.likelihood import nearest_pattern
from varishold.grasp.modes import MODES, ModeOptions
from varishold.grasp.modes.decoders import DEFAULT_DECODER
from varishold.grasp.training import TrainingGrasps

__all__ = ["choose_mode", "remark_on_noise"]

#: Taken where the training grasps cannot tell the modes apart.
DEFAULT_MODE = "vote"
#: The others, smallest circuit first, and the most patterns with which each is tried: above, comparing all pairs of
#: grasps, or making a term of each, takes longer than the mode can be worth.
_TRIED = {"paper": 120, "robust": 300}
_FOLDS = 5
_COPIES, _COPIED_RATE, _COPIED_SWITCHES = 8, 0.05, 4_000_000
#: A mode that is this many standard errors behind the default after a fold is not tried on the next.
_HOPELESS = 3.0
#: Training grasps whose noisy copies a fitted circuit is asked, how often a switch reads wrongly in these at most, and
#: how far behind the nearest training grasp a circuit may stay before that is told.
_ASKED, _MOST_NOISE, _BEHIND = 400, 0.1, 0.1


def choose_mode(grasps: TrainingGrasps, options: ModeOptions) -> str:
    """Return the name of the mode with the smallest circuit that is as good as the default, or the default."""
    counts = np.bincount(grasps.labels, minlength=grasps.n_classes)
    names = [name for name, most in _TRIED.items() if len(grasps) <= most]
    groups = np.array(options.groups or range(len(grasps)), dtype=np.int64)
    few = len(np.unique(groups)) < FEWEST_TELLING
    if few or not names or (counts[counts > 0] < 2).any() or (counts > 0).sum() < 2:
        return DEFAULT_MODE
    rng = np.random.default_rng([options.seed, 4])
    folds = deal_folds(grasps.labels, groups, _FOLDS, rng)
    right = {name: np.zeros(len(grasps)) for name in (*names, DEFAULT_MODE)}
    for fold in range(_FOLDS):
        held = folds == fold
        rest = _only(grasps, ~held)
        if not held.any() or len(np.unique(rest.labels)) < 2:
            continue
        copies = min(_COPIES, _COPIED_SWITCHES // (int(held.sum()) * grasps.n_switches))
        noisy = noisy_copies(grasps.patterns[held], copies, _COPIED_RATE, rng).reshape(-1, copies, grasps.n_switches)
        asked = np.concatenate([grasps.patterns[held][:, None], noisy], axis=1)
        # A greedy separating set and the usual decoder tell as well how a mode would answer.
        part = replace(options, groups=tuple(groups[~held].tolist()), time_limit_s=0.0, decoder=DEFAULT_DECODER)
        for name, hits in right.items():
            circuit = CompiledCircuit(MODES[name](rest, part).netlist)
            answers = circuit.evaluate(asked.reshape(-1, grasps.n_switches)).reshape(len(asked), -1)
            hits[held] = (answers == grasps.labels[held][:, None]).mean(axis=1)
        seen = folds <= fold
        right = {
            name: hits
            for name, hits in right.items()
            if name == DEFAULT_MODE or not _hopeless(hits[seen] - right[DEFAULT_MODE][seen])
        }
    return next(name for name, hits in right.items() if as_good(hits, right[DEFAULT_MODE]))


def remark_on_noise(circuit: CompiledCircuit, grasps: TrainingGrasps, flip_rate: float, mode: str) -> str | None:
    """Say that the circuit bears wrong switches badly, where the nearest training grasp bears them well."""
    rng = np.random.default_rng(0)
    asked = rng.permutation(len(grasps))[:_ASKED]
    rate = min(_MOST_NOISE, flip_rate)
    copies = max(1, min(_COPIES, _COPIED_SWITCHES // max(1, len(asked) * grasps.n_switches)))
    noisy = noisy_copies(grasps.patterns[asked], copies, rate, rng)
    truth = np.repeat(grasps.labels[asked], copies)
    right = float(np.mean(circuit.evaluate(noisy) == truth)) if len(truth) else 1.0
    nearest = float(np.mean(grasps.labels[nearest_pattern(noisy, grasps.patterns)[0]] == truth)) if len(truth) else 1.0
    if right >= nearest - _BEHIND:
        return None
    other = "" if mode == DEFAULT_MODE else f"; mode {DEFAULT_MODE!r} does better with many objects or switches"
    return (
        f"mode {mode!r} names {right:.0%} of noisy copies of the training grasps ({rate:.0%} of the switches wrong), "
        f"the nearest training grasp {nearest:.0%}{other}"
    )


def _hopeless(lead: NDArray[np.float64]) -> bool:
    return bool(lead.mean() < -_HOPELESS * lead.std() / np.sqrt(len(lead)))


def _only(grasps: TrainingGrasps, chosen: NDArray[np.bool_]) -> TrainingGrasps:
    return replace(
        grasps,
        patterns=grasps.patterns[chosen],
        labels=grasps.labels[chosen],
        weights=grasps.weights[chosen],
        numbers=grasps.numbers[chosen],
    )
