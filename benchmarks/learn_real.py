"""What `TactileClassifier` learns by its defaults from ten grasps of each thing, on real recordings of two hands.

Weiss: two fingers pinch 36 objects; touch alone, and with the joint angles less what marks the session (`posture`).
iCub: five fingertips of twelve taxels grasp ten things; readings less the first, beyond a dead band of five counts,
beside the control that taxels which no training grasp presses name the things by their drift.
The defaults were chosen within the first ten grasps of each Weiss object, which the random draws test too, and on
generated days that no benchmark draws. All splits had been run once before the course in detail was added.

Run: python -m benchmarks.learn_real [DRAWS]
"""

from __future__ import annotations

import re
import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from sklearn.ensemble import ExtraTreesClassifier

from benchmarks._figures import figure, share
from benchmarks._real_data import find_recording
from benchmarks.weiss_grasp import posture
from benchmarks.weiss_touch import drawn_grasps, first_grasps
from varishold import TactileClassifier, read
from varishold.learning import labelled_presses, write_model
from varishold.touch.course.presses import Press, as_presses
from varishold.trust import share_interval

DRAWS = 10
# The iCub's taxels rest unevenly and drift by a few counts.
DEAD_BAND = 5.0
UNRELIABLE = "full_coke"


def main() -> None:
    """Print the figures."""
    draws = next((int(word) for word in sys.argv[1:] if word.isdigit()), DRAWS)
    path = find_recording("weiss_dsa36.npz")
    if path is not None:
        name_pinched(path, draws)
    path = find_recording("icub_grasp/README.txt")
    if path is not None:
        name_grasped(path.parent / "iCubGraspDataset", draws)


def name_pinched(path: Path, draws: int) -> None:
    """Print how often the pinched object is named."""
    given = labelled_presses([read(path)], label="label")
    angles = np.rad2deg([list(press.columns.values()) for press in given.presses])
    touch = [replace(press, columns={}) for press in given.presses]
    fused = [
        replace(press, columns={f"angle_rad.{k}": value for k, value in enumerate(row)})
        for press, row in zip(touch, np.deg2rad(posture(angles)), strict=True)
    ]
    print("Weiss, 36 objects, ten grasps each known")
    for title, presses, bars in (
        ("touch alone", touch, (">= 85", ">= 77")),
        ("touch and angles without the session's mark", fused, (">= 97", ">= 93")),
    ):
        _splits(f"Weiss, {title}", presses, given.labels, draws, bars)
    _cost(touch, given.labels)


def name_grasped(folder: Path, draws: int) -> None:
    """Print how often the grasped thing is named."""
    files = sorted(folder.glob("*.txt"), key=lambda file: (_thing(file), int(re.findall(r"\d+", file.stem)[-1])))
    files = [file for file in files if _thing(file) != UNRELIABLE]
    labels = np.array([_thing(file) for file in files])
    readings = [_readings(file) for file in files]
    presses = as_presses([np.maximum(frames[0] - frames - DEAD_BAND, 0.0) for frames in readings])
    print(f"iCub, {len(set(labels))} things, {len(labels)} grasps, ten each known")
    _splits("iCub, touch alone", presses, labels, draws, (">= 83", ">= 79"))
    touched = np.array([any(frames.any() for frames in press.pads.values()) for press in presses])
    most = [_most(touched, labels, drawn_grasps(labels, seed)) for seed in range(draws)]
    said = share(f"iCub, the most that can be right, mean of {draws} draws", np.mean(most))
    first = share(
        "iCub, the most that can be right, the first ten grasps known", _most(touched, labels, first_grasps(labels))
    )
    print(f"  iCub, {np.mean(~touched):.0%} of the grasps press no taxel: at most {said} and {first} can be right")
    _splits("iCub, control: taxels that no training grasp presses, extra trees", readings, labels, draws, fit=_drift)


def _splits(
    title: str,
    presses: list[Any],
    labels: np.ndarray,
    draws: int,
    bars: tuple[str, str] = ("", ""),
    fit: Callable[[list[Any], np.ndarray], Any] | None = None,
) -> None:
    """Print the shares of random draws and of the first ten grasps."""
    learn = fit or (lambda given, names: TactileClassifier().fit(given, names))
    drawn = []
    for seed in range(draws):
        drawn.append(_answers(learn, presses, labels, drawn_grasps(labels, seed)).mean())
    said = share(f"{title}, mean of {draws} draws", np.mean(drawn), bar=bars[0])
    print(f"  {title}: {said} ({100 * min(drawn):.1f}-{100 * max(drawn):.1f}), mean of {draws} draws", flush=True)
    right = _answers(learn, presses, labels, first_grasps(labels))
    low, high = share_interval(int(right.sum()), len(right))
    said = share(f"{title}, the first ten grasps known", right.mean(), bar=bars[1])
    print(f"  {title}: {said} ({100 * low:.1f}-{100 * high:.1f}), the first ten known", flush=True)


def _most(touched: np.ndarray, labels: np.ndarray, train: np.ndarray) -> float:
    """Return the share that is right at most: all grasps in which nothing was touched get one answer, the best."""
    names, counts = np.unique(labels[~train & ~touched], return_counts=True)
    return 1 - float(counts.sum() - counts.max()) / float((~train).sum()) if len(names) else 1.0


def _answers(learn: Callable[..., Any], presses: list[Any], labels: np.ndarray, train: np.ndarray) -> np.ndarray:
    known = learn([presses[k] for k in np.flatnonzero(train)], labels[train])
    return np.asarray(known.predict([presses[k] for k in np.flatnonzero(~train)]) == labels[~train])


class _drift:
    """Extra trees on the change of those taxels alone that no training grasp changes beyond the dead band."""

    def __init__(self, readings: list[np.ndarray], labels: np.ndarray) -> None:
        self.still = np.max([np.abs(frames[0] - frames).max(axis=0) for frames in readings], axis=0) <= DEAD_BAND
        self.trees = ExtraTreesClassifier(300, random_state=0).fit(self._changes(readings), labels)

    def _changes(self, readings: list[np.ndarray]) -> np.ndarray:
        return np.stack([(frames[-1] - frames[0])[self.still] for frames in readings])

    def predict(self, readings: list[np.ndarray]) -> np.ndarray:
        return np.asarray(self.trees.predict(self._changes(readings)))


def _cost(presses: list[Press], labels: np.ndarray) -> None:
    """Print what learning and answering cost."""
    train = first_grasps(labels)
    known = [presses[k] for k in np.flatnonzero(train)]
    began = time.process_time()
    clf = TactileClassifier().fit(known, labels[train])
    learning = time.process_time() - began
    began = time.process_time()
    for press in known[:100]:
        clf.predict_proba([press])
    answering = 10 * (time.process_time() - began)
    with tempfile.TemporaryDirectory() as folder:
        write_model(clf, Path(folder, "model.npz"))
        size = Path(folder, "model.npz").stat().st_size / 1e6
    print(f"  learning 36 classes from 360 grasps: {figure('CPU time of learning', learning, '.1f', 's', bar='<= 60')}")
    print(f"  answering one: {figure('CPU time of an answer', answering, '.2f', 'ms', bar='<= 5')}")
    print(f"  the model: {figure('size of the model', size, '.2f', 'MB', bar='<= 2')}")


def _thing(file: Path) -> str:
    return file.stem.rsplit("_", 1)[0]


def _readings(file: Path) -> np.ndarray:
    """Return the readings of one grasp, shape (n_frames, 5, 1, 12); larger is less pressure."""
    return np.stack([pad.frames for pad in read(file).pads.values()], axis=1).astype(np.float64)


if __name__ == "__main__":
    main()
