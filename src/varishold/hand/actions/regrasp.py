"""Changing the grip: set the object down, let go, and grasp it elsewhere."""

from __future__ import annotations

from typing import Literal

import numpy as np

from varishold.hand.actions.five_step import five_step
from varishold.hand.actions.search import approach, open_hand, search
from varishold.hand.actions.squeeze import squeeze
from varishold.hand.actions.step import Step
from varishold.hand.bench import Bench
from varishold.hand.coordinates import gripped
from varishold.hand.pads import PadSetting

__all__ = ["CLEAR_M", "let_go", "move_round", "object_middle", "regrasp"]

#: Steps back before the hand turns about an object, so that open fingers pass it by; longer ones farther. Metres.
CLEAR_M = 0.11

#: The object may have moved so much farther away. Metres.
_MARGIN_M = 0.03

#: What the hand takes for an object's breadth where it grips nothing. Metres.
_USUAL_M = 0.08

#: A hand that came down from above rises so far before it turns back. Metres.
_RISE_M = 0.10


def object_middle(bench: Bench) -> tuple[float, float]:
    """Return where the middle of what stands before the palm is, as the hand feels it.

    Returns
    -------
    tuple of 2 floats
        Along x and y of the palm's zero frame, metres. Where nothing is gripped, a usual breadth is assumed.
    """
    grip = gripped(bench.sense(), bench.design, bench.layout)
    half_m, aside_m = (_USUAL_M / 2, 0.0) if grip is None else (grip[0] / 2, grip[1])
    ahead = bench.ahead(half_m, aside_m)
    return ahead["reach"], ahead["shift"]


def let_go(bench: Bench) -> None:
    """Set the object down where it was lifted, open the hand and step back."""
    clear_m = CLEAR_M + bench.design.longer_m
    bench.advance(0.5, carriage={"wrist": 0.0})
    bench.advance(0.1)
    open_hand(bench, seconds=0.3)
    if bench.target["roll"] != 0.0:
        bench.advance(0.3, carriage={"raise": bench.target["raise"] + _RISE_M})
        bench.advance(0.5, carriage={**bench.ahead(-2 * clear_m), "roll": 0.0})
        bench.advance(0.4, carriage={"raise": 0.0})
        return
    bench.advance(0.3, carriage=bench.ahead(-clear_m))


def move_round(
    bench: Bench,
    middle_m: tuple[float, float],
    *,
    turn_rad: float,
    raise_m: float,
    away_m: float | None = None,
) -> None:
    """Go and stand before an object from another side, at another height; the hand empty and clear of it.

    Parameters
    ----------
    bench : Bench
    middle_m : (float, float)
        The object's middle along x and y of the palm's zero frame. Metres.
    turn_rad : float
        The palm's turn there, from +x toward +y.
    raise_m : float
        The palm's height over its zero there. Metres.
    away_m : float, optional
        How far from the middle the palm stands. Metres. Default: clear of an object of a usual breadth.
    """
    if away_m is None:
        away_m = CLEAR_M + _USUAL_M / 2 + bench.design.longer_m
    place = {
        "reach": middle_m[0] - away_m * float(np.cos(turn_rad)),
        "shift": middle_m[1] - away_m * float(np.sin(turn_rad)),
        "turn": turn_rad,
        "raise": raise_m,
    }
    bench.advance(0.6, carriage=place)


def regrasp(
    bench: Bench,
    *,
    turn_rad: float = 0.0,
    raise_m: float = 0.0,
    by: Literal["five-step", "squeeze"] = "five-step",
    middle_m: tuple[float, float] | None = None,
    pads: PadSetting | None = None,
    pad_steps: tuple[int, ...] = (5,),
) -> tuple[Step, ...]:
    """Grasp the object that the hand holds from another side or at another height.

    Parameters
    ----------
    bench : Bench
        After a grasp or a touch.
    turn_rad : float
        How far the hand goes round the object, from +x toward +y.
    raise_m : float
        How far it goes up. Metres; the palm stays between the table and the top of what it can reach.
    by : {"five-step", "squeeze"}
        Grasp in five steps, or close all digits at once and leave the object on the table.
    middle_m : (float, float), optional
        Where the object's middle was felt, from `object_middle`; default: what the hand feels now.
    pads : PadSetting, optional
    pad_steps : tuple of int

    Returns
    -------
    tuple of Step
        As `five_step` or `squeeze`; empty where the hand did not find the object again.
    """
    middle_m = object_middle(bench) if middle_m is None else middle_m
    before = bench.target
    let_go(bench)
    move_round(bench, middle_m, turn_rad=before["turn"] + turn_rad, raise_m=before["raise"] + raise_m)
    if not search(bench, most_m=CLEAR_M + _MARGIN_M + bench.design.longer_m).found:
        return ()
    approach(bench, most_m=_MARGIN_M)
    if by == "squeeze":
        return squeeze(bench, pads=pads)
    return five_step(bench, pads=pads, pad_steps=pad_steps)
