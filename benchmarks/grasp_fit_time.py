"""How long fits take: the paper's size in `paper` mode, ten thousand grasps in `auto` mode, many objects or switches.

Many objects or switches: ten grasps an object, a tenth of the switches flipped; nearest neighbour beside them, how
large the circuit is, and what the fit remarks where its mode cannot do well.

CPU seconds of one process (time.process_time); the first fit of a process, which imports what it needs, is left
out and printed apart. Set OMP_NUM_THREADS=2 for two cores.

Run: python -m benchmarks.grasp_fit_time [--part paper | large | many]
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from sklearn.neighbors import KNeighborsClassifier

from benchmarks._figures import figure, share
from benchmarks.planar_grasps import SHAPES, planar_grasps
from varishold.circuit import circuit_size
from varishold.grasp import HyperplaneClassifier

_SEEDS = 30
# Mode, objects, switches.
_MANY = (("auto", 100, 64), ("auto", 2, 10_000), ("robust", 50, 64), ("paper", 20, 300))


def main(argv: Sequence[str] = ()) -> None:
    """Print times."""
    parts = {"paper": _paper, "large": _large, "many": _many}
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--part", choices=parts, action="append", help="only this one")
    for name in parser.parse_args(list(argv)).part or parts:
        parts[name]()


def _paper() -> None:
    times, gaps = [], []
    for seed in range(_SEEDS):
        X, y = planar_grasps(SHAPES[:2], 10, np.random.default_rng(seed))
        for _ in range(3):
            began = time.process_time()
            clf = HyperplaneClassifier("paper").fit(X, y)
            times.append(time.process_time() - began)
        gaps.append(clf.selection_.gap if clf.selection_ else 0)
    later = np.array(times[1:]) * 1e3
    of = "mode paper, 20 grasps x 22 switches"
    print(f"{of}, {_SEEDS} seeds, three fits each:")
    print(
        f"  median {figure(of, np.median(later), '.1f', 'ms')}, "
        f"most {figure(f'{of}: most', later.max(), '.1f', 'ms')}, first of all {times[0] * 1e3:.1f} ms"
    )
    print(f"  sets not proved smallest: {figure(f'{of}: sets not proved smallest', sum(gap > 0 for gap in gaps))}")


def _large(n: int = 10_000, switches: int = 784, classes: int = 10) -> None:
    X, y = _blots(n, switches, classes, seed=0)
    held, truth = _blots(2000, switches, classes, seed=1)
    began, cpu = time.perf_counter(), time.process_time()
    clf = HyperplaneClassifier().fit(X, y)
    wall, cpu = time.perf_counter() - began, time.process_time() - cpu
    of = f"mode auto, {n} grasps x {switches} switches, {classes} classes"
    print(f"{of} ({clf.mode_}):")
    print(
        f"  {wall:.1f} s by the clock, {figure(of, cpu, '.1f', 's of CPU')}, "
        f"{figure(f'{of}: hyperplanes', len(clf.hyperplanes_))} hyperplanes"
    )
    print(f"  held-out accuracy {share(f'{of}: held-out accuracy', clf.score(held, truth), '.2f')}")


def _many() -> None:
    for mode, classes, switches in _MANY:
        rng = np.random.default_rng(0)
        prototypes = rng.random((classes, switches)) < 0.5
        y, truth = np.repeat(np.arange(classes), 10), np.repeat(np.arange(classes), 20)
        X, held = (prototypes[labels] ^ (rng.random((len(labels), switches)) < 0.1) for labels in (y, truth))
        began, cpu = time.perf_counter(), time.process_time()
        clf = HyperplaneClassifier(mode).fit(X, y)
        wall, cpu = time.perf_counter() - began, time.process_time() - cpu
        nearest = KNeighborsClassifier(1).fit(X, y).score(held, truth)
        chosen = f" ({clf.mode_})" if mode == "auto" else ""
        of = f"mode {mode}, {classes} objects x {switches} switches"
        print(f"{of}{chosen}, {len(X)} grasps:")
        spent = figure(of, cpu, ".1f", "s of CPU", bar="<= 20")
        print(f"  {wall:.1f} s by the clock, {spent}; {circuit_size(clf.netlist_)}")
        accuracy = share(f"{of}: held-out accuracy", clf.score(held, truth), ".2f")
        print(f"  held-out accuracy {accuracy}, nearest neighbour {100 * nearest:.2f} %")
        for text in clf.remarks_:
            print(f"  note: {text}")


def _blots(n: int, switches: int, classes: int, *, seed: int) -> tuple[NDArray[np.bool_], NDArray[np.int64]]:
    """Draw noisy copies of five prototypes a class, a fifth of the switches flipped."""
    prototypes = np.random.default_rng(99).random((classes, 5, switches)) < 0.3
    rng = np.random.default_rng(seed)
    labels, variant = rng.integers(classes, size=n), rng.integers(5, size=n)
    return prototypes[labels, variant] ^ (rng.random((n, switches)) < 0.2), labels


if __name__ == "__main__":
    main(sys.argv[1:])
