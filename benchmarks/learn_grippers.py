"""Things much alike, learned on one day from the pads of a gripper and told on another; and things pressed seldom.

What a gripper holds is a ball, a rod, a block or a coin, as its size has it, on every pad at a place of its own and as
hard as it is firm; grips of a day scatter by as much as things differ. Another day the hand sits two or three taxels
elsewhere, presses a quarter or two fifths less, and gains have drifted by 10 %: things lie where others lay. Nothing is
said of sessions. Then pads on which half the things were pressed 40 or 30 times and the others 4 times or twice, asked
on that day and on another a taxel elsewhere. Surfaces, a cover that spreads the pressure and days are drawn here and
nowhere else.

Run: python -m benchmarks.learn_grippers [SEEDS]
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.ndimage import gaussian_filter

from benchmarks._figures import share
from varishold import TactileClassifier

SEEDS = 3
GRIPPERS = ((2, 6, 14), (3, 5, 9), (5, 4, 4))
#: How many things are known and how many strange, how many taxels elsewhere another day is, and its share of the load.
HELD = {"24 things, two taxels elsewhere": (20, 4, 2.0, 0.75), "12 things, three taxels elsewhere": (8, 4, 3.0, 0.6)}
#: The pads of what is pressed seldom, and how often things are pressed.
SELDOM_PADS = ((1, 5, 9), (1, 16, 16), (2, 6, 8), (3, 4, 4))
OFTEN = {"40 and 4 presses": [40] * 4 + [4] * 4, "30 and 2 presses": [30] * 3 + [2] * 5}
PRESSES, TESTED = 10, 10
_FORMS = ("ball", "rod", "block", "coin")
_N_FRAMES, _NOISE, _SPREAD = 20, 4.0, 0.7
Press = tuple[np.ndarray, np.ndarray]


@dataclass(frozen=True)
class Held:
    """A thing as the pads feel it: form and size, where on each pad, how firm it is and how slowly it is gripped."""

    form: str
    radius: float
    turn: float
    places: np.ndarray
    firm: float
    slow: float

    def gap(self, x: np.ndarray, y: np.ndarray, turn: float) -> np.ndarray:
        """Return how far below its highest point the surface lies."""
        along, across = np.cos(turn) * x + np.sin(turn) * y, np.cos(turn) * y - np.sin(turn) * x
        if self.form == "ball":
            return (x * x + y * y) / (2 * self.radius)
        if self.form == "rod":
            return along * along / (2 * self.radius)
        if self.form == "block":
            return 4 * sum(np.maximum(np.abs(u) - self.radius / by, 0) for u, by in ((along, 2), (across, 1.4)))
        return 4 * np.maximum(np.hypot(x, y) - self.radius / 2, 0)


@dataclass(frozen=True)
class Day:
    """Where the hand sits on a day, what share of the usual load it has, and the gain and rest of its taxels."""

    moved: np.ndarray
    load: float
    gain: np.ndarray
    rest: np.ndarray


def draw_held(rng: np.random.Generator, pads: tuple[int, int, int]) -> Held:
    """Return a thing for pads of a shape."""
    radius = rng.uniform(0.35, 1.2) * min(pads[1:])
    places, firm, slow = rng.normal(0, 1.5, (pads[0], 2)), np.exp(rng.normal(0, 0.3)), np.exp(rng.normal(0, 0.2))
    return Held(str(rng.choice(_FORMS)), radius, rng.uniform(0, np.pi), places, float(firm), float(slow))


def draw_days(rng: np.random.Generator, pads: tuple[int, int, int], moved: float, load: float) -> tuple[Day, Day]:
    """Return the day that is learned and another."""
    gain, way = np.exp(rng.normal(0, 0.08, pads)), rng.uniform(0, 2 * np.pi)
    two = gain * np.exp(rng.normal(0, 0.1, pads))
    rest = rng.uniform(5, 25, (2, *pads))
    where = moved * np.array([np.cos(way), np.sin(way)])
    return Day(np.zeros(2), 1.0, gain, rest[0]), Day(where, load, two, rest[1])


def press(thing: Held, day: Day, rng: np.random.Generator) -> Press:
    """Return frames of shape (n_frames, pads, rows, cols) and their times."""
    at = np.linspace(0, 1, _N_FRAMES)
    load = 1.2 * day.load * thing.firm * np.exp(rng.normal(0, 0.2))
    depth = load * np.clip((at - 0.15) / (0.5 * thing.slow * np.exp(rng.normal(0, 0.08))), 0, 1)
    turn, moved = thing.turn + rng.normal(0, 0.08), day.moved + rng.normal(0, 0.8, 2)
    frames = np.zeros((_N_FRAMES, *day.gain.shape))
    row, col = np.indices(day.gain.shape[1:]) - (np.array(day.gain.shape[1:])[:, None, None] - 1) / 2
    for pad, place in enumerate(thing.places):
        dx, dy = place + moved + rng.normal(0, 0.15, 2)
        pressed = np.maximum(depth[:, None, None] - thing.gap(col - dx, row - dy, turn), 0)
        frames[:, pad] = 300 * gaussian_filter(pressed, (0, _SPREAD, _SPREAD))
    frames = frames * day.gain + day.rest + rng.normal(0, _NOISE, frames.shape)
    return np.clip(np.round(frames), 0, 4000), 2 * at


def presses(things: Sequence[Held], day: Day, often: Sequence[int], rng: np.random.Generator) -> list[Press]:
    """Return presses of things, each so often, as far as there are any left in turn."""
    return [press(things[k], day, rng) for k in in_turn(often)]


def in_turn(often: Sequence[int]) -> list[int]:
    """Return which thing is pressed when."""
    return [k for turn in range(max(often)) for k, n in enumerate(often) if turn < n]


def answered(clf: TactileClassifier, new: list[Press], truth: Sequence[int]) -> dict[str, float]:
    """Return how many are right, how sure, and how many are both sure and wrong."""
    p, usual = clf.judge(new)
    right = clf.classes_[p.argmax(axis=1)] == np.array(truth)
    sure = (p.max(axis=1) > 0.9) & (usual > clf.error)
    return {
        "right": float(right.mean()),
        "given with p > .9": float(sure.mean()),
        "given with p > .9 and wrong": float((sure & ~right).mean()),
    }


def measure_alike(pads: tuple[int, int, int], of: tuple[int, int, float, float], seed: int) -> dict[str, float]:
    """Return the figures of a gripper whose things are much alike."""
    known, strange, moved, load = of
    rng = np.random.default_rng((1974, seed, *pads, known))
    things = [draw_held(rng, pads) for _ in range(known + strange)]
    one, two = draw_days(rng, pads, moved, load)
    often = [PRESSES] * known
    clf = TactileClassifier().fit(presses(things, one, often, rng), in_turn(often))
    found = {}
    for when, day in (("the same day", one), ("another day", two)):
        tested = [TESTED] * known
        said = answered(clf, presses(things, day, tested, rng), in_turn(tested))
        found |= {f"{what}, {when}": value for what, value in said.items()}
    strangers = presses(things[known:], two, [TESTED] * strange, rng)
    p, usual = clf.judge(strangers)
    return found | {
        "strangers named with p > .9, another day": float(((p.max(axis=1) > 0.9) & (usual > clf.error)).mean())
    }


def measure_seldom(pads: tuple[int, int, int], often: Sequence[int], seed: int) -> dict[str, float]:
    """Return the figures of things of which some were pressed seldom."""
    rng = np.random.default_rng((1975, seed, *pads, *often))
    things = [draw_held(rng, pads) for _ in often]
    one, two = draw_days(rng, pads, 1.0, 0.75)
    clf = TactileClassifier().fit(presses(things, one, often, rng), in_turn(often))
    tested = [TESTED] * len(often)
    new = [*presses(things, one, tested, rng), *presses(things, two, tested, rng)]
    return answered(clf, new, in_turn(tested) * 2)


def main() -> None:
    """Print the figures."""
    seeds = next((int(word) for word in sys.argv[1:] if word.isdigit()), SEEDS)
    for how, of in HELD.items():
        each = [measure_alike(pads, of, seed) for pads in GRIPPERS for seed in range(seeds)]
        print(f"{how}, mean of {len(GRIPPERS)} grippers and {seeds} seeds")
        for what in each[0]:
            print(f"  {what}: {share(f'{how}: {what}', float(np.mean([one[what] for one in each])))}", flush=True)
    for how, often in OFTEN.items():
        found = [measure_seldom(pads, often, seed) for pads in SELDOM_PADS for seed in range(seeds)]
        print(f"{how}, mean of {len(SELDOM_PADS)} sets of pads and {seeds} seeds")
        for what in found[0]:
            print(f"  {what}: {share(f'{how}: {what}', float(np.mean([one[what] for one in found])))}", flush=True)


if __name__ == "__main__":
    main()
