"""What a ball and a plate tell of a sensor under an elastic cover, and what that does for names.

A logarithm (a = 5) behind a layer of one or two taxels' spacing, or behind a body without a floor, 16 x 16 taxels. Ten
presses each of a ball and a plate, and the yardstick's forms, are pressed by the solver of contacts, which shares no
table with the calibration. Rows: right names as they come, by the calibration, and where the curve is known; "on
springs" is what the calibration finds where no cover is thought of.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from dataclasses import replace
from unittest import mock

import numpy as np
from numpy.typing import NDArray

from benchmarks._figures import share
from benchmarks.touch_calibration import recorded
from benchmarks.touch_distortions import answer_of
from varishold.calibration import Calibration, KnownObject, calibrate_objects, objects
from varishold.errors import InputError
from varishold.evaluation.yardstick.forms import KINDS, Change, draw_face
from varishold.sensor import Logarithmic, Sensor, Skin
from varishold.skin import press
from varishold.solids import Pose, Sphere, SquarePillar

Floats = NDArray[np.float64]

SIDE, CELLS, MARGIN = 16, 6, 6
BALL, PLATE = 24.0, 7.0
NOISE = 0.01
#: By thickness in taxels, as pitch is 1; no thickness is no floor.
COVERS = {
    "layer of 1": Skin("layer", thickness_m=1.0, poisson=0.45),
    "layer of 2": Skin("layer", thickness_m=2.0, poisson=0.45),
    "no floor": Skin("half-space"),
}


def bent(stress: Floats) -> Floats:
    """Return readings of a logarithm."""
    return np.log1p(5 * np.maximum(stress, 0)) / np.log(6)


def known_presses(kind: str, skin: Skin, rng: np.random.Generator, count: int = 10) -> Floats:
    """Return presses of the ball or the plate, the highest stress 1."""
    body = Sphere(BALL) if kind == "ball" else SquarePillar(PLATE, 2.0)
    made = []
    for _ in range(count):
        pose = Pose(*rng.uniform(-3.0, 3.0, 2), rng.uniform(0, np.pi / 2))
        depth = rng.uniform(0.15, 0.8) if kind == "ball" else rng.uniform(0.05, 0.2)
        found = press(body, skin, depth=depth, shape=(SIDE, SIDE), pitch_m=1.0, pose=pose, per_taxel=CELLS)
        made.append(found.pressure.reshape(SIDE, CELLS, SIDE, CELLS).mean(axis=(1, 3)))
    return np.array(made) / np.max(made)


def forms(skin: Skin, per_kind: int, seed: int) -> tuple[Floats, list[str]]:
    """Return the yardstick's forms pressed through a skin, each one's highest stress 1, and their kinds."""
    n = SIDE + 2 * MARGIN
    at = (np.arange(n * 4) + 0.5) / 4 - n / 2
    x, y = np.meshgrid(at, at)
    made, kinds = [], []
    for k, kind in enumerate(KINDS):
        for index in range(per_kind):
            face = next(
                face
                for attempt in range(100)
                if (face := draw_face((seed, k, index, attempt), kind, index, SIDE, Change(), 1.0)) is not None
            )
            height = -np.minimum(face.gap(x, y), 1e3)
            found = press(height, skin, depth=face.depth, shape=(n, n), pitch_m=1.0, per_taxel=4, tolerance=1e-3)
            frame = found.pressure.reshape(n, 4, n, 4).mean(axis=(1, 3))[MARGIN:-MARGIN, MARGIN:-MARGIN]
            made.append(frame / frame.max())
            kinds.append("ridge" if kind == "hip" else kind)
    return np.array(made), kinds


def right(readings: Floats, kinds: Sequence[str], sensor: Sensor | None) -> float:
    """Return the share of right names."""
    of = {} if sensor is None else {"sensor": replace(sensor, rest=0.0, pitch_m=None, cover=None)}
    return float(np.mean([answer_of(frame, **of).name == kind for frame, kind in zip(readings, kinds, strict=True)]))


def main(argv: Sequence[str] = ()) -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--seed", type=int, default=1971)
    parser.add_argument("--per-kind", type=int, default=20)
    asked = parser.parse_args(list(argv))
    print(f"{len(KINDS) * asked.per_kind} frames a row, logarithm a = 5, noise {NOISE:.0%}, seed {asked.seed}")
    for number, (name, skin) in enumerate(COVERS.items()):
        rng = np.random.default_rng([asked.seed, number])
        recordings = [recorded(bent(known_presses(kind, skin, rng)), NOISE, rng) for kind in ("ball", "plate")]
        things = [KnownObject("ball", BALL), KnownObject("plate", PLATE)]
        stress, kinds = forms(skin, asked.per_kind, asked.seed)
        readings = bent(stress) + 2 * NOISE * rng.standard_normal(stress.shape)
        _row(name, "as it comes", right(readings, kinds, None))
        _row(name, "curve known", right(readings, kinds, Sensor(span=1.0, response=Logarithmic(5.0))))
        found = calibrate_objects(recordings, things)
        _row(name, "ball and plate", right(readings, kinds, found.sensor))
        _told(found)
        with mock.patch.object(objects, "tells_thickness", return_value=False):
            try:
                plain = calibrate_objects(recordings, things)
            except InputError as error:
                print(f"  on springs: refused, {error}")
                continue
        _row(name, "on springs", right(readings, kinds, plain.sensor))
        _told(plain)


def _row(of: str, name: str, right_names: float) -> None:
    print(f"  {of:12} {name:16} {share(f'{of}, {name}: right name', right_names, '5.1f')}", flush=True)


def _told(found: Calibration) -> None:
    print("  " + "; ".join(f"{each.name} {each.value:.3g} ± {each.error:.1g}" for each in found.findings))


if __name__ == "__main__":
    main(sys.argv[1:])
