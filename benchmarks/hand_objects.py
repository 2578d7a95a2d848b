"""Ten kinds of object in three sizes: found and held at the first attempt, and the fingertip's touch on the top.

Run: ``python -m benchmarks.hand_objects [--grasps 10]``. Place and turn unknown, physics varied.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence

import numpy as np

from benchmarks._figures import share
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


def main(argv: Sequence[str] = ()) -> None:
    """Print the shares."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--grasps", type=int, default=10)
    parser.add_argument("--processes", type=int, default=None)
    options = parser.parse_args(list(argv))
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
        of = f"{name:18s} {1e3 * size_m:3.0f} mm"
        found, held, felt = (
            share(f"{of}: {what}", each, "3.0f")
            for what, each in zip(("found", "held", "felt as it was"), rows[:, :3].mean(axis=0), strict=True)
        )
        print(f"{of}: found {found}, held {held}, felt as it was {felt}; {height}")
    found, held = (share(f"all: {what}", answers[:, k].mean()) for k, what in enumerate(("found", "held")))
    print(f"all: found {found}, held {held} of {len(jobs)}")


if __name__ == "__main__":
    main(sys.argv[1:])
