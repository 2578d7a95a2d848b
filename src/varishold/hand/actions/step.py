"""What one step of an action leaves behind, and whether the hand feels that it still holds something."""

from __future__ import annotations

from dataclasses import dataclass

from varishold.hand.bench import Bench, Sensed
from varishold.hand.coordinates import feels_held
from varishold.hand.pads import PadFrames, PadSetting, press_pads

__all__ = ["Step", "record_step"]


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


def record_step(
    bench: Bench, number: int, name: str, *, pads: PadSetting | None = None, before: Step | None = None
) -> Step:
    """Read everything that the hand feels at the end of a step, which may follow one `before`."""
    sensed = bench.sense()
    return Step(
        number,
        name,
        sensed,
        feels_held(sensed, bench.design, bench.layout, before=None if before is None else before.sensed),
        bench.held,
        press_pads(bench, setting=pads, seed=bench.seed) if pads is not None else None,
    )
