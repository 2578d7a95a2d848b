"""Ten kinds of object in three sizes: found and held at the first attempt, and the fingertip's touch on the top.

Run: ``python -m benchmarks.hand_objects [--grasps 10]``. Place and turn unknown, physics varied.
"""

from __future__ import annotations

import argparse

import numpy as np

from varishold.hand import OBJECTS, HandSetting, Job, grasp_object, run_jobs, set_up
from varishold.hand.actions import fingertip, let_go, search

_FIRST_SEED = 4_000_000_000
_SIZES_M = (0.05, 0.07, 0.09)
_SETTING = HandSetting(search=True, most_attempts=1)


def _once(job: Job) -> tuple[bool, bool, bool, float]:
    """Found, held, felt as it was, and the height of the top as the fingertip feels it less the true one (metres)."""
    done = grasp_object(job.name, job.size_m, seed=job.seed, setting=_SETTING)
    found = done.attempts[0].search
    bench, _ = set_up(job.name, job.size_m, seed=job.seed, setting=_SETTING)
    search(bench)
    let_go(bench)
    tip = fingertip(bench)
    top = bench.table_m + max(part.centre_m[2] + part.half_m[2] for part in bench.solid.body())
    error = tip.height_m - top if tip.touched else float("nan")
    return bool(found and found.found), done.held, (done.attempts[-1].outcome == "held") == done.held, error


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--grasps", type=int, default=10)
    parser.add_argument("--processes", type=int, default=None)
    options, _ = parser.parse_known_args()
    kinds = [(name, size_m) for name in OBJECTS for size_m in _SIZES_M]
    jobs = [
        Job(name, size_m, _FIRST_SEED + 1000 * k + n)
        for k, (name, size_m) in enumerate(kinds)
        for n in range(options.grasps)
    ]
    answers = np.array(list(run_jobs(jobs, _once, processes=options.processes)), dtype=float)
    for k, (name, size_m) in enumerate(kinds):
        rows = answers[k * options.grasps : (k + 1) * options.grasps]
        tip = rows[:, 3][np.isfinite(rows[:, 3])]
        height = f"top felt {len(tip)} times, off by {1e3 * np.median(tip):+.1f} mm" if tip.size else "top not felt"
        print(
            f"{name:18s} {1e3 * size_m:3.0f} mm: found {100 * rows[:, 0].mean():3.0f} %, "
            f"held {100 * rows[:, 1].mean():3.0f} %, felt as it was {100 * rows[:, 2].mean():3.0f} %; {height}"
        )
    found, held = 100 * answers[:, 0].mean(), 100 * answers[:, 1].mean()
    print(f"all: found {found:.1f} %, held {held:.1f} % of {len(jobs)}")


if __name__ == "__main__":
    main()
