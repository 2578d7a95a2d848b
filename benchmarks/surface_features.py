"""SurfaceFeatures on arrays of 4 x 4 to 64 x 64: what its recipes are worth in a forest of scikit-learn, and its speed.

Ten drawn things are learned from ten presses each, as in `learn_days`, and tested on the same day and on another, on
which gains have drifted, everything lies two taxels elsewhere and is pressed 25 % less. Which levels each recipe takes
was chosen on other seeds. Speed is beside the sections alone, found frame by frame; their equality is checked first.

Run: python -m benchmarks.surface_features [SEEDS]
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from functools import partial

import numpy as np
from sklearn.ensemble import ExtraTreesClassifier

from benchmarks._figures import figure, share
from benchmarks.learn_days import PRESSES, TESTED, THINGS, draw_days, draw_thing, presses
from varishold.levelset.joined import join_sections
from varishold.touch import SurfaceFeatures, find_contacts
from varishold.touch.course.held import HeldFrames, press_floor
from varishold.touch.course.presses import as_presses

SEEDS = 3
SHAPES = ((4, 4), (6, 6), (8, 8), (16, 16), (32, 32), (64, 64))
#: The recipes of docs/features.md.
RECIPES = {
    "one day": {"levels": 4, "relative_levels": 10},
    "other days": {"levels": 0, "relative_levels": 10},
}
FRAMES, REPEATS, TREES = 1000, 5, 300


def readings(given: list[np.ndarray]) -> np.ndarray:
    """Return the mean of the held frames of each press, flat."""
    some = as_presses(given)
    held = HeldFrames.of(some, some[0].shapes, press_floor(some))
    return held.mean(held.frames.reshape(len(held.frames), -1))


def shares_right(shape: tuple[int, int], seed: int) -> dict[str, tuple[float, float]]:
    """Return the shares right on the same day and on another: of the readings, the defaults and each recipe."""
    rng = np.random.default_rng((1972, seed, *shape))
    things = [draw_thing(rng, shape) for _ in range(THINGS)]
    one, two = draw_days(rng, shape)
    known, truth = presses(things, one, PRESSES, rng)
    tested = [presses(things, day, TESTED, rng) for day in (one, two)]
    ways: dict[str, Callable[[list[np.ndarray]], np.ndarray]] = {"readings": readings}
    for name, settings in {"defaults": {}, **RECIPES}.items():
        ways[name] = SurfaceFeatures(per="press", **settings).fit(known).transform
    found = {}
    for name, numbers in ways.items():
        forest = ExtraTreesClassifier(TREES, random_state=0).fit(numbers(known), truth)
        same, other = ((forest.predict(numbers(given)) == of).mean() for given, of in tested)
        found[name] = float(same), float(other)
    return found


def one_by_one(features: SurfaceFeatures, frames: np.ndarray) -> np.ndarray:
    """Return the areas of a frame's sections at its thresholds, falling, found frame by frame."""
    peaks = np.maximum(frames.max(axis=(1, 2)) - features.floor_, 0.0)
    own = features.floor_ + peaks[:, None] * features.relative_levels_
    thresholds = -np.sort(-np.concatenate([np.tile(features.levels_, (len(frames), 1)), own], axis=1), axis=1)
    owner, profiles = [], []
    for i, frame in enumerate(frames):
        contacts = find_contacts(frame, thresholds[i], floor=features.floor_)
        owner += [i] * len(contacts)
        profiles += [contact.profile for contact in contacts]
    of = (np.stack([getattr(p, name) for p in profiles]) for name in ("area", "perimeter", "centroid", "covariance"))
    return join_sections(np.array(owner), len(frames), *of)["area"]


def cost(shape: tuple[int, int]) -> tuple[float, float]:
    """Return the CPU time of a frame, microseconds: by the transformer, and of its sections one by one."""
    rng = np.random.default_rng(0)
    y, x = np.indices(shape)
    n = FRAMES if shape[0] < 32 else FRAMES // 5
    middle, breadth = rng.uniform(0.3, 0.7, (n, 2, 1, 1)) * shape[0], rng.uniform(0.15, 0.4, (n, 1, 1)) * shape[0]
    frames = 100 * np.maximum(1 - np.hypot(x - middle[:, 0], y - middle[:, 1]) / breadth, 0.0)
    frames += rng.normal(0, 1, frames.shape)
    features = SurfaceFeatures().fit(frames)
    numbers = features.table(frames)
    mine = np.stack([of for name, of in numbers.items() if name.startswith("area_above")], axis=1)
    np.testing.assert_allclose(-np.sort(-mine), np.sort(one_by_one(features, frames))[:, ::-1], rtol=1e-9, atol=1e-9)
    times: list[list[float]] = [[], []]
    for _ in range(REPEATS):
        for kept, call in zip(times, (features.transform, partial(one_by_one, features)), strict=True):
            began = time.process_time()
            call(frames)
            kept.append(1e6 * (time.process_time() - began) / n)
    return float(np.median(times[0])), float(np.median(times[1]))


def main() -> None:
    """Print the figures."""
    seeds = next((int(word) for word in sys.argv[1:] if word.isdigit()), SEEDS)
    print(f"{THINGS} things, {PRESSES} presses each; right on the same day / on another; mean of {seeds} seeds")
    for shape in SHAPES:
        title = f"{shape[0]} x {shape[1]}"
        found = [shares_right(shape, seed) for seed in range(seeds)]
        told = []
        for name in found[0]:
            same, other = np.mean([each[name] for each in found], axis=0)
            told.append(f"{name} {share(f'{title}: {name}, same day', same)}")
            told[-1] += f" / {share(f'{title}: {name}, another day', other)}"
        print(f"  {title}: {'; '.join(told)}", flush=True)
    print("microseconds a frame (CPU), defaults")
    for shape in SHAPES:
        title = f"{shape[0]} x {shape[1]}"
        mine, plain = cost(shape)
        ratio = figure(f"{title}: sections alone, frame by frame", plain / mine, ".1f")
        own = figure(f"{title}: CPU time of a frame", mine, ".0f", "us")
        print(f"  {title}: {own}; sections alone, frame by frame, {ratio} times")


if __name__ == "__main__":
    main()
