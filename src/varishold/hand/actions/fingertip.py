"""The touch of a fingertip: a finger's end comes down on what the hand stands before."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

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

#: The pointing finger is held straight; the other digits stay out of its way.
_STRAIGHT_RAD, _FOLDED_RAD = (0.0, 0.0, 0.0), (1.7, 1.9, 1.5)


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
    approach(bench, most_m=_FAR_M, push_m=0.0)
    bench.advance(0.3, carriage=bench.ahead(-_BACK_M))
    return come_down(bench, _BACK_M + inward_m, pads=pads)


def come_down(bench: Bench, ahead_m: float, *, pads: PadSetting | None = None) -> Fingertip:
    """Come down from above with the pointing finger's end, so far ahead of the palm; arguments as of `fingertip`.

    The hand stands clear of the object, open, and heads for it.
    """
    design = bench.design
    bench.advance(0.5, carriage={"raise": _START_M, "wrist": 0.0})
    pointer, thumb = design.digits[design.pointer], design.thumb
    others = tuple(digit for digit in design.digits if digit not in (pointer.name, thumb.name))
    bench.put_digits(posed_digits={pointer.name: _STRAIGHT_RAD, thumb.name: _FOLDED_RAD}, open_digits=others)
    # Turned by a quarter about its heading, the hand's fingers' side looks up and their inner sides down.
    knuckle_m, _ = design.knuckle_m
    *others_m, last_m = design.lengths_m(pointer.name).tolist()
    tip_m = knuckle_m + (sum(others_m) + last_m / 2)
    forward = bench.ahead(ahead_m - tip_m, pointer.height_m)
    bench.advance(0.5, carriage={**forward, "roll": np.pi / 2})
    bench.closed[:] = False
    while not bench.part_touched(design.tip) and bench.target["raise"] > _LOWEST_M:
        bench.advance(0.01, carriage={"raise": bench.target["raise"] - 0.01 * _SPEED_M_S})
    touched = bench.part_touched(design.tip)
    if touched:
        bench.advance(0.05, carriage={"raise": bench.target["raise"] - _PUSH_M})
    step = record_step(bench, 1, "fingertip", pads=pads)
    place = phalanges(step.sensed.angles_rad, design)
    _, toward_fingers_m, _ = dict(zip(place.parts, place.middle_m.tolist(), strict=True))[design.tip]
    height = bench.target["raise"] + toward_fingers_m
    return Fingertip(touched, height, step)
