"""Thirty-six household objects by a gripper's two tactile fingertips (Weiss DSA), ten grasps an object for training.

Tactile values only, the frame of largest total pressure of each grasp; mean of ten draws. The recordings are not
part of the project: their folder is named by VARISHOLD_DATA, or stands beside the checkout as ../shared/data.

Run: python -m benchmarks.grasp_weiss [DRAWS]
"""

from __future__ import annotations

import os
import sys
import time
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from sklearn.ensemble import ExtraTreesClassifier, RandomForestClassifier
from sklearn.neighbors import KNeighborsClassifier
from sklearn.svm import SVC

from varishold.grasp import HyperplaneClassifier, ThresholdEncoder, shift_variants

_SHAPE = (2, 13, 6)


def load() -> tuple[NDArray[np.float64], NDArray[np.str_]] | None:
    """Peak frames (grasps, 156) in sensor units and labels, or None where the recordings are missing."""
    folder = Path(os.environ.get("VARISHOLD_DATA", Path(__file__).resolve().parents[2] / "shared" / "data"))
    file = folder / "weiss_dsa36.npz"
    if not file.is_file():
        return None
    with np.load(file) as data:
        at = data["start"][:-1] + data["peak"]
        return data["frames"][at].reshape(len(at), -1).astype(np.float64), data["label"]


def main() -> None:
    """Print mean accuracies."""
    loaded = load()
    if loaded is None:
        print("weiss_dsa36.npz is missing; set VARISHOLD_DATA to its folder")
        return
    raw, labels = loaded
    draws = int(sys.argv[1]) if len(sys.argv) > 1 and sys.argv[1].isdigit() else 10
    print(f"Weiss DSA, 36 objects, 10 training grasps each, mean of {draws} draws")
    results: dict[str, list[float]] = {}
    began = time.process_time()
    for seed in range(draws):
        train = _draw(labels, seed)
        _measure(raw, labels, train, results)
    for name, values in results.items():
        print(f"  {name:58s} {np.mean(values):.3f} (sd {np.std(values):.3f})")
    print("First ten grasps of each object as training, the rest as test")
    first: dict[str, list[float]] = {}
    train = np.concatenate([np.flatnonzero(labels == name)[:10] for name in np.unique(labels)])
    _measure(raw, labels, train, first)
    for name, values in first.items():
        print(f"  {name:58s} {values[0]:.3f}")
    print(f"CPU seconds: {time.process_time() - began:.0f}")


def _draw(labels: NDArray[np.str_], seed: int) -> NDArray[np.int64]:
    rng = np.random.default_rng(seed)
    names = np.unique(labels)
    return np.concatenate([rng.choice(np.flatnonzero(labels == name), 10, replace=False) for name in names])


def _measure(
    raw: NDArray[np.float64],
    labels: NDArray[np.str_],
    train: NDArray[np.int64],
    results: dict[str, list[float]],
) -> None:
    test = np.setdiff1d(np.arange(len(labels)), train)
    on = raw > 0

    def note(name: str, value: float) -> None:
        results.setdefault(name, []).append(value)

    peers = {
        "1-NN": KNeighborsClassifier(1),
        "RBF SVM": SVC(),
        "RBF SVM, C 10": SVC(C=10),
        "random forest": RandomForestClassifier(200, random_state=0),
        "extra trees": ExtraTreesClassifier(200, random_state=0),
    }
    for name, peer in peers.items():
        note(f"on/off texels, {name}", peer.fit(on[train], labels[train]).score(on[test], labels[test]))
    plain = HyperplaneClassifier().fit(on[train], labels[train])
    note("on/off texels, HyperplaneClassifier", plain.score(on[test], labels[test]))
    tolerant = HyperplaneClassifier(variants=shift_variants(_SHAPE)).fit(on[train], labels[train])
    note("on/off texels, HyperplaneClassifier, one-texel shifts", tolerant.score(on[test], labels[test]))

    encoder = ThresholdEncoder("quantile", levels=6, shared=True).fit(raw[train])
    bits, held = encoder.transform(raw[train]), encoder.transform(raw[test])
    for name in ("1-NN", "RBF SVM, C 10", "extra trees"):
        note(f"raw texels, 6 thresholds, {name}", peers[name].fit(bits, labels[train]).score(held, labels[test]))
    plain.fit(bits, labels[train])
    note("raw texels, 6 thresholds, HyperplaneClassifier", plain.score(held, labels[test]))
    tolerant = HyperplaneClassifier(variants=shift_variants(_SHAPE, bits=encoder.bits_per_channel_))
    tolerant.fit(bits, labels[train])
    note("raw texels, 6 thresholds, HyperplaneClassifier, shifts", tolerant.score(held, labels[test]))


if __name__ == "__main__":
    main()
