"""What 5 x 9 taxels can tell of ten things on another day: the answers of somebody who knows each thing's true form.

He knows how things are pressed, how far gains have drifted on the mean and how loud the noise is, and learns from no
press. Of each press he finds, for each thing, the place, the turn, the load and the depths that explain all its frames
best, with one gain a taxel that is the likelier the nearer it is to 1. What explains a press best is his answer; what
nothing explains is a stranger. Nothing that learns from presses can do much better.

Run: python -m benchmarks.learn_days_limit [SEEDS]
"""

from __future__ import annotations

import sys
from itertools import product

import numpy as np

from benchmarks._figures import share
from benchmarks.learn_days import PRESSES, SEEDS, SHAPES, TESTED, THINGS, Thing, draw_all, presses

_SHAPE = SHAPES[1]
#: So many presses of each thing and stranger are explained.
_EACH = 6
_DEPTHS = np.linspace(0.08, 1.0, 48)
# Noise, with what is left of the steps; the spread of gains on day two; usual loads.
_NOISE, _GAINS, _LOAD, _LOADS = 1.15, 0.112, 75.0, (35.0, 150.0)
# Finer and finer steps in place (taxels) and turn (radians).
_STEPS = ((0.13, 0.1), (0.06, 0.05), (0.03, 0.03), (0.015, 0.015))
# So many of the things that explain a press best at first are looked at closely.
_LIKELY = 4

Floats = np.ndarray


def felt(thing: Thing, poses: Floats) -> tuple[Floats, Floats]:
    """Return what each pose presses at full depth, shape (n, taxels), and at each depth, (n, depths, taxels)."""
    row, col = np.indices(_SHAPE) - (np.array(_SHAPE)[:, None, None] - 1) / 2
    x, y, turn = (poses[:, k, None, None] for k in range(3))
    u, v = col - x, row - y
    u, v = np.cos(turn) * u + np.sin(turn) * v, np.cos(turn) * v - np.sin(turn) * u
    full = thing.pressure(u, v, 1.0).reshape(len(poses), -1)
    let_go = (1 - _DEPTHS[:, None]) * thing.dome
    return full, _DEPTHS[:, None] * np.maximum(full[:, None] - let_go, 0.0)


def surprise(thing: Thing, poses: Floats, frames: Floats) -> tuple[float, Floats]:
    """Return how badly a thing explains frames of shape (n_frames, taxels) in its best pose, and that pose."""
    full, by_depth = felt(thing, poses)
    peak = frames[frames.sum(axis=1).argmax()]
    load = full @ peak / np.maximum((full * full).sum(axis=1), 1e-9)
    load = np.where((load > _LOADS[0]) & (load < _LOADS[1]), load, np.nan)
    by_depth = by_depth * load[:, None, None]
    gain, noise = np.ones_like(full), _NOISE**2
    pose = np.arange(len(poses))[:, None]
    for _ in range(3):
        likely = by_depth * gain[:, None]
        apart = (likely**2).sum(axis=2)[:, :, None] - 2 * likely @ frames.T
        pressed = by_depth[pose, np.nan_to_num(apart, nan=np.inf).argmin(axis=1)]
        weight = _GAINS**-2 + (pressed**2).sum(axis=1) / noise
        gain = (_GAINS**-2 + (pressed * frames).sum(axis=1) / noise) / weight
    left = ((frames - gain[:, None] * pressed) ** 2).sum(axis=(1, 2)) / noise
    left += (((gain - 1) / _GAINS) ** 2 + np.log(weight * _GAINS**2)).sum(axis=1) + ((load - _LOAD) / 12) ** 2
    left += (poses[:, 2] / 0.15) ** 2
    best = int(np.nan_to_num(left, nan=np.inf).argmin())
    return float(np.nan_to_num(left[best], nan=np.inf)), poses[best]


def surprises(things: list[Thing], press: Floats) -> Floats:
    """Return how badly each thing explains a press, infinite where it is far from the best."""
    loaded = (press - press[:2].mean(axis=0)).reshape(len(press), -1)[2:-2]
    far = np.arange(-3.2, 3.21, 0.4)
    everywhere = np.array(list(product(far, far, (-0.15, 0.0, 0.15))))
    first = [surprise(thing, everywhere, loaded) for thing in things]
    found = np.full(len(things), np.inf)
    for k in np.argsort([left for left, _ in first])[:_LIKELY]:
        left, pose = first[k]
        for place, turn in _STEPS:
            near = pose + np.array(list(product((-place, 0.0, place), (-place, 0.0, place), (-turn, 0.0, turn))))
            closer, pose = surprise(things[k], near, loaded)
            left = min(left, closer)
        found[k] = left
    return found


def measure(seed: int) -> dict[str, float]:
    """Return the figures of the seed of `learn_days`."""
    rng, things, one, two = draw_all(_SHAPE, seed)
    presses(things[:THINGS], one, PRESSES, rng)
    presses(things[:THINGS], one, TESTED, rng)
    other, truth = presses(things[:THINGS], two, TESTED, rng)
    strangers, _ = presses(things[THINGS:], two, TESTED, rng)
    known, strange = (
        np.array([surprises(things[:THINGS], press) for press in some[: _EACH * THINGS]]) for some in (other, strangers)
    )
    right = known.argmin(axis=1) == truth[: len(known)]
    explained = np.isfinite(known.min(axis=1))
    p = np.exp(-0.5 * (known - np.where(explained, known.min(axis=1), 0.0)[:, None]))
    sure = explained & (p.max(axis=1) > 0.9 * p.sum(axis=1))
    limit = np.quantile(known.min(axis=1), 0.95)
    return {
        "right on the other day": float(right.mean()),
        "given with p > .9": float(sure.mean()),
        "of these right": float(right[sure].mean()),
        "strangers refused where 5 % of known things are": float((strange.min(axis=1) > limit).mean()),
    }


def main() -> None:
    """Print the figures."""
    seeds = next((int(word) for word in sys.argv[1:] if word.isdigit()), SEEDS)
    found = [measure(seed) for seed in range(seeds)]
    print(f"{_SHAPE[0]} x {_SHAPE[1]} taxels, each thing's form known, {_EACH} presses of each, mean of {seeds} seeds")
    for name in found[0]:
        print(f"  {name}: {share(name, float(np.nanmean([each[name] for each in found])))}")


if __name__ == "__main__":
    main()
