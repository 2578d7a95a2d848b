"""Touches outside of what a library has seen: how many names are given with p > .9, had nothing been outside, and now.

The shipped library: ten kinds of object and four strangers in three sizes, each touched in every way by the hand that
evaluates; what was felt is then changed as a sensor would change it, and touches are chosen and stopped as usual. Own
libraries: named numbers of ten presses each of ten things on one simulated day (`learn_days`), felt once on the same
day and on another; and the same with the answers of a `TactileClassifier`, which has learned from the same presses, as
evidence beside them.

Run: python -m benchmarks.perceive_outside [--examples N] [--seeds N]
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from benchmarks._evaluation_hand import WHAT_DIFFERS, evaluation_setting
from benchmarks._figures import share
from benchmarks.learn_days import PRESSES, TESTED, THINGS, Day, Thing, draw_days, draw_thing, presses
from varishold import TactileClassifier
from varishold.exploration import Felt, touch_all
from varishold.hand import OBJECTS, HandSetting, Job, run_jobs
from varishold.hand.objects import STRANGERS
from varishold.learning import evidence_of_presses
from varishold.perceive import NONE_OF_THESE, Evidence, Library, NameEvidence, Perceiver

_FIRST_SEED = 7_400_000_000
_SIZES_M = (0.055, 0.08, 0.105)
_SURE = 0.9
_SHAPES = ((28, 50), (5, 9))

Touches = Mapping[str, Evidence]


def _pads(felt: Felt, change: Callable[[np.ndarray], np.ndarray]) -> Felt:
    pads = felt.step.pads
    if pads is None:
        return felt
    frames = {name: change(frame) for name, frame in pads.frames.items()}
    return replace(felt, step=replace(felt.step, pads=replace(pads, frames=frames)))


def _angles(felt: Felt, off_rad: float) -> Felt:
    sensed = felt.step.sensed
    return replace(felt, step=replace(felt.step, sensed=replace(sensed, angles_rad=sensed.angles_rad + off_rad)))


def _stuck(felt: Felt, which: Sequence[int]) -> Felt:
    switches = felt.step.sensed.switches.copy()
    switches[list(which)] = True
    return replace(felt, step=replace(felt.step, sensed=replace(felt.step.sensed, switches=switches)))


#: How sensors have changed since the library was made; the gains of one touch are drawn by its own load.
CHANGES: Mapping[str, Callable[[Felt], Felt]] = {
    "as they were": lambda felt: felt,
    "all joints read .2 rad too much": lambda felt: _angles(felt, 0.2),
    "four switches stuck": lambda felt: _stuck(felt, (0, 6, 11, 17)),
    "taxels' gains off by a half": lambda felt: _pads(felt, _other_gains),
    "pads rest at a fifth of their peak": lambda felt: _pads(felt, lambda frame: frame + 0.2 * max(frame.max(), 1.0)),
}


def _other_gains(frame: np.ndarray) -> np.ndarray:
    drawn = np.random.default_rng(int(frame.sum()) % 2**32).normal(0, 0.5, frame.shape)
    return np.asarray(frame * np.exp(drawn))


@dataclass(frozen=True)
class _Example:
    """Every touch of one object, as felt by each change of the sensors."""

    setting: HandSetting

    def __call__(self, job: Job) -> dict[str, dict[str, Evidence]]:
        felt = touch_all(job.name, job.size_m, seed=job.seed, setting=self.setting)
        return {
            name: {touch: what.touch.evidence(change(what), self.setting)[0] for touch, what in felt.items()}
            for name, change in CHANGES.items()
        }


@dataclass(frozen=True)
class Outcome:
    """How one object was perceived: whether its name was given, and refused, with p > .9 before and now."""

    right: bool
    refused: bool
    before: bool
    now: bool
    likeliest_right: bool


def explore(touches: Touches, true: str) -> Outcome:
    """Return how it ends if touches are chosen among these and stopped as usual."""
    perceiver = Perceiver()
    wanted: str | None = "grasp" if "grasp" in touches else "squeeze"
    while wanted is not None:
        perceiver.feel(touches[wanted])
        left = [touch for touch in touches if touch not in (*perceiver.belief.touches, "grasp")]
        choice = None if perceiver.stopped else perceiver.next_touch(left)
        wanted = None if choice is None else choice[0]
    return outcome(perceiver, true)


def outcome(perceiver: Perceiver, true: str) -> Outcome:
    """Return what a perceiver says in the end."""
    belief, answer = perceiver.belief, perceiver.answer()
    return Outcome(
        right=answer.object == true,
        refused=answer.object == NONE_OF_THESE,
        before=belief.probability[belief.best] > _SURE,
        now=belief.believed[belief.best] > _SURE,
        likeliest_right=belief.best == true,
    )


def report(of: str, outcomes: Sequence[Outcome]) -> None:
    """Print shares of a row."""
    n = max(len(outcomes), 1)
    before, now, right, refused = (
        sum(getattr(o, what) for o in outcomes) / n for what in ("before", "now", "right", "refused")
    )
    wrong_before, wrong = (
        sum(getattr(o, when) and not o.likeliest_right for o in outcomes) / n for when in ("before", "now")
    )
    print(
        f"  {of.split(', ', 1)[1]:48s} p > .9 {share(f'{of}: p > .9 before', before)} -> "
        f"{share(f'{of}: p > .9', now)}; wrong ones {share(f'{of}: wrong with p > .9 before', wrong_before)} -> "
        f"{share(f'{of}: wrong with p > .9', wrong)}; named right {share(f'{of}: right', right)}, "
        f"refused {share(f'{of}: refused', refused)} ({len(outcomes)})"
    )


def shipped(examples: int) -> None:
    """Print how the shipped library fares with changed sensors."""
    names = (*OBJECTS, *STRANGERS)
    jobs = [
        Job(name, size_m, _FIRST_SEED + 100_000 * k + 1000 * j + n)
        for k, name in enumerate(names)
        for j, size_m in enumerate(_SIZES_M)
        for n in range(examples)
    ]
    felt = list(zip(jobs, run_jobs(jobs, _Example(evaluation_setting()), processes=1), strict=True))
    print(f"The shipped library; {WHAT_DIFFERS}")
    for change in CHANGES:
        for title, who in (("ten kinds", OBJECTS), ("strangers", STRANGERS)):
            found = [explore(of[change], job.name) for job, of in felt if job.name in who and of[change]]
            report(f"shipped, {title}, {change}", found)


def numbers(frames: np.ndarray) -> Evidence:
    """Return seventeen plain numbers of a press: areas, load, place, spread and time of its peak."""
    pressure = frames - frames[:2].mean(axis=0)
    total = pressure.sum(axis=(1, 2))
    peak = pressure[int(total.argmax())]
    row, col = np.indices(peak.shape)
    weight = np.maximum(peak, 0) / np.maximum(peak, 0).sum()
    middle = (weight * row).sum(), (weight * col).sum()
    found = {f"area_{level}": float((peak >= level).sum()) for level in (10, 20, 40, 60, 80)}
    found |= {f"share_{level}": float((peak >= level * peak.max()).sum()) for level in (0.2, 0.4, 0.6, 0.8)}
    found |= {"peak": float(peak.max()), "total": float(total.max()), "row": middle[0], "col": middle[1]}
    found |= {"rows": float(np.sqrt((weight * (row - middle[0]) ** 2).sum()))}
    found |= {"cols": float(np.sqrt((weight * (col - middle[1]) ** 2).sum()))}
    return Evidence("press", {**found, "time": float(total.argmax()), "frames": float(len(frames))})


def own(seeds: int) -> None:
    """Print how own libraries fare on another day, alone and with a learned model's answers beside them."""
    for shape in _SHAPES:
        rows: dict[str, list[Outcome]] = {}
        for seed in range(seeds):
            rng = np.random.default_rng((1907, seed, *shape))
            things = [draw_thing(rng, shape) for _ in range(2 * THINGS)]
            for title, found in _days(things, draw_days(rng, shape), rng).items():
                rows.setdefault(title, []).extend(found)
        title = f"own library of {shape[0]} x {shape[1]} taxels"
        print(f"An {title}, {seeds} draws, one press felt")
        for name, outcomes in rows.items():
            report(f"{title}, {name}", outcomes)


def _days(things: Sequence[Thing], days: tuple[Day, Day], rng: np.random.Generator) -> dict[str, list[Outcome]]:
    known, codes = presses(list(things[:THINGS]), days[0], PRESSES, rng)
    examples: dict[str, list[list[Evidence]]] = {}
    for frames, code in zip(known, codes, strict=True):
        examples.setdefault(f"thing {code}", []).append([numbers(frames)])
    library = Library.from_examples(examples)
    model = TactileClassifier().fit(known, np.array([f"thing {code}" for code in codes]))
    rows = {}
    for title, day, of in (
        ("known things, the same day", days[0], things[:THINGS]),
        ("known things, another day", days[1], things[:THINGS]),
        ("strangers, the same day", days[0], things[THINGS:]),
        ("strangers, another day", days[1], things[THINGS:]),
    ):
        asked, truth = presses(list(of), day, TESTED // 2, rng)
        said = evidence_of_presses(model, asked)
        names = [f"thing {code}" if title.startswith("known") else "" for code in truth]
        for how in ("numbers alone", "the model's answer alone", "both"):
            found = []
            for frames, answer, name in zip(asked, said, names, strict=True):
                felt: list[Evidence | NameEvidence] = [numbers(frames), answer]
                felt = felt if how == "both" else felt[:1] if how == "numbers alone" else felt[1:]
                perceiver = Perceiver(library, most_touches=len(felt))
                for one in felt:
                    perceiver.feel(one)
                found.append(outcome(perceiver, name))
            rows[f"{title}, {how}"] = found
    return rows


def main(argv: Sequence[str] = ()) -> None:
    """Print shares of names given with p > .9, right ones, and refusals."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--examples", type=int, default=2, help="of each object and size, shipped library")
    parser.add_argument("--seeds", type=int, default=3, help="draws of things and days, own libraries")
    options = parser.parse_args(list(argv))
    if options.examples:
        shipped(options.examples)
    if options.seeds:
        own(options.seeds)


if __name__ == "__main__":
    main(sys.argv[1:])
