"""The touch of a fingertip: a finger's end comes down on what the hand stands before."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from varishold.errors import require
from varishold.hand.actions.search import approach, open_hand
from varishold.hand.actions.step import Step, record_step
from varishold.hand.bench import Bench
from varishold.hand.coordinates import phalanges
from varishold.hand.pads import PadSetting

__all__ = ["Fingertip", "come_down", "fingertip"]

#: The palm starts so high above its usual height, and ends its way down here. Metres.
_START_M, _LOWEST_M = 0.10, -0.08

#: The palm goes forward at most so far until it touches, and so far back before it rises. Metres.
_FAR_M, _BACK_M = 0.20, 0.12

#: Speed of the way down. Metres per second.
_SPEED_M_S = 0.10

#: How far the fingertip pushes on after its switch has closed. Metres.
_PUSH_M = 0.001


@dataclass(frozen=True)
class Fingertip:
    """What the fingertip met.

    Parameters
    ----------
    touched : bool
        Whether the distal switch closed on the way down.
    height_m : float
        Height of the pad over the palm's zero where it stopped. Metres.
    step : Step
        Everything felt there.
    """

    touched: bool
    height_m: float
    step: Step


def fingertip(bench: Bench, *, inward_m: float = 0.015, pads: PadSetting | None = None) -> Fingertip:
    """Touch the top of the object with the pointing finger's end, near the side that faces the palm.

    Parameters
    ----------
    bench : Bench
        The hand empty and behind the object, as `let_go` leaves it; it goes forward until it touches.
    inward_m : float
        How far behind the palm's plane, along its heading, the middle of the fingertip's pad comes down. Metres.
    pads : PadSetting, optional

    Returns
    -------
    Fingertip
    """
    open_hand(bench)
    approach(bench, most_m=_FAR_M + bench.design.longer_m, push_m=0.0)
    back_m = _BACK_M + bench.design.longer_m
    bench.advance(0.3, carriage=bench.ahead(-back_m))
    return come_down(bench, back_m + inward_m, pads=pads)


def come_down(bench: Bench, ahead_m: float, *, pads: PadSetting | None = None) -> Fingertip:
    """Come down from above with the pointing finger's end, so far ahead of the palm; arguments as of `fingertip`.

    The hand stands clear of the object, open, and heads for it.

    Raises
    ------
    InputError
        If no digit of the hand can.
    """
    design, tip = bench.design, bench.design.tip
    require(tip is not None, "no digit of this hand can come down on an object from above")
    bench.advance(0.5, carriage={"raise": _START_M, "wrist": 0.0})
    wanted = design.to_come_down()
    bench.put_digits(
        posed_digits={digit: angles for digit, angles in wanted.items() if angles is not None},
        open_digits=tuple(digit for digit, angles in wanted.items() if angles is None),
    )
    # Turned by a quarter about its heading, the hand's fingers' side looks up and their inner sides down.
    tip_m, height_m = design.tip_place_m
    forward = bench.ahead(ahead_m - tip_m, height_m)
    bench.advance(0.5, carriage={**forward, "roll": np.pi / 2})
    bench.closed[:] = False
    while not bench.part_touched(str(tip)) and bench.target["raise"] > _LOWEST_M:
        bench.advance(0.01, carriage={"raise": bench.target["raise"] - 0.01 * _SPEED_M_S})
    touched = bench.part_touched(str(tip))
    if touched:
        bench.advance(0.05, carriage={"raise": bench.target["raise"] - _PUSH_M})
    step = record_step(bench, 1, "fingertip", pads=pads)
    place = phalanges(step.sensed.angles_rad, design)
    _, toward_fingers_m, _ = dict(zip(place.parts, place.middle_m.tolist(), strict=True))[str(tip)]
    height = bench.target["raise"] + toward_fingers_m
    return Fingertip(touched, height, step)
