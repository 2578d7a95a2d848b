"""Names of presses of which some readings are no readings: spikes, lines, frames lost or full, what sticks, and hum.

So are rests with a form of their own, and readings below zero that are stored without a sign.

Faces are drawn by the yardstick, 11 kinds, edges and planes apart, on height maps and in a thin cover; each is pressed
once, over 41 frames, and is to be one press with one right name, whatever the wire did. Then frames alone, in which a
taxel of the contact sticks high, or rows and columns rest unlike: nothing in time tells it.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence

import numpy as np

from benchmarks._figures import figure
from benchmarks._scores import Scores
from benchmarks.touch_distortions import SIDES
from varishold.evaluation.yardstick.forms import ENDLESS, Change
from varishold.evaluation.yardstick.media import clean_frames
from varishold.evaluation.yardstick.rows import NOISE
from varishold.recording import Pad, Recording
from varishold.touch import find_contacts, recognize, recognize_recording

SEED = 1971
FRAMES_PER_KIND = 10
#: How high the load is at each frame.
COURSE = np.r_[np.zeros(12), np.linspace(0.1, 1.0, 10), np.ones(6), np.linspace(0.8, 0.0, 5), np.zeros(8)]
#: What a reading shows that is none, in parts of the peak.
FULL = 1.2
#: Share of all readings that are spikes.
SPIKES = 0.0005
#: Frames before the press from one of which on something sticks.
STICKS = (5, 9)
#: How far all taxels go together, or each row for itself, in parts of the peak, and by how many radians a frame.
HUM, PACE = 0.025, 2.1
WAYS = (
    *("nothing", "a spike", "many spikes", "a line", "a frame lost", "a frame full"),
    *("a taxel that sticks", "a line that sticks", "hum", "rows that flicker"),
    *("a rest that bends", "rows that rest unlike", "a wrinkle at rest", "no sign"),
)
#: What a pad shows at rest, in parts of the peak: bent over its breadth, row by row, or along a wrinkle.
BENT, UNLIKE, WRINKLE = 0.15, 0.05, 0.15
#: Counts of a peak that is stored without a sign, and of the noise at least.
COUNTS = 400.0
#: What a hot taxel shows in a frame alone, in parts of the peak; it is one where the contact shows more than this.
HOT = {f"hot taxel at {high:g}": high for high in (1.3, 2.0, 4.0)}
WITHIN = 0.15
#: How far rows, and columns, of such a frame rest off each other, in parts of the peak.
UNEVEN = 0.03
ROWS, LINES = "rows that rest unlike", "rows and columns that rest unlike"


def spoiled(frames: np.ndarray, how: str, rng: np.random.Generator) -> np.ndarray:
    """Return frames with what a sensor's wire does to some of them."""
    made, (n, rows, cols) = frames.copy(), frames.shape
    if how == "a spike":
        made[rng.integers(n), rng.integers(rows), rng.integers(cols)] = FULL
    elif how == "many spikes":
        made[rng.random(made.shape) < SPIKES] = FULL
    elif how == "a line":
        made[rng.integers(n), rng.integers(rows)] = FULL
    elif how == "a frame lost":
        made[rng.integers(n)] = 0.0
    elif how == "a taxel that sticks":
        made[rng.integers(*STICKS) :, rng.integers(rows), rng.integers(cols)] = FULL
    elif how == "a line that sticks":
        made[rng.integers(*STICKS) :, rng.integers(rows)] = FULL
    elif how == "hum":
        made += HUM * np.sin(PACE * np.arange(n) + rng.uniform(0, 2 * np.pi))[:, None, None]
    elif how == "rows that flicker":
        made += rng.normal(0.0, HUM, (n, rows, 1))
    elif how == "a frame full":
        made[rng.integers(n)] = FULL
    elif how == "no sign":
        made = np.rint(COUNTS * made).astype(np.int64).astype(np.uint16)
    else:
        made += resting(how, (rows, cols), rng)
    return made


def resting(how: str, shape: tuple[int, int], rng: np.random.Generator) -> np.ndarray:
    """Return what a pad shows when nothing presses; shape (rows, cols)."""
    row, col = (2 * np.indices(shape) + 1) / np.array(shape)[:, None, None] - 1
    turn = rng.uniform(0, np.pi)
    along = row * np.cos(turn) + col * np.sin(turn)
    if how == "a rest that bends":
        return np.asarray(BENT * rng.choice([-1, 1]) * along**2)
    if how == "rows that rest unlike":
        return np.broadcast_to(rng.normal(0.0, UNLIKE, (shape[0], 1)), shape)
    if how == "a wrinkle at rest":
        return np.asarray(WRINKLE * np.exp(-(((along - rng.uniform(-0.8, 0.8)) / 0.12) ** 2)))
    return np.zeros(shape)


def alone(face: np.ndarray, how: str, rng: np.random.Generator) -> np.ndarray:
    """Return a noisy frame of a face, with what is wrong in it."""
    frame = face + rng.normal(0.0, NOISE[face.shape[0]], face.shape)
    if how in HOT:
        frame[tuple(rng.choice(np.argwhere(face > WITHIN)))] = HOT[how]
    else:
        frame += rng.normal(0.0, UNEVEN, (face.shape[0], 1))
        if how == LINES:
            frame += rng.normal(0.0, UNEVEN, (1, face.shape[1]))
    return frame


def name_alone(side: int, how: str, asked: argparse.Namespace) -> None:
    """Print the names of single frames, and the contacts that they have too many."""
    rng = np.random.default_rng([asked.seed, side])
    scores, too_many = Scores(), 0
    for medium in ("ideal", "cover"):
        faces, kinds = clean_frames(medium, side, Change(), asked.frames, asked.seed)
        for face, kind in zip(faces, kinds.tolist(), strict=True):
            if kind in ENDLESS:
                continue
            contacts = find_contacts(alone(face, how, rng))
            named = recognize(contacts[0]) if contacts else None
            scores.add(kind, named.name if named else "none", named.probability if named else 1.0)
            too_many += max(len(contacts) - 1, 0)
    print(f"{side} x {side} taxels, a frame alone, {how}:")
    scores.report(f"{side} x {side}, {how}")
    said = figure(f"{side} x {side}, {how}: contacts too many", 100 * too_many / len(scores.truth), ".1f", "a hundred")
    print(f"  contacts too many: {said} frames")


def main(argv: Sequence[str] = ()) -> None:
    """Print the figures."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--seed", type=int, default=SEED)
    parser.add_argument("--ways", nargs="*", choices=WAYS, default=WAYS, help="what is wrong; default: everything")
    parser.add_argument("--frames", type=int, default=FRAMES_PER_KIND, help="of each kind, on each of two media")
    asked = parser.parse_args(list(argv))
    for side in SIDES:
        for how in asked.ways:
            rng = np.random.default_rng([asked.seed, side])
            scores, once = Scores(), []
            for medium in ("ideal", "cover"):
                faces, kinds = clean_frames(medium, side, Change(), asked.frames, asked.seed)
                for face, kind in zip(faces, kinds.tolist(), strict=True):
                    if kind in ENDLESS:
                        continue
                    noisy = COURSE[:, None, None] * face + rng.normal(0.0, NOISE[side], (len(COURSE), *face.shape))
                    recording = Recording({"pad": Pad(spoiled(noisy, how, rng))})
                    answers = list(recognize_recording(recording, frames="press"))
                    once.append(len(answers) == 1)
                    # The first is the answer; an answer too many is counted beside it.
                    first = answers[0].surface if answers else None
                    scores.add(kind, first.name if first else "none", first.probability if first else 1.0)
            print(f"{side} x {side} taxels, {how} is wrong:")
            scores.report(f"{side} x {side}, {how} wrong")
            said = figure(
                f"{side} x {side}, {how} wrong: one answer a press", 100 * np.mean(once), ".1f", "%", bar=">= 95"
            )
            print(f"  presses with one answer: {said}")
        for how in (*HOT, ROWS, LINES) if asked.ways == WAYS else ():
            name_alone(side, how, asked)


if __name__ == "__main__":
    main(sys.argv[1:])
