"""Surfaces that are none of the known ones: how many are called unknown, of kinds that training never draws.

Beside them, labelled as such, the figure of `touch_ideal`, whose kinds of strangers training draws too. Half of the
frames are height maps, half pressed into a thin cover (the yardstick); breadth 14 to 24 taxels on a pad of
32 x 32 with noise of 1 %, 9 to 13 on one of 16 x 16 with 2 %. Answers are those of the largest contact.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence

from benchmarks._figures import share
from benchmarks._strange_frames import FRAMES_PER_KIND, SEED, means, measured
from benchmarks.touch_distortions import PER_KIND, SIDES, measure
from benchmarks.touch_ideal import strangers as drawn_in_training
from varishold.evaluation.yardstick.rows import NOISE, ROWS

#: Least called unknown, most named with p > .9, most known kinds called unknown.
BARS = {32: (0.90, 0.025, 0.03), 16: (0.82, 0.025, 0.03)}


def main(argv: Sequence[str] = ()) -> None:
    """Print the shares."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--seed", type=int, default=SEED, help="default: the last word's; 1: for development")
    parser.add_argument("--frames", type=int, default=FRAMES_PER_KIND, help="of each kind")
    asked = parser.parse_args(list(argv))
    for side in SIDES:
        unknown_bar, sure_bar, known_bar = BARS[side]
        shares = measured(side, asked.frames, asked.seed)
        unknown, sure = means(shares)
        of = f"{side} x {side}"
        print(f"\n{of}, noise {NOISE[side]:.0%}: {len(shares)} kinds never drawn, {asked.frames} frames each")
        for kind, (u, s, names) in shares.items():
            most = ", ".join(f"{name} {n}" for name, n in sorted(names.items(), key=lambda item: -item[1])[:3])
            called = share(f"{of}, {kind}: unknown", u, "5.1f")
            print(f"  {kind:20} unknown {called}   named with p > .9 {100 * s:5.1f} %   {most}")
        unknown = share(f"{of}, MEAN: unknown", unknown, "5.1f", bar=f">= {100 * unknown_bar:.0f}")
        sure = share(f"{of}, MEAN: named with p > .9", sure, "5.1f", bar=f"<= {100 * sure_bar:.1f}")
        print(f"  MEAN                 unknown {unknown}   named with p > .9 {sure}")
        known = measure(ROWS[0], ("ideal", "cover"), side, PER_KIND // 2, asked.seed).figures()["unknown"]
        known = share(f"{of}: known kinds called unknown", known, bar=f"<= {100 * known_bar:.0f}")
        print(f"  known kinds called unknown, clean frames: {known}")
        size, noise = ((8.0, 24.0), 0.01) if side == 32 else ((4.0, 12.0), 0.02)
        drawn = drawn_in_training(side, size, noise)
        print("  in-distribution (kinds that training draws), called unknown: ", end="")
        print(", ".join(f"{kind} {share(f'{of}, in-distribution: {kind}', said)}" for kind, said in drawn.items()))


if __name__ == "__main__":
    main(sys.argv[1:])
