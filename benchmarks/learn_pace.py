"""Things learned at one pace and told at others: half as fast and twice as fast, on another day.

Pads, things and days are those of `learn_days`, a fingertip of 5 x 9 and a mat of 16 x 16, with times: each thing is
pressed in its own, as softer ones take longer, and on day two all of them also twice and half as long. How long a press
takes then tells of the hand, not of the thing.

Run: python -m benchmarks.learn_pace [SEEDS]
"""

from __future__ import annotations

import sys

import numpy as np

from benchmarks._figures import share
from benchmarks.learn_days import PRESSES, TESTED, THINGS, Day, Thing, draw_days, draw_thing, press
from varishold import TactileClassifier

SEEDS = 3
SHAPES = ((5, 9), (16, 16))
#: What is told of each pace, by how many times as long the presses of day two take.
PACES = {"the same pace": 1.0, "half as fast": 2.0, "twice as fast": 0.5}
_A_FRAME_S, _MOST_SLOWER, _SCATTER = 0.02, 1.4, 0.15
Presses = tuple[list[tuple[np.ndarray, np.ndarray]], np.ndarray]


def presses(
    things: list[tuple[Thing, float]], day: Day, each: int, rng: np.random.Generator, longer: float = 1.0
) -> Presses:
    """Return presses of all things in turn, frames and times, and which is which."""
    found = []
    for thing, slower in things * each:
        frames = press(thing, day, rng)
        takes = _A_FRAME_S * slower * longer * float(np.exp(rng.normal(0, _SCATTER)))
        found.append((frames, takes * np.arange(len(frames))))
    return found, np.tile(np.arange(len(things)), each)


def measure(shape: tuple[int, int], seed: int) -> dict[str, float]:
    """Return the figures of a pad and a seed, nothing said of sessions."""
    rng = np.random.default_rng((1973, seed, *shape))
    things = [(draw_thing(rng, shape), _MOST_SLOWER ** rng.uniform(-1, 1)) for _ in range(THINGS)]
    one, two = draw_days(rng, shape)
    clf = TactileClassifier().fit(*presses(things, one, PRESSES, rng))
    found = {}
    for pace, longer in PACES.items():
        X, truth = presses(things, two, TESTED, rng, longer)
        p = clf.predict_proba(X)
        right, sure = p.argmax(axis=1) == truth, p.max(axis=1) > 0.9
        found |= {
            f"right, {pace}": float(right.mean()),
            f"given with p > .9, {pace}": float(sure.mean()),
            f"given with p > .9 and wrong, {pace}": float((sure & ~right).mean()),
        }
    return found


def main() -> None:
    """Print the figures."""
    seeds = next((int(word) for word in sys.argv[1:] if word.isdigit()), SEEDS)
    for shape in SHAPES:
        each = [measure(shape, seed) for seed in range(seeds)]
        pad = f"{shape[0]} x {shape[1]}"
        print(f"{pad} taxels, {THINGS} things, {PRESSES} presses each, another day, mean of {seeds} seeds")
        for what in each[0]:
            print(f"  {what}: {share(f'{pad}: {what}', float(np.mean([of[what] for of in each])))}", flush=True)


if __name__ == "__main__":
    main()
