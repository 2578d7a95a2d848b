"""What choosing the next touch saves against every fixed order of touches, in seconds of the hand, at equal error.

Run: ``python -m benchmarks.perceive_order [--examples 6] [--seed 5] [--first grasp] [--hand HAND --library FILE]``. In
each example every touch is made once, and clocked in the simulation; orders and choice are then replayed on the same
touches, with the same rule for stopping. Beside the whole hand: one without pads, and one whose joints are not known
either, which needs more touches; both have learned what they know without what they lack. Of another hand, as
three-finger, the library is what it has felt. Development used seed 90.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import combinations, permutations
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray

from benchmarks._evaluation_hand import WHAT_DIFFERS, evaluation_setting
from benchmarks._figures import figure, share
from varishold.cli.hand_file import require_library_of
from varishold.errors import InputError, require
from varishold.exploration import TOUCHES, Grip, touch_all
from varishold.exploration.hand_library import EXAMPLE_TRUST, GRIP_TRUST
from varishold.hand import OBJECTS, HandSetting, Job, read_hand, run_jobs
from varishold.perceive import (
    Belief,
    Evidence,
    Library,
    Perceiver,
    expected_information,
    read_library,
    shipped_library,
)
from varishold.perceive.touch_learning import touch_model

_FIRST_SEED = 7_300_000_000
_SIZES_M = (0.055, 0.08, 0.105)
_MOST = 6
_BEGIN = ("grasp", "squeeze")
_ERRORS = (0.03, 0.01, 0.003, 0.001)
#: What each hand does not know, by the beginning of the numbers' names.
_HANDS: dict[str, tuple[str, ...]] = {
    "the whole hand": (),
    "without pads": ("pad.", "form.pads", "form.least"),
    "switches and fingertip alone": ("pad.", "form.", "fit.", "size."),
}
#: What choosing must save, percent.
_BARS = {"the whole hand": ">= 0", "switches and fingertip alone": ">= 20", "three-finger": ">= 10"}


@dataclass(frozen=True)
class _Felt:
    """Every touch of one object that was made, and the seconds it took."""

    evidence: dict[str, Evidence]
    seconds: dict[str, float]


@dataclass(frozen=True)
class _Example:
    """Touch one object in every way."""

    setting: HandSetting

    def __call__(self, job: Job) -> _Felt:
        felt = touch_all(job.name, job.size_m, seed=job.seed, setting=self.setting)
        return _Felt(
            {touch: what.touch.evidence(what, self.setting)[0] for touch, what in felt.items()},
            {touch: what.seconds or 0.0 for touch, what in felt.items()},
        )


def without(library: Library, hidden: tuple[str, ...]) -> Library:
    """Return a library that was learned without the numbers whose names begin so: it has a kernel of its own."""
    if not hidden:
        return library
    touches = {}
    for touch, model in library.touches.items():
        keep = np.array([not name.startswith(hidden) for name in model.metric.names])
        names = tuple(name for name, kept in zip(model.metric.names, keep, strict=True) if kept)
        table, others = model.values[:, keep], model.others[:, keep]
        if model.size is not None and not any(name.startswith(hidden) for name in model.size.names):
            names += model.size.names
            table = np.hstack([table, model.size_values])
            others = np.hstack([others, np.full((len(others), len(model.size.names)), np.nan)])
        touches[touch] = touch_model(
            names,
            table,
            library.owner,
            library.log_size,
            others=others,
            failed=model.failed,
            cost=model.cost,
            seconds=model.seconds,
        )
    grips = [touch for touch, made in TOUCHES.items() if isinstance(made, Grip)]
    return replace(library, touches=touches).tempered(GRIP_TRUST, grips, own=EXAMPLE_TRUST)


class _Replay:
    """One example's touches; beliefs are kept by the set of touches made, for orders share them."""

    def __init__(self, name: str, felt: _Felt, library: Library, first: str) -> None:
        self.name, self.library = name, library
        self.evidence, self.seconds = felt.evidence, felt.seconds
        self.first = first if first in self.evidence else next(t for t in _BEGIN if t in self.evidence)
        self._beliefs: dict[frozenset[str], Belief] = {}
        self._states: dict[frozenset[str], tuple[str, float]] = {}
        self._chosen: dict[tuple[frozenset[str], float | None], str | None] = {}

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
        return [t for t in TOUCHES if t in self.evidence and t not in made and t not in _BEGIN]

    def chosen(self, made: tuple[str, ...], error: float | None) -> str | None:
        """The next touch as a perceiver chooses it; without an error, by information alone."""
        key = frozenset(made), error
        if key not in self._chosen:
            can = self.left(made)
            if error is None:
                gains = {touch: expected_information(self.belief(made), touch) for touch in can}
                self._chosen[key] = max(gains, key=gains.__getitem__) if gains else None
            else:
                perceiver = Perceiver(self.library, error=error)
                perceiver.belief = self.belief(made)
                wanted = perceiver.plan(can)
                self._chosen[key] = None if wanted is None else wanted.touch
        return self._chosen[key]

    def run(
        self, error: float, order: Sequence[str] | None = None, *, seconds_count: bool = True
    ) -> tuple[float, int, bool]:
        """Seconds and touches until sure, and whether the name is right."""
        made = (self.first,)
        while True:
            best, p = self.state(made)
            following = None
            if p < 1 - error and len(made) < _MOST:
                if order is None:
                    following = self.chosen(made, error if seconds_count else None)
                else:
                    can = self.left(made)
                    following = next((t for t in order if t in can), None)
            if following is None:
                return sum(self.seconds[touch] for touch in made), len(made), best == self.name
            made = (*made, following)

    def least(self, error: float) -> float:
        """Seconds of the touches that make the name sure soonest, as somebody would choose them who knew them all."""
        can = self.left((self.first,))
        longest = min(_MOST - 1, len(can))
        sets = [(self.first, *more) for n in range(longest + 1) for more in combinations(can, n)]
        taken = {made: sum(self.seconds[touch] for touch in made) for made in sets}
        sure = [taken[made] for made in sets if self.state(made)[1] >= 1 - error]
        return min(sure or [taken[made] for made in sets if len(made) == 1 + longest])


def chosen_before(runs: NDArray[np.float64], wrong: float) -> NDArray[np.float64]:
    """Return means of fixed orders that were each best on the other half of the examples: seconds, touches, right.

    `runs` has shape (n_orders, n_examples, 3). Best is the quickest of those that err no more often than `wrong`, or of
    those that err least.
    """
    kept = []
    for half in (0, 1):
        seen = runs[:, half::2].mean(axis=1)
        least = max(wrong + 1e-9, float((1 - seen[:, 2]).min()) + 1e-9)
        best = np.where(1 - seen[:, 2] <= least, seen[:, 0], np.inf).argmin()
        kept.append(runs[best, 1 - half :: 2])
    return np.concatenate(kept).mean(axis=0)


def of_each_object(runs: NDArray[np.float64], names: Sequence[str]) -> tuple[float, float]:
    """Return mean seconds of an order for each object, as who knew it beforehand would have one.

    The first is of orders that are best in hindsight, the second of such as were each best on the other half of the
    object's examples. `runs` as of `chosen_before`.
    """
    by_name = [runs[:, np.array(names) == name] for name in dict.fromkeys(names)]
    hindsight = sum(each[..., 0].sum(axis=1).min() for each in by_name)
    # However often they err.
    before = sum(each.shape[1] * chosen_before(each, 1.0)[0] for each in by_name)
    return float(hindsight) / len(names), float(before) / len(names)


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
    parser.add_argument("--seed", type=int, default=5)
    parser.add_argument("--first", choices=_BEGIN, default="grasp", help="the touch that every sequence begins with")
    parser.add_argument("--hand", help="a hand's file, or one that comes with the program")
    parser.add_argument("--library", type=Path, help="what that hand has felt, as of perceive_hand")
    parser.add_argument("--processes", type=int, default=None)
    options = parser.parse_args(list(argv))
    if (options.hand is None) != (options.library is None):
        parser.error("--hand and --library go together")
    if options.hand is None:
        setting, known, hands = evaluation_setting(), shipped_library(), _HANDS
    else:
        try:
            hand, known = read_hand(options.hand), read_library(options.library)
            require_library_of(hand, known, where=str(options.library), given=options.hand)
            require(known.seconds, f"{options.library}: does not know how long touches take; let the hand feel it anew")
        except InputError as error:
            parser.error(str(error))
        setting, hands = evaluation_setting(hand=hand), {hand.name: ()}
    print(f"  {WHAT_DIFFERS}")
    jobs = [
        Job(name, size_m, _FIRST_SEED + 10_000_000 * options.seed + 100_000 * k + 1000 * j + n)
        for k, name in enumerate(OBJECTS)
        for j, size_m in enumerate(_SIZES_M)
        for n in range(options.examples)
    ]
    examples = list(run_jobs(jobs, _Example(setting), processes=options.processes))
    others = [touch for touch in TOUCHES if touch not in _BEGIN]
    # What comes after five touches hardly ever matters: the rest follows in the usual order.
    orders = [(*first, *(t for t in others if t not in first)) for first in permutations(others, 4)]
    for touch in known.touches:
        taken = [felt.seconds[touch] for felt in examples if touch in felt.seconds]
        print(f"  {touch}: {figure(f'{touch} takes', np.mean(taken), '.2f', 's')}")
    for hand, hidden in hands.items():
        library = without(known, hidden)
        replays = [
            _Replay(job.name, felt, library, options.first)
            for job, felt in zip(jobs, examples, strict=True)
            if any(touch in felt.evidence for touch in _BEGIN)
        ]
        for error in _ERRORS:
            seconds, touches, right = _means([replay.run(error) for replay in replays])
            plain_s, _, plain_right = _means([replay.run(error, seconds_count=False) for replay in replays])
            wrong = 1 - right
            runs = np.array([[replay.run(error, order) for replay in replays] for order in orders], dtype=float)
            fixed = [(*_means(each), order) for each, order in zip(runs, orders, strict=True)]
            before = chosen_before(runs, wrong)
            by_object = of_each_object(runs, [replay.name for replay in replays])
            equal = [row for row in fixed if 1 - row[2] <= wrong + 1e-9] or [max(fixed, key=lambda row: row[2])]
            best = min(equal, key=lambda row: row[0])
            least = float(np.mean([replay.least(error) for replay in replays]))
            # What a fixed order without a rule for stopping needs: so many touches of everything.
            length = fixed_length(replays, orders, wrong)
            of = f"{hand}, error {error:g} accepted"
            print(
                f"  {of}: chosen {figure(f'{of}: chosen', seconds, '.2f', 's')}, "
                f"{figure(f'{of}: touches', touches, '.3f', 'touches')}, {share(f'{of}: wrong', wrong)} wrong; "
                f"best fixed order of {len(orders)} {figure(f'{of}: best fixed order', best[0], '.2f', 's')}, "
                f"{best[1]:.3f} touches, {100 * (1 - best[2]):.1f} % wrong ({' '.join(best[3][:3])} ..); "
                f"saved {share(f'{of}: saved', 1 - seconds / best[0], '.1f', bar=_BARS.get(hand, ''))}; "
                f"of an order that was best on the other half of the examples "
                f"{share(f'{of}: saved of an order chosen before', 1 - seconds / before[0], '.1f')} of "
                f"{before[0]:.2f} s, {100 * (1 - before[2]):.1f} % wrong; "
                f"who knew the object beforehand, by the best order for each, "
                f"{share(f'{of}: saved by who knew the object', 1 - by_object[0] / best[0], '.1f')} in hindsight, "
                f"{share(f'{of}: of other halves', 1 - by_object[1] / before[0], '.1f')} where it was best on the "
                f"other half; "
                f"by information alone {figure(f'{of}: by information alone', plain_s, '.2f', 's')}, "
                f"{100 * (1 - plain_right):.1f} % wrong; no order, chosen in hindsight for each example, takes less "
                f"than {figure(f'{of}: least', least, '.2f', 's')}, {100 * (1 - least / best[0]):.1f} % saved; "
                + (
                    f"against a fixed order of {length} touches for all, {100 * (1 - touches / length):.0f} %"
                    if length
                    else f"no fixed order of up to {_MOST} touches for all is so often right"
                ),
                flush=True,
            )


def _means(runs: ArrayLike) -> tuple[float, float, float]:
    seconds, touches, right = np.asarray(runs, dtype=float).mean(axis=0)
    return float(seconds), float(touches), float(right)


if __name__ == "__main__":
    main(sys.argv[1:])
