"""What calibration wins back: names on frames of an uneven, bent and blurred sensor, before and after.

Frames, forms and media are those of `touch_distortions`; sensors are made here, by other code than
`varishold.sensor`. Presses to calibrate with are other presses than those that are named. Rows:

- gains: spread 25 %, three taxels at .3. Unlabelled presses are 100 frames of a seed of their own. The even pressure is
  to come within one point of the true gains, the unlabelled presses are to win back half of what was lost.
- gains of 20 %: the same without weak taxels; after unlabelled presses 99 % at 32 x 32 and 95 % at 16 x 16 are wanted.
- bent: a logarithm (a = 5) and a blur of .6 taxels. A ball and a plate press ten times each; three points of the true
  curve are allowed.
- bent and uneven: the same with gains of 20 %, which these presses tell too.

Columns: right names, of 13 kinds (ridge and hip one), on height maps and thin covers together.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from benchmarks._drawn_frames import frames
from benchmarks._figures import share
from benchmarks.touch_distortions import answer_of
from varishold.calibration import KnownObject, calibrate_even, calibrate_objects, calibrate_unlabelled
from varishold.evaluation.yardstick.forms import Change
from varishold.evaluation.yardstick.rows import NOISE
from varishold.recording import Pad, Recording
from varishold.sensor import Logarithmic, Sensor

Floats = NDArray[np.float64]
MEDIA = ("ideal", "cover")
BALL, PLATE = 16.0, 7.0


def uneven(side: int, rng: np.random.Generator, spread: float, weak: int) -> Floats:
    """Return gains that spread so far, some of them .3."""
    gains = np.maximum(1 + spread * rng.standard_normal((side, side)), 0.1)
    gains.ravel()[rng.choice(gains.size, weak, replace=False)] = 0.3
    return gains


def bent(stress: Floats, gains: float | Floats = 1.0) -> Floats:
    """Return readings of a blurred logarithm, behind gains."""
    blurred = ndimage.gaussian_filter(stress, (0, 0.6, 0.6), mode="nearest", truncate=6)
    return np.log1p(5 * gains * np.maximum(blurred, 0)) / np.log(6)


def recorded(readings: Floats, noise: float, rng: np.random.Generator) -> Recording:
    """Return presses with pauses, as a recording of pitch 1 (a metre a taxel)."""
    still = np.zeros((4, *readings.shape[1:]))
    clean = np.concatenate([still, *(np.concatenate([np.repeat(f[None], 3, 0), still]) for f in readings)])
    return Recording({"pad": Pad(clean + noise * rng.standard_normal(clean.shape), pitch_m=(1.0, 1.0))})


def known_presses(kind: str, side: int, rng: np.random.Generator) -> Floats:
    """Return ten presses of a ball or a square plate, in taxels, the deepest 1."""
    size = (BALL if kind == "ball" else PLATE) * side / 16
    fine = 8
    at = (np.arange(side * fine) + 0.5) / fine - side / 2
    x, y = np.meshgrid(at, at)
    made = []
    for _ in range(10):
        depth = rng.uniform(0.3, 1.0)
        place = rng.uniform(-1, 1, 2) * (side / 2 - (np.sqrt(depth * size) if kind == "ball" else 0.72 * size))
        if kind == "ball":
            gap = size / 2 - np.sqrt(np.maximum(size**2 / 4 - (x - place[0]) ** 2 - (y - place[1]) ** 2, 0))
            face = np.maximum(depth - gap, 0)
        else:
            turn = rng.uniform(0, np.pi / 2)
            u = np.cos(turn) * (x - place[0]) + np.sin(turn) * (y - place[1])
            v = np.cos(turn) * (y - place[1]) - np.sin(turn) * (x - place[0])
            face = np.where(np.maximum(abs(u), abs(v)) < size / 2, depth, 0.0)
        made.append(face.reshape(side, fine, side, fine).mean(axis=(1, 3)))
    return np.array(made)


def right(side: int, per_kind: int, seed: int, read: Callable[[Floats], Floats], sensor: Sensor | None) -> float:
    """Return the share of right names on readings."""
    rng = np.random.default_rng([seed, side, 7])
    hits = []
    for medium in MEDIA:
        clean, kinds = frames(medium, side, Change(), per_kind, seed)
        readings = read(clean)
        readings = readings + NOISE[side] * rng.standard_normal(clean.shape)
        for frame, kind in zip(readings, kinds.tolist(), strict=True):
            name = answer_of(frame) if sensor is None else answer_of(frame, sensor=sensor)
            hits.append(name.name == ("ridge" if kind == "hip" else kind))
    return float(np.mean(hits))


def main(argv: Sequence[str] = ()) -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--seed", type=int, default=1971)
    parser.add_argument("--per-kind", type=int, default=40)
    parser.add_argument("--side", type=int, choices=(16, 32), action="append")
    asked = parser.parse_args(list(argv))
    for side in asked.side or (32, 16):
        rng = np.random.default_rng([asked.seed, side])
        noise = NOISE[side]
        gains = uneven(side, rng, 0.25, 3)
        even = recorded(np.array([0.4, 0.7, 1.0])[:, None, None] * gains, noise, rng)
        others = np.concatenate([frames(medium, side, Change(), 10, asked.seed + 1000)[0] for medium in MEDIA])
        anything = recorded(others[rng.choice(len(others), 100, replace=False)] * gains, noise, rng)
        of = f"{side} x {side}"
        print(f"\n{of}, noise {noise:.0%}, {26 * asked.per_kind} frames a row, seed {asked.seed}")
        _row(of, "even sensor", right(side, asked.per_kind, asked.seed, np.asarray, None))
        for name, sensor in (
            ("gains: as they come", None),
            ("gains: true ones known", Sensor(gains=gains)),
            ("gains: three even presses", calibrate_even([even]).sensor),
            ("gains: 100 unlabelled", calibrate_unlabelled([anything]).sensor),
        ):
            _row(
                f"{side} x {side}",
                name,
                right(side, asked.per_kind, asked.seed, partial(np.multiply, gains), _at_rest(sensor)),
            )
        milder = uneven(side, rng, 0.20, 0)
        anything = recorded(others[rng.choice(len(others), 100, replace=False)] * milder, noise, rng)
        for name, sensor in (
            ("gains of 20 %: as they come", None),
            ("gains of 20 %: 100 unlabelled", calibrate_unlabelled([anything]).sensor),
        ):
            _row(
                f"{side} x {side}",
                name,
                right(side, asked.per_kind, asked.seed, partial(np.multiply, milder), _at_rest(sensor)),
            )
        recordings = [recorded(bent(known_presses(kind, side, rng)), noise, rng) for kind in ("ball", "plate")]
        objects = [KnownObject("ball", BALL * side / 16), KnownObject("plate", PLATE * side / 16)]
        found = calibrate_objects(recordings, objects)
        curve = Sensor(span=1.0, response=Logarithmic(5.0), blur_taxels=0.6)
        for name, sensor in (
            ("bent: as it comes", None),
            ("bent: curve and blur known", curve),
            ("bent: ball and plate", found.sensor),
        ):
            _row(of, name, right(side, asked.per_kind, asked.seed, bent, _at_rest(sensor)))
        print("  " + "; ".join(str(each) for each in found.findings))
        read = partial(bent, gains=milder)
        recordings = [recorded(read(known_presses(kind, side, rng)), noise, rng) for kind in ("ball", "plate")]
        found = calibrate_objects(recordings, objects)
        for name, sensor in (
            ("bent and uneven: as it comes", None),
            ("bent and uneven: all of it known", replace(curve, gains=milder)),
            ("bent and uneven: ball and plate", found.sensor),
            ("bent and uneven: without the gains", replace(found.sensor, gains=None)),
        ):
            _row(of, name, right(side, asked.per_kind, asked.seed, read, _at_rest(sensor)))
        print("  " + "; ".join(str(each) for each in found.findings))


def _at_rest(sensor: Sensor | None) -> Sensor | None:
    """Return a sensor for frames whose rest is zero, lengths in taxels."""
    if sensor is None:
        return None
    return replace(sensor, rest=0.0, pitch_m=None)


def _row(of: str, name: str, right_names: float) -> None:
    print(f"  {name:30} {share(f'{of}, {name}: right name', right_names, '5.1f')}", flush=True)


if __name__ == "__main__":
    main(sys.argv[1:])
