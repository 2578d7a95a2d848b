"""Two-finger pinch grasps of 36 objects (Weiss DSA): names and shapes from the tactile peak frame alone.

The thresholds of the features are learned from the training grasps of each split alone, and no joint angle is
used. For the names, pads in pairs and the number of relative levels were chosen by cross-validation within the
first ten grasps of each object; the trees are scikit-learn's defaults but for their number.
"""

from __future__ import annotations

from collections import Counter
from pathlib import Path
from typing import Any

import numpy as np
from sklearn.base import clone
from sklearn.ensemble import ExtraTreesClassifier, RandomForestClassifier
from sklearn.model_selection import GridSearchCV, LeaveOneGroupOut
from sklearn.neighbors import KNeighborsClassifier
from sklearn.pipeline import make_pipeline
from sklearn.preprocessing import StandardScaler

from benchmarks._figures import share
from benchmarks._real_data import find_recording
from varishold.touch import SurfaceFeatures, find_contacts, recognize
from varishold.trust import share_interval

TRAINING_GRASPS = 10
DRAWS = 10
TREES = 500
# Chosen by `within_first_grasps`, which main prints too.
RELATIVE_LEVELS = 16
# The shapes take the transformer's default, and nothing was chosen for them but what main prints beside it.
SHAPE_RELATIVE_LEVELS = 6
SHAPES = {
    "sphere": (
        "christmas_ball",
        "foam_ball",
        "golf_ball",
        "green_plastic_ball_large",
        "green_plastic_ball_small",
        "hockey_ball",
        "ping-pong_ball",
        "tennis_ball",
    ),
    "cylinder": ("aerosol_can", "bottle_glass", "pen_medium", "pen_thick", "pen_thin", "wooden_cylinder"),
    "box": ("dice_large", "dice_small", "wooden_block_flat", "wooden_block_small"),
}


def peak_frames(path: Path) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return each grasp's frame of largest total (n, 2, rows, cols), its object, and where there are texels."""
    with np.load(path, allow_pickle=False) as data:
        return data["frames"][data["start"][:-1] + data["peak"]].astype(float), data["label"], data["texel_mask"]


def first_grasps(label: np.ndarray) -> np.ndarray:
    """Return where the first ten grasps of each object stand, in the order of recording."""
    train = np.zeros(len(label), bool)
    for name in np.unique(label):
        train[np.flatnonzero(label == name)[:TRAINING_GRASPS]] = True
    return train


def drawn_grasps(label: np.ndarray, seed: int) -> np.ndarray:
    """Return ten random grasps of each object."""
    rng = np.random.default_rng(seed)
    train = np.zeros(len(label), bool)
    for name in np.unique(label):
        train[rng.choice(np.flatnonzero(label == name), TRAINING_GRASPS, replace=False)] = True
    return train


def _features(mask: np.ndarray, relative_levels: int) -> SurfaceFeatures:
    return SurfaceFeatures(relative_levels=relative_levels, pairs=True, field=mask)


def within_first_grasps(frames: np.ndarray, label: np.ndarray, mask: np.ndarray) -> None:
    """Print the score by number of relative levels within each object's first ten grasps: eight train, two test."""
    first = first_grasps(label)
    frames, label = frames[first], label[first]
    place = np.zeros(len(label), int)
    for name in np.unique(label):
        place[label == name] = np.arange(TRAINING_GRASPS)
    for n in (6, 10, 16):
        scores = []
        for fold in range(TRAINING_GRASPS // 2):
            train = place // 2 != fold
            features = _features(mask, n).fit(frames[train])
            inputs = features.transform(frames)
            scores += [
                _object_score(inputs, label, train, ExtraTreesClassifier(200, random_state=seed)) for seed in range(3)
            ]
        named = share(f"within the first ten: {n} relative levels", np.mean(scores))
        print(f"  within the first ten grasps, eight train and two test: {n} relative levels {named}")


def _measured(frames: np.ndarray, mask: np.ndarray, train: np.ndarray, relative_levels: int) -> np.ndarray:
    """Return the features of all grasps, their thresholds learned from the training grasps."""
    return _features(mask, relative_levels).fit(frames[train]).transform(frames)


def _object_score(inputs: np.ndarray, label: np.ndarray, train: np.ndarray, classifier: Any) -> float:
    return float(clone(classifier).fit(inputs[train], label[train]).score(inputs[~train], label[~train]))


def name_objects(frames: np.ndarray, label: np.ndarray, mask: np.ndarray) -> None:
    """Print how often the object is named, ten random draws and the first ten grasps."""
    raw = frames.reshape(len(frames), -1)
    draws = [drawn_grasps(label, seed) for seed in range(DRAWS)]
    forests = {"random forest": RandomForestClassifier, "extra trees": ExtraTreesClassifier}
    plain = [
        _object_score(raw, label, train, RandomForestClassifier(200, random_state=k)) for k, train in enumerate(draws)
    ]
    named = share("raw peak frame in a random forest", np.mean(plain))
    print(f"  raw peak frame in a random forest, mean of {DRAWS} draws: {named}")
    measured = [_measured(frames, mask, train, RELATIVE_LEVELS) for train in draws]
    first = first_grasps(label)
    measured_first = _measured(frames, mask, first, RELATIVE_LEVELS)
    for name, forest in forests.items():
        drawn = [
            _object_score(inputs, label, train, forest(TREES, random_state=k))
            for k, (inputs, train) in enumerate(zip(measured, draws, strict=True))
        ]
        honest = [_object_score(measured_first, label, first, forest(TREES, random_state=k)) for k in range(DRAWS)]
        n = int((~first).sum())
        low, high = share_interval(round(np.mean(honest) * n), n)
        print(
            f"  SurfaceFeatures of both fingers in {name} ({TREES} trees): mean of {DRAWS} draws "
            f"{share(f'{name}: draws', np.mean(drawn), bar='>= 78')} ({min(drawn):.3f}-{max(drawn):.3f})"
        )
        print(
            f"    first ten grasps train, the other {n} test: "
            f"{share(f'{name}: first ten', np.mean(honest), bar='>= 72')}, interval {low:.3f}-{high:.3f} "
            f"(mean of {DRAWS} seeds, {min(honest):.3f}-{max(honest):.3f})"
        )


def name_shapes(frames: np.ndarray, label: np.ndarray, mask: np.ndarray) -> None:
    """Print how often sphere, cylinder and box are told apart on objects that were never seen."""
    shape_of = {name: shape for shape, names in SHAPES.items() for name in names}
    known = np.isin(label, list(shape_of))
    frames, label = frames[known], label[known]
    shape = np.array([shape_of[name] for name in label])
    raw = frames.reshape(len(frames), -1)
    nearest = make_pipeline(StandardScaler(), KNeighborsClassifier(1, metric="manhattan"))
    chosen = GridSearchCV(
        nearest,
        {"kneighborsclassifier__n_neighbors": [1, 3, 5], "kneighborsclassifier__metric": ["manhattan", "euclidean"]},
        cv=LeaveOneGroupOut(),
    )
    right = {name: np.zeros(len(label), bool) for name in ("raw", "nearest", "chosen", "trees")}
    for held in np.unique(label):
        train = label != held
        inputs = _measured(frames, mask, train, SHAPE_RELATIVE_LEVELS)
        trees = ExtraTreesClassifier(TREES, random_state=0)
        right["raw"][~train] = (
            KNeighborsClassifier(1).fit(raw[train], shape[train]).predict(raw[~train]) == shape[~train]
        )
        right["nearest"][~train] = (
            clone(nearest).fit(inputs[train], shape[train]).predict(inputs[~train]) == shape[~train]
        )
        right["chosen"][~train] = (
            clone(chosen).fit(inputs[train], shape[train], groups=label[train]).predict(inputs[~train]) == shape[~train]
        )
        right["trees"][~train] = trees.fit(inputs[train], shape[train]).predict(inputs[~train]) == shape[~train]
    titles = {
        "raw": "raw peak frame, 1 nearest neighbour",
        "nearest": "SurfaceFeatures, 1 nearest neighbour, sum of absolute differences of standardized features",
        "chosen": "SurfaceFeatures, nearest neighbours with number and distance chosen inside the training objects",
        "trees": f"SurfaceFeatures, extra trees ({TREES})",
    }
    objects = np.unique(label)
    print(f"  shape of {len(label)} grasps of {len(objects)} objects, the object held out:")
    for name, title in titles.items():
        low, high = _over_objects(right[name], label)
        bar = ">= 86" if name != "raw" else ""
        named = share(f"shape: {title}", right[name].mean(), bar=bar)
        print(f"    {title}: {named}, interval over objects {low:.3f}-{high:.3f}")
    by_object = {name: right["nearest"][label == name].mean() for name in objects}
    worst = sorted(by_object, key=by_object.__getitem__)[:5]
    print("    hardest: " + "; ".join(f"{name} {by_object[name]:.2f}" for name in worst))


def recognize_untrained(frames: np.ndarray, label: np.ndarray, mask: np.ndarray) -> None:
    """Print what `recognize`, which has never seen this sensor, calls each finger's largest contact."""
    print("  recognize, learned from generated frames alone, on each finger's largest contact:")
    for shape, names in SHAPES.items():
        given: Counter[str] = Counter()
        closed: Counter[str] = Counter()
        for g in np.flatnonzero(np.isin(label, names)):
            for finger in (0, 1):
                contact = find_contacts(frames[g, finger], field=mask[finger])[0]
                given[recognize(contact).name] += 1
                closed[recognize(contact, among=("sphere", "lying cylinder", "rectangular pillar")).name] += 1
        n = given.total()
        print(f"    {shape}: " + ", ".join(f"{name} {k / n:.2f}" for name, k in given.most_common(5)))
        print("      among three names: " + ", ".join(f"{name} {k / n:.2f}" for name, k in closed.most_common()))
        share(f"recognize, {shape}: unknown", given["unknown"] / n)


def _over_objects(right: np.ndarray, label: np.ndarray) -> tuple[float, float]:
    """Return the 95 % bootstrap interval of a share; whole objects are drawn."""
    rng = np.random.default_rng(0)
    of_object = [right[label == name] for name in np.unique(label)]
    shares = [
        np.concatenate([of_object[i] for i in rng.integers(0, len(of_object), len(of_object))]).mean()
        for _ in range(4000)
    ]
    low, high = np.percentile(shares, [2.5, 97.5])
    return float(low), float(high)


def main() -> None:
    """Print the figures."""
    path = find_recording("weiss_dsa36.npz")
    if path is not None:
        frames, label, mask = peak_frames(path)
        recognize_untrained(frames, label, mask)
        name_shapes(frames, label, mask)
        within_first_grasps(frames, label, mask)
        name_objects(frames, label, mask)


if __name__ == "__main__":
    main()
