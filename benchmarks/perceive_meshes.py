"""Ten household meshes of equal size, added to the shipped library: named in how many touches, and how surely wrong.

Run: ``python -m benchmarks.perceive_meshes [--episodes 30] [--seed 2] [--processes 2]``; needs the extra ``meshes``.
The library is grown by `varishold objects add`, as a person would; every episode is a closed loop at a fresh place,
under other physics than the examples. Development used ``--seed 1`` and ``--seed 6``.
"""

from __future__ import annotations

import argparse
import subprocess
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np
from examples.household_meshes import make_meshes

from benchmarks._evaluation_hand import WHAT_DIFFERS, evaluation_setting
from benchmarks._figures import figure, share
from varishold.exploration import mesh_to_grip, perceive
from varishold.files import spread
from varishold.files.crew import processors
from varishold.perceive import NONE_OF_THESE, Library, Perceiver, read_library
from varishold.solids import MeshSolid
from varishold.trust import share_interval

_FIRST_SEED = 8_100_000_000
_SIZE_M = 0.08
_SURE = 0.95
_read = cache(read_library)


@dataclass(frozen=True)
class Outcome:
    """How one episode ended."""

    true: str
    object: str
    probability: float
    touches: int
    drops: int


@dataclass(frozen=True)
class _Episode:
    """One closed loop: a thing and a seed."""

    library: Path
    most_touches: int

    def __call__(self, job: tuple[MeshSolid, int]) -> Outcome:
        thing, seed = job
        known: Library = _read(self.library)
        perceiver = Perceiver(known, most_touches=self.most_touches)
        done = perceive(thing, thing.size_m, seed=seed, perceiver=perceiver, setting=evaluation_setting())
        answer = done.perception
        if answer is None:
            return Outcome(thing.called, "", 0.0, 0, done.drops)
        return Outcome(thing.called, answer.object, answer.probability, len(done.touches), done.drops)


def add(files: Sequence[Path], library: Path, examples: int, processes: int) -> float:
    """Add meshes to a fresh library by the command; return the seconds that it took."""
    begun = time.monotonic()
    words = ["objects", "add", *map(str, files), "--library", str(library)]
    counts = ["--examples", str(examples), "--workers", str(processes)]
    subprocess.run([sys.executable, "-m", "varishold", *words, *counts], check=True)
    return time.monotonic() - begun


def run(
    things: Sequence[MeshSolid], library: Path, *, episodes: int, seed: int, processes: int, most_touches: int = 4
) -> list[Outcome]:
    """Return the outcomes of episodes at each thing."""
    jobs = [
        (thing, _FIRST_SEED + 10_000_000 * seed + 100_000 * k + n)
        for k, thing in enumerate(things)
        for n in range(episodes)
    ]
    return list(spread(_Episode(library, most_touches), jobs, processes=processes))


def main(argv: Sequence[str] = ()) -> None:
    """Print the figures."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--episodes", type=int, default=30, help="of each thing")
    parser.add_argument("--examples", type=int, default=50, help="of each thing")
    parser.add_argument("--seed", type=int, default=2)
    parser.add_argument("--processes", type=int, default=processors())
    parser.add_argument("--library", type=Path, help="a library that knows the ten already, or where to write it")
    options = parser.parse_args(list(argv))
    with tempfile.TemporaryDirectory() as folder:
        files = make_meshes(Path(folder), size_m=_SIZE_M)
        library = options.library or Path(folder, "household.npz")
        if not library.exists():
            seconds = add(list(files.values()), library, options.examples, options.processes)
            print(
                f"  ten meshes added, {options.examples} examples each, by {options.processes} processes: "
                f"{figure('time to add ten', seconds / 60, '.1f', 'min', bar='<= 15')}"
            )
        known = len(read_library(library).objects)
        things = [mesh_to_grip(path) for path in files.values()]
        done = run(things, library, episodes=options.episodes, seed=options.seed, processes=options.processes)
    print(f"  {WHAT_DIFFERS}")
    n = len(done)
    right = sum(each.object == each.true for each in done)
    named = [each for each in done if each.object not in (each.true, NONE_OF_THESE, "")]
    sure = sum(each.probability > _SURE for each in named)
    refused = sum(each.object == NONE_OF_THESE for each in done)
    low, high = share_interval(right, n)
    touches = np.array([each.touches for each in done])
    print(
        f"  ten things of {1e3 * _SIZE_M:.0f} mm among {known} objects, {n} episodes: "
        f"right name in at most {touches.max()} touches {share('right name', right / n, bar='>= 93')} "
        f"({100 * low:.1f}-{100 * high:.1f}), {figure('touches', touches.mean(), '.2f', 'touches')} on the mean; "
        f"wrong with p > {_SURE} {share('surely wrong', sure / n, bar='<= 1')}; "
        f"refused {share('refused', refused / n)}; never gripped {figure('never gripped', sum(touches == 0))}; "
        f"{sum(each.drops for each in done)} drops and misses"
    )
    for thing in things:
        name = thing.called
        own = [each for each in done if each.true == name]
        others = Counter(each.object or "nothing" for each in own if each.object != name)
        print(
            f"    {name:7s} right {share(f'{name}: right', np.mean([each.object == name for each in own]), '5.1f')}, "
            f"{np.mean([each.touches for each in own]):.2f} touches, {sum(each.drops for each in own)} drops and misses"
            + (f"; called {', '.join(f'{other} {times}' for other, times in others.items())}" if others else "")
        )


if __name__ == "__main__":
    main(sys.argv[1:])
