"""Table 5 in simulation: right answers in the four groups of function, grasps held, searches that found.

Run: ``python -m benchmarks.hand_table5 [--repetitions 4] [--grasps 20] [--seed 2026] [--place-known]``. The hand was
designed on seeds below 100,000; every seed here is fresh.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence

import numpy as np

from benchmarks._figures import figure, share
from varishold.hand import TABLE_5_OBJECTS, HandSetting, Job, run_jobs
from varishold.hand.grasping import grasp
from varishold.paper.finger_length import finger_length_sweep
from varishold.paper.table5 import OBJECT_NAMES, as_paper_table, table_5
from varishold.trust import share_interval

#: First seed of the grasps without retries.
_FIRST_SEED = 2_000_000_000


class _Once:
    """One grasp without a second attempt: was the object found, was it held."""

    def __init__(self, setting: HandSetting) -> None:
        self.setting = setting

    def __call__(self, job: Job) -> tuple[bool, bool, bool]:
        done = grasp(job.name, job.size_m, seed=job.seed, setting=self.setting)
        search = done.attempts[0].search
        return search is None or search.found, done.held, done.attempts[-1].outcome == "held"


def held_once(grasps: int, *, search: bool, seed: int, processes: int | None) -> None:
    """Print how many grasps hold the object after step 5 at the first attempt, and how many searches find it."""
    setting = HandSetting(search=search, most_attempts=1)
    jobs = [
        Job(name, size_m, _FIRST_SEED + (seed * 10 + k) * 10_000 + n)
        for k, (name, size_m) in enumerate(TABLE_5_OBJECTS)
        for n in range(grasps)
    ]
    answers = np.array(list(run_jobs(jobs, _Once(setting), processes=processes))).reshape(10, grasps, 3)
    how = "searched" if search else "place known"
    for column, what in ((0, "found"), (1, "held after step 5"))[not search :]:
        each = answers[:, :, column].sum(axis=1)
        low, high = share_interval(int(each.sum()), 10 * grasps)
        worst = OBJECT_NAMES[int(each.argmin())]
        print(
            f"{how}: {what} {share(f'{how}: {what}', each.sum() / (10 * grasps), '.2f')} of {10 * grasps} at the first "
            f"attempt ({100 * low:.1f}-{100 * high:.1f} %), least {worst} {100 * each.min() / grasps:.0f} %"
        )
    wrong = int((answers[:, :, 1] != answers[:, :, 2]).sum())
    print(f"{how}: felt outcome differs from the truth in {figure(f'{how}: felt wrong', wrong)} of {10 * grasps}")


def main(argv: Sequence[str] = ()) -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--repetitions", type=int, default=4)
    parser.add_argument("--grasps", type=int, default=20)
    parser.add_argument("--seed", type=int, default=2026)
    parser.add_argument("--place-known", action="store_true")
    parser.add_argument("--finger-length", action="store_true", help="repeat it with digits of several lengths")
    parser.add_argument("--processes", type=int, default=None)
    options = parser.parse_args(list(argv))
    for search in (False, True):
        held_once(40, search=search, seed=options.seed, processes=options.processes)
    table = table_5(
        grasps=options.grasps,
        repetitions=options.repetitions,
        seed=options.seed,
        search=not options.place_known,
        processes=options.processes,
    )
    print(as_paper_table(table).ours)
    for group in table.groups:
        p = table.below_paper(group)
        worst = int(p.argmin())
        least = figure(f"{group}: least p of being below the paper", p[worst], ".3f")
        print(f"{group}: least p of being below the paper {least} ({OBJECT_NAMES[worst]})")
    if options.finger_length:
        print(finger_length_sweep(seed=options.seed, processes=options.processes))


if __name__ == "__main__":
    main(sys.argv[1:])
