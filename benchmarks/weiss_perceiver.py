"""A perceiver that is fed real grasps of 36 objects (Weiss): how many numbers it takes, and what its example prints.

The number of principal components was chosen within the first ten grasps of each object, five known and five felt.
"""

from __future__ import annotations

import importlib.util
import sys
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks._figures import figure, share
from benchmarks._real_data import find_recording
from varishold.perceive import Belief, Evidence, Library

EXAMPLE = Path(__file__).resolve().parents[1] / "examples" / "weiss_perceiver.py"
KNOWN = 5
TRIED = (10, 15, 20, 30, 60, 100)
# A name that a belief rules out costs so many nats and no more.
_MOST_NATS = 20.0


def load_example() -> Any:
    """Return the example as a module."""
    spec = importlib.util.spec_from_file_location("weiss_perceiver_example", EXAMPLE)
    if spec is None or spec.loader is None:
        raise ImportError(f"{EXAMPLE} cannot be loaded")
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module
    spec.loader.exec_module(module)
    return module


def choose_numbers(example: Any, grasps: Any) -> None:
    """Print what one touch names, by how many numbers are kept: five of the first ten grasps known, five felt."""
    names = [str(name) for name in np.unique(grasps.label)]
    inside = grasps.place < example.EXAMPLES
    for how_many in (*TRIED, None):
        right, nats, odd = [], [], []
        for half in range(2):
            known = inside & (grasps.place // KNOWN == half)
            felt = np.flatnonzero(inside & ~known)
            measured = example.measure(grasps, known)
            if how_many is None:
                spread = measured[known].std(axis=0)
                rows = measured[:, spread > 0]
                evidence = [Evidence("grasp", {f"grasp.{k}": value for k, value in enumerate(row)}) for row in rows]
            else:
                example.NUMBERS = how_many
                evidence = example.as_evidence(measured, known)
            examples = {name: [[evidence[k]] for k in np.flatnonzero(known & (grasps.label == name))] for name in names}
            before = Belief.before(Library.from_examples(examples))
            for k in felt:
                belief = before.after(evidence[k])
                right.append(belief.best == grasps.label[k])
                nats.append(min(-np.log(max(belief.probability[str(grasps.label[k])], 1e-300)), _MOST_NATS))
                odd.append(belief.atypical)
        of = f"{'all' if how_many is None else how_many} numbers"
        print(
            f"  {of}: right {share(f'{of}: right', np.mean(right))}, "
            f"{figure(f'{of}: loss', np.mean(nats), '.2f', 'nats')}, "
            f"odd {np.mean(odd):.3f} (expected {1 / (KNOWN + 1):.3f})"
        )


def main() -> None:
    """Print the figures."""
    print("Weiss DSA, 36 objects, a perceiver fed grasp after grasp")
    path = find_recording("weiss_dsa36.npz")
    if path is None:
        return
    example = load_example()
    chosen = example.NUMBERS
    print(f"within the first ten grasps of each object, {KNOWN} known and {KNOWN} felt, and the reverse; one touch:")
    choose_numbers(example, example.read_grasps(path))
    example.NUMBERS = chosen
    example.main(path.parent)


if __name__ == "__main__":
    main()
