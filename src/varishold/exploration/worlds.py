"""Every touch of one object in one world, as a library is learned from."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from varishold.exploration.touches import PLANS, Felt, Station, make_touch
from varishold.hand import HandSetting, set_up, stand_up_at

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
        The same seed gives the same world, bit by bit.
    setting : HandSetting

    Returns
    -------
    dict of str to Felt
        By name of `PLANS`; without the touches that missed or dropped the object.
    """
    bench, _ = set_up(name, size_m, seed=seed, setting=setting)
    felt = {"grasp": make_touch(bench, PLANS["grasp"], Station(), setting)}
    chance = bench.circumstances
    stand_up_at(bench, setting, (chance.forward_m, chance.sideways_m, chance.yaw_rad))
    station = Station()
    felt["squeeze"] = make_touch(bench, PLANS["squeeze"], station, setting)
    others = [plan for plan in PLANS if plan not in ("grasp", "squeeze", _BEYOND)]
    if felt["squeeze"] is not None:
        for k in np.random.default_rng(seed + 77).permutation(len(others)):
            felt[others[k]] = make_touch(bench, PLANS[others[k]], station, setting)
        felt[_BEYOND] = touch_beyond(name, size_m, seed=seed, setting=setting)
    return {touch: what for touch, what in felt.items() if what is not None}


def touch_beyond(name: str, size_m: float, *, seed: int, setting: HandSetting) -> Felt | None:
    """Squeeze the object where it was set up, and touch beyond its middle; arguments as of `touch_all`."""
    bench, _ = set_up(name, size_m, seed=seed, setting=setting)
    station = Station()
    if make_touch(bench, PLANS["squeeze"], station, replace(setting, pads=None)) is None:
        return None
    return make_touch(bench, PLANS[_BEYOND], station, setting)
