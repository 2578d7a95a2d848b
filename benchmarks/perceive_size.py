"""Step 1, size from one grip: joint angles and touched phalanges alone, for cylinders and pillars of 50 to 110 mm.

Run: ``python -m benchmarks.perceive_size [--grasps 150] [--seed 1]``. Nothing is trained: the fit knows the hand's
geometry only.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from benchmarks._evaluation_hand import WHAT_DIFFERS, evaluation_setting
from benchmarks._figures import share
from varishold.exploration import TOUCHES, Episode, grip_contacts
from varishold.hand import HandSetting, Job, run_jobs, set_up
from varishold.perceive import grip_size

_FIRST_SEED = 7_400_000_000
_KINDS = ("cylinder", "square-pillar")
_SIZES_M = (0.050, 0.110)


@dataclass(frozen=True)
class _Grip:
    """One grip: size, its standard deviation, and whether it is taken for a cylinder."""

    setting: HandSetting

    def __call__(self, job: Job) -> tuple[float, float, bool] | None:
        bench, rng = set_up(job.name, job.size_m, seed=job.seed, setting=self.setting)
        felt = Episode(bench, rng, self.setting).touch(TOUCHES["grasp"])
        size = None if felt is None else grip_size(grip_contacts(felt.step.sensed, bench.design, bench.layout))
        return None if size is None else (size.size_m, size.sigma_m, size.p_cylinder >= 0.5)


def main(argv: Sequence[str] = ()) -> None:
    """Print the figures."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--grasps", type=int, default=150)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--processes", type=int, default=None)
    options = parser.parse_args(list(argv))
    print(f"  {WHAT_DIFFERS}; no pads")
    rng = np.random.default_rng(options.seed)
    for scale in (1.0, 1.2):
        setting = evaluation_setting(finger_scale=scale)
        setting = HandSetting(design=setting.design, randomization=setting.randomization, search=True)
        jobs = [
            Job(
                name, float(np.exp(rng.uniform(*np.log(_SIZES_M)))), _FIRST_SEED + options.seed * 100_000 + 1000 * k + j
            )
            for k, name in enumerate(_KINDS)
            for j in range(options.grasps)
        ]
        said = list(run_jobs(jobs, _Grip(setting), processes=options.processes))
        for name in (*_KINDS, "both"):
            rows = [(job, s) for job, s in zip(jobs, said, strict=True) if name in (job.name, "both")]
            told = [(job, s) for job, s in rows if s is not None]
            off = np.array([abs(s[0] / job.size_m - 1) for job, s in told])
            z = np.array([abs(s[0] - job.size_m) / s[1] for job, s in told])
            kind = np.mean([s[2] == (job.name == "cylinder") for job, s in told])
            of = f"digits x {scale:g}, {name}"
            print(
                f"  {of}: {len(told)} of {len(rows)} told; "
                f"median error {share(f'{of}: median error', np.median(off), '.2f', bar='<= 3')}, "
                f"95 % within {share(f'{of}: 95 % within', np.quantile(off, 0.95), bar='<= 8')}; "
                f"within two standard deviations {share(f'{of}: within two sigma', np.mean(z <= 2), '.0f')}; "
                f"round or square told {share(f'{of}: round or square told', kind)}"
            )


if __name__ == "__main__":
    main(sys.argv[1:])
