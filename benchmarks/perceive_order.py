"""What choosing the next touch by expected information saves against every fixed order of touches, at equal error.

Run: ``python -m benchmarks.perceive_order [--examples 6] [--seed 2]``. In each example every touch is made
once; orders and choice are then replayed on the same touches, with the same rule for stopping. Beside the whole hand:
one without pads, and one whose joints are not known either, which needs more touches.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import permutations

import numpy as np

from benchmarks._evaluation_hand import WHAT_DIFFERS, evaluation_setting
from benchmarks._figures import figure, share
from varishold.exploration import TOUCHES, touch_all
from varishold.hand import OBJECTS, HandSetting, Job, run_jobs
from varishold.perceive import Belief, Evidence, Library, expected_information, shipped_library

_FIRST_SEED = 7_300_000_000
_SIZES_M = (0.055, 0.08, 0.105)
_MOST = 6
_ERRORS = (0.03, 0.01, 0.003, 0.001)
#: What each hand does not know, by the beginning of the numbers' names.
_HANDS: dict[str, tuple[str, ...]] = {
    "the whole hand": (),
    "without pads": ("pad.", "form.pads", "form.least"),
    "switches and fingertip alone": ("pad.", "form.", "fit.", "size."),
}


@dataclass(frozen=True)
class _Example:
    """Every touch of one object."""

    setting: HandSetting

    def __call__(self, job: Job) -> dict[str, Evidence]:
        felt = touch_all(job.name, job.size_m, seed=job.seed, setting=self.setting)
        return {touch: what.touch.evidence(what, self.setting)[0] for touch, what in felt.items()}


def without(library: Library, hidden: tuple[str, ...]) -> Library:
    """Return a library that never knew the numbers whose names begin so."""
    touches = {}
    for touch, model in library.touches.items():
        metric = model.metric
        keep = (
            np.array([not name.startswith(hidden) for name in metric.names])
            if hidden
            else np.ones(len(metric.names), bool)
        )
        size_hidden = model.size is not None and bool(hidden) and any(n.startswith(hidden) for n in model.size.names)
        touches[touch] = replace(
            model,
            metric=metric.of(keep),
            values=model.values[:, keep],
            others=model.others[:, keep],
            size=None if size_hidden else model.size,
        )
    return replace(library, touches=touches)


class _Replay:
    """One example's touches; beliefs and gains are kept by the set of touches made, for orders share them."""

    def __init__(self, name: str, evidence: dict[str, Evidence], library: Library) -> None:
        self.name, self.library = name, library
        self.evidence = evidence
        self.first = "grasp" if "grasp" in evidence else "squeeze"
        self._beliefs: dict[frozenset[str], Belief] = {}
        self._states: dict[frozenset[str], tuple[str, float]] = {}
        self._chosen: dict[frozenset[str], str | None] = {}

    def belief(self, made: tuple[str, ...]) -> Belief:
        key = frozenset(made)
        if key not in self._beliefs:
            before = self.belief(made[:-1]) if len(made) > 1 else Belief.before(self.library)
            self._beliefs[key] = before.after(self.evidence[made[-1]])
        return self._beliefs[key]

    def state(self, made: tuple[str, ...]) -> tuple[str, float]:
        """The likeliest name and its probability."""
        key = frozenset(made)
        if key not in self._states:
            belief = self.belief(made)
            self._states[key] = belief.best, belief.probability[belief.best]
        return self._states[key]

    def left(self, made: tuple[str, ...]) -> list[str]:
        return [t for t in TOUCHES if t in self.evidence and t not in made and t not in ("grasp", "squeeze")]

    def chosen(self, made: tuple[str, ...]) -> str | None:
        key = frozenset(made)
        if key not in self._chosen:
            belief = self.belief(made)
            gains = {t: expected_information(belief, t) for t in self.left(made)}
            self._chosen[key] = max(gains, key=gains.__getitem__) if gains else None
        return self._chosen[key]

    def run(self, error: float, order: Sequence[str] | None) -> tuple[int, bool]:
        """Touches made until sure, and whether the name is right."""
        made = (self.first,)
        while True:
            best, p = self.state(made)
            if p >= 1 - error or len(made) == _MOST:
                return len(made), best == self.name
            if order is None:
                following = self.chosen(made)
            else:
                can = self.left(made)
                following = next((t for t in order if t in can), None)
            if following is None:
                return len(made), best == self.name
            made = (*made, following)


def fixed_length(replays: Sequence[_Replay], orders: Sequence[Sequence[str]], wrong: float) -> int | None:
    """Return how many touches the best fixed order needs to err no more often when it never stops early."""
    for n in range(1, _MOST + 1):
        starts = dict.fromkeys(tuple(order[: n - 1]) for order in orders)
        for start in starts:
            errors = 0
            for replay in replays:
                made = (replay.first, *(t for t in start if t in replay.evidence))
                errors += replay.state(made)[0] != replay.name
            if errors / len(replays) <= wrong + 1e-9:
                return n
    return None


def main(argv: Sequence[str] = ()) -> None:
    """Print the figures."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--examples", type=int, default=6, help="examples of each kind and size")
    parser.add_argument("--seed", type=int, default=2)
    parser.add_argument("--processes", type=int, default=None)
    options = parser.parse_args(list(argv))
    print(f"  {WHAT_DIFFERS}")
    jobs = [
        Job(name, size_m, _FIRST_SEED + 10_000_000 * options.seed + 100_000 * k + 1000 * j + n)
        for k, name in enumerate(OBJECTS)
        for j, size_m in enumerate(_SIZES_M)
        for n in range(options.examples)
    ]
    examples = list(run_jobs(jobs, _Example(evaluation_setting()), processes=options.processes))
    others = [touch for touch in TOUCHES if touch not in ("grasp", "squeeze")]
    # What comes after five touches hardly ever matters: the rest follows in the usual order.
    orders = [(*first, *(t for t in others if t not in first)) for first in permutations(others, 4)]
    for hand, hidden in _HANDS.items():
        library = without(shipped_library(), hidden)
        replays = [
            _Replay(job.name, evidence, library)
            for job, evidence in zip(jobs, examples, strict=True)
            if "grasp" in evidence or "squeeze" in evidence
        ]
        for error in _ERRORS:
            chosen = np.array([replay.run(error, None) for replay in replays], dtype=float)
            wrong = 1 - chosen[:, 1].mean()
            fixed = []
            for order in orders:
                runs = np.array([replay.run(error, order) for replay in replays], dtype=float)
                fixed.append((runs[:, 0].mean(), 1 - runs[:, 1].mean(), order))
            equal = [row for row in fixed if row[1] <= wrong + 1e-9] or [min(fixed, key=lambda row: row[1])]
            best = min(equal, key=lambda row: row[0])
            touches = chosen[:, 0].mean()
            floor = 1 + np.mean([replay.state((replay.first,))[1] < 1 - error for replay in replays])
            # What a fixed order without a rule for stopping needs: so many touches of everything.
            length = fixed_length(replays, orders, wrong)
            of = f"{hand}, error {error:g} accepted"
            print(
                f"  {of}: chosen {figure(f'{of}: chosen', touches, '.3f', 'touches')}, "
                f"{share(f'{of}: wrong', wrong)} wrong; best fixed order of {len(orders)} "
                f"{figure(f'{of}: best fixed order', best[0], '.3f', 'touches')}, {100 * best[1]:.1f} % wrong "
                f"({' '.join(best[2][:3])} ..); saved {share(f'{of}: saved', 1 - touches / best[0], '.0f')} of all, "
                f"{100 * (1 - (touches - 1) / max(best[0] - 1, 1e-9)):.0f} % of those after the first; "
                f"no order can need fewer than {floor:.3f}; "
                + (
                    f"against a fixed order of {length} touches for all, {100 * (1 - touches / length):.0f} %"
                    if length
                    else f"no fixed order of up to {_MOST} touches for all is so often right"
                )
            )


if __name__ == "__main__":
    main(sys.argv[1:])
