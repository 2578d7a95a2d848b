"""Nine kinds of object that lie on a side, at any turn, in free proportions; and things that nobody knows, lying too.

Run: ``python -m benchmarks.perceive_lying [--episodes 10] [--strangers 10] [--seed 1] [--library FILE]``. Closed loops
as in `perceive_objects`, with the same hand. What lies in two ways alike has two right names: a lying pillar is a box
too, and so is a box a pillar where two of its lengths are within a fifth. A ball lies as it stands and is left out.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from benchmarks._evaluation_hand import WHAT_DIFFERS, evaluation_setting
from benchmarks._figures import figure, share
from benchmarks.perceive_objects import Outcome, print_kinds, run
from varishold.hand import OBJECTS
from varishold.hand.objects import right_names
from varishold.perceive import NONE_OF_THESE
from varishold.trust import share_interval

KINDS = tuple(name for name in OBJECTS if name != "sphere")
#: What is in no library and has a side to lie on; lumps of numbers that no library was made with.
STRANGERS = ("half-cylinder", "l-block", "lump-910001", "lump-910002")


def _is_right(done: Outcome) -> bool:
    return done.object in right_names(done.true, done.size_m, seed=done.seed, pose="lying")


def main(argv: Sequence[str] = ()) -> None:
    """Print the figures."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--episodes", type=int, default=10)
    parser.add_argument("--strangers", type=int, default=10)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--library", type=Path, help="what is known; default: the shipped library")
    parser.add_argument("--processes", type=int, default=None)
    options = parser.parse_args(list(argv))
    print(f"  {WHAT_DIFFERS}")
    setting = replace(evaluation_setting(turn_deg=180.0), pose="lying")
    # Seeds of its own: no episode of `perceive_objects` is laid down here.
    seed, more = 50 + options.seed, {"setting": setting, "library": options.library}
    known = run(KINDS, options.episodes, seed, options.processes, **more)
    n, right = len(known), [_is_right(done) for done in known]
    low, high = share_interval(sum(right), n)
    refused = np.mean([done.object == NONE_OF_THESE for done in known])
    lost = [done for done in known if done.object == ""]
    sure = np.mean([done.sure and not good for done, good in zip(known, right, strict=True)])
    print(
        f"  nine kinds x three sizes, lying, {n} episodes: right name "
        f"{share('right name', np.mean(right), bar='>= 90')} ({100 * low:.1f}-{100 * high:.1f}), "
        f"{figure('touches', np.mean([d.touches for d in known]), '.2f', 'touches')} on the mean; "
        f"refused {share('refused', refused)}; never gripped {figure('never gripped', len(lost))}; "
        f"{sum(d.drops for d in known)} drops and misses; "
        f"another name with more than .95 {share('wrong and sure', sure, bar='<= 1')}"
    )
    posed = [done.pose == "lying" for done in known if done.pose is not None]
    if posed:
        print(f"  said to lie, of those that were named: {share('pose right', np.mean(posed))}")
    print_kinds(known, right)
    strangers = run(STRANGERS, options.strangers, seed, options.processes, **more)
    for name in STRANGERS:
        own_refused = [done.object == NONE_OF_THESE for done in strangers if done.true == name]
        print(f"    {name:17s} refused {share(f'{name}: refused', np.mean(own_refused), '5.1f')}")
    gone = [done.object == NONE_OF_THESE for done in strangers]
    low, high = share_interval(sum(gone), len(gone))
    print(
        f"  strangers refused {share('strangers refused', np.mean(gone))} of {len(gone)} "
        f"({100 * low:.1f}-{100 * high:.1f}), named with more than .95 "
        f"{share('strangers named for sure', np.mean([done.sure for done in strangers]))}"
    )


if __name__ == "__main__":
    main(sys.argv[1:])
