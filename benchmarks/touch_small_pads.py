"""Pads of few taxels, from 5 x 5: how many names are given with p > .9 and wrong, to known forms and to strange ones.

Faces are drawn by the yardstick to fit the pad, as height maps with noise of 2 %, clean or with gains that spread
by 10 %. Few taxels cannot tell most forms apart; what is wanted is that nothing wrong is said for sure. The strange
forms are those of `touch_strangers`, .55 to .95 of the pad's shorter side broad; they are as many on every pad and
spread. Last, of all names with p > .9, how many are wrong where one contact in five is a strange form.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence

import numpy as np

from benchmarks._figures import figure, share
from benchmarks._strange_frames import strange_face
from benchmarks._strange_shapes import SHAPES
from benchmarks.touch_depth_maps import draw, on_grid, taxels
from benchmarks.touch_distortions import SURE, Tally, answer_of
from varishold.evaluation.yardstick import faults
from varishold.evaluation.yardstick.forms import KINDS

SEED = 55
PER_KIND = 30
PER_STRANGE_KIND = 10
STRANGE_SHARE = 0.2
BREADTHS = (0.55, 0.95)
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
            _read(result, clean, rng, _ONE_KIND.get(kind, kind))
    return result


def strange_tallies(pad: tuple[int, int], per_kind: int, seed: int) -> dict[float, Tally]:
    """Return the answers given to strange forms on one pad, by the spread of gains."""
    result = {spread: Tally() for spread in SPREADS}
    for k, shape in enumerate(SHAPES.values()):
        rng = np.random.default_rng([seed, *pad, len(KINDS) + k])
        for _ in range(per_kind):
            breadth = float(rng.uniform(*BREADTHS)) * min(pad)
            clean = taxels(on_grid(strange_face(rng, shape, breadth, pad), pad, _CELLS))
            _read(result, clean, rng, "unknown")
    return result


def _read(tallies_of: dict[float, Tally], clean: np.ndarray, rng: np.random.Generator, truth: str) -> None:
    """Add the answers to a clean frame as pads of each spread of gains read it."""
    for spread, tally in tallies_of.items():
        read = faults.gains(clean[None] / clean.max(), rng, spread)
        tally.add((truth,), answer_of(faults.noise(read, rng, NOISE)[0]))


def sure(tally: Tally) -> tuple[float, float]:
    """Return the shares of answers that are names with p > .9, right and wrong."""
    named = (np.array(tally.probability) > SURE) & ~np.array(tally.unknown)
    right = np.array(tally.right)
    return float(np.mean(named & right)), float(np.mean(named & ~right))


def main(argv: Sequence[str] = ()) -> None:
    """Print the shares."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--seed", type=int, default=SEED)
    asked = parser.parse_args(list(argv))
    totals = np.zeros(3)
    for pad in PADS:
        strange = strange_tallies(pad, PER_STRANGE_KIND, asked.seed)
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
            right, wrong = sure(tally)
            _, named = sure(strange[spread])
            totals += (right, wrong, named)
            unknown = strange[spread].figures()["unknown"]
            print(
                f"    right with p > {SURE:g} {share(f'{of}: right and sure', right, '5.1f')}; strange forms:"
                f" named with p > {SURE:g} {share(f'{of}: strange, named and sure', named, '5.1f')}"
                f"  unknown {share(f'{of}: strange, unknown', unknown, '5.1f')}"
            )
    right, wrong, named = totals / (len(PADS) * len(SPREADS))
    false = (1 - STRANGE_SHARE) * wrong + STRANGE_SHARE * named
    of_sure = false / max((1 - STRANGE_SHARE) * right + false, 1e-12)
    print(
        f"  all: right with p > {SURE:g} {share('all: right and sure', right, '5.1f')}"
        f"  wrong {share('all: wrong and sure', wrong, '5.2f')}"
        f"  strange forms named with p > {SURE:g} {share('all: strange, named and sure', named, '5.2f')}"
        f"; one contact in five strange: wrong of all sure ones {share('all: wrong of sure', of_sure, '5.1f')}"
    )


if __name__ == "__main__":
    main(sys.argv[1:])
