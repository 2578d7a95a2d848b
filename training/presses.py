"""Labelled frames of random presses into random elastic skins."""

from __future__ import annotations

import warnings
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from training.frames import NAMELESS_PILLARS, PADS, Pad, nameless_pillar
from training.strangers import stranger_face
from varishold.skin import Skin, press, sense
from varishold.solids import draw_contact

Array = NDArray[np.float64]

SkinPads = tuple[tuple[float, Pad, tuple[float, float], int], ...]
#: Pads on skins, of each table: weight, the pad, the range of its pitch (metres), solver cells along a taxel's side.
SKIN_PADS: dict[str, SkinPads] = {
    "small": tuple((weight, pad, (2.5e-3, 4.5e-3), 10) for weight, pad in PADS["small"]),
    "middle": (
        (0.48, Pad((16, 16), (3.6, 13.0), (0.003, 0.025)), (1.4e-3, 3.2e-3), 5),
        (0.14, Pad((16, 16), (2.1, 5.5), (0.003, 0.025)), (1.4e-3, 3.2e-3), 5),
        (0.14, Pad((10, 10), (2.2, 8.5), (0.003, 0.025)), (2.0e-3, 4.0e-3), 7),
        (0.12, Pad((12, 12), (2.4, 10.0), (0.003, 0.025)), (1.8e-3, 3.6e-3), 6),
        (0.12, Pad((12, 20), (2.4, 10.5), (0.003, 0.025)), (1.4e-3, 3.2e-3), 5),
    ),
    "surfaces": (
        (0.64, Pad((32, 32), (7.0, 26.0), (0.002, 0.02)), (0.7e-3, 1.6e-3), 3),
        (0.10, Pad((32, 32), (2.4, 8.0), (0.002, 0.02)), (0.7e-3, 1.6e-3), 3),
        (0.20, Pad((24, 24), (4.0, 20.0), (0.002, 0.025)), (0.8e-3, 2.2e-3), 4),
        (0.06, Pad((24, 24), (2.2, 6.0), (0.002, 0.025)), (0.8e-3, 2.2e-3), 4),
    ),
}
SKIN_PADS["wide"] = tuple((row[0] / 2, *row[1:]) for table in ("middle", "surfaces") for row in SKIN_PADS[table])


#: Share of the skins whose taxels lie at the surface, where a sharp edge presses without limit.
AT_THE_SURFACE = 0.25


@dataclass(frozen=True)
class Pressed:
    """A random press: the noiseless frame, the skin and pitch under it, and the (long, short) lengths, in
    taxels, that recognition should report."""

    frame: Array
    skin: Skin
    pitch_m: float
    pad: Pad
    size: tuple[float, float]


def draw_skin(rng: np.random.Generator, pitch_m: float, cell_m: float) -> Skin:
    """Draw a skin: mostly layers of any softness and thickness, some half-spaces, a few springs.

    Taxels lie at the surface or at least one solver cell below it: nothing between is resolved.
    """
    sensing = float(rng.uniform(0.0, 1.4) * min(pitch_m, 1.5e-3))
    sensing = 0.0 if rng.random() < AT_THE_SURFACE else max(sensing, 1.02 * cell_m)
    choice = rng.random()
    if choice < 0.42:
        return Skin("half-space", poisson=float(rng.uniform(0.3, 0.5)), sensing_depth_m=sensing)
    thickness = float(np.exp(rng.uniform(*np.log((2e-3, 14e-3)))))
    thickness = max(thickness, 2 * sensing)
    poisson = float(rng.uniform(0.3, 0.47) if rng.random() < 0.6 else rng.uniform(0.47, 0.499))
    kind = "winkler" if choice > 0.95 else "layer"
    return Skin(kind, thickness_m=thickness, poisson=poisson, sensing_depth_m=sensing)


def draw_skin_pad(rng: np.random.Generator, pads: SkinPads) -> tuple[Pad, float, int]:
    """Draw a pad by its weight: the pad, its pitch in metres, solver cells a taxel's side."""
    weights = np.array([row[0] for row in pads])
    _, pad, pitches, per_taxel = pads[int(rng.choice(len(pads), p=weights / weights.sum()))]
    return pad, float(np.exp(rng.uniform(*np.log(pitches)))), per_taxel


def press_on(rng: np.random.Generator, key: str, pad: Pad, skin: Skin, pitch: float, per_taxel: int) -> Pressed:
    """Press the kind `key` at a random place, size and depth into `skin`.

    Raises
    ------
    InputError
        If nothing touches.
    """
    rows, cols = pad.shape
    broad = (pad.size[0] * pitch, pad.size[1] * pitch)
    if key == "lying-cylinder" and rng.random() < 0.6:
        # As narrow as other bars are.
        broad = (max(0.5 * pad.size[0], 1.4) * pitch, 0.5 * pad.size[1] * pitch)
    deepest = 0.3 * broad[0] if skin.thickness_m is None else min(0.3 * broad[0], 0.4 * skin.thickness_m)
    depth = float(np.exp(rng.uniform(*np.log((max(0.08 * deepest, 1e-5), deepest)))))
    with warnings.catch_warnings():
        # A press that stopped a little short of its tolerance is still far below the taxels' noise.
        warnings.simplefilter("ignore", RuntimeWarning)
        if key in NAMELESS_PILLARS or key == "stranger":
            if key == "stranger":
                face = stranger_face(rng, pad.shape, pad.size, per_taxel=per_taxel)
            else:
                face = nameless_pillar(rng, key, pad, per_taxel)
            made = press(
                face * 1.5 * depth,
                skin,
                depth=depth,
                shape=pad.shape,
                pitch_m=pitch,
                per_taxel=per_taxel,
                tolerance=1e-3,
            )
            return Pressed(sense(made), skin, pitch, pad, (np.nan, np.nan))
        drawn = draw_contact(
            rng,
            key,
            field_m=(rows * pitch, cols * pitch),
            size_m=broad,
            depth_m=depth,
            aspect=(1.35, 3.0),
            top=(0.28, 0.62),
        )
        pose = drawn.pose
        if rng.random() < 0.25:
            tip = 0.15 * drawn.depth_m / broad[0]
            pose = replace(pose, tip_x=float(rng.uniform(-tip, tip)), tip_y=float(rng.uniform(-tip, tip)))
        # What leaves the field may go on over skin that has no taxels, or the skin may end with them.
        beyond = 0
        if drawn.solid.may_leave_field and rng.random() < 0.5:
            beyond = max(2, round(0.3 * min(pad.shape)))
        made = press(
            drawn.solid,
            skin,
            depth=drawn.depth_m,
            pose=pose,
            shape=(rows + 2 * beyond, cols + 2 * beyond),
            pitch_m=pitch,
            per_taxel=per_taxel,
            tolerance=1e-3,
        )
        frame = sense(made)[beyond : beyond + rows, beyond : beyond + cols]
    long, short = drawn.true_size_m
    return Pressed(frame, skin, pitch, pad, (long / pitch, short / pitch))
