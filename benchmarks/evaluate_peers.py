"""What `evaluate` prints beside nine plain peers: the same folds, presses, pooling and zeroing, all by defaults.

Weiss: 36 pinched objects, the peak frame alone and the whole grasp, touch alone; every object was recorded in one
session, so that blocks of neighbours in time are held out. Simulated: ten things on a mat of 28 x 50 taxels and on a
fingertip of 5 x 9, four days, each held out once; forms and presses are drawn as in `learn_days`, by another seed.
The best peer is chosen after the fact. Nothing of the learner was chosen here.

Run: python -m benchmarks.evaluate_peers [SEEDS]
"""

from __future__ import annotations

import sys
from dataclasses import replace

import numpy as np

from benchmarks._figures import figure, share
from benchmarks._real_data import find_recording
from benchmarks.learn_days import SHAPES, Day, draw_days, draw_thing, press
from varishold import evaluate, read
from varishold.evaluation import Evaluation
from varishold.learning import labelled_presses
from varishold.touch.course.presses import Press

SEEDS = 2
THINGS, DAYS, PRESSES = 10, 4, 6
# From day to day: gains drift, rests move, things lie elsewhere and are pressed less. As in `learn_days`.
_DRIFT, _ELSEWHERE, _LIGHTEST = 0.1, 2.0, 0.75


def main() -> None:
    """Print the figures."""
    seeds = next((int(word) for word in sys.argv[1:] if word.isdigit()), SEEDS)
    found = []
    path = find_recording("weiss_dsa36.npz")
    if path is not None:
        given = labelled_presses([read(path)], label="label")
        whole = [replace(one, columns={}) for one in given.presses]
        found.append(_told("Weiss, peak frame", [evaluated([_peak(one) for one in whole], given.labels)]))
        found.append(_told("Weiss, whole grasp", [evaluated(whole, given.labels)]))
    for shape in SHAPES:
        each = [evaluated(*days(shape, seed)) for seed in range(seeds)]
        found.append(_told(f"simulated {shape[0]} x {shape[1]}, another day", each))
    mean = figure("mean ahead of the best peers", 100 * float(np.mean(found)), ".1f", "points", bar=">= 5")
    print(f"ahead of the best peer of each set, mean of {len(found)} sets: {mean}")


def evaluated(presses: list, labels: np.ndarray, groups: np.ndarray | None = None) -> Evaluation:
    """Return the evaluation of defaults, without what is not asked for here."""
    return evaluate(presses, labels, groups, shots=(), strangers=False)


def days(shape: tuple[int, int], seed: int) -> tuple[list[np.ndarray], np.ndarray, np.ndarray]:
    """Return presses of ten things on four days, which is which, and of which day."""
    rng = np.random.default_rng((2013, seed, *shape))
    things = [draw_thing(rng, shape) for _ in range(THINGS)]
    first, _ = draw_days(rng, shape)
    pressed, labels, groups = [], [], []
    for number in range(DAYS):
        way, far = rng.uniform(0, 2 * np.pi), rng.uniform(0, _ELSEWHERE)
        day = Day(
            first.gain * np.exp(rng.normal(0, _DRIFT, shape)),
            first.rest + rng.normal(0, 4, shape),
            (far * np.cos(way), far * np.sin(way)),
            rng.uniform(_LIGHTEST, 1.0),
        )
        for _ in range(PRESSES):
            for name, thing in enumerate(things):
                pressed.append(press(thing, day, rng))
                labels.append(name)
                groups.append(number)
    return pressed, np.array(labels), np.array(groups)


def _peak(grasp: Press) -> Press:
    """Return the frame of largest total alone."""
    total = np.sum([frames.sum(axis=(1, 2)) for frames in grasp.pads.values()], axis=0)
    at = slice(int(np.argmax(total)), int(np.argmax(total)) + 1)
    return replace(grasp, pads={name: frames[at] for name, frames in grasp.pads.items()}, time_s=None)


def _told(title: str, found: list[Evaluation]) -> float:
    """Print a set's figures, the mean over its seeds; return how far ahead of the best peer."""
    right = float(np.mean([one.scores.right.value for one in found]))
    print(f"{title}: {found[0].n_presses} presses of {len(found[0].things)} things, held out: {found[0].split}")
    print(f"  ours: {share(f'{title}: ours', right)}", flush=True)
    names = sorted({peer.name for peer in found[0].peers})
    shares = {name: float(np.mean([_of(one, name).right.value for one in found])) for name in names}
    for name in sorted(names, key=lambda one: -shares[one]):
        print(f"  {name}: {share(f'{title}: {name}', shares[name])}")
    best = max(names, key=lambda one: shares[one])
    ahead = right - shares[best]
    said = figure(f"{title}: ahead of the best peer", 100 * ahead, "+.1f", "points", bar=">= 0 within the interval")
    print(f"  ahead of {best}: {said}", flush=True)
    for seed, one in enumerate(found):
        of = _of(one, best).ahead
        ends = "no interval" if of.low is None or of.high is None else f"{100 * of.low:+.1f} to {100 * of.high:+.1f}"
        print(f"    seed {seed}: {100 * of.value:+.1f} ({ends} over {of.over}); leaks: {_leaks(one)}")
    return ahead


def _of(found: Evaluation, name: str):
    return next(peer for peer in found.peers if peer.name == name)


def _leaks(found: Evaluation) -> str:
    return ", ".join(leak.name for leak in found.leaks) or "none"


if __name__ == "__main__":
    main()
