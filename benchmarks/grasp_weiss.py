"""Thirty-six household objects by a gripper's two tactile fingertips (Weiss DSA), ten grasps an object for training.

Tactile values only, the frame of largest total pressure of each grasp; mean of ten draws. On/off texels, raw texels
at thresholds, and the numbers of the sections (`SurfaceFeatures`) at thresholds. Everything that is learned, thresholds
too, is learned from the training grasps of each draw. The number of thresholds a section number gets was chosen by
cross-validation within each object's first ten grasps, which `within_first_grasps` prints again. The recordings are not
part of the project: their folder is named by VARISHOLD_DATA, or stands beside the checkout as ../shared/data.

Run: python -m benchmarks.grasp_weiss [--draws N] [--of texels | sections]
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from sklearn.ensemble import ExtraTreesClassifier, RandomForestClassifier
from sklearn.neighbors import KNeighborsClassifier
from sklearn.svm import SVC

from benchmarks._figures import share
from benchmarks._real_data import find_recording
from benchmarks.weiss_touch import RELATIVE_LEVELS, TRAINING_GRASPS, drawn_grasps, first_grasps, peak_frames
from varishold.grasp import HyperplaneClassifier, ThresholdEncoder, shift_variants
from varishold.touch import SurfaceFeatures

_SHAPE = (2, 13, 6)
# Thresholds for each number of the sections: the encoder's default, and the best of those that
# `within_first_grasps` tries.
_SECTION_LEVELS = 4
_LEVELS_TRIED = (2, 4, 8)


def main(argv: Sequence[str] = ()) -> None:
    """Print mean accuracies."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--draws", type=int, default=10, help="how many random draws of the training grasps")
    parser.add_argument("--of", choices=("texels", "sections"), help="only what is measured of these")
    asked = parser.parse_args(list(argv))
    path = find_recording("weiss_dsa36.npz")
    if path is None:
        return
    frames, labels, mask = peak_frames(path)
    results: dict[str, list[float]] = {}
    first: dict[str, list[float]] = {}
    began = time.process_time()
    splits = [(drawn_grasps(labels, seed), results) for seed in range(asked.draws)] + [(first_grasps(labels), first)]
    for train, noted in splits:
        if asked.of != "sections":
            _measure_texels(frames.reshape(len(frames), -1), labels, train, noted)
        if asked.of != "texels":
            _measure_sections(frames, labels, mask, train, noted)
    print(f"Weiss DSA, 36 objects, {TRAINING_GRASPS} training grasps each, mean of {asked.draws} draws")
    for name, values in results.items():
        print(f"  {name:58s} {share(f'draws: {name}', np.mean(values))} (sd {100 * np.std(values):.1f})")
    print("First ten grasps of each object as training, the rest as test")
    for name, values in first.items():
        print(f"  {name:58s} {share(f'first ten: {name}', values[0])}")
    if asked.of != "texels":
        within_first_grasps(frames, labels, mask)
    print(f"CPU seconds: {time.process_time() - began:.0f}")


def within_first_grasps(frames: NDArray[np.float64], labels: NDArray[np.str_], mask: NDArray[np.bool_]) -> None:
    """Print the score by thresholds a section number, within each object's first ten grasps: eight train, two test."""
    first = first_grasps(labels)
    frames, labels = frames[first], labels[first]
    place = np.zeros(len(labels), int)
    for name in np.unique(labels):
        place[labels == name] = np.arange(TRAINING_GRASPS)
    scores: dict[int, list[float]] = {n: [] for n in _LEVELS_TRIED}
    for fold in range(TRAINING_GRASPS // 2):
        train = place // 2 != fold
        sections = _sections(frames, mask, train)
        for n, found in scores.items():
            bits = ThresholdEncoder("quantile", levels=n).fit(sections[train]).transform(sections)
            machine = HyperplaneClassifier("vote").fit(bits[train], labels[train])
            found.append(machine.score(bits[~train], labels[~train]))
    print("Within the first ten grasps, eight train and two test, sections, HyperplaneClassifier")
    for n, found in scores.items():
        print(f"  {n} thresholds a number {share(f'within the first ten, {n} thresholds', np.mean(found))}")


def _sections(frames: NDArray[np.float64], mask: NDArray[np.bool_], train: NDArray[np.bool_]) -> NDArray[np.float64]:
    """Measure the sections of both fingers in all grasps, their thresholds learned from the training grasps."""
    features = SurfaceFeatures(relative_levels=RELATIVE_LEVELS, pairs=True, field=mask)
    return features.fit(frames[train]).transform(frames)


def _measure_sections(
    frames: NDArray[np.float64],
    labels: NDArray[np.str_],
    mask: NDArray[np.bool_],
    train: NDArray[np.bool_],
    results: dict[str, list[float]],
) -> None:
    sections = _sections(frames, mask, train)
    bits = ThresholdEncoder("quantile", levels=_SECTION_LEVELS).fit(sections[train]).transform(sections)
    contenders = {
        "1-NN": KNeighborsClassifier(1, algorithm="brute"),
        "one-against-one linear SVM": SVC(kernel="linear"),
        "RBF SVM, C 10": SVC(C=10),
        "extra trees": ExtraTreesClassifier(200, random_state=0),
        "HyperplaneClassifier": HyperplaneClassifier("vote"),
    }
    for name, machine in contenders.items():
        machine.fit(bits[train], labels[train])
        score = machine.score(bits[~train], labels[~train])
        results.setdefault(f"sections, {_SECTION_LEVELS} thresholds a number, {name}", []).append(score)


def _measure_texels(
    raw: NDArray[np.float64],
    labels: NDArray[np.str_],
    train: NDArray[np.bool_],
    results: dict[str, list[float]],
) -> None:
    test = ~train
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
    main(sys.argv[1:])
