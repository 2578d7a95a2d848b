"""Make ``surfaces.npz``: every surface pressed once into a soft skin over a 32 x 32 pad.

Run ``python examples/make_surfaces.py``; the same seed gives the same file. Each press is a ramp of five
frames between empty ones; noise is 1 % of a press's peak, and three taxels are dead.
"""

from __future__ import annotations

import sys
import warnings
from pathlib import Path

import numpy as np

from varishold.recording import Pad, Recording, write
from varishold.skin import Skin, press, sense
from varishold.solids import SOLIDS, draw_contact

SEED = 1971
SIDE, PITCH_M = 32, 1e-3
RAMP = (0.35, 0.7, 1.0, 0.7, 0.35)
# How deep each is pressed, metres: pointed ones deeper, so that all weigh about as much.
FLAT, ROUND, POINTED = 0.6e-3, 1.4e-3, 2.6e-3
DEPTH_M = {"sphere": ROUND, "lying-cylinder": ROUND, "cone-frustum": ROUND, "pyramid-frustum": ROUND} | dict.fromkeys(
    ("cone", "pyramid", "ridge", "hip", "wedge"), POINTED
)
SKIN = Skin("layer", thickness_m=6e-3, poisson=0.45, sensing_depth_m=1e-3, youngs_modulus_pa=150e3)
DEAD = ((4, 27), (19, 8), (20, 21))


def main(path: Path) -> None:
    """Write the recording to `path`."""
    rng = np.random.default_rng(SEED)
    frames = [np.zeros((SIDE, SIDE))]
    for name in SOLIDS:
        field = SIDE * PITCH_M
        drawn = draw_contact(rng, name, field_m=(field, field), size_m=(15e-3, 22e-3), depth_m=DEPTH_M.get(name, FLAT))
        for share in RAMP:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore", RuntimeWarning)
                pressed = press(
                    drawn.solid, SKIN, depth=share * drawn.depth_m, pose=drawn.pose, shape=(SIDE, SIDE), pitch_m=PITCH_M
                )
            frames.append(sense(pressed))
        frames += [np.zeros((SIDE, SIDE))] * 2
    pressure = np.array(frames)
    noise = 0.01 * float(np.median([frame.max() for frame in pressure if frame.max() > 0]))
    pressure += rng.normal(0, noise, pressure.shape)
    valid = np.ones((SIDE, SIDE), dtype=bool)
    for row, col in DEAD:
        pressure[:, row, col] = 0.0
        valid[row, col] = False
    pad = Pad(np.round(pressure).astype(np.int32), valid=valid, pitch_m=(PITCH_M, PITCH_M))
    time_s = np.arange(len(pressure)) / 50
    write(Recording({"pad": pad}, time_s=time_s, unit="Pa", sensor="generated: 6 mm layer, 32 x 32, 1 mm"), path)


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).with_name("surfaces.npz"))
