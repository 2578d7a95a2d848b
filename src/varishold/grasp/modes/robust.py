"""Robust terms: every grasp a product term over bisectors, with the fewest literals that bear noise.

Unpruned, the OR over a class's grasps of the AND of all their enemy bisectors answers as the nearest
training grasp does. Pruned so that noisy copies of the enemies are still rejected and noisy copies of the
class's own grasps still accepted, it keeps a few hyperplanes, which its terms share.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from varishold.circuit import evaluate
from varishold.errors import require
from varishold.grasp.comparison import noisy_copies
from varishold.grasp.hyperplanes import Hyperplanes, bisectors, distinct
from varishold.grasp.likelihood import hamming
from varishold.grasp.modes.learned import (
    Learned,
    ModeOptions,
    circuit_of,
    learn_constant,
    term_scores,
)
from varishold.grasp.training import TrainingGrasps

__all__ = ["learn_robust"]

#: More distinct patterns than this make the choice of terms slow and the circuit large; `vote` is for them.
ROBUST_PATTERNS = 1000
#: Bisectors considered for one class: those of its grasps with their nearest enemies.
_CANDIDATES = 1500
#: Noisy copies of each side, each pattern at least one, and switches of these copies together.
_COPIES, _COPIED_SWITCHES = 2000, 8_000_000
#: A literal of another grasp's bisector may be borrowed where it accepts this part of a grasp's own copies.
_BORROWED = 0.9
#: Copies that may stay unrejected or unaccepted, as a part of those that all literals or terms would settle.
_UNREJECTED = 0.02
_UNACCEPTED = 0.05
#: The two candidate circuits of a two-class problem are compared at this part of the flip rate.
_COMPARED_RATE = 0.7


def learn_robust(grasps: TrainingGrasps, options: ModeOptions) -> Learned:
    """Choose product terms for every class but one; of two classes, for the one that is told better so."""
    require(
        len(grasps) <= ROBUST_PATTERNS,
        f"mode 'robust' makes a term of a grasp and takes up to {ROBUST_PATTERNS} different patterns, "
        f"got {len(grasps)}; use mode 'vote'",
    )
    present = np.unique(grasps.labels)
    if len(present) < 2:
        return learn_constant(grasps, options)
    terms = {int(c): _class_terms(grasps, int(c), options) for c in present}
    if len(present) > 2:
        return _assembled(grasps, terms, options)
    either = [_assembled(grasps, {int(c): terms[int(c)]}, options) for c in present]
    copies = max(1, 2 * _copies(grasps) // len(grasps))
    rng = np.random.default_rng([options.seed, 3])
    noisy = noisy_copies(grasps.patterns, copies, options.flip_rate * _COMPARED_RATE, rng)
    wanted = np.repeat(grasps.labels, copies)
    share = np.repeat(1.0 / np.bincount(grasps.labels, minlength=grasps.n_classes)[grasps.labels], copies)
    right = [float(((evaluate(one.netlist, noisy) == wanted) * share).sum()) for one in either]
    return either[int(np.argmax(right))]


@dataclass(frozen=True)
class _Terms:
    """Candidate hyperplanes of one class and the literals that each of its terms keeps."""

    planes: Hyperplanes
    literals: list[list[tuple[int, int]]]


def _class_terms(grasps: TrainingGrasps, label: int, options: ModeOptions) -> _Terms:
    own, enemies = grasps.labels == label, grasps.labels != label
    patterns = grasps.patterns[own]
    planes, owners = _candidates(grasps, own, enemies, options.keep)
    rng = np.random.default_rng([options.seed, 1])
    hostile = noisy_copies(
        grasps.patterns[enemies], max(1, _copies(grasps) // int(enemies.sum())), options.flip_rate, rng
    )
    per_own = max(2, _copies(grasps) // int(own.sum()))
    friendly = noisy_copies(patterns, per_own, options.flip_rate, rng)
    to_enemy = hamming(hostile, grasps.patterns[enemies]).min(axis=1)
    rejectable = (hamming(hostile, patterns) > to_enemy[:, None]).T
    accepted = (hamming(friendly, patterns) < hamming(friendly, grasps.patterns[enemies]).min(axis=1)[:, None]).T
    terms = _covering_terms(accepted)

    wanted = planes.signs(patterns)
    on_friendly = planes.signs(friendly).reshape(len(patterns), per_own, len(planes))
    bears = (on_friendly == wanted[:, None]).mean(axis=1) >= _BORROWED
    usable = bears | owners
    need = {t: rejectable[t].copy() for t in terms}
    literals: dict[int, list[tuple[int, int]]] = {t: [] for t in terms}
    on_hostile = planes.signs(hostile)
    allowed = _UNREJECTED * sum(int(n.sum()) for n in need.values())
    used: set[int] = set()
    while terms and sum(int(n.sum()) for n in need.values()) > allowed:
        open_copies = np.array([need[t] for t in terms])
        ones = open_copies.astype(np.float32) @ on_hostile.astype(np.float32)
        rejected = np.where(wanted[terms], open_copies.sum(axis=1)[:, None] - ones, ones) * usable[terms]
        gains = rejected.sum(axis=0)
        if options.max_hyperplanes is not None and len(used) >= options.max_hyperplanes:
            gains[[k for k in range(len(planes)) if k not in used]] = 0
        best = int(gains.argmax())
        if gains[best] <= 0:
            break
        used.add(best)
        for row, t in enumerate(terms):
            if rejected[row, best] > 0:
                literals[t].append((best, int(wanted[t, best])))
                need[t] &= on_hostile[:, best] == wanted[t, best]
    return _Terms(planes, [literals[t] for t in terms if literals[t]])


def _candidates(
    grasps: TrainingGrasps, own: NDArray[np.bool_], enemies: NDArray[np.bool_], keep: Hyperplanes | None
) -> tuple[Hyperplanes, NDArray[np.bool_]]:
    """Bisectors of every own grasp with its nearest enemies, and which own grasp has which of them."""
    rows, foes = np.flatnonzero(own), np.flatnonzero(enemies)
    nearest = min(len(foes), max(1, _CANDIDATES // len(rows)))
    distances = hamming(grasps.patterns[rows], grasps.patterns[foes])
    chosen = np.argsort(distances, axis=1, kind="stable")[:, :nearest]
    i, j = np.repeat(rows, nearest), foes[chosen].ravel()
    both = bisectors(grasps.patterns[i], grasps.patterns[j], pairs=grasps.numbers[np.column_stack([i, j])])
    planes = distinct(keep, both) if keep is not None and len(keep) else distinct(both)
    place = {row.tobytes(): k for k, row in enumerate(planes.weights)}
    owners = np.zeros((len(rows), len(planes)), dtype=np.bool_)
    for n, row in enumerate(both.weights):
        owners[n // nearest, place[row.tobytes()]] = True
    return planes, owners


def _covering_terms(accepted: NDArray[np.bool_]) -> list[int]:
    """Few terms that together accept nearly all copies that any term accepts, largest gain first."""
    left = accepted.any(axis=0)
    allowed = _UNACCEPTED * accepted.shape[1]
    terms: list[int] = []
    while left.sum() > allowed:
        best = int((accepted & left).sum(axis=1).argmax())
        terms.append(best)
        left &= ~accepted[best]
    return terms


def _assembled(grasps: TrainingGrasps, terms: dict[int, _Terms], options: ModeOptions) -> Learned:
    """Renumber the hyperplanes that some term uses, and make the circuit."""
    keep = options.keep
    used = [t.planes.take(sorted({k for term in t.literals for k, _ in term})) for t in terms.values()]
    planes = distinct(*([keep] if keep is not None and len(keep) else []), *used)
    place = {row.tobytes(): k for k, row in enumerate(planes.weights)}
    terms_of = {
        label: [
            tuple(sorted((place[t.planes.weights[k].tobytes()], wanted) for k, wanted in term)) for term in t.literals
        ]
        for label, t in terms.items()
    }
    products, scores = term_scores(grasps, terms_of)
    notes = {"classes with terms": ", ".join(str(grasps.classes[label]) for label in terms)}
    return replace(Learned(planes, circuit_of(grasps, planes, products, scores)), notes=notes)


def _copies(grasps: TrainingGrasps) -> int:
    return min(_COPIES, _COPIED_SWITCHES // grasps.n_switches)
