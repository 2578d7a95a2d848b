"""Two-finger pinch grasps of 36 objects (Weiss DSA): names from the whole grasp in time, then with the joint angles.

Tactile only first: the sections of the peak frame and the loading in time, in one classifier. Then joint angles in a
classifier of their own, and both fused late, with weights from cross-validation inside the training grasps. What is
learned (thresholds, moments, trees, weights) is learned from the training grasps of each split alone. The choices that
stand below as constants were made by cross-validation within the first ten grasps of each object, which main prints.
"""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from itertools import combinations, pairwise
from pathlib import Path
from typing import Any

import numpy as np
from sklearn.base import clone
from sklearn.ensemble import ExtraTreesClassifier, RandomForestClassifier

from benchmarks._figures import share
from benchmarks._held_out import held_out_log_probabilities, training_folds
from benchmarks._real_data import find_recording
from benchmarks.weiss_touch import RELATIVE_LEVELS, TREES, drawn_grasps, first_grasps
from varishold.touch import SurfaceFeatures
from varishold.touch.course.features import LoadingFeatures
from varishold.trust import share_interval
from varishold.trust.fusion import SourceWeights, choose_weights, fuse, log_loss

DRAWS = 10
# Weights need a second round of fits in every split.
TREES_HELD_OUT = 200
SEEDS = 3
# Set before the grasp, and still in it.
IDLE_JOINTS = [0, 3, 4]
# Sources are calibrated on the earlier half of each object's training grasps against the later one and the reverse:
# in neighbouring grasps a source is surer, and rightly so, than in those of another time.
FOLDS = 2


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
            "angles": links(self.angles),
            "pose": links(posture(self.angles)),
            "idle joints": self.angles[:, IDLE_JOINTS],
            "angles as measured": self.angles,
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


def posture(angles: np.ndarray) -> np.ndarray:
    """Return the angles without what only says when they were recorded.

    Three joints are set before the grasp and stand still in it. Where they stand, to the hundredth of a degree, is the
    same in all grasps of an object and another for the next: a mark of the session. To a degree only what
    was set on purpose is left of them, and the moving joints are told to a tenth.
    """
    kept = angles.round(1)
    kept[:, IDLE_JOINTS] = angles[:, IDLE_JOINTS].round(0)
    return kept


def links(angles: np.ndarray) -> np.ndarray:
    """Return the joint angles and every two's sum and difference.

    Along a finger the sum is the direction of the next link, across fingers the difference says how far they open.
    """
    pairs = [angles[:, a] + sign * angles[:, b] for a, b in combinations(range(angles.shape[1]), 2) for sign in (1, -1)]
    return np.column_stack([angles, *pairs])


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
    print("  within the first ten grasps of each object, by which was chosen: right names and log loss")
    sources = {name: inputs[first] for name, inputs in grasps.measured(first).items()}
    sources["tactile and joint angles in one classifier"] = np.concatenate(
        [sources["tactile"], sources["angles as measured"]], axis=1
    )
    for title, folds in (("eight train, two test", 5), ("five train, five test", 2)):
        fold = training_folds(number, folds)
        said = {
            name: held_out_log_probabilities(trees(0, TREES_HELD_OUT), inputs, number, fold=fold)
            for name, inputs in sources.items()
        }
        forest = RandomForestClassifier(TREES_HELD_OUT, random_state=0)
        said["angles, random forest"] = held_out_log_probabilities(
            forest, sources["angles as measured"], number, fold=fold
        )
        print(f"    {title}:")
        for name, values in said.items():
            named = share(f"within the first ten, {title}: {name}", right(values, number))
            print(f"      {name}: {named}, {log_loss(fuse({name: values}), number):.3f}")
        for tactile, angles in (
            ("peak", "angles"),
            ("tactile", "angles as measured"),
            ("tactile", "angles"),
            ("tactile", "pose"),
        ):
            pair = {name: said[name] for name in (tactile, angles)}
            weights = choose_weights(pair, number)
            for how, fused in (("even weights", fuse(pair)), (told(weights), fuse(pair, weights))):
                print(f"      {tactile} + {angles}, {how}: {right(fused, number):.3f}, {log_loss(fused, number):.3f}")


def told(weights: SourceWeights) -> str:
    """Return weights and mixing weights in words."""
    return "; ".join(
        f"{name} weight {weights.weights[name]:.2f} mixing {weights.mixing[name]:.3f}" for name in weights.weights
    )


def name_objects(grasps: Grasps, train: np.ndarray, seed: int) -> dict[str, float]:
    """Return the share of right names of one split by source, and the weights that were chosen inside it."""
    number, truth = grasps.number, grasps.number[~train]
    sources = grasps.measured(train)
    said = {name: log_probabilities(trees(seed), sources[name], number, train) for name in sources}
    forest = RandomForestClassifier(TREES, random_state=seed)
    said["angles, random forest"] = log_probabilities(forest, sources["angles"], number, train)
    said["fused, even weights"] = fuse({name: said[name] for name in ("tactile", "angles")})
    shares = {}
    halves = training_folds(number[train], FOLDS)
    held = {
        name: held_out_log_probabilities(trees(seed, TREES_HELD_OUT), sources[name][train], number[train], fold=halves)
        for name in ("tactile", "angles", "pose")
    }
    for angles, key in (("angles", "fused"), ("pose", "fused with pose")):
        weights = choose_weights({name: held[name] for name in ("tactile", angles)}, number[train])
        said[key] = fuse({name: said[name] for name in ("tactile", angles)}, weights)
        if key == "fused":
            shares |= {f"weight of {name}": weights.weights[name] for name in weights.weights}
            shares |= {f"mixing of {name}": weights.mixing[name] for name in weights.mixing}
    return shares | {name: right(values, truth) for name, values in said.items()}


def confused(grasps: Grasps, train: np.ndarray) -> None:
    """Print what the tactile source takes for what most often."""
    said = log_probabilities(trees(0), grasps.measured(train)["tactile"], grasps.number, train)
    names, truth = np.unique(grasps.label), grasps.number[~train]
    pairs = Counter((names[t], names[g]) for t, g in zip(truth, said.argmax(axis=1), strict=True) if t != g)
    print("    tactile, most often: " + "; ".join(f"{t} taken for {g} {n} x" for (t, g), n in pairs.most_common(6)))


def report(title: str, rows: list[dict[str, float]], n: int, bars: dict[str, str]) -> None:
    """Print the mean, spread and interval of every figure over the splits of one kind."""
    print(f"  {title}, {n} test grasps a split, mean of {len(rows)} (least-most), 95 % interval of one split:")
    names = {
        "tactile": "tactile only, peak frame and loading",
        "peak": "peak frame alone",
        "loading": "loading alone",
        "fused": "tactile and joint angles fused late, weights chosen inside the training grasps",
        "fused, even weights": "the same with even weights",
        "angles": "joint angles alone, the classifier that is fused (angles, their sums and differences, extra trees)",
        "angles as measured": "joint angles alone as they are, extra trees",
        "angles, random forest": "joint angles alone as they are, random forest (the plain baseline)",
        "idle joints": "the three joints that stand still in a grasp, alone (a mark of the session)",
        "pose": "joint angles without that mark, alone",
        "fused with pose": "tactile and joint angles without that mark, fused late",
    }
    for key, name in names.items():
        values = np.array([row[key] for row in rows])
        low, high = share_interval(round(values.mean() * n), n)
        mean = share(f"{title}: {name}", values.mean(), bar=bars.get(key, ""))
        print(f"    {name}: {mean} ({values.min():.3f}-{values.max():.3f}), interval {low:.3f}-{high:.3f}")
    for fused, angles in (("fused", "angles"), ("fused with pose", "pose")):
        gain = np.array([row[fused] - row[angles] for row in rows])
        print(
            f"    {names[fused]}, less those angles alone: "
            f"{share(f'{title}: {names[fused]}, gain', gain.mean(), '+.1f')} "
            f"({gain.min():+.3f} to {gain.max():+.3f}), "
            f"above in {int((gain > 0).sum())} of {len(rows)}"
        )
    for name in ("tactile", "angles"):
        for kind in ("weight", "mixing"):
            chosen = [row[f"{kind} of {name}"] for row in rows]
            print(f"    {kind} of {name}: {np.mean(chosen):.3f} ({min(chosen):.3f}-{max(chosen):.3f})")


def main() -> None:
    """Print the figures."""
    print("Weiss DSA, 36 objects, whole grasps")
    path = find_recording("weiss_dsa36.npz")
    if path is None:
        return
    grasps = read_grasps(path)
    within_first_grasps(grasps)
    first = first_grasps(grasps.label)
    n = int((~first).sum())
    drawn = [name_objects(grasps, drawn_grasps(grasps.label, seed), seed) for seed in range(DRAWS)]
    bars = {"tactile": ">= 82", "fused": ">= 98 and above angles alone"}
    report("ten random grasps of each object train", drawn, n, bars)
    honest = [name_objects(grasps, first, seed) for seed in range(SEEDS)]
    bars["tactile"] = ">= 73"
    report("the first ten grasps train", honest, n, bars)
    confused(grasps, first)


if __name__ == "__main__":
    main()
