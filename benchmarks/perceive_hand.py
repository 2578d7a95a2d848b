"""Ten kinds of object in three sizes under the shipped three-finger hand: named, refused, in how many touches.

Run: ``python -m benchmarks.perceive_hand [--library FILE] [--examples 48] [--episodes 5] [--seed 2] [--switches]``.
Without --library the hand feels the ten objects and some lumps first, which takes some twenty minutes of a core, and
keeps the library in ``out/benchmarks``. Episodes are closed loops as in `perceive_objects`: the hand searches, the
perceiver chooses each next touch and stops. With --switches the hand has no pads.
"""

from __future__ import annotations

import argparse
import sys
from collections import Counter
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from benchmarks._evaluation_hand import WHAT_DIFFERS, evaluation_setting
from benchmarks._figures import figure, share
from benchmarks.perceive_objects import Outcome, reliability, run
from varishold.cli.hand_file import require_library_of
from varishold.errors import InputError
from varishold.exploration.hand_library import feel_library, library_kept_beside
from varishold.exploration.object_examples import example_setting
from varishold.hand import OBJECTS, read_hand
from varishold.hand.mjcf import MjcfHand
from varishold.hand.objects import STRANGERS
from varishold.perceive import NONE_OF_THESE, read_library, write_library
from varishold.trust import share_interval

_FOLDER = Path("out/benchmarks")
# Examples are drawn with this seed, and no episode is.
_LIBRARY_SEED = 1


def library_of(hand: MjcfHand, examples: int, lumps: int, processes: int | None) -> Path:
    """Return the file of the hand's library, felt if it is not there yet."""
    setting = example_setting(hand)
    path = _FOLDER / f"{hand.name}-{examples}-{lumps}.npz"
    if path.exists() and read_library(path).hand == hand.identity:
        return path
    path.parent.mkdir(parents=True, exist_ok=True)
    keep = library_kept_beside(path, setting, seed=_LIBRARY_SEED)
    made = feel_library(setting, examples=examples, lumps=lumps, seed=_LIBRARY_SEED, processes=processes, keep=keep)
    write_library(made, path)
    return path


def told(outcomes: Sequence[Outcome]) -> None:
    """Print what became of known things."""
    n = len(outcomes)
    right = sum(done.object == done.true for done in outcomes)
    refused = sum(done.object == NONE_OF_THESE for done in outcomes)
    lost = sum(done.object == "" for done in outcomes)
    other = n - right - refused - lost
    low, high = share_interval(right, n)
    touches = np.array([done.touches for done in outcomes])
    wrong = sum(done.sure and done.object != done.true for done in outcomes)
    print(
        f"  ten kinds x three sizes, {n} episodes: right name {share('right name', right / n)} "
        f"({100 * low:.1f}-{100 * high:.1f}), {figure('touches', touches.mean(), '.2f', 'touches')} on the mean; "
        f"refused {share('refused', refused / n)}; another name {share('another name', other / n)}, "
        f"with p > .95 {share('another name for sure', wrong / n)}; "
        f"never gripped {figure('never gripped', lost)}; {sum(done.drops for done in outcomes)} drops and misses"
    )
    for name in OBJECTS:
        own = [done for done in outcomes if done.true == name]
        said = Counter(done.object or "nothing" for done in own if done.object != name)
        print(
            f"    {name:17s} right {share(f'{name}: right', np.mean([d.object == name for d in own]), '5.1f')}, "
            f"{np.mean([d.touches for d in own]):.2f} touches"
            + (f"; called {', '.join(f'{each} {k}' for each, k in said.items())}" if said else "")
        )
    sized = [done for done in outcomes if done.object == done.true and done.said_m is not None]
    off = np.array([abs((done.said_m or 0) / done.size_m - 1) for done in sized])
    print(
        f"  size, rightly named: median error {share('size: median error', np.median(off), '.2f')}, "
        f"95 % within {share('size: 95 % within', np.quantile(off, 0.95))}"
    )
    rows = reliability(outcomes)
    error = sum(count * abs(p - seen) for p, seen, count in rows) / sum(count for *_, count in rows)
    print(f"  expected calibration error {figure('expected calibration error', error, '.3f')}")


def main(argv: Sequence[str] = ()) -> None:
    """Print the figures."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--hand", default="three-finger", help="a hand's file, or one that comes with the program")
    parser.add_argument("--library", type=Path, help="what it knows; default: felt now")
    parser.add_argument("--examples", type=int, default=48)
    parser.add_argument("--lumps", type=int, default=60)
    parser.add_argument("--episodes", type=int, default=5, help="episodes of each kind and size")
    parser.add_argument("--strangers", type=int, default=5, help="episodes of each strange kind and size")
    parser.add_argument("--seed", type=int, default=2)
    parser.add_argument("--switches", action="store_true", help="leave the pads out")
    parser.add_argument("--processes", type=int, default=None)
    options = parser.parse_args(list(argv))
    try:
        hand = read_hand(options.hand)
        path = options.library or library_of(hand, options.examples, options.lumps, options.processes)
        require_library_of(hand, read_library(path), where=str(path), given=options.hand)
    except InputError as error:
        parser.error(str(error))
    setting = evaluation_setting(hand=hand)
    if options.switches:
        setting = replace(setting, pads=None)
    print(f"  {hand.name}; {WHAT_DIFFERS}" + ("; no pads" if setting.pads is None else ""))
    told(run(tuple(OBJECTS), options.episodes, options.seed, options.processes, setting=setting, library=path))
    strangers = run(tuple(STRANGERS), options.strangers, options.seed, options.processes, setting=setting, library=path)
    gone = sum(done.object == NONE_OF_THESE for done in strangers)
    by = {name: np.mean([d.object == NONE_OF_THESE for d in strangers if d.true == name]) for name in STRANGERS}
    low, high = share_interval(gone, len(strangers))
    print(
        f"  strangers refused {share('strangers refused', gone / len(strangers))} of {len(strangers)} "
        f"({100 * low:.1f}-{100 * high:.1f}), named with more than .95 "
        f"{share('strangers named for sure', np.mean([done.sure for done in strangers]))}: "
        + ", ".join(f"{name} {100 * each:.0f} %" for name, each in by.items())
    )


if __name__ == "__main__":
    main(sys.argv[1:])
