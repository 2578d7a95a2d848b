"""Pads of the simulated hand's grasps, labelled with what truly lay under them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from training.pad_scenes import NOMINAL, LabelledPad, Place, labelled_press, vary_skin
from varishold.hand import OBJECTS, Bench, HandDesign, HandSetting, PadSetting, Randomization, Step, grasp_object
from varishold.hand.pads import pad_shape
from varishold.skin import Taxels

__all__ = ["grasped_pads"]

# A pad pressed with less says nothing. Newtons.
_LEAST_N = 0.1


def grasped_pads(
    seeds: Sequence[int],
    *,
    size_m: tuple[float, float] = (0.05, 0.11),
    noise: tuple[float, float] = (0.003, 0.03),
    spread: float = 0.3,
    friction: float | None = None,
    finger_scale: tuple[float, float] = (1.0, 1.0),
    steps: tuple[int, ...] = (3, 5),
) -> Iterator[tuple[str, float, LabelledPad]]:
    """Grasp an object a seed and yield each touched pad with the object's name and size.

    Parameters
    ----------
    seeds : sequence of int
        The objects of `OBJECTS` are taken in turn.
    size_m : (float, float)
    noise : (float, float)
        Range of the taxels' noise over the peak.
    spread : float
        Of the skin's thickness and modulus about the nominal ones.
    friction : float, optional
        Coefficient between hand and object; default: the hand's.
    finger_scale : (float, float)
        Range of the digits' lengths.
    steps : tuple of int
        Steps of the grasp at whose end the pads are looked at.
    """
    names = tuple(OBJECTS)
    pads = PadSetting()
    for k, seed in enumerate(seeds):
        rng = np.random.default_rng([seed, 77])
        design = HandDesign(finger_scale=float(rng.uniform(*finger_scale)))
        if friction is not None:
            design = replace(design, friction=friction)
        setting = HandSetting(design=design, randomization=Randomization(), search=bool(rng.random() < 0.5))
        name, size = names[k % len(names)], float(rng.uniform(*size_m))
        seen: list[Place] = []

        def look(bench: Bench, step: Step, seen: list[Place] = seen) -> None:
            if step.number in steps:
                seen.extend(_places(bench, pads))

        grasp_object(name, size, seed=seed, setting=setting, watch=look)
        for place in seen:
            skin = vary_skin(rng, NOMINAL, spread)
            taxels = Taxels(noise=float(np.exp(rng.uniform(*np.log(noise)))))
            pad = labelled_press(place, skin, taxels, seed=int(rng.integers(2**31)))
            if pad is not None:
                yield name, size, pad


def _places(bench: Bench, pads: PadSetting) -> Iterator[Place]:
    forces = bench.object_forces_n()
    at, turn = bench.object_pose()
    for part in bench.design.parts:
        if forces[part] < _LEAST_N:
            continue
        pitch = pads.palm_pitch_m if part == "palm" else pads.phalanx_pitch_m
        origin, across, up, outward = bench.pad_frame(part)
        yield Place(
            tuple(bench.solid.body()),
            (origin - at) @ turn,
            across @ turn,
            up @ turn,
            outward @ turn,
            pad_shape(part, bench.design, pads),
            pitch,
            forces[part],
        )
