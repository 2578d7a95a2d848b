"""Two-finger pinch grasps of 36 objects (Weiss DSA): names from the whole grasp in time, then with the joint angles.

Tactile only first: the sections of the peak frame and the loading in time, in one classifier. Then joint angles in a
classifier of their own, and both fused late, with weights from cross-validation inside the training grasps. What is
learned (thresholds, moments, trees, weights) is learned from the training grasps of each split alone. The choices that
stand below as constants were made by cross-validation within the first ten grasps of each object, which main prints.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from sklearn.base import clone
from sklearn.ensemble import ExtraTreesClassifier, RandomForestClassifier

from benchmarks._real_data import find_recording
from benchmarks._scores import wilson
from benchmarks.weiss_touch import RELATIVE_LEVELS, TREES, drawn_grasps, first_grasps
from varishold.perceive.fusion import choose_weights, fuse, log_loss
from varishold.perceive.held_out import held_out_log_probabilities, training_folds
from varishold.perceive.loading_transformer import LoadingFeatures
from varishold.touch import SurfaceFeatures

DRAWS = 10
# Weights need a second round of fits in every split.
TREES_HELD_OUT = 200
SEEDS = 3


@dataclass(frozen=True)
class Grasps:
    """All grasps: frames and seconds of each, its peak frame, joint angles, object by name and by number, texels."""

    whole: list[tuple[np.ndarray, np.ndarray]]
    peak: np.ndarray
    angles: np.ndarray
    label: np.ndarray
    number: np.ndarray
    mask: np.ndarray

    def measured(self, train: np.ndarray) -> dict[str, np.ndarray]:
        """Return the features of all grasps by source; what they learn, they learn from the training grasps."""
        chosen = [self.whole[g] for g in np.flatnonzero(train)]
        surface = SurfaceFeatures(relative_levels=RELATIVE_LEVELS, pairs=True, field=self.mask).fit(self.peak[train])
        loading = LoadingFeatures(field=self.mask).fit(chosen)
        peak, time = surface.transform(self.peak), loading.transform(self.whole)
        return {
            "peak": peak,
            "loading": time,
            "tactile": np.concatenate([peak, time], axis=1),
            "angles": self.angles,
        }


def read_grasps(path: Path) -> Grasps:
    """Read the recording."""
    with np.load(path, allow_pickle=False) as data:
        frames, start, label = data["frames"].astype(np.float64), data["start"], data["label"]
        time = data["time_ms"] / 1000.0
        whole = [(frames[a:b], time[a:b]) for a, b in pairwise(start)]
        number = np.unique(label, return_inverse=True)[1]
        angles = data["joint_angles_deg"].astype(np.float64)
        return Grasps(whole, frames[start[:-1] + data["peak"]], angles, label, number, data["texel_mask"])


def trees(seed: int, n: int = TREES) -> ExtraTreesClassifier:
    """Return the classifier of every source."""
    return ExtraTreesClassifier(n, random_state=seed)


def log_probabilities(classifier: Any, inputs: np.ndarray, number: np.ndarray, train: np.ndarray) -> np.ndarray:
    """Fit on the training grasps and return what is said about the others."""
    fitted = clone(classifier).fit(inputs[train], number[train])
    with np.errstate(divide="ignore"):
        return np.log(fitted.predict_proba(inputs[~train]))


def right(said: np.ndarray, truth: np.ndarray) -> float:
    """Return the share of right names."""
    return float((said.argmax(axis=1) == truth).mean())


def within_first_grasps(grasps: Grasps) -> None:
    """Print what the choices were made by: folds within each object's first ten grasps."""
    first = first_grasps(grasps.label)
    number = grasps.number[first]
    print("  within the first ten grasps of each object (chosen here), share of right names and log loss:")
    sources = {name: inputs[first] for name, inputs in grasps.measured(first).items()}
    for title, folds in (("eight train, two test", 5), ("five train, five test", 2)):
        fold = training_folds(number, folds)

        def held(source: str, classifier: Any, fold: np.ndarray = fold) -> np.ndarray:
            return held_out_log_probabilities(classifier, sources[source], number, fold=fold)

        said = {name: held(name, trees(0, TREES_HELD_OUT)) for name in sources}
        said["angles, random forest"] = held("angles", RandomForestClassifier(TREES_HELD_OUT, random_state=0))
        for tactile in ("peak", "tactile"):
            said[f"{tactile} + angles"] = fuse({name: said[name] for name in (tactile, "angles")})
        joined = np.concatenate([sources["tactile"], sources["angles"]], axis=1)
        said["angles among the tactile features"] = held_out_log_probabilities(
            trees(0, TREES_HELD_OUT), joined, number, fold=fold
        )
        print(
            f"    {title}: "
            + "; ".join(
                f"{name} {right(s, number):.3f} ({log_loss(fuse({'': s}), number):.2f})" for name, s in said.items()
            )
        )


def name_objects(grasps: Grasps, train: np.ndarray, seed: int) -> dict[str, float]:
    """Return the share of right names of one split by source, and the weights that were chosen inside it."""
    number, truth = grasps.number, grasps.number[~train]
    sources = grasps.measured(train)
    said = {name: log_probabilities(trees(seed), sources[name], number, train) for name in sources}
    forest = RandomForestClassifier(TREES, random_state=seed)
    said["angles, random forest"] = log_probabilities(forest, sources["angles"], number, train)
    pair = ("tactile", "angles")
    held = {
        name: held_out_log_probabilities(trees(seed, TREES_HELD_OUT), sources[name][train], number[train])
        for name in pair
    }
    weights = choose_weights(held, number[train])
    said["fused"] = fuse({name: said[name] for name in pair}, weights)
    said["fused, even weights"] = fuse({name: said[name] for name in pair})
    shares = {name: right(values, truth) for name, values in said.items()}
    return shares | {f"weight of {name}": weights[name] for name in pair}


def report(title: str, rows: list[dict[str, float]], n: int, bars: dict[str, str]) -> dict[str, float]:
    """Print the mean, spread and interval of every figure over the splits of one kind."""
    print(f"  {title}, {n} test grasps a split, mean of {len(rows)} (least-most), 95 % interval of one split:")
    names = {
        "tactile": "tactile only, peak frame and loading",
        "peak": "peak frame alone",
        "loading": "loading alone",
        "fused": "tactile and joint angles fused late, weights chosen inside the training grasps",
        "fused, even weights": "the same with even weights",
        "angles": "joint angles alone, the classifier that is fused (extra trees)",
        "angles, random forest": "joint angles alone, random forest (the plain baseline)",
    }
    means = {}
    for key, name in names.items():
        values = np.array([row[key] for row in rows])
        low, high = wilson(round(values.mean() * n), n)
        means[key] = float(values.mean())
        print(
            f"    {name}: {values.mean():.3f} ({values.min():.3f}-{values.max():.3f}), interval {low:.3f}-{high:.3f}"
            + (f"; bar {bars[key]}" if key in bars else "")
        )
    gain = np.array([row["fused"] - row["angles"] for row in rows])
    better = int((gain > 0).sum())
    print(
        f"    fused less angles alone: {gain.mean():+.3f} ({gain.min():+.3f} to {gain.max():+.3f}), above in {better}"
    )
    for name in ("tactile", "angles"):
        chosen = [row[f"weight of {name}"] for row in rows]
        print(f"    weight of {name}: {np.mean(chosen):.2f} ({min(chosen):.2f}-{max(chosen):.2f})")
    return means


def main(say: Callable[[str], None] = print) -> dict[str, float]:
    """Print the figures."""
    say("Weiss DSA, 36 objects, whole grasps")
    path = find_recording("weiss_dsa36.npz")
    if path is None:
        return {}
    grasps = read_grasps(path)
    within_first_grasps(grasps)
    first = first_grasps(grasps.label)
    n = int((~first).sum())
    drawn = [name_objects(grasps, drawn_grasps(grasps.label, seed), seed) for seed in range(DRAWS)]
    bars = {"tactile": ".82", "fused": ".98 and above angles alone"}
    found = {f"draws, {k}": v for k, v in report("ten random grasps of each object train", drawn, n, bars).items()}
    honest = [name_objects(grasps, first, seed) for seed in range(SEEDS)]
    bars["tactile"] = ".73"
    found |= {f"first ten, {k}": v for k, v in report("the first ten grasps train", honest, n, bars).items()}
    return found


if __name__ == "__main__":
    main()
