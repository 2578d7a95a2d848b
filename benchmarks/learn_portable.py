"""What the form that a controller can hold costs: `PortableClassifier` beside `TactileClassifier`, by their defaults.

Simulated days as in `learn_days`, of other seeds: ten things, ten presses each on day one, answered on the same day and
on another. Weiss: two fingers pinch 36 objects, touch alone; every third of each object's grasps, in the order of
recording, is left out in turn. Neither was looked at while the portable form was made, but that its inputs and its
learner were chosen by cross-validation within the first ten grasps of each Weiss object.

Run: python -m benchmarks.learn_portable [SEEDS]
"""

from __future__ import annotations

import sys
import tempfile
import time
from dataclasses import replace
from pathlib import Path

import numpy as np

from benchmarks._figures import figure, share
from benchmarks._real_data import find_recording
from benchmarks.learn_days import PRESSES, TESTED, THINGS, draw_days, draw_thing, presses
from benchmarks.weiss_touch import first_grasps
from varishold import TactileClassifier, read
from varishold.learning import PortableClassifier, PressClassifier, labelled_presses, write_model
from varishold.touch.course.presses import Press
from varishold.trust import share_interval

SEEDS = 5
SHAPES = ((16, 16), (28, 44), (5, 9))
LEARNERS: dict[str, type[PressClassifier]] = {"portable": PortableClassifier, "default": TactileClassifier}
THIRDS = 3


def measure(shape: tuple[int, int], seed: int) -> dict[str, dict[str, float]]:
    """Return the figures of one pad and seed, by learner."""
    rng = np.random.default_rng((2026, seed, *shape))
    things = [draw_thing(rng, shape) for _ in range(2 * THINGS)]
    one, two = draw_days(rng, shape)
    known = presses(things[:THINGS], one, PRESSES, rng)
    same = presses(things[:THINGS], one, TESTED, rng)
    other = presses(things[:THINGS], two, TESTED, rng)
    strangers, _ = presses(things[THINGS:], two, TESTED, rng)
    return {name: judged(of().fit(*known), same, other, strangers) for name, of in LEARNERS.items()}


def judged(
    clf: PressClassifier,
    same: tuple[list[np.ndarray], np.ndarray],
    other: tuple[list[np.ndarray], np.ndarray],
    strangers: list[np.ndarray],
) -> dict[str, float]:
    """Return the figures of one classifier."""
    p, rare = clf.judge(other[0])
    right, top = p.argmax(axis=1) == other[1], p.max(axis=1)
    sure, strange = top > 0.9, clf.p_values(strangers)
    return {
        "right on the same day": float((clf.predict(same[0]) == same[1]).mean()),
        "right on the other day": float(right.mean()),
        "given with p > .9 there": float(sure.mean()),
        "of these right": float(right[sure].mean()) if sure.any() else float("nan"),
        "known things refused there": float((rare <= clf.error).mean()),
        "strangers refused there": float((strange <= clf.error).mean()),
        "strangers refused where 5 % of known things are": float((strange <= np.quantile(rare, 0.05)).mean()),
    }


def simulated_days(seeds: int) -> None:
    """Print the figures of simulated days."""
    for shape in SHAPES:
        found = [measure(shape, seed) for seed in range(seeds)]
        title = f"{shape[0]} x {shape[1]}"
        print(f"{title} taxels, {THINGS} things, {PRESSES} presses each, mean of {seeds} seeds: {' / '.join(LEARNERS)}")
        for row in found[0]["default"]:
            said = [
                share(f"{title}: {row}, {name}", float(np.nanmean([each[name][row] for each in found])))
                for name in LEARNERS
            ]
            print(f"  {row}: {' / '.join(said)}", flush=True)


def pinched(path: Path) -> None:
    """Print how often the pinched object is named, and what learning, an answer and a model cost."""
    given = labelled_presses([read(path)], label="label")
    touch, labels = [replace(press, columns={}) for press in given.presses], given.labels
    third = np.zeros(len(labels), dtype=int)
    for label in np.unique(labels):
        of = np.flatnonzero(labels == label)
        third[of] = np.arange(len(of)) * THIRDS // len(of)
    print(f"Weiss, {len(np.unique(labels))} objects, {len(labels)} grasps, touch alone")
    for name, learner in LEARNERS.items():
        right = np.concatenate([answers(learner, touch, labels, third != k) for k in range(THIRDS)])
        told(f"each third of the grasps left out, {name}", right)
    told("the first ten known, portable", answers(PortableClassifier, touch, labels, first_grasps(labels)))
    cost(touch, labels)


def answers(learner: type[PressClassifier], touch: list[Press], labels: np.ndarray, train: np.ndarray) -> np.ndarray:
    """Return which presses are named right that were not learned from."""
    clf = learner().fit([touch[k] for k in np.flatnonzero(train)], labels[train])
    return np.asarray(clf.predict([touch[k] for k in np.flatnonzero(~train)]) == labels[~train])


def told(title: str, right: np.ndarray) -> None:
    """Print a share of right answers and its interval."""
    low, high = share_interval(int(right.sum()), len(right))
    said = share(f"Weiss, {title}", float(right.mean()))
    print(f"  {title}: {said} ({100 * low:.1f}-{100 * high:.1f})", flush=True)


def cost(touch: list[Press], labels: np.ndarray) -> None:
    """Print what learning, answering and keeping 36 classes cost in the portable form."""
    known = np.flatnonzero(first_grasps(labels))
    began = time.process_time()
    clf = PortableClassifier().fit([touch[k] for k in known], labels[known])
    learning = time.process_time() - began
    began = time.process_time()
    for k in known[:100]:
        clf.predict_proba([touch[k]])
    answering = 10 * (time.process_time() - began)
    with tempfile.TemporaryDirectory() as folder:
        write_model(clf, Path(folder, "model.npz"))
        size = Path(folder, "model.npz").stat().st_size / 1e6
    print(f"  learning 36 classes from 360 grasps: {figure('CPU time of learning', learning, '.1f', 's')}")
    print(f"  answering one: {figure('CPU time of an answer', answering, '.2f', 'ms')}")
    print(f"  the model: {figure('size of the model', size, '.2f', 'MB')}")


def main() -> None:
    """Print the figures."""
    simulated_days(next((int(word) for word in sys.argv[1:] if word.isdigit()), SEEDS))
    path = find_recording("weiss_dsa36.npz")
    if path is not None:
        pinched(path)


if __name__ == "__main__":
    main()
