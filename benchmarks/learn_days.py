"""Ten things learned from ten presses each on one day, and tested on the same day and on another, on simulated pads.

Day two is another seed of everything: the gains of the taxels have drifted by 10 %, their rests have moved, everything
lies two taxels elsewhere and is pressed 25 % less; strangers are ten other things. A mat of 28 x 50 taxels, a
fingertip of 5 x 9, and a hand of three pads of 8 x 10 that hold a thing between them: each feels a form of its own, and
on day two the hand sits a taxel elsewhere and each pad one more. Forms and sensor are drawn here and nowhere else.

Run: python -m benchmarks.learn_days [SEEDS]
"""

from __future__ import annotations

import sys
from dataclasses import dataclass, replace

import numpy as np

from benchmarks._figures import figure, share
from varishold import TactileClassifier

SEEDS = 3
SHAPES = ((28, 50), (5, 9))
PADS, PAD_SHAPE = 3, (8, 10)
THINGS, PRESSES, TESTED = 10, 10, 20
_NOISE, _DRIFT, _LIGHTER, _ELSEWHERE = 0.01, 0.1, 0.75, 2.0


@dataclass(frozen=True)
class Thing:
    """A rounded outline |u|^n + |v|^n < 1 with a dome, and perhaps a hole or a second part."""

    sides: tuple[float, float]
    exponent: float
    dome: float
    hole: float
    apart: float

    def pressure(self, x: np.ndarray, y: np.ndarray, depth: float) -> np.ndarray:
        """Return the pressure where the thing is pressed so deep, 1 the most."""
        found = np.zeros(x.shape)
        for side in (-0.5, 0.5) if self.apart else (0.0,):
            u, v = (x - side * self.apart) / self.sides[0], y / self.sides[1]
            r = (np.abs(u) ** self.exponent + np.abs(v) ** self.exponent) ** (1 / self.exponent)
            found = np.maximum(found, np.where(r < 1, 1 - self.dome * r**2, 0.0) * (r >= self.hole))
        return np.maximum(found - (1 - depth) * self.dome, 0.0)


@dataclass(frozen=True)
class Day:
    """What a pad and a hand are like on a day."""

    gain: np.ndarray
    rest: np.ndarray
    place: tuple[float, float]
    load: float


def draw_thing(rng: np.random.Generator, shape: tuple[int, int]) -> Thing:
    """Return a thing that fits the pad."""
    small = 0.5 * min(shape)
    sides = (small * rng.uniform(0.35, 0.8), small * rng.uniform(0.35, 0.8))
    hole = rng.choice([0.0, 0.5], p=[0.75, 0.25])
    apart = rng.choice([0.0, 2.4 * sides[0]], p=[0.75, 0.25])
    return Thing(sides, float(rng.choice([1.0, 2.0, 6.0])), rng.uniform(0.2, 0.95), float(hole), float(apart))


def draw_days(rng: np.random.Generator, shape: tuple[int, int]) -> tuple[Day, Day]:
    """Return day one and day two."""
    gain = np.exp(rng.normal(0, 0.05, shape))
    way = rng.uniform(0, 2 * np.pi)
    moved = (_ELSEWHERE * np.cos(way), _ELSEWHERE * np.sin(way))
    one = Day(gain, rng.normal(0, 2, shape), (0.0, 0.0), 1.0)
    two = Day(gain * np.exp(rng.normal(0, _DRIFT, shape)), rng.normal(3, 4, shape), moved, _LIGHTER)
    return one, two


def draw_course(rng: np.random.Generator) -> tuple[np.ndarray, float]:
    """Return how deep a thing is pressed from frame to frame, 1 the most, and how hard beside the usual."""
    rise = np.sort(rng.uniform(0.1, 1.0, int(rng.integers(8, 14))))
    return np.concatenate([[0.0, 0.0], rise, [1.0, 1.0, 0.4, 0.0]]), rng.uniform(0.85, 1.15)


def press(
    thing: Thing, day: Day, rng: np.random.Generator, course: tuple[np.ndarray, float] | None = None
) -> np.ndarray:
    """Return the frames of a press: rest, rise, holding, letting go."""
    row, col = np.indices(day.gain.shape) - (np.array(day.gain.shape)[:, None, None] - 1) / 2
    x, y = col - day.place[0] - rng.normal(0, 0.7), row - day.place[1] - rng.normal(0, 0.7)
    yaw = rng.normal(0, 0.15)
    x, y = np.cos(yaw) * x + np.sin(yaw) * y, np.cos(yaw) * y - np.sin(yaw) * x
    depths, hard = draw_course(rng) if course is None else course
    load = 100 * day.load * hard
    frames = np.stack([load * d * thing.pressure(x, y, d) for d in depths])
    return np.asarray(day.gain * frames + day.rest + rng.normal(0, 100 * _NOISE, frames.shape))


def presses(things: list[Thing], day: Day, each: int, rng: np.random.Generator) -> tuple[list[np.ndarray], np.ndarray]:
    """Return presses of all things in turn, and which is which."""
    return [press(thing, day, rng) for _ in range(each) for thing in things], np.tile(np.arange(len(things)), each)


def draw_hands(rng: np.random.Generator) -> tuple[list[Day], list[Day]]:
    """Return the pads of a hand on day one and on day two."""
    days = [draw_days(rng, PAD_SHAPE) for _ in range(PADS)]
    hand = draw_days(rng, PAD_SHAPE)[1].place
    # Half of two taxels elsewhere all together, and each pad as far again in a way of its own.
    places = [((hand[0] + two.place[0]) / 2, (hand[1] + two.place[1]) / 2) for _, two in days]
    return [one for one, _ in days], [replace(two, place=at) for (_, two), at in zip(days, places, strict=True)]


def grips(
    things: list[list[Thing]], hand: list[Day], each: int, rng: np.random.Generator
) -> tuple[list[np.ndarray], np.ndarray]:
    """Return grips of all things in turn, frames of shape (n_frames, pads, rows, cols), and which is which."""
    found = []
    for forms in things * each:
        course = draw_course(rng)
        pads = [press(form, day, rng, course) for form, day in zip(forms, hand, strict=True)]
        found.append(np.stack(pads, axis=1))
    return found, np.tile(np.arange(len(things)), each)


def measure_hand(seed: int) -> dict[str, float]:
    """Return the figures of a hand and a seed, nothing said of sessions."""
    rng = np.random.default_rng((1972, seed, PADS, *PAD_SHAPE))
    things = [[draw_thing(rng, PAD_SHAPE) for _ in range(PADS)] for _ in range(2 * THINGS)]
    one, two = draw_hands(rng)
    clf = TactileClassifier().fit(*grips(things[:THINGS], one, PRESSES, rng))
    found = {}
    for when, hand in (("the same", one), ("the other", two)):
        known, truth = grips(things[:THINGS], hand, TESTED, rng)
        strangers, _ = grips(things[THINGS:], hand, TESTED, rng)
        (p, usual), (strange, rare) = clf.judge(known), clf.judge(strangers)
        right, sure = p.argmax(axis=1) == truth, p.max(axis=1) > 0.9
        found |= {
            f"right on {when} day": float(right.mean()),
            f"given with p > .9 on {when} day": float(sure.mean()),
            f"of {when} day, given with p > .9 and wrong": float((sure & ~right).mean()),
            f"known things refused on {when} day": float((usual <= clf.error).mean()),
            f"strangers refused on {when} day": float((rare <= clf.error).mean()),
            f"strangers of {when} day, named with p > .9": float((strange.max(axis=1) > 0.9).mean()),
        }
    return found


def draw_all(shape: tuple[int, int], seed: int) -> tuple[np.random.Generator, list[Thing], Day, Day]:
    """Return what draws the presses, things and then strangers, day one and day two."""
    rng = np.random.default_rng((1971, seed, *shape))
    things = [draw_thing(rng, shape) for _ in range(2 * THINGS)]
    return rng, things, *draw_days(rng, shape)


def measure(shape: tuple[int, int], seed: int) -> dict[str, float]:
    """Return the figures of one pad and seed."""
    rng, things, one, two = draw_all(shape, seed)
    known = presses(things[:THINGS], one, PRESSES, rng)
    clf = TactileClassifier().fit(*known)
    same, same_truth = presses(things[:THINGS], one, TESTED, rng)
    other, truth = presses(things[:THINGS], two, TESTED, rng)
    strangers, _ = presses(things[THINGS:], two, TESTED, rng)
    there = TactileClassifier().fit(*presses(things[:THINGS], two, PRESSES, rng))
    placed = TactileClassifier(position=True, absolute=True).fit(*known)
    adapted = placed.adapt(other)
    p, known = clf.judge(other)
    right, top = p.argmax(axis=1) == truth, p.max(axis=1)
    sure = top > 0.9
    strange = clf.p_values(strangers)
    return {
        "right on the same day": float((clf.predict(same) == same_truth).mean()),
        "right on the other day": float(right.mean()),
        "right there where that day itself was learned": float((there.predict(other) == truth).mean()),
        "the same, place and load learned too": float((placed.predict(other) == truth).mean()),
        "the same, adapted to the unlabelled presses of that day": float((adapted.predict(other) == truth).mean()),
        "given with p > .9 on the other day": float(sure.mean()),
        "of these right": float(right[sure].mean()) if sure.any() else float("nan"),
        "mean p less the share right": float(top.mean() - right.mean()),
        "known things refused on the other day": float((known <= clf.error).mean()),
        "strangers refused": float((strange <= clf.error).mean()),
        "strangers refused where 5 % of known things of that day are": float(
            (strange <= np.quantile(known, 0.05)).mean()
        ),
    }


def main() -> None:
    """Print the figures."""
    seeds = next((int(word) for word in sys.argv[1:] if word.isdigit()), SEEDS)
    bars = {
        "given with p > .9 on the other day": ">= 40",
        "of these right": ">= 90",
        "strangers refused where 5 % of known things of that day are": ">= 85",
    }
    for shape in SHAPES:
        title = f"{shape[0]} x {shape[1]}"
        found = [measure(shape, seed) for seed in range(seeds)]
        means = {name: float(np.nanmean([each[name] for each in found])) for name in found[0]}
        print(f"{title} taxels, {THINGS} things, {PRESSES} presses each, mean of {seeds} seeds")
        for name, value in means.items():
            print(f"  {name}: {share(f'{title}: {name}', value, bar=bars.get(name, ''))}")
        ratio = means["right on the other day"] / means["right on the same day"]
        print(f"  of the same day's share: {figure(f'{title}: share of the same day', ratio, '.3f', bar='>= .9')}")
    found = [measure_hand(seed) for seed in range(seeds)]
    title = f"a hand of {PADS} pads of {PAD_SHAPE[0]} x {PAD_SHAPE[1]}"
    print(f"{title} taxels, {THINGS} things, {PRESSES} grips each, mean of {seeds} seeds")
    for name in found[0]:
        mean = float(np.mean([each[name] for each in found]))
        bar = "<= 15" if name == "known things refused on the other day" else ""
        print(f"  {name}: {share(f'{title}: {name}', mean, bar=bar)}")


if __name__ == "__main__":
    main()
