"""Touch alone, a camera alone, and both: how often they err, and how many seconds of touching it takes.

Run: ``python -m benchmarks.perceive_camera [--episodes 4] [--strangers 5] [--seed 1]``. The camera sees a silhouette
and is right in some 70 % (`benchmarks/_camera.py`); what it says is the prior, names and size. Everything else is as in
`perceive_objects`: closed loops with another hand than that which made the library, each once without a camera and once
with it, from the same seed. Development used seed 0.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from benchmarks._camera import camera_says, learned
from benchmarks._evaluation_hand import WHAT_DIFFERS, evaluation_setting
from benchmarks._figures import figure, share
from varishold.exploration import perceive
from varishold.hand import OBJECTS, HandSetting, Job, run_jobs
from varishold.hand.objects import STRANGERS
from varishold.perceive import NONE_OF_THESE, Perceiver

_FIRST_SEED = 7_900_000_000
_SIZES_M = (0.055, 0.08, 0.105)


@dataclass(frozen=True)
class Answer:
    """What was answered at the end, in how many touches and seconds of the hand."""

    object: str
    probability: float
    touches: int
    seconds: float


@dataclass(frozen=True)
class Outcome:
    """One object: what it is, what the camera took it for, and what was answered by touch alone and with the camera."""

    true: str
    seen: str
    alone: Answer
    both: Answer


@dataclass(frozen=True)
class _Episode:
    setting: HandSetting

    def __call__(self, job: Job) -> Outcome:
        seen = camera_says(job.name, job.size_m, job.seed)
        best = "" if seen is None else max(seen.probability, key=seen.probability.__getitem__)
        return Outcome(job.name, best, self._answer(job, Perceiver()), self._answer(job, Perceiver(prior=seen)))

    def _answer(self, job: Job, perceiver: Perceiver) -> Answer:
        done = perceive(job.name, job.size_m, seed=job.seed, setting=self.setting, perceiver=perceiver)
        said = done.perception
        if said is None:
            return Answer("", 0.0, 0, done.seconds)
        return Answer(said.object, said.probability, len(done.touches), done.seconds)


def run(names: Sequence[str], episodes: int, seed: int, processes: int | None) -> list[Outcome]:
    """Return the outcomes of episodes at objects of these names, in three sizes each."""
    jobs = [
        Job(name, size_m, _FIRST_SEED + 10_000_000 * seed + 100_000 * k + 1000 * j + n)
        for k, name in enumerate(names)
        for j, size_m in enumerate(_SIZES_M)
        for n in range(episodes)
    ]
    return list(run_jobs(jobs, _Episode(evaluation_setting()), processes=processes))


def main(argv: Sequence[str] = ()) -> None:
    """Print the figures."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--episodes", type=int, default=4, help="episodes of each kind and size")
    parser.add_argument("--strangers", type=int, default=5, help="the same of each unknown kind and size")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--processes", type=int, default=None)
    options = parser.parse_args(list(argv))
    print(f"  {WHAT_DIFFERS}")
    print(f"  the camera's answers are raised to the power {learned()[1]:.2f}, which it learned")
    known = run(tuple(OBJECTS), options.episodes, options.seed, options.processes)
    n = len(known)
    seen_wrong = float(np.mean([done.seen != done.true for done in known]))
    print(f"  camera alone: {share('camera alone: errors', seen_wrong)} of {n} wrong")
    wrong, seconds = {}, {}
    for way, title in (("alone", "touch alone"), ("both", "touch and camera")):
        answers: list[tuple[str, Answer]] = [(done.true, getattr(done, way)) for done in known]
        wrong[way] = float(np.mean([said.object != true for true, said in answers]))
        seconds[way] = float(np.mean([said.seconds for _, said in answers]))
        refused = float(np.mean([said.object == NONE_OF_THESE for _, said in answers]))
        other = float(np.mean([said.object not in (true, NONE_OF_THESE, "") for true, said in answers]))
        touches = float(np.mean([said.touches for _, said in answers]))
        named = [said for true, said in answers if said.object not in (true, NONE_OF_THESE)]
        sure = sum(said.probability > 0.95 for said in named) / n
        bar = f"<= {50 * min(seen_wrong, wrong['alone']):.1f}" if way == "both" else ""
        print(
            f"  {title}: {share(f'{title}: errors', wrong[way], bar=bar)} wrong: refused "
            f"{share(f'{title}: refused', refused)}, another name {share(f'{title}: another name', other)} "
            f"({100 * sure:.1f} % with p > .95); {figure(f'{title}: touches', touches, '.2f', 'touches')}, "
            f"{figure(f'{title}: seconds', seconds[way], '.2f', 's')} of the hand"
        )
    print(
        f"  seconds saved by the camera: {share('seconds saved', 1 - seconds['both'] / seconds['alone'], bar='>= 30')}"
    )
    for title, right in (("right", True), ("wrong", False)):
        own = [done for done in known if (done.seen == done.true) == right]
        if own:
            print(
                f"    where the camera was {title}, {len(own)}: "
                f"touch alone {np.mean([d.alone.seconds for d in own]):.2f} s, "
                f"both {np.mean([d.both.seconds for d in own]):.2f} s, "
                f"{100 * np.mean([d.both.object != d.true for d in own]):.1f} % wrong"
            )
    strangers = run(tuple(STRANGERS), options.strangers, options.seed, options.processes)
    for way, title in (("alone", "touch alone"), ("both", "touch and camera")):
        refusals = [(done.true, getattr(done, way).object == NONE_OF_THESE) for done in strangers]
        gone = float(np.mean([refused for _, refused in refusals]))
        each = ", ".join(
            f"{name} {100 * np.mean([refused for true, refused in refusals if true == name]):.0f} %"
            for name in STRANGERS
        )
        print(f"  strangers refused, {title}: {share(f'strangers refused, {title}', gone)} of {len(strangers)}: {each}")


if __name__ == "__main__":
    main(sys.argv[1:])
