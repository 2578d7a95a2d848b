"""The classifier beside scikit-learn's, on generated grasps of 22 switches and on binarized digits.

Two classes and six classes, ten grasps each, 30 seeds, 300 grasps of each class for testing; scikit-learn's
8 x 8 digits cut at half scale, ten a class and in full. Gates are two-input gates and inverters counted by
`varishold.circuit.gate_count`.

Run: python -m benchmarks.grasp_peers [--seeds N]
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray
from sklearn.datasets import load_digits
from sklearn.ensemble import ExtraTreesClassifier, RandomForestClassifier
from sklearn.linear_model import LogisticRegression
from sklearn.neighbors import KNeighborsClassifier
from sklearn.svm import SVC
from sklearn.tree import DecisionTreeClassifier

from benchmarks._figures import figure, share
from benchmarks.planar_grasps import SHAPES, planar_grasps
from varishold.circuit import gate_count
from varishold.grasp import HyperplaneClassifier

_TEST_GRASPS = 300

PEERS: Mapping[str, Callable[[], Any]] = {
    "1-NN": lambda: KNeighborsClassifier(1),
    "RBF SVM": lambda: SVC(),
    "random forest": lambda: RandomForestClassifier(100, random_state=0),
    "extra trees": lambda: ExtraTreesClassifier(100, random_state=0),
    "logistic regression": lambda: LogisticRegression(max_iter=1000),
    "decision tree": lambda: DecisionTreeClassifier(random_state=0),
}

OURS: Mapping[str, Callable[[], HyperplaneClassifier]] = {
    "paper": lambda: HyperplaneClassifier("paper"),
    "robust": lambda: HyperplaneClassifier("robust"),
    "vote": lambda: HyperplaneClassifier("vote"),
    "auto": lambda: HyperplaneClassifier("auto"),
}


def main(argv: Sequence[str] = ()) -> None:
    """Print mean accuracies, sizes of the circuits and ratios to the best peer."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--seeds", type=int, default=30, help="how many")
    seeds = parser.parse_args(list(argv)).seeds
    began = time.process_time()
    _generated("two classes", SHAPES[:2], seeds, ("paper", "robust", "vote", "auto"))
    _generated("six classes", SHAPES, seeds, ("vote", "auto"))
    _digits(max(1, seeds // 3))
    print(f"CPU seconds: {time.process_time() - began:.0f}")


def _generated(title: str, shapes: tuple[str, ...], seeds: int, modes: tuple[str, ...]) -> None:
    accuracy: dict[str, list[float]] = {}
    sizes: dict[str, list[tuple[int, int]]] = {}
    for seed in range(seeds):
        rng = np.random.default_rng(seed)
        train, labels = planar_grasps(shapes, 10, rng)
        test, truth = planar_grasps(shapes, _TEST_GRASPS, rng)
        for name, make in PEERS.items():
            accuracy.setdefault(name, []).append(make().fit(train, labels).score(test, truth))
        for name in modes:
            clf = OURS[name]().fit(train, labels)
            accuracy.setdefault(name, []).append(clf.score(test, truth))
            if name in ("paper", "robust"):
                sizes.setdefault(name, []).append((len(clf.hyperplanes_), gate_count(clf.netlist_)))
    print(f"Generated grasps of 22 switches, {title}, 10 grasps each, {seeds} seeds")
    _report(title, accuracy, sizes, reference=None)


def _digits(seeds: int) -> None:
    data = load_digits()
    X, y = data.data >= 8, data.target
    small: dict[str, list[float]] = {}
    full: dict[str, list[float]] = {}
    for seed in range(seeds):
        rng = np.random.default_rng(seed)
        few = np.concatenate([rng.choice(np.flatnonzero(y == d), 10, replace=False) for d in range(10)])
        _digit_run(X, y, few, small)
        if seed < max(1, seeds // 3):
            _digit_run(X, y, rng.permutation(len(y))[:1200], full)
    print(f"Digits 8 x 8, binarized, 10 a class, {seeds} draws")
    _report("digits, 10 a class", small, {}, reference="RBF SVM")
    print(f"Digits 8 x 8, binarized, 1200 for training, 597 for testing, {len(full['auto'])} draws")
    _report("digits, 1200 for training", full, {}, reference=None)


def _digit_run(
    X: NDArray[np.bool_], y: NDArray[np.int64], train: NDArray[np.int64], results: dict[str, list[float]]
) -> None:
    test = np.setdiff1d(np.arange(len(y)), train)
    for name, make in PEERS.items():
        results.setdefault(name, []).append(make().fit(X[train], y[train]).score(X[test], y[test]))
    results.setdefault("auto", []).append(OURS["auto"]().fit(X[train], y[train]).score(X[test], y[test]))


def _report(
    of: str, accuracy: dict[str, list[float]], sizes: dict[str, list[tuple[int, int]]], reference: str | None
) -> None:
    best = reference or max(PEERS, key=lambda name: float(np.mean(accuracy[name])))
    top = float(np.mean(accuracy[best]))
    for name, values in accuracy.items():
        line = f"  {name:20s} {share(f'{of}: {name}', np.mean(values), '.2f')}"
        if name not in PEERS:
            line += f"  {figure(f'{of}: {name}, of {best}', np.mean(values) / top, '.4f')} of {best}"
        if name in sizes:
            planes, gates = np.array(sizes[name]).T
            line += f"; hyperplanes {planes.mean():.1f} (most {planes.max()})"
            line += f", gates {figure(f'{of}: {name}, gates', gates.mean(), '.0f')} (most {gates.max()})"
        print(line)


if __name__ == "__main__":
    main(sys.argv[1:])
