"""Presses of all kinds, eight in a recording, on a rest that has a form of its own or does not stay, or spoilt.

Faces are drawn by the yardstick, edges and planes among them, on height maps and in a thin cover. Each press is to have
one answer, with the right name.

    python -m benchmarks.touch_presses
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence

import numpy as np

from benchmarks._figures import figure, share
from benchmarks._scores import Scores
from benchmarks.touch_distortions import SIDES
from benchmarks.touch_glitches import COURSE, resting
from varishold.errors import InputError
from varishold.evaluation.yardstick.forms import Change
from varishold.evaluation.yardstick.media import clean_frames
from varishold.evaluation.yardstick.rows import NOISE
from varishold.recording import Pad, Recording
from varishold.touch import recognize_recording
from varishold.touch.answer import Answer

SEED = 2026
FRAMES_PER_KIND = 8
PRESSES = 8
#: What the pad shows at rest, and how far the rest goes, in parts of the peak; how unlike taxels go.
OFFSET, DRIFT, WANDER, JUMP, UNLIKE, WALK = 0.3, 0.5, 0.1, 0.12, 0.2, 0.2
#: Presses of a recording between which the rest jumps, as a share of it.
JUMPS = (0.3, 0.7)
#: What lies in a corner: how high, and which share of the pad's sides it covers.
LIES, COVERS = 0.3, 1 / 6
STILL = ("nothing", "a rest that bends", "rows that rest unlike", "a wrinkle at rest", "something that lies there")
OWN = "a rest of each taxel's own that "
MOVING = (
    "a rest that drifts",
    "a rest that wanders",
    "a rest that jumps",
    f"{OWN}drifts",
    f"{OWN}walks",
    f"{OWN}jumps",
)
#: The share of frames that break off, or are full of noise; how far the sensor is off when it is switched on, in parts
#: of the peak, and in how many frames that goes away; in how many frames readings forget what presses.
SPOILT, SETTLES, IN_FRAMES, FORGETS = 0.05, 0.5, 10, 60
#: A large pad, and how high light presses on it are, in sigma.
MAT, PEAKS = 64, (10.0, 20.0)
FIRST = "a first frame of noise"
ADAPTS = "readings that adapt to what presses"
SPOILT_HOW = (
    "a start within a press",
    FIRST,
    "a sensor that settles",
    "frames that break off",
    "bursts of noise",
    ADAPTS,
)


def rest_of(how: str, n_frames: int, side: int, rng: np.random.Generator) -> np.ndarray:
    """Return what a pad shows when nothing presses, of a shape that goes with (n_frames, side, side)."""
    time, own = np.arange(n_frames)[:, None, None] / n_frames, 1.0 + rng.normal(0.0, UNLIKE, (side, side))
    if how == "something that lies there":
        lies, reach = np.zeros((side, side)), int(COVERS * side)
        lies[:reach, :reach] = LIES
        return lies
    if how == "a rest that drifts":
        return np.asarray(DRIFT * rng.choice([-1, 1]) * time * own)
    if how == "a rest that wanders":
        return np.asarray(WANDER * np.sin(3 * np.pi * time + rng.uniform(0, 2 * np.pi)) * own)
    if how == "a rest that jumps":
        return np.asarray(JUMP * rng.choice([-1, 1]) * (time > rng.uniform(*JUMPS)) * own)
    if how == f"{OWN}drifts":
        return np.asarray(UNLIKE / 2 * time * rng.normal(0.0, 1.0, (side, side)))
    if how == f"{OWN}walks":
        return np.cumsum(rng.normal(0.0, WALK / np.sqrt(n_frames), (n_frames, side, side)), axis=0)
    if how == f"{OWN}jumps":
        return np.asarray(JUMP * (time > rng.uniform(*JUMPS)) * rng.normal(0.0, 1.0, (side, side)))
    return resting(how, (side, side), rng)


def spoil(how: str, frames: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Return frames with what is wrong in some of them; those of a recording that starts later are the last ones."""
    n, rows, cols = frames.shape
    some = rng.random(n) < SPOILT
    if how == "a start within a press":
        return np.asarray(frames[int(rng.choice(np.flatnonzero(COURSE > SETTLES))) :])
    if how == FIRST:
        frames[0] = 2 * rng.random((rows, cols))
    elif how == "a sensor that settles":
        frames += SETTLES * np.exp(-np.arange(n) / IN_FRAMES)[:, None, None]
    elif how == "frames that break off":
        for k in np.flatnonzero(some):
            frames[k].flat[rng.integers(cols, rows * cols) :] = 0.0
    elif how == ADAPTS:
        rest = np.full((rows, cols), OFFSET)
        for k in range(n):
            frames[k] -= rest - OFFSET
            rest += (frames[k] - OFFSET) / FORGETS
    elif how == "bursts of noise":
        frames[some] += rng.normal(0.0, OFFSET, (np.count_nonzero(some), rows, cols))
    return frames


def answers_of(recording: Recording) -> list[Answer]:
    """Return one answer for each contact of each press; none where no press is found."""
    try:
        return list(recognize_recording(recording, frames="press"))
    except InputError:
        return []


def light(peak: float, asked: argparse.Namespace) -> None:
    """Print how presses of a 16 x 16 face, so many sigma high, are found on a large pad."""
    made = [clean_frames(medium, 16, Change(), asked.frames, asked.seed) for medium in ("ideal", "cover")]
    faces = np.concatenate([faces for faces, _ in made])
    faces = faces[[face[0].max() + face[-1].max() + face[:, 0].max() + face[:, -1].max() == 0.0 for face in faces]]
    rng = np.random.default_rng([asked.seed, MAT])
    missed = too_many = 0
    for some in np.split(rng.permutation(len(faces)), np.arange(PRESSES, len(faces), PRESSES)):
        placed = np.zeros((len(some), MAT, MAT))
        for one, i in zip(placed, some, strict=True):
            row, col = rng.integers(0, MAT - 16, 2)
            one[row : row + 16, col : col + 16] = faces[i] / faces[i].max()
        frames = np.concatenate([peak * COURSE[:, None, None] * one for one in placed])
        frames += 10 * rng.random((MAT, MAT)) + rng.normal(0.0, 1.0, frames.shape)
        at = [answer.frame // len(COURSE) for answer in answers_of(Recording({"pad": Pad(frames)}))]
        missed += len(some) - len(set(at))
        too_many += len(at) - len(set(at))
    of = f"{MAT} x {MAT}, presses {peak:g} sigma high"
    print(
        f"{MAT} x {MAT} taxels, presses of 16 x 16 of them, {peak:g} sigma high: missed "
        f"{share(f'{of}: missed', missed / len(faces))} of {len(faces)}, answers too many "
        f"{figure(f'{of}: too many', 100 * too_many / len(faces), '.1f', 'a hundred')}"
    )


def main(argv: Sequence[str] = ()) -> None:
    """Print the figures."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--seed", type=int, default=SEED)
    parser.add_argument("--frames", type=int, default=FRAMES_PER_KIND, help="of each kind, on each of two media")
    asked = parser.parse_args(list(argv))
    for peak in PEAKS:
        light(peak, asked)
    for side in SIDES:
        made = [clean_frames(medium, side, Change(), asked.frames, asked.seed) for medium in ("ideal", "cover")]
        faces, kinds = np.concatenate([faces for faces, _ in made]), np.concatenate([kinds for _, kinds in made])
        for how in (*STILL, *MOVING, *SPOILT_HOW):
            rng = np.random.default_rng([asked.seed, side])
            scores, missed, too_many = Scores(), 0, 0
            for some in np.split(rng.permutation(len(faces)), np.arange(PRESSES, len(faces), PRESSES)):
                frames = OFFSET + np.concatenate([COURSE[:, None, None] * faces[i] for i in some])
                frames += rest_of(how, len(frames), side, rng) + rng.normal(0.0, NOISE[side], frames.shape)
                shown = spoil(how, frames, rng)
                begins = len(frames) - len(shown)
                answers = answers_of(Recording({"pad": Pad(shown)}))
                for k, i in enumerate(some.tolist()):
                    own = [answer.surface for answer in answers if (begins + answer.frame) // len(COURSE) == k]
                    missed += not own
                    too_many += max(len(own) - 1, 0)
                    scores.add(str(kinds[i]), own[0].name if own else "none", own[0].probability if own else 0.0)
            print(f"{side} x {side} taxels, {how}:")
            of = f"{side} x {side}, {how}"
            scores.report(of)
            print(
                f"  presses missed {share(f'{of}: missed', missed / len(scores.truth))}, "
                f"answers too many {figure(f'{of}: too many', 100 * too_many / len(scores.truth), '.1f', 'a hundred')}"
            )


if __name__ == "__main__":
    main(sys.argv[1:])
