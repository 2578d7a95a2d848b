"""Six surfaces on a 5 x 9 array of 3.4 mm pitch, 2 % noise: share of right names and time a frame.

The published rival (Liu et al., ICRA 2012, six primitives on a 5 x 9 array) has 97.5 % in 576 microseconds.
"""

from __future__ import annotations

import time
import warnings

import numpy as np

from benchmarks._scores import Scores
from benchmarks.touch_ideal import TRUE_NAME
from varishold.errors import InputError
from varishold.skin import Skin, press, sense
from varishold.solids import draw_contact, ideal_frame
from varishold.touch import find_contacts, recognize

SEED = 40_000
SHAPE, PITCH_M, NOISE = (5, 9), 3.4e-3, 0.02
KEYS = ("plane", "sphere", "edge", "lying-cylinder", "square-pillar", "cone")
NAMES = tuple(TRUE_NAME[key] for key in KEYS)
FRAMES_PER_KIND = 350
#: None is an ideal surface: pressure of the object's own form.
SKINS: dict[str, Skin | None] = {
    "ideal": None,
    "layer of 6 mm": Skin("layer", thickness_m=6e-3, poisson=0.45, sensing_depth_m=1e-3),
    "half-space": Skin("half-space", poisson=0.45, sensing_depth_m=1e-3),
}


def frame_of(rng: np.random.Generator, key: str, skin: Skin | None) -> np.ndarray:
    """Return a noisy frame of a random contact of 7 to 16 mm."""
    field = (SHAPE[0] * PITCH_M, SHAPE[1] * PITCH_M)
    while True:
        depth = float(rng.uniform(0.4e-3, 1.5e-3))
        drawn = draw_contact(rng, key, field_m=field, size_m=(7e-3, 16e-3), depth_m=depth)
        if skin is None:
            frame = ideal_frame(drawn.solid, SHAPE, PITCH_M, depth_m=drawn.depth_m, pose=drawn.pose)
            break
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore", RuntimeWarning)
                frame = sense(
                    press(drawn.solid, skin, depth=drawn.depth_m, pose=drawn.pose, shape=SHAPE, pitch=PITCH_M)
                )
            break
        except InputError:
            continue
    return frame + rng.normal(0, NOISE * frame.max(), frame.shape)


def main() -> None:
    """Print the share of right names on every skin, and the time of a recognition."""
    for number, (name, skin) in enumerate(SKINS.items()):
        rng = np.random.default_rng([SEED, number])
        scores, times = Scores(), []
        for key in KEYS:
            for _ in range(FRAMES_PER_KIND):
                frame = frame_of(rng, key, skin)
                begun = time.perf_counter()
                contacts = find_contacts(frame, 16)
                surface = recognize(contacts[0], among=NAMES) if contacts else None
                times.append(time.perf_counter() - begun)
                scores.add(
                    TRUE_NAME[key], surface.name if surface else "unknown", surface.probability if surface else 1
                )
        print(f"{name}, skin unknown (bar 97.5 %, under 100 microseconds):")
        scores.report()
        print(f"  find and recognize, 16 levels: median {np.median(times) * 1e6:.0f} microseconds a frame")


if __name__ == "__main__":
    main()
