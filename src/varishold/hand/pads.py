"""Taxel pads on the phalanges and the palm: what a skin makes of the contact force and the object's surface.

The simulation's bodies are rigid; each contact gives a force and where the object's surface lies before the
pad. The skin room presses that surface into the pad's skin with that force.
"""

from __future__ import annotations

import warnings
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from varishold.errors import InputError, NotConvergedError
from varishold.frame.checks import as_positive
from varishold.hand.hand import Hand
from varishold.skin import Skin, Taxels, press, sense

if TYPE_CHECKING:
    from varishold.hand.bench import Bench

__all__ = ["PadFrames", "PadSetting", "pad_pitch_m", "pad_shape", "press_pads"]

#: Rays to the object's surface start so far behind the pad, and what lies farther before it cannot touch. Metres.
_BEHIND_M, _BEFORE_M = 0.015, 0.012

#: A pad has so many taxels each way at least.
_LEAST_TAXELS = 4


@dataclass(frozen=True)
class PadSetting:
    """The pads' taxels and skin.

    Parameters
    ----------
    phalanx_pitch_m, palm_pitch_m : float
        Taxel spacing. Metres.
    skin : Skin
    taxels : Taxels
    least_n : float
        A pad pressed with less reports zeros. Newtons.
    tolerance : float
        Of the contact solver, as a share of the depth.
    cells_a_taxel : int
        Cells of the contact solver along a taxel, at least; more where taxels lie too shallow for so few.
    """

    phalanx_pitch_m: float = 0.002
    palm_pitch_m: float = 0.004
    skin: Skin = field(
        default_factory=lambda: Skin(
            "layer", thickness_m=0.004, poisson=0.45, sensing_depth_m=0.001, youngs_modulus_pa=1.5e5
        )
    )
    taxels: Taxels = field(default_factory=lambda: Taxels(noise=0.01))
    least_n: float = 0.1
    tolerance: float = 1e-3
    cells_a_taxel: int = 2

    def __post_init__(self) -> None:
        for name in ("phalanx_pitch_m", "palm_pitch_m", "least_n", "tolerance"):
            as_positive(getattr(self, name), f"{name} of the pads")
        if not 1 <= self.cells_a_taxel <= 16:
            raise InputError(f"cells_a_taxel of the pads must lie in 1 .. 16, got {self.cells_a_taxel!r}")
        if self.skin.youngs_modulus_pa is None:
            raise InputError("the pads' skin needs youngs_modulus_pa, for the simulation gives forces")


@dataclass(frozen=True)
class PadFrames:
    """What all pads read at one moment.

    Parameters
    ----------
    frames : dict of str to ndarray of shape (rows, cols), float64
        By the part that each covers. Columns run along a phalanx away from the palm, or along the palm's y; rows
        along z. Pascals.
    pitch_m : dict of str to float
        Taxel spacing. Metres.
    force_n : dict of str to float
        Force that pressed each pad. Newtons.
    """

    frames: dict[str, NDArray[np.float64]]
    pitch_m: dict[str, float]
    force_n: dict[str, float]


def pad_pitch_m(part: str, design: Hand, setting: PadSetting) -> float:
    """Taxel spacing of a part's pad, metres."""
    usual = setting.palm_pitch_m if part == "palm" else setting.phalanx_pitch_m
    return design.pad_pitch_m(part) or usual


def pad_shape(part: str, design: Hand, setting: PadSetting) -> tuple[int, int]:
    """Rows and columns of a part's pad."""
    pitch = pad_pitch_m(part, design, setting)
    rows, cols = (max(_LEAST_TAXELS, round(length / pitch)) for length in design.pad_size_m(part))
    return rows, cols


def press_pads(bench: Bench, *, setting: PadSetting | None = None, seed: int = 0) -> PadFrames:
    """Press the object's surface on each pad that it touches.

    Parameters
    ----------
    bench : Bench
    setting : PadSetting, optional
    seed : int
        Fixes the taxels' noise.

    Returns
    -------
    PadFrames
        Zeros where a pad touches nothing.
    """
    setting = setting or PadSetting()
    forces = bench.object_forces_n()
    frames, pitches = {}, {}
    for k, part in enumerate(bench.design.pads):
        pitch = pad_pitch_m(part, bench.design, setting)
        shape = pad_shape(part, bench.design, setting)
        pitches[part] = pitch
        frames[part] = np.zeros(shape)
        if forces[part] < setting.least_n:
            continue
        height = surface_before(bench, part, shape, pitch)
        if height is None:
            continue
        try:
            with warnings.catch_warnings():
                # A pad's edge can stop the solver a little short; its share is below the taxels' noise.
                warnings.simplefilter("ignore", RuntimeWarning)
                pressed = press(
                    height,
                    setting.skin,
                    force=forces[part],
                    shape=shape,
                    pitch_m=pitch,
                    per_taxel=max(setting.cells_a_taxel, _cells_a_taxel(pitch, setting.skin)),
                    tolerance=setting.tolerance,
                )
        except NotConvergedError:
            continue
        frames[part] = sense(pressed, setting.taxels, seed=1000 * seed + k)
    return PadFrames(frames, pitches, forces)


def _cells_a_taxel(pitch_m: float, skin: Skin) -> int:
    """The solver's cells must not be coarser than the taxels lie deep."""
    return max(2, int(np.ceil(pitch_m / skin.sensing_depth_m - 1e-9))) if skin.sensing_depth_m > 0 else 2


def surface_before(bench: Bench, part: str, shape: tuple[int, int], pitch_m: float) -> NDArray[np.float64] | None:
    """Height of the object's surface over a pad's plane, toward the pad, at twice as many points as taxels.

    Returns
    -------
    ndarray of shape (2 * rows, 2 * cols), or None
        Metres; None where no part of the object lies before the pad.
    """
    origin, across, up, outward = bench.pad_frame(part)
    rows, cols = 2 * shape[0], 2 * shape[1]
    u = (np.arange(cols) + 0.5 - cols / 2) * pitch_m / 2
    v = (np.arange(rows) + 0.5 - rows / 2) * pitch_m / 2
    grid_u, grid_v = np.meshgrid(u, v)
    points = origin + grid_u[..., None] * across + grid_v[..., None] * up - _BEHIND_M * outward
    place, turn = bench.object_pose()
    local = (points.reshape(-1, 3) - place) @ turn
    direction = outward @ turn
    reach = np.full(local.shape[0], np.inf)
    for body in bench.solid.body():
        reach = np.minimum(reach, body.hits(local, direction))
    height = _BEHIND_M - reach
    if not (height > -_BEFORE_M).any():
        return None
    cut: NDArray[np.float64] = np.maximum(height, height.max() - _BEFORE_M).reshape(rows, cols)
    return cut
