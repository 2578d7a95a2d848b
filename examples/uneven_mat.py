"""Make recordings of a mat as it comes out of its box: unequal taxels, a rest that is not zero, a bent response.

Run ``python examples/uneven_mat.py DIR`` (default: out/mat). It writes ``anything.npz``, eighty presses of things that
nobody names, ``known.npz``, forty presses with the name of what pressed, and ``one.npz``, one press of a cone. The same
seed gives the same files.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np

from varishold.recording import Pad, Recording, write
from varishold.sensor import Power, Sensor
from varishold.solids import Cone, Cylinder, Pose, Pyramid, Ridge, Solid, Sphere, SquarePillar, ideal_frame

SEED, SHAPE, PITCH_M = 1971, (16, 16), 5e-3
COURSE = (0.0, 0.0, 0.0, 0.4, 0.8, 1.0, 0.7, 0.3)


def mat(rng: np.random.Generator) -> Sensor:
    """Return a mat whose taxels differ by a quarter and rest between 15 and 45 counts."""
    return Sensor(
        shape=SHAPE,
        rest=rng.uniform(15, 45, SHAPE),
        span=220.0,
        full_scale=1.0,
        response=Power(0.8),
        gains=np.exp(rng.normal(0, 0.25, SHAPE)),
    )


def thing(rng: np.random.Generator, name: str) -> Solid:
    """Return a thing of a drawn size, in taxels."""
    d = rng.uniform(8, 11)
    made = {
        "cone": Cone(d, 0.8),
        "cylinder": Cylinder(d, 0.8),
        "pyramid": Pyramid(d, 0.8),
        "ridge": Ridge(d, 0.6 * d, 0.8),
        "sphere": Sphere(0.8 * d),
        "square-pillar": SquarePillar(0.8 * d, 0.8),
    }
    return made[name]


def recording(mat: Sensor, rng: np.random.Generator, names: list[str], *, told: bool) -> Recording:
    """Return a press of each thing, the mat free before it."""
    frames = []
    for name in names:
        x, y = rng.uniform(-4, 4, 2)
        pressed = ideal_frame(thing(rng, name), SHAPE, 1.0, pose=Pose(x, y, rng.uniform(0, np.pi)))
        frames += [mat.forward(0.8 * share * pressed / pressed.max()) for share in COURSE]
    readings = np.round(np.array(frames) + rng.normal(0, 1, (len(frames), *SHAPE))).clip(0, 255).astype(np.uint8)
    press = np.repeat(np.arange(len(names)), len(COURSE))
    columns = {"thing": np.array(names)} if told else {}
    return Recording(
        {"pad": Pad(readings, pitch_m=(PITCH_M, PITCH_M))},
        time_s=np.arange(len(readings)) / 50,
        sensor="generated: a mat of 16 x 16, 5 mm",
        press=press if told else None,
        press_columns=columns,
    )


def main(folder: Path) -> None:
    """Write the three recordings."""
    folder.mkdir(parents=True, exist_ok=True)
    rng = np.random.default_rng(SEED)
    one_mat = mat(rng)
    known = ["cone", "cylinder", "pyramid", "ridge", "sphere", "square-pillar"]
    for name, things in {
        "anything": rng.choice(known, 80).tolist(),
        "known": (known * 7)[:40],
        "one": ["cone"],
    }.items():
        write(recording(one_mat, rng, things, told=name == "known"), folder / f"{name}.npz")
        print(folder / f"{name}.npz")


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else Path("out/mat"))
