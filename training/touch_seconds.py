"""Measure how long each touch takes the hand in simulation, and write that into a library.

Run: ``python -m training.touch_seconds [--examples 4] [--library FILE]``, some minutes on one core. Clocked is the
simulation's time from the end of one touch to the end of the next: letting go, coming there, finding the object again
and lifting are part of it. Touches of an example come in an order drawn by chance, so that what stood before one
touch averages out. Sizes are drawn as for the library; seeds from 110,000 on, which no library and no figure uses.
"""

from __future__ import annotations

import argparse
import sys
from collections import defaultdict
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from training.objects import OUTPUT, draw_example, write_packed
from varishold.exploration import TOUCHES, touch_all
from varishold.exploration.object_examples import example_setting
from varishold.hand import OBJECTS, Job, run_jobs
from varishold.perceive.library_file import read_packed_library

FIRST_SEED = 110_000


def clocked(job: Job) -> dict[str, float]:
    """Return the seconds of each touch of one object that was made."""
    # Pads take the computer's time and none of the hand's.
    felt = touch_all(job.name, job.size_m, seed=job.seed, setting=replace(example_setting(), pads=None))
    return {touch: what.seconds for touch, what in felt.items() if what.seconds is not None}


def main(argv: Sequence[str] = ()) -> None:
    """Measure, print, and write."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--examples", type=int, default=4, help="examples of each object")
    parser.add_argument("--processes", type=int, default=None)
    parser.add_argument("--library", type=Path, default=OUTPUT, help="the library that is to know it")
    options = parser.parse_args(list(argv))
    library = read_packed_library(options.library)
    jobs = [Job(name, *draw_example(FIRST_SEED, k, name)) for k in range(options.examples) for name in OBJECTS]
    taken = defaultdict(list)
    for clock in run_jobs(jobs, clocked, processes=options.processes):
        for touch, seconds in clock.items():
            taken[touch].append(seconds)
    for touch in TOUCHES:
        of = np.array(taken[touch])
        print(f"{touch:18s} {of.mean():5.2f} s, {of.min():.2f} to {of.max():.2f}, made {len(of)} of {len(jobs)} times")
    seconds = {touch: round(float(np.mean(taken[touch])), 2) for touch in TOUCHES if touch in library.touches}
    write_packed(library.with_seconds(seconds), options.library)
    print(f"{options.library}: {len(seconds)} touches")


if __name__ == "__main__":
    main(sys.argv[1:])
