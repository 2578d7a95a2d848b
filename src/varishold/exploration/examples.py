"""Every touch of one object, as a library is learned from: one example."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from varishold.exploration.touch import Felt, PoseEstimate
from varishold.exploration.touches import TOUCHES
from varishold.hand import HandSetting, set_up
from varishold.hand.grasping import stand_up_at

__all__ = ["touch_all", "touch_beyond"]

_BEYOND = "fingertip-beyond"


def touch_all(name: str, size_m: float, *, seed: int, setting: HandSetting) -> dict[str, Felt]:
    """Grasp, stand the object up again, squeeze, and then make every other touch in an order drawn by chance.

    The fingertip's touch beyond the middle is made after a squeeze of its own.

    Parameters
    ----------
    name : str
        As of `varishold.hand.graspable`.
    size_m : float
        Metres.
    seed : int
        The same seed gives the same example, bit by bit.
    setting : HandSetting

    Returns
    -------
    dict of str to Felt
        By name of `TOUCHES`; without the touches that missed or dropped the object.
    """
    bench, _ = set_up(name, size_m, seed=seed, setting=setting)
    felt = {"grasp": TOUCHES["grasp"].make_timed(bench, PoseEstimate(), setting)}
    chance = bench.circumstances
    stand_up_at(bench, setting, (chance.forward_m, chance.sideways_m, chance.yaw_rad))
    pose = PoseEstimate()
    felt["squeeze"] = TOUCHES["squeeze"].make_timed(bench, pose, setting)
    others = [touch for touch in TOUCHES.values() if not touch.begins and touch.name != _BEYOND]
    if felt["squeeze"] is not None:
        for k in np.random.default_rng(seed + 77).permutation(len(others)):
            felt[others[k].name] = others[k].make_timed(bench, pose, setting)
        felt[_BEYOND] = touch_beyond(name, size_m, seed=seed, setting=setting)
    return {touch: what for touch, what in felt.items() if what is not None}


def touch_beyond(name: str, size_m: float, *, seed: int, setting: HandSetting) -> Felt | None:
    """Squeeze the object where it was set up, and touch beyond its middle; arguments as of `touch_all`."""
    bench, _ = set_up(name, size_m, seed=seed, setting=setting)
    pose = PoseEstimate()
    if TOUCHES["squeeze"].make_timed(bench, pose, replace(setting, pads=None)) is None:
        return None
    return TOUCHES[_BEYOND].make_timed(bench, pose, setting)
