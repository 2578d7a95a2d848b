"""Ten kinds of object in three sizes, and 23 kinds that nobody knows: named, sized, refused, in how many touches.

Run: ``python -m benchmarks.perceive_objects [--episodes 20] [--strangers 20] [--seed 2] [--turn-deg 20]
[--library FILE] [--lacks pads coordinates]``. Every episode is a closed loop: the hand searches, the perceiver chooses
each next touch and stops. What the hand lacks is not known of any touch. Development used seeds below 100,000,000.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cache, partial
from itertools import pairwise
from pathlib import Path

import numpy as np

from benchmarks._evaluation_hand import TURN_DEG, WHAT_DIFFERS, evaluation_setting
from benchmarks._figures import figure, share
from benchmarks._strangers import KNOWN_BEFORE, NEW, STRANGERS, to_touch
from varishold.errors import InputError
from varishold.exploration import perceive
from varishold.hand import OBJECTS, HandSetting, Job, run_jobs
from varishold.perceive import NONE_OF_THESE, Evidence, Library, NameEvidence, Perceiver, read_library
from varishold.perceive.perceiver import BeliefUpdate
from varishold.trust import share_interval

_FIRST_SEED = 7_200_000_000
_SIZES_M = (0.055, 0.08, 0.105)
#: What the numbers begin with that a hand may lack.
_LACKS = {"pads": ("pad.", "form."), "coordinates": ("fit.", "size.")}
_BINS = (0.0, 0.5, 0.7, 0.9, 0.97, 0.99, 0.999, 1.0)


@dataclass(frozen=True)
class Outcome:
    """How one episode ended; `trace`: likeliest name, its probability among known ones and whether it is right."""

    true: str
    size_m: float
    object: str
    said_m: float | None
    interval_m: tuple[float, float] | None
    touches: int
    drops: int
    trace: tuple[tuple[str, float, bool], ...]
    seed: int = 0
    pose: str | None = None
    probability: float = 0.0

    @property
    def sure(self) -> bool:
        """Whether a name was given with more than .95."""
        return self.object not in ("", NONE_OF_THESE) and self.probability > 0.95


class _Lacking(Perceiver):
    """Knows nothing of numbers that begin so."""

    hidden: tuple[str, ...] = ()

    def feel(self, evidence: Evidence | NameEvidence) -> BeliefUpdate:
        if isinstance(evidence, Evidence):
            values = {name: value for name, value in evidence.values.items() if not name.startswith(self.hidden)}
            evidence = replace(evidence, values=values)
        return super().feel(evidence)


@dataclass(frozen=True)
class _Episode:
    """One closed loop; `library`: what is known, the shipped one where None; `hidden`: beginnings of numbers."""

    setting: HandSetting
    library: Path | None = None
    hidden: tuple[str, ...] = ()

    def __call__(self, job: Job) -> Outcome:
        perceiver = _Lacking(None if self.library is None else _library(self.library))
        perceiver.hidden = self.hidden
        thing = to_touch(job.name, job.size_m)
        done = perceive(thing, job.size_m, seed=job.seed, setting=self.setting, perceiver=perceiver)
        answer = done.perception
        if answer is None:
            return Outcome(job.name, job.size_m, "", None, None, 0, done.drops, (), job.seed)
        best = (next(iter(thought.probability.items())) for thought in answer.trace)
        trace = tuple((name, p, name == job.name) for name, p in best)
        return Outcome(
            job.name,
            job.size_m,
            answer.object,
            answer.size_m,
            answer.size_interval_m,
            len(done.touches),
            done.drops,
            trace,
            job.seed,
            answer.pose,
            answer.probability,
        )


@cache
def _library(path: Path) -> Library:
    return read_library(path)


def run(
    names: Sequence[str],
    episodes: int,
    seed: int,
    processes: int | None,
    *,
    setting: HandSetting | None = None,
    library: Path | None = None,
    hidden: tuple[str, ...] = (),
) -> list[Outcome]:
    """Return the outcomes of episodes at objects of these names, in three sizes each."""
    jobs = [
        Job(name, size_m, _FIRST_SEED + 10_000_000 * seed + 100_000 * k + 1000 * j + n)
        for k, name in enumerate(names)
        for j, size_m in enumerate(_SIZES_M)
        for n in range(episodes)
    ]
    return list(run_jobs(jobs, _Episode(setting or evaluation_setting(), library, hidden), processes=processes))


def reliability(outcomes: Sequence[Outcome]) -> list[tuple[float, float, int]]:
    """Return mean probability, share right and number of likeliest names after each touch, in bins."""
    pairs = np.array([(p, right) for done in outcomes for _, p, right in done.trace]).reshape(-1, 2)
    rows = []
    for low, high in pairwise(_BINS):
        inside = (pairs[:, 0] >= low) & ((pairs[:, 0] < high) | (high == 1.0))
        if inside.any():
            rows.append((float(pairs[inside, 0].mean()), float(pairs[inside, 1].mean()), int(inside.sum())))
    return rows


def print_kinds(known: Sequence[Outcome], right: Sequence[bool]) -> None:
    """Print how often boxes and pillars are taken for each other, and how often each kind is named rightly."""
    pair = ("box", "square-pillar")
    judged = list(zip(known, right, strict=True))
    mixed = [not good and done.object in pair for done, good in judged if done.true in pair]
    print(f"  boxes called pillars or pillars boxes: {share('box and pillar mixed up', np.mean(mixed), bar='<= 1')}")
    for name in dict.fromkeys(done.true for done in known):
        own = [(done, good) for done, good in judged if done.true == name]
        wrong = [done.object or "nothing" for done, good in own if not good]
        print(
            f"    {name:17s} right {share(f'{name}: right', np.mean([good for _, good in own]), '5.1f')}, "
            f"{np.mean([done.touches for done, _ in own]):.2f} touches"
            + (f"; called {', '.join(wrong)}" if wrong else "")
        )


def main(argv: Sequence[str] = ()) -> None:
    """Print the figures."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--episodes", type=int, default=20)
    parser.add_argument("--strangers", type=int, default=20)
    parser.add_argument("--seed", type=int, default=2)
    parser.add_argument("--turn-deg", type=float, default=TURN_DEG, help="objects are turned at most so far either way")
    parser.add_argument("--library", type=Path, help="what is known; default: the shipped library")
    parser.add_argument("--lacks", nargs="+", choices=_LACKS, default=[], help="what the hand does not give")
    parser.add_argument("--processes", type=int, default=None)
    parser.add_argument("--figure", type=Path, help="write the reliability diagram (PNG) here")
    options = parser.parse_args(list(argv))
    if options.library is not None:
        try:
            _library(options.library)
        except InputError as error:
            parser.error(f"--library: {error}")
    print(f"  {WHAT_DIFFERS}")
    setting = evaluation_setting(turn_deg=options.turn_deg)
    run_here = partial(
        run,
        seed=options.seed,
        processes=options.processes,
        setting=setting,
        library=options.library,
        hidden=tuple(start for what in options.lacks for start in _LACKS[what]),
    )
    known = run_here(tuple(OBJECTS), options.episodes)
    n = len(known)
    right = sum(done.object == done.true for done in known)
    refused = sum(done.object == NONE_OF_THESE for done in known)
    lost = sum(done.object == "" for done in known)
    touches = np.array([done.touches for done in known])
    low, high = share_interval(right, n)
    print(
        f"  ten kinds x three sizes, {n} episodes: right name {share('right name', right / n, bar='>= 97')} "
        f"({100 * low:.1f}-{100 * high:.1f}), "
        f"{figure('touches', touches.mean(), '.2f', 'touches', bar='<= 2.2')} on the mean, "
        f"{touches.max()} at most; refused {share('refused', refused / n, bar='<= 3')}; "
        f"never gripped {figure('never gripped', lost)}; {sum(d.drops for d in known)} drops and misses"
    )
    sure = np.mean([done.sure and done.object != done.true for done in known])
    print(f"  another name with more than .95: {share('wrong and sure', sure, bar='<= 1')}")
    print_kinds(known, [done.object == done.true for done in known])
    for kinds, title in (
        (("cylinder", "square-pillar"), "cylinders and square pillars"),
        (tuple(OBJECTS), "all kinds"),
    ):
        sized = [done for done in known if done.true in kinds and done.object == done.true and done.said_m is not None]
        off = np.array([abs((done.said_m or 0) / done.size_m - 1) for done in sized])
        held = np.mean([done.interval_m[0] <= done.size_m <= done.interval_m[1] for done in sized if done.interval_m])
        print(
            f"  size of {title}, rightly named: "
            f"median error {share(f'size of {title}: median error', np.median(off), '.2f')}, "
            f"95 % within {share(f'size of {title}: 95 % within', np.quantile(off, 0.95))}; "
            f"the 95 % interval holds it in {share(f'size of {title}: interval holds', held, '.0f')}"
        )
    print("  reliability of the likeliest name after every touch: mean probability, share right, number")
    rows = reliability(known)
    for p, seen, count in rows:
        print(f"    {p:.4f}  {seen:.4f}  {count}")
    error = sum(count * abs(p - seen) for p, seen, count in rows) / sum(count for *_, count in rows)
    print(f"    expected calibration error {figure('expected calibration error', error, '.4f')}")
    strangers = run_here(STRANGERS, options.strangers)
    for name in STRANGERS:
        own = [done for done in strangers if done.true == name]
        named = [done.object or "nothing" for done in own if done.object != NONE_OF_THESE]
        print(
            f"    {name:17s} refused "
            f"{share(f'{name}: refused', np.mean([d.object == NONE_OF_THESE for d in own]), '5.1f')}, "
            f"{np.mean([d.touches for d in own]):.2f} touches"
            + (f"; called {', '.join(sorted(set(named)))}" if named else "")
        )
    for title, kinds, bar in (
        ("strangers", STRANGERS, ">= 92"),
        ("kinds that had been measured before", KNOWN_BEFORE, ""),
        ("kinds that had not", NEW, ""),
    ):
        of = [done for done in strangers if done.true in kinds]
        gone = sum(done.object == NONE_OF_THESE for done in of)
        low, high = share_interval(gone, len(of))
        print(
            f"  {title}: refused {share(f'{title} refused', gone / len(of), bar=bar)} of {len(of)} "
            f"({100 * low:.1f}-{100 * high:.1f}); "
            f"named with more than .95 {share(f'{title}: named surely', np.mean([done.sure for done in of]))}"
        )
    if options.figure is not None:
        from benchmarks._reliability_figure import draw_reliability

        draw_reliability([(p, seen, *share_interval(round(seen * n), n), n) for p, seen, n in rows], options.figure)
        print(f"  {options.figure}")


if __name__ == "__main__":
    main(sys.argv[1:])
