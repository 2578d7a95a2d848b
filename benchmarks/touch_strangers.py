"""Surfaces that are none of the known ones: how many are called unknown, of kinds that training never draws.

Beside them, labelled as such, the figure of `touch_ideal`, whose kinds of strangers training draws too. Half of the
frames are height maps, half pressed into a thin cover (`_distort_media`); breadth 14 to 24 taxels on a pad of
32 x 32 with noise of 1 %, 9 to 13 on one of 16 x 16 with 2 %. Answers are those of the largest contact.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Sequence
from typing import Any

from benchmarks._strange_frames import FRAMES_PER_KIND, SEED, means, measured
from benchmarks.touch_distortions import NOISE, PER_KIND, ROWS, SIDES, measure
from benchmarks.touch_ideal import strangers as drawn_in_training

#: Least called unknown, most named with p > .9, most known kinds called unknown.
BARS = {32: (0.90, 0.025, 0.03), 16: (0.82, 0.025, 0.03)}


def main(argv: Sequence[str] = ()) -> None:
    """Print the shares."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--seed", type=int, default=SEED, help="default: the last word's; 1: for development")
    parser.add_argument("--frames", type=int, default=FRAMES_PER_KIND, help="of each kind")
    parser.add_argument("--json", action="store_true", help="print one JSON object after the tables")
    asked = parser.parse_args(list(argv))
    result: dict[str, Any] = {"seed": asked.seed}
    for side in SIDES:
        unknown_bar, sure_bar, known_bar = BARS[side]
        shares = measured(side, asked.frames, asked.seed)
        unknown, sure = means(shares)
        print(
            f"\n{side} x {side}, noise {NOISE[side]:.0%}: {len(shares)} kinds never drawn, {asked.frames} frames each"
        )
        for kind, (u, s, names) in shares.items():
            most = ", ".join(f"{name} {n}" for name, n in sorted(names.items(), key=lambda item: -item[1])[:3])
            print(f"  {kind:20} unknown {100 * u:5.1f}   named with p > .9 {100 * s:5.1f}   {most}")
        print(f"  MEAN                 unknown {100 * unknown:5.1f} (bar {100 * unknown_bar:.0f})", end="")
        print(f"   named with p > .9 {100 * sure:5.1f} (bar {100 * sure_bar:.1f})")
        known = measure(ROWS[0], ("ideal", "cover"), side, PER_KIND // 2, asked.seed).figures()["unknown"]
        print(f"  known kinds called unknown, clean frames: {100 * known:.1f} (bar {100 * known_bar:.0f})")
        size, noise = ((8.0, 24.0), 0.01) if side == 32 else ((4.0, 12.0), 0.02)
        drawn = drawn_in_training(side, size, noise)
        print("  in-distribution (kinds that training draws), called unknown: ", end="")
        print(", ".join(f"{kind} {100 * share:.1f}" for kind, share in drawn.items()))
        result[str(side)] = {
            "unknown": unknown,
            "named_sure": sure,
            "known_called_unknown": known,
            "in_distribution": drawn,
            "kinds": {kind: {"unknown": u, "named_sure": s} for kind, (u, s, _) in shares.items()},
        }
    if asked.json:
        print(json.dumps(result))


if __name__ == "__main__":
    main(sys.argv[1:])
