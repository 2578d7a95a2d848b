"""Table 5 fused: learned from one cylinder and one pillar, ten grasps each; ten objects, several finger lengths.

Run: ``python -m benchmarks.perceive_table5 [--grasps 40] [--seed 2026] [--turn-deg 20] [--widest-friction]``. What is
fused: how much better a circle fits the grip than a square, and how much likelier curved is than flat or edge under the
pads. A grasp that leaves more than one in a thousand of doubt is followed by a grip elsewhere. Drops are retried and
counted.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from benchmarks._evaluation_hand import TURN_DEG, WHAT_DIFFERS, WIDEST_FRICTION, evaluation_setting
from benchmarks._figures import figure
from varishold.exploration import TOUCHES, Episode
from varishold.hand import TABLE_5_OBJECTS, HandDesign, HandSetting, Job, PadSetting, run_jobs, set_up
from varishold.paper.table5 import OBJECT_NAMES
from varishold.perceive import Evidence, Library, Perceiver
from varishold.trust import share_interval

#: Training grasps begin here; evaluation seeds are far above.
_TRAINING_SEED, _FIRST_SEED = 20_000, 7_100_000_000
_TRAINED = (("cylinder", 0.09), ("square-pillar", 0.07))
_ORDER = ("grasp", "regrasp-turned-45", "regrasp-higher", "regrasp-turned-90")
_DOUBT = 0.001


def grip_evidence(episode: Episode, touch: str) -> Evidence | None:
    """Make a touch and return what tells round from angular; every grip counts as the same kind of touch."""
    felt = episode.touch(TOUCHES[touch])
    if felt is None:
        return None
    full, _ = felt.touch.evidence(felt, episode.setting)
    return Evidence("grip", {name: value for name, value in full.values.items() if name.startswith("form.")})


@dataclass(frozen=True)
class _Train:
    """One training grasp."""

    setting: HandSetting

    def __call__(self, job: Job) -> Evidence | None:
        bench, rng = set_up(job.name, job.size_m, seed=job.seed, setting=self.setting)
        return grip_evidence(Episode(bench, rng, self.setting), _ORDER[0])


@dataclass(frozen=True)
class _Test:
    """One episode: the name after the first touch, the name in the end, touches, drops."""

    setting: HandSetting
    library: Library

    def __call__(self, job: Job) -> tuple[str, str, int, int]:
        bench, rng = set_up(job.name, job.size_m, seed=job.seed, setting=self.setting)
        perceiver = Perceiver(self.library, error=_DOUBT, refuse=False)
        episode = Episode(bench, rng, self.setting)
        names: list[str] = []
        for touch in _ORDER:
            evidence = grip_evidence(episode, touch)
            if evidence is None:
                break
            perceiver.feel(evidence)
            names.append(perceiver.belief.best)
            if perceiver.stopped:
                break
        return (names[0], names[-1], len(names), episode.drops) if names else ("", "", 0, episode.drops)


def main(argv: Sequence[str] = ()) -> None:
    """Print the figures."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--grasps", type=int, default=40)
    parser.add_argument("--seed", type=int, default=2026)
    parser.add_argument("--scales", type=float, nargs="*", default=[1.0, 1.2, 0.9])
    parser.add_argument("--turn-deg", type=float, default=TURN_DEG, help="objects are turned at most so far either way")
    parser.add_argument("--widest-friction", action="store_true", help="friction .4 to 1.3, even in logarithm")
    parser.add_argument("--processes", type=int, default=None)
    options = parser.parse_args(list(argv))
    print(f"  {WHAT_DIFFERS}")
    if options.widest_friction:
        print(f"  but friction from {WIDEST_FRICTION[0]:g} to {WIDEST_FRICTION[1]:g}")
    for scale in options.scales:
        learned = HandSetting(design=HandDesign(finger_scale=scale), pads=PadSetting(), search=True)
        jobs = [
            Job(name, size_m, _TRAINING_SEED + 100 * k + j)
            for k, (name, size_m) in enumerate(_TRAINED)
            for j in range(10)
        ]
        felt = list(run_jobs(jobs, _Train(learned), processes=options.processes))
        library = Library.from_examples(
            {
                name: [[e] for e, job in zip(felt, jobs, strict=True) if job.name == name and e is not None]
                for name, _ in _TRAINED
            }
        )
        hand = evaluation_setting(
            finger_scale=scale, turn_deg=options.turn_deg, widest_friction=options.widest_friction
        )
        tests = [
            Job(name, size_m, _FIRST_SEED + options.seed * 100_000 + 1000 * k + j)
            for k, (name, size_m) in enumerate(TABLE_5_OBJECTS)
            for j in range(options.grasps)
        ]
        answers = list(run_jobs(tests, _Test(hand, library), processes=options.processes))
        first = np.array([a[0] == job.name for a, job in zip(answers, tests, strict=True)])
        right = np.array([a[1] == job.name for a, job in zip(answers, tests, strict=True)])
        n = len(tests)
        low, high = share_interval(int((~right).sum()), n)
        of = f"digits x {scale:g}"
        bar = "<= 0" if scale in (1.0, 1.2) else ""
        print(
            f"  {of}: {figure(f'{of}: errors', int((~right).sum()), '', 'errors', bar=bar)} in {n} "
            f"(95 %: {100 * low:.2f}-{100 * high:.2f} %); after the first touch {int((~first).sum())}; "
            f"{figure(f'{of}: touches', np.mean([a[2] for a in answers]), '.2f', 'touches')} on the mean; "
            f"{sum(a[3] for a in answers)} drops and misses, retried"
        )
        by_object = right.reshape(len(TABLE_5_OBJECTS), -1).mean(axis=1)
        print("    " + ", ".join(f"{name} {100 * p:.0f}" for name, p in zip(OBJECT_NAMES, by_object, strict=True)))


if __name__ == "__main__":
    main(sys.argv[1:])
