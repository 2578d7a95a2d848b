"""The hand that evaluates what was learned with another: other friction, noise, grid and ranges of chance."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from varishold.hand import HandDesign, HandSetting, PadSetting, Randomization, hand_setting
from varishold.hand.mjcf import MjcfHand
from varishold.skin import Taxels

__all__ = ["TURN_DEG", "WHAT_DIFFERS", "WIDEST_FRICTION", "evaluation_setting"]

#: How far objects are turned at most to either side, unless something else is asked for. Degrees.
TURN_DEG = 20.0

#: Coefficients of friction between which hands and things may lie at all.
WIDEST_FRICTION = (0.4, 1.3)

#: Said beside every figure.
WHAT_DIFFERS = (
    "evaluated with friction .65 instead of .8, wider chance of friction and torque (1.3, 1.25), 2 % noise on the pads "
    "instead of 1 %, and the pads' contact solved with 3 cells a taxel instead of 2"
)


def evaluation_setting(
    *,
    finger_scale: float = 1.0,
    turn_deg: float = TURN_DEG,
    widest_friction: bool = False,
    hand: MjcfHand | None = None,
) -> HandSetting:
    """Return a hand that must search, with pads.

    Parameters
    ----------
    finger_scale : float
    turn_deg : float
        How far objects are turned at most to either side. Degrees.
    widest_friction : bool
        Draw the friction between `WIDEST_FRICTION` instead.
    hand : MjcfHand, optional
        Another hand than the built-in one.
    """
    friction, factor = 0.65, 1.3
    if widest_friction:
        low, high = WIDEST_FRICTION
        friction, factor = float(np.sqrt(low * high)), float(np.sqrt(high / low))
    usual = HandSetting(design=HandDesign(finger_scale=finger_scale, friction=friction))
    return replace(
        usual if hand is None else hand_setting(replace(hand, friction=friction)),
        randomization=Randomization(friction=factor, torque=1.25, search_rad=float(np.deg2rad(turn_deg))),
        pads=PadSetting(taxels=Taxels(noise=0.02), cells_a_taxel=3),
        search=True,
    )
