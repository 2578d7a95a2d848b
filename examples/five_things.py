"""Press five things ten times each on three days, as recordings to learn from.

Run ``python examples/five_things.py DIR`` (default: out/things), then::

    varishold evaluate out/things --label thing --group day --report out/evaluation.html
    varishold learn out/things/monday.npz out/things/tuesday.npz --label thing --group day -o out/things.model
    varishold recognize out/things.model out/things/wednesday.npz --adapt

The pad is simulated: a soft skin over 16 x 20 taxels, 1.5 mm apart. From day to day its taxels' gains drift by ten
percent, their rests move, it sits up to two millimetres elsewhere, and the hand presses harder or less hard. The same
seed gives the same files.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np

from varishold.recording import Pad, Recording, write
from varishold.skin import Skin, press, sense
from varishold.solids import Cone, LyingCylinder, Pose, Solid, Sphere, SquarePillar, Torus

SEED = 1971
SHAPE, PITCH_M = (16, 20), 1.5e-3
DAYS = ("monday", "tuesday", "wednesday")
PRESSES = 10
SKIN = Skin("layer", thickness_m=4e-3, poisson=0.45, sensing_depth_m=1e-3, youngs_modulus_pa=150e3)
DEPTH_M = 0.8e-3


def things() -> dict[str, Solid]:
    """Return the things, sizes in metres."""
    return {
        "ball": Sphere(0.016),
        "can": LyingCylinder(0.016, 0.012),
        "nut": Torus(0.006, 0.002),
        "die": SquarePillar(0.010, 0.004),
        "spike": Cone(0.012, 0.004),
    }


def day(name: str, seed: int) -> Recording:
    """Return a day's presses: every thing in turn, each press with its thing and day."""
    rng = np.random.default_rng((SEED, seed))
    gain = np.exp(rng.normal(0, 0.1, SHAPE))
    rest = rng.uniform(200, 240, SHAPE)
    elsewhere, load = rng.uniform(-2e-3, 2e-3, 2), rng.uniform(0.8, 1.2)
    frames, press_of, named = [], [], []
    for number, thing in enumerate(np.tile(list(things()), PRESSES)):
        x, y = elsewhere + rng.normal(0, 0.5e-3, 2)
        pose = Pose(x, y, rng.normal(0, 0.1))
        for share in (0.0, 0.3, 0.6, 1.0, 0.9, 0.4, 0.0):
            depth = share * load * rng.uniform(0.97, 1.03) * DEPTH_M
            stress = felt(things()[thing], depth, pose) if share else np.zeros(SHAPE)
            frames.append(rest + 0.01 * gain * stress + rng.normal(0, 2, SHAPE))
            press_of.append(number)
        named.append(thing)
    pad = Pad(np.round(frames).astype(np.int32), pitch_m=(PITCH_M, PITCH_M))
    return Recording(
        {"pad": pad},
        time_s=np.arange(len(frames)) / 50,
        sensor="generated: 4 mm layer, 16 x 20, 1.5 mm",
        press=np.array(press_of),
        press_columns={"thing": np.array(named), "day": np.repeat(name, len(named))},
    )


def felt(thing: Solid, depth_m: float, pose: Pose) -> np.ndarray:
    """Return the stress on the taxels, pascal."""
    return sense(press(thing, SKIN, depth=depth_m, pose=pose, shape=SHAPE, pitch_m=PITCH_M))


def main(folder: Path) -> None:
    """Write a recording for each day."""
    folder.mkdir(parents=True, exist_ok=True)
    for seed, name in enumerate(DAYS):
        write(day(name, seed), folder / f"{name}.npz")
        print(folder / f"{name}.npz")


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else Path("out/things"))
