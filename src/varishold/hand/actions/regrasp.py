"""Changing the grip: set the object down, let go, and grasp it elsewhere."""

from __future__ import annotations

import numpy as np

from varishold.hand.actions.five_step import five_step
from varishold.hand.actions.search import approach, open_hand, search
from varishold.hand.actions.step import Step
from varishold.hand.bench import Bench
from varishold.hand.coordinates import gripped
from varishold.hand.pads import PadSetting

__all__ = ["let_go", "regrasp"]

#: Steps back before the hand turns about an object, so that open fingers pass it by. Metres.
_CLEAR_M = 0.11

#: The object may have moved so much farther away. Metres.
_MARGIN_M = 0.03

#: What the hand takes for an object's breadth where it grips nothing. Metres.
_USUAL_M = 0.08


def let_go(bench: Bench) -> None:
    """Set the object down where it was lifted, open the hand and step back."""
    bench.advance(0.5, carriage={"wrist": 0.0})
    bench.advance(0.1)
    open_hand(bench, seconds=0.3)
    bench.advance(0.3, carriage=bench.ahead(-_CLEAR_M))


def regrasp(
    bench: Bench,
    *,
    turn_rad: float = 0.0,
    raise_m: float = 0.0,
    pads: PadSetting | None = None,
    pad_steps: tuple[int, ...] = (5,),
) -> tuple[Step, ...]:
    """Grasp the object that the hand holds from another side or at another height, in five steps.

    Parameters
    ----------
    bench : Bench
        After a grasp.
    turn_rad : float
        How far the hand goes round the object, from +x toward +y.
    raise_m : float
        How far it goes up. Metres; the palm stays between the table and the top of what it can reach.
    pads : PadSetting, optional
    pad_steps : tuple of int

    Returns
    -------
    tuple of Step
        As `five_step`; empty where the hand did not find the object again.
    """
    grip = gripped(bench.sense(), bench.design, bench.layout)
    ahead_m = (grip[0] if grip is not None else _USUAL_M) / 2
    let_go(bench)
    target = bench.target
    middle_m = ahead_m + _CLEAR_M
    before, after = target["turn"], target["turn"] + turn_rad
    place = {
        "reach": target["reach"] + middle_m * float(np.cos(before) - np.cos(after)),
        "shift": target["shift"] + middle_m * float(np.sin(before) - np.sin(after)),
        "turn": after,
        "raise": target["raise"] + raise_m,
    }
    bench.advance(0.6, carriage=place)
    if not search(bench, most_m=_CLEAR_M + _MARGIN_M).found:
        return ()
    approach(bench, most_m=_MARGIN_M)
    return five_step(bench, pads=pads, pad_steps=pad_steps)
