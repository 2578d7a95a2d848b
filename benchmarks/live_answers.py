"""Answers pooled over a press, beside those of its single frames: errors, calibration, sure and wrong.

Presses of the yardstick's faces (height maps) with its noise and tilts: the depth rises in .1 s, holds .6 s and falls
again, 50 frames a second, with fresh noise in every frame. "hand": the face's angle wanders by up to 1.5 degrees, its
place by up to a quarter of a taxel. "vice": neither does, and what the first frame does to recognition all others do
again; only noise is left to be averaged. "One frame" is the largest contact of six frames of the hold, "pooled" what
the tracker says of its heaviest touch when the hold ends.

Of a hundred answers to the counted rows one or two are wrong: it takes thousands of presses to compare them.

Seeds: 3, 4, 5, 6, 21, 33, 77 and 78 were looked at while building; the default was not.

    python -m benchmarks.live_answers [--seed N] [--seeds N] [--quick] [--row NAME] [--side N] [--only hand|vice]
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from benchmarks._figures import figure, share
from benchmarks.touch_distortions import calibration_error
from varishold.evaluation.yardstick.forms import ENDLESS, KINDS, Face, draw_face
from varishold.evaluation.yardstick.media import cell_centres, height_map
from varishold.evaluation.yardstick.rows import NOISE, ROWS, Row, as_one
from varishold.touch import ContactTracker, Surface, find_contacts, recognize

FINAL_SEED = 79
#: Presses of each kind in a counted row and in another one; a quick run takes a sixth.
PER_KIND = {"hand": (72, 12), "vice": (24, 6)}
SIDES = (32, 16)
RATE_HZ = 50
RISE, HOLD = 5, 30
#: Rows whose errors are counted, and rows that show what becomes of other faults.
COUNTED = ("clean", "tilt 5 degrees", "tilt 10 degrees")
OTHERS = ("gain spread 20 %", "bad mix")
WANDERS = {"hand": (1.5, 0.25), "vice": (0.0, 0.0)}
SURE = 0.9
# A frame with fewer loaded taxels is drawn again, as in the yardstick.
_LEAST_TAXELS = {32: 24, 16: 11}


@dataclass
class Answers:
    """Answers to presses: the probability of each, and whether it is right."""

    probability: list[float] = field(default_factory=list)
    right: list[bool] = field(default_factory=list)

    def add(self, surface: Surface | None, truth: tuple[str, ...]) -> None:
        """Add an answer; none is unknown."""
        names: dict[str, float] = {}
        for name, p in ({"unknown": 1.0} if surface is None else surface.names).items():
            names[as_one(name)] = names.get(as_one(name), 0.0) + p
        best = max(names, key=names.__getitem__)
        self.probability.append(names[best])
        self.right.append(best in truth)

    def extend(self, others: Answers) -> None:
        """Add answers."""
        self.probability += others.probability
        self.right += others.right

    def told(self, of: str) -> str:
        """Return errors, calibration error and sure errors as they are printed."""
        p, right = np.array(self.probability), np.array(self.right)
        sure = float(np.mean(~right & (p > SURE)))
        return (
            f"wrong {share(f'{of}: wrong', self.wrong, '5.2f')}"
            f"  calibration error {figure(f'{of}: calibration error', calibration_error(p, right), '.3f')}"
            f"  wrong with p > .9 {share(f'{of}: wrong with p > .9', sure, '.2f')}"
        )

    @property
    def wrong(self) -> float:
        """Share of wrong answers."""
        return 1 - float(np.mean(self.right))


def clean_press(rng: np.random.Generator, face: Face, side: int, wanders: tuple[float, float]) -> np.ndarray:
    """Return the frames of a press without fault; the peak of the middle one is 1."""
    full = height_map(face, side)
    x, y = cell_centres(side, 1)
    middle_x, middle_y = (float((full * at).sum() / full.sum()) for at in (x, y))
    rise = np.linspace(0, 1, RISE + 2)[1:-1]
    shares = np.concatenate([rise, np.ones(HOLD), rise[::-1]])
    phase = rng.uniform(0, 2 * np.pi, 4)
    frames = []
    for i, depth in enumerate(shares):
        if wanders == (0.0, 0.0) and depth == 1:
            frames.append(full)
            continue
        seconds = i / RATE_HZ
        waves = np.sin(2 * np.pi * np.array([1.3, 1.7, 1.1, 1.9]) * seconds + phase)
        lean_x, lean_y = np.tan(np.radians(wanders[0] * waves[:2]))
        dx, dy = wanders[1] * waves[2:]
        frames.append(height_map(_moved(face, dx, dy, lean_x, lean_y, (middle_x, middle_y), depth), side))
    return np.array(frames) / full.max()


def _moved(
    face: Face, dx: float, dy: float, lean_x: float, lean_y: float, about: tuple[float, float], depth: float
) -> Face:
    """Return a face that is shifted, leans about a point, and is pressed by a share of its depth."""

    def gap(x: np.ndarray, y: np.ndarray) -> np.ndarray:
        return face.gap(x - dx, y - dy) + lean_x * (x - about[0]) + lean_y * (y - about[1])

    return replace(face, gap=gap, depth=face.depth * depth)


def read_press(rng: np.random.Generator, clean: np.ndarray, row: Row) -> np.ndarray:
    """Return what a sensor says of a press: its faults stay, its noise is new in every frame."""
    faults = int(rng.integers(1 << 30))
    side = clean.shape[1]
    read = []
    for frame in clean:
        same = np.random.default_rng(faults)
        said = frame[None]
        for fault in row.before:
            said = fault(said, same)
        said = said + NOISE[side] * rng.standard_normal(said.shape)
        for fault in row.after:
            said = fault(said, same)
        read.append(said[0])
    return np.array(read)


def pooled(frames: np.ndarray) -> Surface | None:
    """Return what the tracker says of the heaviest touch at the end of the hold."""
    tracker = ContactTracker()
    for i, frame in enumerate(frames[: RISE + HOLD]):
        tracker.update(i / RATE_HZ, find_contacts(frame), frame)
    heaviest = max(tracker.tracks, key=lambda track: track.peak_load, default=None)
    return None if heaviest is None else heaviest.answer


def draw(seed: int, row: Row, side: int, kind: str, index: int) -> Face:
    """Return a face that leaves enough taxels loaded."""
    for attempt in range(100):
        face = draw_face((seed, side, 0, KINDS.index(kind), index, attempt), kind, index, side, row.change)
        if face is None:
            continue
        frame = height_map(face, side)
        least = _LEAST_TAXELS[side] if kind not in ENDLESS else side
        if np.count_nonzero(frame > 0.1 * frame.max()) >= least:
            return face
    raise RuntimeError(f"no {kind} fits on {side} x {side} taxels")


def measure(seed: int, row: Row, side: int, wander: str, per_kind: int) -> tuple[Answers, Answers]:
    """Return the answers of single frames and the pooled ones."""
    one, all_of = Answers(), Answers()
    rng = np.random.default_rng([seed, side, len(wander), *row.name.encode()])
    for kind in KINDS:
        for index in range(per_kind):
            clean = clean_press(rng, draw(seed, row, side, kind, index), side, WANDERS[wander])
            truth = _truth(row, as_one(kind), clean[RISE])
            frames = read_press(rng, clean, row)
            all_of.add(pooled(frames), truth)
            for frame in frames[RISE : RISE + HOLD : HOLD // 6]:
                contacts = find_contacts(frame)
                one.add(recognize(contacts[0]) if contacts else None, truth)
    return one, all_of


def _truth(row: Row, kind: str, clean: np.ndarray) -> tuple[str, ...]:
    if kind == "plane" and row.change.tilt > 0:
        return ("plane", "edge") if clean.min() > 0 else ("edge",)
    return (kind, *row.also.get(kind, ()))


def main(argv: Sequence[str] = ()) -> None:
    """Print both kinds of answers, row by row."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--seed", type=int, default=FINAL_SEED)
    parser.add_argument("--seeds", type=int, default=1, help="this and so many that follow, together")
    parser.add_argument("--only", choices=list(WANDERS), help="how the face is held")
    parser.add_argument("--quick", action="store_true", help="a sixth of the presses")
    parser.add_argument("--side", type=int, choices=SIDES, action="append", help="only pads of this many taxels a side")
    parser.add_argument("--row", action="append", help="only rows whose name holds this")
    asked = parser.parse_args(list(argv))
    sides = asked.side or SIDES
    rows = [row for row in ROWS if row.name in (*COUNTED, *OTHERS)]
    rows = [row for row in rows if not asked.row or any(part in row.name for part in asked.row)]
    seeds = range(asked.seed, asked.seed + asked.seeds)
    for wander in [asked.only] if asked.only else WANDERS:
        counted, other = (max(n // 6, 1) if asked.quick else n for n in PER_KIND[wander])
        each = [13 * n * len(seeds) for n in (counted, other)]
        print(f"{wander}: {each[0]} presses a counted row and side, {each[1]} another, from seed {asked.seed} on")
        total = Answers(), Answers()
        for row in rows:
            for side in sides:
                both, per_kind = (Answers(), Answers()), counted if row.name in COUNTED else other
                for seed in seeds:
                    for sum_of, answers in zip(both, measure(seed, row, side, wander, per_kind), strict=True):
                        sum_of.extend(answers)
                for name, answers in zip(("one frame", "pooled"), both, strict=True):
                    of = f"{wander}, {row.name}, {side} x {side}, {name}"
                    print(f"  {of:48} {answers.told(of)}")
                if row.name in COUNTED:
                    for sum_of, answers in zip(total, both, strict=True):
                        sum_of.extend(answers)
        if total[0].right:
            bar = "<= .5" if wander == "hand" else ""
            for name, answers in zip(("one frame", "pooled"), total, strict=True):
                of = f"{wander}, noise and tilt, {name}"
                print(f"  {of.upper():48} {answers.told(of)}")
            ratio = total[1].wrong / max(total[0].wrong, 1e-9)
            print(f"  pooled errors over one frame's: {figure(f'{wander}: ratio of errors', ratio, '.2f', bar=bar)}")


if __name__ == "__main__":
    main(sys.argv[1:])
