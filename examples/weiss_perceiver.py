"""Recognize what a real hand holds, grasp after grasp: 36 objects between two tactile fingers (Weiss DSA).

Run ``python examples/weiss_perceiver.py [FOLDER]``; FOLDER, or the environment variable VARISHOLD_DATA, is where
``weiss_dsa36.npz`` lies. The first ten grasps of each object are what a `Perceiver` knows; it is then given later
grasps of one object, one after another, until it is sure or has had four. Everything is tactile: joint angles are
never looked at. In the end each object in turn is one that the perceiver does not know, and is then added from ten
grasps.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import numpy as np
from sklearn.decomposition import PCA
from sklearn.pipeline import make_pipeline
from sklearn.preprocessing import StandardScaler

from varishold.errors import InputError
from varishold.perceive import (
    NONE_OF_THESE,
    Evidence,
    Library,
    Perceiver,
    Perception,
    evidence_of_recording,
)
from varishold.recording import Pad, Recording, frame_of, peak_frame
from varishold.touch import LoadingFeatures, SurfaceFeatures

FILE = "weiss_dsa36.npz"
PITCH_M = 3.4e-3
EXAMPLES, MOST_TOUCHES = 10, 4
# Far fewer than there are known grasps, so that how much numbers vary is learned well. Five grasps of each object's
# first ten against the other five: from 15 to 30 hardly differ, more are worse.
NUMBERS = 30

Say = Callable[[str], None]


@dataclass(frozen=True)
class Grasps:
    """Each grasp as a recording of two pads, its object, and its place among the grasps of that object."""

    recordings: list[Recording]
    label: np.ndarray
    place: np.ndarray

    def of(self, name: str, first: int, stop: int | None = None) -> list[int]:
        """Return the numbers of some grasps of one object, in the order in which they were made."""
        return np.flatnonzero(self.label == name)[first:stop].tolist()


@dataclass(frozen=True)
class Count:
    """What came of some sequences of grasps."""

    sequences: int
    right_at_once: int
    right: int
    refused: int
    touches: int

    def told(self) -> str:
        """Return it in words."""
        n = max(self.sequences, 1)
        return (
            f"right after the first touch {self.right_at_once / n:.3f}, right at the end {self.right / n:.3f}, "
            f"refused {self.refused / n:.3f}, {self.touches / n:.2f} touches on average ({self.sequences} sequences)"
        )


def find_file(folder: str | os.PathLike[str] | None = None) -> Path:
    """Return where the recording is.

    Raises
    ------
    InputError
        If it is not there; the message says what to set.
    """
    path = Path(folder or os.environ.get("VARISHOLD_DATA", ".")) / FILE
    if not path.is_file():
        raise InputError(f"{path}: no such file; give the folder that holds {FILE}, or set VARISHOLD_DATA to it")
    return path


def read_grasps(path: Path, objects: int | None = None) -> Grasps:
    """Read the grasps of the first so many objects, all by default."""
    with np.load(path, allow_pickle=False) as data:
        label, start, mask = data["label"], data["start"], data["texel_mask"]
        frames, time_s = data["frames"], data["time_ms"] / 1000
    names = np.unique(label)[:objects]
    recordings = [
        Recording(
            {f"finger{k}": Pad(frames[a:b, k], field=mask[k], pitch_m=PITCH_M) for k in range(2)}, time_s=time_s[a:b]
        )
        for (a, b), name in zip(pairwise(start), label, strict=True)
        if name in names
    ]
    label = label[np.isin(label, names)]
    place = np.array([(label[:k] == name).sum() for k, name in enumerate(label)])
    return Grasps(recordings, label, place)


def measure(grasps: Grasps, known: np.ndarray) -> np.ndarray:
    """Return the sections of each grasp's peak frame and how it is loaded in time, in numbers, one row a grasp.

    Thresholds and moments are set by the known grasps alone, without their names.
    """
    peaks = np.array([[frame_of(pad, peak_frame(r)) for pad in r.pads.values()] for r in grasps.recordings])
    field = np.array([pad.field for pad in grasps.recordings[0].pads.values()])
    training = [grasps.recordings[k] for k in np.flatnonzero(known)]
    surface = SurfaceFeatures(field=field).fit(peaks[known]).transform(peaks)
    loading = LoadingFeatures(pairs=False).fit(training).transform(grasps.recordings)
    return np.concatenate([surface, loading], axis=1)


def as_evidence(measured: np.ndarray, known: np.ndarray) -> list[Evidence]:
    """Return each grasp as evidence of few numbers, the principal components of the known grasps."""
    few = make_pipeline(StandardScaler(), PCA(min(NUMBERS, int(known.sum()) - 1), random_state=0)).fit(measured[known])
    return [Evidence("grasp", {f"grasp.{k}": value for k, value in enumerate(row)}) for row in few.transform(measured)]


def library_of(grasps: Grasps, evidence: Sequence[Evidence], names: Sequence[str]) -> Library:
    """Learn objects from their first ten grasps; each grasp is an example of its own."""
    return Library.from_examples({name: [[evidence[k]] for k in grasps.of(name, 0, EXAMPLES)] for name in names})


def feel(library: Library, evidence: Sequence[Evidence], *, refuse: bool = True) -> Perception:
    """Feel grasps of one object one after another until it is known; each one holds the object in another place."""
    perceiver = Perceiver(library, most_touches=MOST_TOUCHES, refuse=refuse)
    for k, touch in enumerate(evidence):
        if k:
            perceiver.moved()
        perceiver.feel(touch)
        if perceiver.stopped:
            break
    return perceiver.answer()


def count(
    grasps: Grasps, evidence: Sequence[Evidence], library: Library, name: str, *, refuse: bool = True
) -> tuple[Count, list[Perception]]:
    """Feel all later grasps of one object, four at a time."""
    later = grasps.of(name, EXAMPLES)
    fours = [later[k : k + MOST_TOUCHES] for k in range(0, len(later) - MOST_TOUCHES + 1, MOST_TOUCHES)]
    answers = [feel(library, [evidence[k] for k in four], refuse=refuse) for four in fours]
    return (
        Count(
            sequences=len(answers),
            right_at_once=sum(next(iter(answer.trace[0].probability)) == name for answer in answers),
            right=sum(answer.object == name for answer in answers),
            refused=sum(answer.object == NONE_OF_THESE for answer in answers),
            touches=sum(len(answer.trace) for answer in answers),
        ),
        answers,
    )


def shuffled(grasps: Grasps, seed: int) -> Grasps:
    """Return the grasps of each object in a random order."""
    order = np.random.default_rng(seed).permutation(len(grasps.label))
    order = order[np.argsort(grasps.label[order], kind="stable")]
    place = np.concatenate([np.arange((grasps.label == name).sum()) for name in np.unique(grasps.label)])
    return Grasps([grasps.recordings[k] for k in order], grasps.label[order], place)


def recognize_drawn(grasps: Grasps, seed: int) -> tuple[Count, Count]:
    """Count what is recognized if ten random grasps of each object are known; then if nothing may be refused."""
    drawn = shuffled(grasps, seed)
    names, known = [str(name) for name in np.unique(drawn.label)], drawn.place < EXAMPLES
    evidence = as_evidence(measure(drawn, known), known)
    library = library_of(drawn, evidence, names)
    refusing, never = (
        total([count(drawn, evidence, library, name, refuse=refuse)[0] for name in names]) for refuse in (True, False)
    )
    return refusing, never


def total(counts: Sequence[Count]) -> Count:
    """Return all counts together."""
    return Count(*(sum(getattr(one, field) for one in counts) for field in Count.__dataclass_fields__))


def main(
    folder: str | os.PathLike[str] | None = None, *, objects: int | None = None, draws: int = 5, say: Say = print
) -> dict[str, Count]:
    """Print what is recognized, and return the totals."""
    grasps = read_grasps(find_file(folder), objects)
    names = [str(name) for name in np.unique(grasps.label)]
    known = grasps.place < EXAMPLES
    measured = measure(grasps, known)

    say(f"{len(names)} objects known from {EXAMPLES} grasps each; later grasps, up to {MOST_TOUCHES} a sequence:")
    evidence = as_evidence(measured, known)
    library = library_of(grasps, evidence, names)
    counts, named, sure = [], [], []
    for name in names:
        one, answers = count(grasps, evidence, library, name)
        counts.append(one)
        named.append(count(grasps, evidence, library, name, refuse=False)[0])
        sure += [answer.object == name for answer in answers if answer.trace[-1].verdict == "sure"]
        given = ", ".join(dict.fromkeys(answer.object for answer in answers))
        say(f"  {name}: {one.right} of {one.sequences} right, {one.touches} touches; it said {given}")
    totals = {"known": total(counts), "never refusing": total(named)}
    say(f"in all: {totals['known'].told()}")
    say(f"  it called itself sure {len(sure)} times and was right in {sum(sure)} of them")
    say(f"the same, told that it must be one of these: {totals['never refusing'].told()}")

    drawn, never = (total(part) for part in zip(*(recognize_drawn(grasps, k) for k in range(draws)), strict=True))
    totals |= {"drawn": drawn, "drawn, never refusing": never}
    say(f"touch drifts within a session: had ten random grasps of each been known ({draws} draws), {drawn.told()};")
    say(f"  told that it must be one of these: {never.told()}")

    first = grasps.of(names[0], EXAMPLES)[0]
    said = "; ".join(evidence_of_recording(grasps.recordings[first]).reasons)
    say(f"the surface under each pad in one grasp of {names[0]}: {said}")

    say("each object in turn is not known, then added from its ten grasps; nothing else is learned again")
    say("(thresholds and moments, which know no names, were set with its grasps among the rest):")
    strange, added = [], []
    for name in names:
        others = known & (grasps.label != name)
        evidence = as_evidence(measured, others)
        library = library_of(grasps, evidence, [other for other in names if other != name])
        strange.append(count(grasps, evidence, library, name)[0])
        wider = library.with_object(name, [[evidence[k]] for k in grasps.of(name, 0, EXAMPLES)])
        added.append(count(grasps, evidence, wider, name)[0])
        say(
            f"  {name}: refused as {NONE_OF_THESE!r} in {strange[-1].refused} of {strange[-1].sequences}, "
            f"recognized in {added[-1].right} once it was added"
        )
    totals |= {"unknown": total(strange), "added": total(added)}
    n = max(totals["unknown"].sequences, 1)
    say(f"before: refused {totals['unknown'].refused / n:.3f}; after: {totals['added'].told()}")
    say(f"no simulator was imported: {'mujoco' not in sys.modules}")
    return totals


if __name__ == "__main__":
    try:
        main(sys.argv[1] if len(sys.argv) > 1 else None)
    except InputError as error:
        raise SystemExit(str(error)) from None
