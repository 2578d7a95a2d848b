"""Known objects and strangers under poor taxels: by the shipped library, and by one that knows these taxels.

Run: ``python -m benchmarks.perceive_poor_pads [--episodes 8] [--strangers 6] [--seed 5]``. Closed loops as in
`perceive_objects`, with another hand, grid and contact solver than the library's. What the library is felt again by are
touches of the library's own hand, and the taxels of no pad are the same.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
import time
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from benchmarks._evaluation_hand import WHAT_DIFFERS, evaluation_setting
from benchmarks._figures import figure, share
from benchmarks.perceive_objects import Outcome, run
from varishold.hand import OBJECTS, HandSetting
from varishold.hand.objects import STRANGERS
from varishold.perceive import NONE_OF_THESE, for_pads, shipped_library, write_library
from varishold.skin import Taxels
from varishold.trust import share_interval

POOR = Taxels(noise=0.03, crosstalk=0.08, gain_spread=0.15, dead=0.03)
#: Lumps of numbers that no library, training or development has used.
_LUMPS = tuple(f"lump-{number}" for number in range(400_001, 400_005))


def _setting() -> HandSetting:
    usual = evaluation_setting()
    assert usual.pads is not None
    return replace(usual, pads=replace(usual.pads, taxels=POOR))


def _say(of: str, known: Sequence[Outcome], strange: Sequence[Outcome], *, bars: bool) -> None:
    n = len(known)
    right = sum(done.object == done.true for done in known)
    refused = sum(done.object == NONE_OF_THESE for done in known)
    gone = sum(done.object == NONE_OF_THESE for done in strange)
    low, high = share_interval(right, n)
    least, most = share_interval(gone, len(strange))
    print(
        f"  {of}: {n} episodes, right name "
        f"{share(f'{of}: right name', right / n, bar='>= 92' if bars else None)} ({100 * low:.1f}-{100 * high:.1f}), "
        f"refused {share(f'{of}: refused', refused / n, bar='<= 5' if bars else None)}, "
        f"another name {share(f'{of}: another name', (n - right - refused) / n)}, "
        f"{figure(f'{of}: touches', sum(done.touches for done in known) / n, '.2f', 'touches')} on the mean; "
        f"strangers refused {share(f'{of}: strangers refused', gone / len(strange))} of {len(strange)} "
        f"({100 * least:.1f}-{100 * most:.1f})"
    )


def main(argv: Sequence[str] = ()) -> None:
    """Print the figures."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--episodes", type=int, default=8)
    parser.add_argument("--strangers", type=int, default=6)
    parser.add_argument("--seed", type=int, default=5)
    parser.add_argument("--processes", type=int, default=None)
    options = parser.parse_args(list(argv))
    print(f"  {WHAT_DIFFERS}; noise 3 %, crosstalk .08, gains spread by 15 %, 3 % of the taxels dead and unmarked")
    strangers, setting = (*STRANGERS, *_LUMPS), _setting()
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "poor.npz")
        begun = time.process_time()
        write_library(for_pads(shipped_library(), POOR), path)
        took = figure("a library for taxels", time.process_time() - begun, ".0f", "s of CPU time")
        print(f"  the library was felt again in {took}")
        for of, library in (("the shipped library", None), ("a library for these taxels", path)):
            known = run(
                tuple(OBJECTS), options.episodes, options.seed, options.processes, setting=setting, library=library
            )
            strange = run(
                strangers, options.strangers, options.seed, options.processes, setting=setting, library=library
            )
            _say(of, known, strange, bars=library is not None)


if __name__ == "__main__":
    main(sys.argv[1:])
