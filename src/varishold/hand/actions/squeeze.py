"""A grip by all digits at once, where the object stands."""

from __future__ import annotations

from varishold.hand.actions.step import Step, record_step
from varishold.hand.bench import Bench
from varishold.hand.pads import PadSetting

__all__ = ["squeeze"]

# Seconds until all digits have come to rest, and that the wrist takes to lift.
_CLOSE_S, _LIFT_S = 0.5, 0.5


def squeeze(bench: Bench, *, lift: bool = False, pads: PadSetting | None = None) -> tuple[Step, ...]:
    """Close thumb and all fingers around what stands before the palm, and lift it if asked.

    What two digits would drop, such as a ball, all five can hold.

    Parameters
    ----------
    bench : Bench
        The hand open before the object, as `search` and `approach` leave it.
    lift : bool
        Turn the wrist afterwards.
    pads : PadSetting, optional
        Press these taxel pads at the end of each step.

    Returns
    -------
    tuple of Step
        One step, or two.
    """
    design = bench.design
    bench.close_all()
    bench.advance(_CLOSE_S)
    steps = [record_step(bench, 1, "thumb and all fingers grasp", pads=pads)]
    if lift:
        bench.advance(_LIFT_S, carriage={"wrist": design.lift_rad})
        steps.append(record_step(bench, 2, "the wrist lifts", pads=pads, before=steps[0]))
    return tuple(steps)
