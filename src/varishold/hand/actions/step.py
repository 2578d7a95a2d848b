"""What one step of an action leaves behind, and whether the hand feels that it still holds something."""

from __future__ import annotations

from dataclasses import dataclass

from varishold.hand.bench import Bench, Sensed
from varishold.hand.coordinates import gripped, touching
from varishold.hand.design import HandDesign
from varishold.hand.layouts import Layout
from varishold.hand.pads import PadFrames, PadSetting, press_pads

__all__ = ["Step", "feels_held", "record_step"]

#: Digits that meet nearer than this have met each other and no object. Metres.
_EMPTY_M = 0.02


@dataclass(frozen=True)
class Step:
    """The end of one step.

    Parameters
    ----------
    number : int
        Counted from 1 within its action.
    name : str
        What the hand did.
    sensed : Sensed
        Switches, forces, joint angles and the palm's place.
    felt : bool
        Whether touch and angles alone say that something is held.
    held : bool
        The truth: whether the object hangs in the hand, off the table.
    pads : PadFrames or None
        The taxel pads' frames, where they were asked for.
    """

    number: int
    name: str
    sensed: Sensed
    felt: bool
    held: bool
    pads: PadFrames | None = None


def feels_held(sensed: Sensed, design: HandDesign, layout: Layout) -> bool:
    """Whether touch and angles alone say that something is between fingers and thumb.

    A closed hand touches itself; its angles then say that nothing is left between the digits.
    """
    grip = gripped(sensed, design, layout)
    return grip is not None and grip[0] > _EMPTY_M and bool(touching(sensed, layout).any())


def record_step(bench: Bench, number: int, name: str, *, pads: PadSetting | None = None) -> Step:
    """Read everything that the hand feels at the end of a step."""
    sensed = bench.sense()
    return Step(
        number,
        name,
        sensed,
        feels_held(sensed, bench.design, bench.layout),
        bench.held,
        press_pads(bench, setting=pads, seed=bench.seed) if pads is not None else None,
    )
