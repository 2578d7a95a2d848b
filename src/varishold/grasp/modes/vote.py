"""Voting: many small bisectors, whose signs are added up with integer weights.

Bisectors are restricted to a few of the switches in which their two grasps differ, chosen so that every
pair of enemies is parted many times over, and a decoder turns their signs into a score a class. Every
decoder is linear in the signs, so that the circuit computes it exactly.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from varishold.circuit import Score
from varishold.grasp.comparison import FEWEST_TELLING, as_good, deal_folds, noisy_copies
from varishold.grasp.hyperplanes import Hyperplanes, bisectors, distinct
from varishold.grasp.modes.decoders import DECODERS, Decoder, Weights, choose_decoder
from varishold.grasp.modes.learned import Learned, ModeOptions, circuit_of, learn_constant
from varishold.grasp.training import TrainingGrasps

__all__ = ["learn_vote"]

#: Numbers of differing switches that a restricted bisector looks at, where its grasps differ in at least twice as
#: many: odd, so that no vote is a tie.
WIDTHS = (1, 3, 5, 7, 9)
#: Hyperplanes unless the user says otherwise: up to 32 switches; above; above for each class from the tenth on; and
#: two for each grasp, up to a number at which least squares still take seconds.
_FEW, _MANY, _A_CLASS, _MOST, _BY_GRASPS = 600, 1000, 100, 4000, 2500
#: Candidates drawn for each hyperplane that is wanted, and pairs of enemies that they are judged by; where more
#: are wanted than judging pays for, as many are drawn as wanted.
_OVERSAMPLING, _JUDGED_PAIRS, _JUDGED = 2, 600, 1000
#: Each time a pair of enemies is parted once more, parting it counts this much less.
_SATED = 0.9
#: Scores are rounded so that the largest weight is this: as accurate as 255, and half the gates.
_LARGEST_WEIGHT = 15
_LARGEST_OFFSET = 1 << 20
#: Fewest hyperplanes that are tried where the user says nothing, each time half as many; compared on so many grasps
#: in so many folds (above so many grasps in one fold), with so many noisy copies and switches of these together.
_FEWEST, _COMPARED, _FOLDS, _ALL_FOLDS = 120, 2000, 5, 600
_COPIES, _COPIED_RATE, _COPIED_SWITCHES = 8, 0.05, 8_000_000


def learn_vote(grasps: TrainingGrasps, options: ModeOptions) -> Learned:
    """Draw, select and decode."""
    keep = options.keep if options.keep is not None and len(options.keep) else None
    if len(np.unique(grasps.labels)) < 2:
        return learn_constant(grasps, options)
    rng = np.random.default_rng([options.seed, 2])
    copied = len(set(options.groups)) or len(grasps)
    many = max(_MANY, min(_MOST, _A_CLASS * grasps.n_classes), min(_BY_GRASPS, 2 * copied))
    wanted = options.max_hyperplanes or (_FEW if grasps.n_switches <= 32 else many)
    candidates = _draw(grasps, wanted * (_OVERSAMPLING if wanted <= _JUDGED else 1), rng)
    planes = candidates.take(_multicover(grasps, candidates, wanted, rng))
    if keep is not None:
        planes = distinct(keep, planes)
    signs = np.where(planes.signs(grasps.patterns), 1.0, -1.0)
    groups = np.array(options.groups or range(len(grasps)), dtype=np.int64)
    name = options.decoder or choose_decoder(signs, grasps.labels, grasps.weights, groups, grasps.n_classes, rng)
    if options.max_hyperplanes is None and keep is None and copied >= FEWEST_TELLING:
        count = _fewest_as_good(grasps, planes, signs, groups, DECODERS[name], rng)
        planes, signs = planes.take(range(count)), signs[:, :count]
    weights = DECODERS[name](signs, grasps.labels, grasps.weights, grasps.n_classes)
    return _assembled(grasps, planes, weights, name, keep)


def _draw(grasps: TrainingGrasps, count: int, rng: np.random.Generator) -> Hyperplanes:
    """Draw pairs of enemies, every two classes alike, and restrict each to an odd number of differing switches."""
    labels = grasps.labels
    order = np.argsort(labels, kind="stable")
    present, starts, sizes = np.unique(labels[order], return_index=True, return_counts=True)
    one = rng.integers(len(present), size=count)
    other = (one + rng.integers(1, len(present), size=count)) % len(present)
    i = order[starts[one] + rng.integers(1 << 30, size=count) % sizes[one]]
    j = order[starts[other] + rng.integers(1 << 30, size=count) % sizes[other]]
    differ = grasps.patterns[i] ^ grasps.patterns[j]
    width = np.resize(np.array(WIDTHS), count)
    width = np.minimum(width, np.maximum(1, differ.sum(axis=1) // 2))
    width -= width % 2 == 0
    drawn = np.where(differ, rng.random(differ.shape), 2.0)
    widest = min(max(WIDTHS), grasps.n_switches)
    nth = np.partition(drawn, np.arange(widest), axis=1)[np.arange(count), width - 1]
    within = drawn <= nth[:, None]
    return distinct(
        bisectors(grasps.patterns[i], grasps.patterns[j], pairs=grasps.numbers[np.column_stack([i, j])], within=within)
    )


def _multicover(
    grasps: TrainingGrasps, candidates: Hyperplanes, wanted: int, rng: np.random.Generator
) -> NDArray[np.int64]:
    """Choose hyperplanes that part every pair of enemies often: a soft multicover, greedily, in this order."""
    if len(candidates) <= wanted:
        return np.arange(len(candidates))
    n = len(grasps)
    pairs = np.unique(np.sort(rng.integers(n, size=(8 * _JUDGED_PAIRS, 2)), axis=1), axis=0)
    pairs = pairs[grasps.labels[pairs[:, 0]] != grasps.labels[pairs[:, 1]]]
    pairs = pairs[rng.permutation(len(pairs))[:_JUDGED_PAIRS]]
    signs = candidates.signs(grasps.patterns)
    parted = (signs[pairs[:, 0]] != signs[pairs[:, 1]]).astype(np.float32)
    hunger = np.ones(len(pairs), dtype=np.float32)
    free = np.ones(len(candidates), dtype=np.bool_)
    chosen = []
    for _ in range(wanted):
        best = int(np.where(free, hunger @ parted, -1.0).argmax())
        chosen.append(best)
        free[best] = False
        hunger *= np.where(parted[:, best] > 0, np.float32(_SATED), np.float32(1))
        if hunger.max() < 1e-12:
            hunger /= hunger.max()
    return np.array(chosen, dtype=np.int64)


def _fewest_as_good(
    grasps: TrainingGrasps,
    planes: Hyperplanes,
    signs: NDArray[np.float64],
    groups: NDArray[np.int64],
    decode: Decoder,
    rng: np.random.Generator,
) -> int:
    """Halve the number of hyperplanes as long as held-out grasps and noisy copies of them are told as well."""
    some = np.arange(len(grasps))
    if len(some) > _COMPARED:
        some = np.sort(rng.choice(some, _COMPARED, replace=False))
    labels, weights = grasps.labels[some], grasps.weights[some]
    folds = deal_folds(labels, groups[some], _FOLDS, rng)
    tried = range(_FOLDS if len(some) <= _ALL_FOLDS else 1)
    held = np.flatnonzero(np.isin(folds, tried))
    copies = min(_COPIES, _COPIED_SWITCHES // (len(held) * grasps.n_switches))
    patterns = grasps.patterns[some[held]]
    noisy = np.concatenate([patterns, noisy_copies(patterns, copies, _COPIED_RATE, rng)])
    copy_of = np.concatenate([np.arange(len(held)), np.repeat(np.arange(len(held)), copies)])
    on_noisy = np.where(planes.signs(noisy), 1.0, -1.0)

    def right(count: int) -> NDArray[np.float64]:
        hits = np.zeros(len(noisy))
        for fold in tried:
            rest, own = folds != fold, folds[held][copy_of] == fold
            if len(np.unique(labels[rest])) < 2:
                continue
            slopes, offsets = decode(signs[some[rest], :count], labels[rest], weights[rest], grasps.n_classes)
            answers = (on_noisy[own, :count] @ slopes.T + offsets).argmax(axis=1)
            hits[own] = answers == labels[held[copy_of[own]]]
        return np.bincount(copy_of, weights=hits) / (copies + 1)

    count, best = len(planes), right(len(planes))
    while count // 2 >= _FEWEST and as_good(right(count // 2), best):
        count //= 2
    return count


def _assembled(
    grasps: TrainingGrasps, planes: Hyperplanes, weights: Weights, decoder: str, keep: Hyperplanes | None
) -> Learned:
    """Round the scores to integers; leave out hyperplanes without weight, the kept ones excepted."""
    slopes, offsets = weights
    slopes, offsets = slopes - slopes[0], offsets - offsets[0]
    # An offset that no sum of slopes could outweigh needs no more digits.
    scale = _LARGEST_WEIGHT / max(np.abs(slopes).max(), np.abs(offsets).max() / _LARGEST_OFFSET, 1e-12)
    whole = np.rint(slopes * scale).astype(np.int64)
    bias = np.rint(offsets * scale).astype(np.int64)
    used = np.flatnonzero(whole.any(axis=0) | (np.arange(len(planes)) < (len(keep) if keep else 0)))
    planes, whole = planes.take(used), whole[:, used]
    # The decoders know signs as -1 and 1, the circuit as 0 and 1: w (2 s - 1) = 2 w s - w.
    scores = [
        Score([(int(k), int(2 * row[k])) for k in np.flatnonzero(row)], int(b - row.sum()))
        for row, b in zip(whole, bias, strict=True)
    ]
    terms = [((k, 1),) for k in range(len(planes))]
    return Learned(planes, circuit_of(grasps, planes, terms, scores), notes={"decoder": decoder})
