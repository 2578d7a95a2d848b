"""How well the object's surface is seen through the skin, and how fast.

Random presses (seeded) of every drawable solid into a layer of 6 mm, Poisson's ratio .45, sensing depth 1 mm,
and into a half-space. The shape error is the root mean square, over the eroded mask, of what is left of the
reconstructed displacement after the true one is fitted to it by scale and offset (by offset alone where the
true face is level), over the depth of the press.

Run: python -m benchmarks.skin_reconstruction [--presses 30]
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from benchmarks._figures import figure
from varishold.skin import PressedSolid, Relief, Skin, Taxels, press, reconstruct, sense
from varishold.solids import SOLIDS, draw_contact

SEED = 2071
PRESSES = 30
SETTINGS = {
    "layer 6 mm nu .45, 32 x 32, 1 % noise": (Skin("layer", 6e-3, 0.45, 1e-3), 32, 1e-3, 0.01, 0.025, 8.0),
    "layer 6 mm nu .45, 16 x 16, 2 % noise": (Skin("layer", 6e-3, 0.45, 1e-3), 16, 2e-3, 0.02, 0.045, 3.0),
    "half-space, 32 x 32, 1 % noise": (Skin("half-space", sensing_depth_m=1e-3), 32, 1e-3, 0.01, None, 8.0),
}


def shape_error(relief: Relief, pressed: PressedSolid) -> float:
    """Return the shape error of a relief against the press that it shows."""
    cells = pressed.displacement_m.shape[0] // relief.core.shape[0]
    rows, cols = relief.core.shape
    true = pressed.displacement_m.reshape(rows, cells, cols, cells).mean(axis=(1, 3))[relief.core]
    seen = relief.displacement[relief.core]
    true, seen = true - true.mean(), seen - seen.mean()
    level = true @ true < 1e-3 * (seen @ seen)
    scale = 1.0 if level else (true @ seen) / (true @ true)
    return float(np.sqrt(np.mean((seen - scale * true) ** 2)) / pressed.depth_m)


def overlap(relief: Relief, pressed: PressedSolid) -> float:
    """Return the intersection of mask and true contact over their union."""
    rows, cols = relief.mask.shape
    cells = pressed.contact.shape[0] // rows
    true: NDArray[np.bool_] = pressed.contact.reshape(rows, cells, cols, cells).mean(axis=(1, 3)) > 0.5
    return float((relief.mask & true).sum() / (relief.mask | true).sum())


def main(argv: Sequence[str] = ()) -> None:
    """Print the figures."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--presses", type=int, default=PRESSES, help="of each form, on each skin")
    each = parser.parse_args(list(argv)).presses
    for title, (skin, size, pitch, noise, bar, limit) in SETTINGS.items():
        rng = np.random.default_rng(SEED)
        errors: dict[str, list[float]] = {}
        masks: dict[str, list[float]] = {}
        milliseconds: list[float] = []
        for form in SOLIDS:
            for _ in range(each):
                drawn = draw_contact(
                    rng, form, field_m=(size * pitch, size * pitch), size_m=(8e-3, 20e-3), slope=(0.05, 0.3)
                )
                shape = (size, size)
                pressed = press(drawn.solid, skin, depth=drawn.depth_m, pose=drawn.pose, shape=shape, pitch_m=pitch)
                frame = sense(pressed, Taxels(noise=noise), seed=int(rng.integers(2**31)))
                relief = reconstruct(frame, skin, pitch=pitch)
                began = time.process_time()
                reconstruct(frame, skin, pitch=pitch)
                milliseconds.append(1e3 * (time.process_time() - began))
                errors.setdefault(form, []).append(shape_error(relief, pressed))
                masks.setdefault(form, []).append(overlap(relief, pressed))
        every = np.concatenate([np.asarray(values) for values in errors.values()])
        print(f"{title} ({every.size} presses, seed {SEED})")
        wanted = "" if bar is None else f"<= {bar:.3f}"
        middle = figure(f"{title}: shape error", np.median(every), ".4f", bar=wanted)
        print(f"  shape error: median {middle}; 95 % {np.quantile(every, 0.95):.4f}")
        for form, values in errors.items():
            print(
                f"    {form:19s} median {np.median(values):.4f}, 95 % {np.quantile(values, 0.95):.4f}; "
                f"mask over contact {np.median(masks[form]):.2f}"
            )
        spent = figure(f"{title}: time", np.median(milliseconds), ".2f", "ms", bar=f"<= {limit:g}")
        print(f"  time: median {spent} CPU a frame")


if __name__ == "__main__":
    main(sys.argv[1:])
