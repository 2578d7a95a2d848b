"""Pads of few taxels, from 5 x 5: how many names are given with p > .9 and wrong.

Faces are drawn by the yardstick to fit the pad, as height maps with noise of 2 %, clean or with gains that spread
by 10 %. Few taxels cannot tell most forms apart; what is wanted is that nothing wrong is said for sure.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence

import numpy as np

from benchmarks._figures import figure, share
from benchmarks.touch_depth_maps import draw, on_grid, taxels
from benchmarks.touch_distortions import SURE, Tally, answer_of
from varishold.evaluation.yardstick import faults
from varishold.evaluation.yardstick.forms import KINDS

SEED = 55
PER_KIND = 30
NOISE = 0.02
PADS = ((5, 5), (6, 6), (8, 8), (13, 6), (12, 12))
SPREADS = (0.0, 0.10)
BAR = 0.01
_CELLS = 6
_ONE_KIND = {"hip": "ridge"}


def tallies(pad: tuple[int, int], per_kind: int, seed: int) -> dict[float, Tally]:
    """Return the answers given on one pad, by the spread of gains."""
    result = {spread: Tally() for spread in SPREADS}
    rng = np.random.default_rng([seed, *pad])
    for k, kind in enumerate(KINDS):
        for index in range(per_kind):
            clean = taxels(on_grid(draw((seed, *pad, k, index), kind, index, pad), pad, _CELLS))
            for spread, tally in result.items():
                read = faults.gains(clean[None] / clean.max(), rng, spread)
                tally.add((_ONE_KIND.get(kind, kind),), answer_of(faults.noise(read, rng, NOISE)[0]))
    return result


def main(argv: Sequence[str] = ()) -> None:
    """Print the shares."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--seed", type=int, default=SEED)
    asked = parser.parse_args(list(argv))
    for pad in PADS:
        for spread, tally in tallies(pad, PER_KIND, asked.seed).items():
            f = tally.figures()
            of = f"{pad[0]:2} x {pad[1]:2}, gain spread {100 * spread:2.0f} %"
            said = [
                f"{what} {share(f'{of}: {what}', f[key], '5.1f', bar=bar)}"
                for key, what, bar in (
                    ("wrong_sure", f"wrong with p > {SURE:g}", f"<= {100 * BAR:.0f}"),
                    ("right", "right", ""),
                    ("unknown", "unknown", ""),
                    ("outline", "outline", ""),
                    ("set_holds", "set holds", ""),
                )
            ]
            size = figure(f"{of}: set size", f["set_size"], ".2f", "names")
            worst = "; ".join(f"{pair} {n}" for pair, n in list(f["confused"].items())[:2])
            print(f"  {of}: {'  '.join(said)}, set of {size}  {worst}", flush=True)


if __name__ == "__main__":
    main(sys.argv[1:])
