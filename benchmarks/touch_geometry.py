"""Sizes, radii, tilts, depths and roundings of what is touched: errors, and how often the 90 % intervals hold them.

Faces are drawn and pressed by the yardstick, on pads with a pitch of 1 mm (32 x 32,
noise of 1 %) or 2 mm (16 x 16, 2 %), one frame a recording. Rows: a height map in metres, upright and tilted by 3
degrees; the same rounded by a tenth of the breadth; a half-space of 1 MPa read 1 mm deep, in pascal, its skin file
given. Only frames that got their right name count. True is:

- the size of the top face of a pillar or frustum; of other forms, on height maps alone, that of the section at the
  answer's own floor (length and breadth of the rectangle or circle of its area and second moments);
- the radius of a ball or lying cylinder, the depth of the foremost point (height maps: over the rest), the face's tilt.

A cell without a figure is a key that the answer does not have, or null.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from typing import Any

import numpy as np

from benchmarks._figures import figure, share
from benchmarks.touch_distortions import SIDES
from varishold.evaluation.yardstick.forms import KINDS, Change, Face, draw_face
from varishold.evaluation.yardstick.media import half_space_reading, height_map
from varishold.evaluation.yardstick.rows import NOISE
from varishold.recording import Pad, Recording
from varishold.skin import Skin
from varishold.touch import recognize_recording

SEED = 77
PER_KIND = 12
PITCH_M = {32: 1e-3, 16: 2e-3}
TILT_DEG, ROUNDING = 3.0, 0.1
MODULUS_PA = 1e6
SKIN = Skin("half-space", poisson=0.45, sensing_depth_m=1e-3, youngs_modulus_pa=MODULUS_PA)
#: Name, change, whether it is pressed into a skin.
ROWS = (
    ("height map", Change(), False),
    ("height map, tilted 3 degrees", Change(tilt=TILT_DEG), False),
    ("height map, rounded by a tenth", Change(rounding=ROUNDING), False),
    ("half-space, skin given", Change(), True),
    ("half-space, skin given, tilted 3 degrees", Change(tilt=TILT_DEG), True),
)
_FACED = ("cylinder", "square pillar", "rectangular pillar", "frustum of a cone", "frustum of a pyramid")
_ROUND = ("cylinder", "frustum of a cone", "sphere", "cone")
_CURVED = ("sphere", "lying cylinder")
_SAME = {"hip": "ridge"}
#: Points a side of the grid on which a section's true size is taken.
_POINTS = 400
_ALMOST_FLAT = 1e-6
BARS = "bars: median size error 3 %, radius 10 %, 90 % intervals hold 85-95 %"


def section_size(face: Face, side: int, gap: float, round_: bool) -> tuple[float, float]:
    """Return the long and short size of the face's section at `gap`, in taxels."""
    at = (np.arange(_POINTS) + 0.5) / _POINTS * side - side / 2
    x, y = np.meshgrid(at, at)
    inside = face.gap(x, y) <= gap
    area = inside.sum() * (side / _POINTS) ** 2
    if round_:
        d = 2 * float(np.sqrt(area / np.pi))
        return d, d
    minor, major = np.linalg.eigvalsh(np.cov(np.stack([x[inside], y[inside]])))
    aspect = float(np.sqrt(major / minor))
    return float(np.sqrt(area * aspect)), float(np.sqrt(area / aspect))


def true_size(kind: str, upright: Face, face: Face, side: int, floor: float) -> tuple[float, float]:
    """Return the long and short size in taxels; `floor` is how high the lowest section stands, in taxels."""
    if kind in _FACED:
        return section_size(upright, side, _ALMOST_FLAT, kind in _ROUND)
    long, short = section_size(face, side, face.depth - floor, kind in _ROUND)
    return (long, short) if kind not in ("square pillar", "pyramid") else ((long + short) / 2, (long + short) / 2)


class Errors:
    """Relative errors of one measure, and whether intervals held the truth."""

    def __init__(self) -> None:
        self.errors: list[float] = []
        self.held: list[bool] = []

    def add(self, got: float | None, truth: float, interval: Any, relative: bool = True) -> None:
        """Add one answer; None where it says nothing."""
        if got is not None and np.isfinite(got):
            self.errors.append(abs(got - truth) / (truth if relative else 1.0))
        if interval is not None:
            self.held.append(bool(interval[0] <= truth <= interval[1]))

    def figures(self) -> dict[str, Any]:
        """Return the median error, the 90th percentile and the coverage."""
        return {
            "n": len(self.errors),
            "median": float(np.median(self.errors)) if self.errors else None,
            "p90": float(np.percentile(self.errors, 90)) if self.errors else None,
            "held": float(np.mean(self.held)) if self.held else None,
        }


def answer_to(frame: np.ndarray, side: int, pressed: bool) -> Any:
    """Return the answer for the largest contact of a one-frame recording, or None."""
    pad = Pad(frame[None], pitch_m=(PITCH_M[side], PITCH_M[side]))
    recording = Recording({"pad": pad}, unit="Pa" if pressed else "m")
    answers = list(recognize_recording(recording, frames="all", skin=SKIN if pressed else None, exact=pressed))
    return answers[0] if answers else None


def add_pair(errors: Errors, got: Any, truth: tuple[float, float], interval: Any) -> None:
    """Add a long and a short size."""
    for k in range(2):
        errors.add(None if got is None else got[k], truth[k], None if interval is None else interval[k])


def measure(change: Change, side: int, pressed: bool, per_kind: int, seed: int) -> dict[str, Any]:
    """Return the errors of one row, by measure."""
    found = {key: Errors() for key in ("size", "size, faces", "radius", "depth", "tilt", "rounding")}
    pitch, right, n = PITCH_M[side], 0, 0
    for k, kind in enumerate(KINDS[:-2]):
        made, attempt = 0, 0
        while made < per_kind:
            draw = ((seed, side, k, made, attempt), kind, made, side)
            face, upright = draw_face(*draw, change), draw_face(*draw, Change())
            attempt += 1
            if face is None or upright is None:
                continue
            made += 1
            n += 1
            rng = np.random.default_rng([seed, side, k, made])
            if pressed:
                clean = half_space_reading(face, side, SKIN.sensing_depth_m / pitch)
                clean *= MODULUS_PA / (1 - SKIN.poisson**2)
            else:
                clean = height_map(face, side) * pitch
            answer = answer_to(clean + NOISE[side] * clean.max() * rng.standard_normal(clean.shape), side, pressed)
            if answer is None or _SAME.get(answer.surface.name, answer.surface.name) != _SAME.get(kind, kind):
                continue
            right += 1
            told = answer.to_dict()
            if kind in _FACED or not pressed:
                floor = 0.0 if pressed else answer.surface.contact.floor / pitch
                size = tuple(pitch * s for s in true_size(kind, upright, face, side, floor))
                add_pair(found["size"], told["size_m"], size, told.get("size_interval_m"))
                if kind in _FACED:
                    add_pair(found["size, faces"], told["size_m"], size, told.get("size_interval_m"))
            if kind in _CURVED:
                radius = pitch * (face.breadth**2 / 4 + face.depth**2) / (2 * face.depth)
                found["radius"].add(told["radius_m"], radius, told.get("radius_interval_m"))
            if change == Change():
                found["depth"].add(told["depth_m"], pitch * face.depth, told.get("depth_interval_m"))
            if kind in _FACED and told.get("tilt_rad") is not None:
                found["tilt"].add(np.degrees(told["tilt_rad"]), change.tilt, None, relative=False)
            if kind in ("cylinder", "square pillar", "rectangular pillar") and change.rounding > 0:
                found["rounding"].add(told.get("rounding_m"), pitch * change.rounding * face.breadth, None)
    return {key: errors.figures() for key, errors in found.items()} | {"right": right / n}


def main(argv: Sequence[str] = ()) -> None:
    """Print the errors."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--seed", type=int, default=SEED)
    parser.add_argument("--frames", type=int, default=PER_KIND, help="of each kind")
    asked = parser.parse_args(list(argv))
    print(f"  {BARS}")
    for side in SIDES:
        for name, change, pressed in ROWS:
            figures = measure(change, side, pressed, asked.frames, asked.seed)
            of = f"{side} x {side}, {name}"
            print(f"  {of}: right name {share(f'{of}: right name', figures['right'])}", flush=True)
            for key, f in figures.items():
                if key == "right" or f["n"] == 0:
                    continue
                unit, scale = ("degrees", 1.0) if key == "tilt" else ("%", 100.0)
                middle = figure(f"{of}: {key}, median error", scale * f["median"], "5.1f", unit)
                most = figure(f"{of}: {key}, 90 % within", scale * f["p90"], "5.1f", unit)
                held = "no interval"
                if f["held"] is not None:
                    held = f"interval holds {share(f'{of}: {key}, interval holds', f['held'])}"
                print(f"      {key:12} median error {middle}, 90 % within {most}; {held} ({f['n']})")


if __name__ == "__main__":
    main(sys.argv[1:])
