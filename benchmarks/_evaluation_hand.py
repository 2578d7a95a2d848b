"""The hand that evaluates what was learned with another: other friction, noise, grid and ranges of chance."""

from __future__ import annotations

from varishold.hand import HandDesign, HandSetting, PadSetting, Randomization
from varishold.skin import Taxels

__all__ = ["WHAT_DIFFERS", "evaluation_setting"]

#: Said beside every figure.
WHAT_DIFFERS = (
    "evaluated with friction .65 instead of .8, wider chance of friction and torque (1.3, 1.25), 2 % noise on the pads "
    "instead of 1 %, and the pads' contact solved with 3 cells a taxel instead of 2"
)


def evaluation_setting(*, finger_scale: float = 1.0) -> HandSetting:
    """Return a hand that must search, with pads."""
    return HandSetting(
        design=HandDesign(finger_scale=finger_scale, friction=0.65),
        randomization=Randomization(friction=1.3, torque=1.25),
        pads=PadSetting(taxels=Taxels(noise=0.02), cells_a_taxel=3),
        search=True,
    )
