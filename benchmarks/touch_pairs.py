"""Names of two things that press one pad: each beside another, and alone on as large a pad.

Faces are drawn by the yardstick, 11 kinds, edges and planes apart, on height maps and in a thin cover. Each has a half
of the pad to itself; the lower one's peak is half of the higher one's or more. The name counts of the largest contact
whose peak lies in a face's half. What stands beside a contact must make no stranger of it.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator, Sequence

import numpy as np

from benchmarks._figures import figure
from benchmarks._scores import Scores
from benchmarks.touch_distortions import SIDES
from varishold.evaluation.yardstick.forms import ENDLESS, Change
from varishold.evaluation.yardstick.media import clean_frames
from varishold.evaluation.yardstick.rows import NOISE
from varishold.touch import find_contacts, recognize

SEED = 1971
FRAMES_PER_KIND = 30
#: Least peak of the lower of two, in parts of the higher one's.
LOWEST = 0.5


def pairs(side: int, per_kind: int, seed: int) -> Iterator[tuple[np.ndarray, tuple[str, str]]]:
    """Yield (side, 2 side) frames without noise, of a face in each half, and their kinds; each face comes twice."""
    rng = np.random.default_rng([seed, side])
    for medium in ("ideal", "cover"):
        frames, kinds = clean_frames(medium, side, Change(), per_kind, seed)
        ends = [k for k, kind in enumerate(kinds.tolist()) if kind not in ENDLESS]
        for left, right in zip(rng.permutation(ends), rng.permutation(ends), strict=True):
            yield (
                np.hstack([frames[left], rng.uniform(LOWEST, 1.0) * frames[right]]),
                (str(kinds[left]), str(kinds[right])),
            )


def add_named(scores: Scores, frame: np.ndarray, half: int, kind: str) -> None:
    """Add the name of the largest contact whose peak lies in a half of the pad, 0 on the left."""
    middle = frame.shape[1] // 2
    own = [contact for contact in find_contacts(frame) if (contact.peak_taxel[1] >= middle) == bool(half)]
    surface = recognize(own[0]) if own else None
    scores.add(kind, surface.name if surface else "none", surface.probability if surface else 1.0)


def main(argv: Sequence[str] = ()) -> None:
    """Print the figures."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--seed", type=int, default=SEED)
    parser.add_argument("--frames", type=int, default=FRAMES_PER_KIND, help="of each kind, on each of two media")
    asked = parser.parse_args(list(argv))
    for side in SIDES:
        rng = np.random.default_rng([asked.seed, side, 1])
        beside, alone = Scores(), Scores()
        for frame, kinds in pairs(side, asked.frames, asked.seed):
            for half, kind in enumerate(kinds):
                noise = rng.normal(0.0, NOISE[side], frame.shape)
                add_named(beside, frame + noise, half, kind)
                only = frame.copy()
                only[:, (1 - half) * side : (2 - half) * side] = 0.0
                add_named(alone, only + noise, half, kind)
        of = f"{side} x {2 * side}"
        for scores, how in ((beside, "beside another"), (alone, "alone")):
            print(f"{of} taxels, {how}:")
            scores.report(f"{of}, {how}")
        lost = 100 * (alone.right.mean() - beside.right.mean())
        said = figure(f"{of}: right names lost beside another", lost, ".1f", "points", bar="<= 2")
        print(f"  right names that are lost by what stands beside: {said}")


if __name__ == "__main__":
    main(sys.argv[1:])
