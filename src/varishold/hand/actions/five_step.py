"""The grasping action of the paper's section 3.1, in its five steps."""

from __future__ import annotations

from collections.abc import Callable

from varishold.hand.actions.step import Step, record_step
from varishold.hand.bench import Bench
from varishold.hand.hand import FIVE_STEPS
from varishold.hand.pads import PadSetting

__all__ = ["FIVE_STEPS", "five_step"]

# Seconds that each step takes: until digits have come to rest.
_CLOSE_S, _LIFT_S, _SETTLE_S, _ADD_S, _REMOVE_S, _ALL_S = 0.4, 0.4, 0.1, 0.3, 0.25, 0.4


def five_step(
    bench: Bench,
    *,
    pads: PadSetting | None = None,
    pad_steps: tuple[int, ...] = (5,),
    go_on: bool = False,
    watch: Callable[[Bench, Step], None] | None = None,
) -> tuple[Step, ...]:
    """Grasp what stands before the palm.

    Parameters
    ----------
    bench : Bench
    pads : PadSetting, optional
        Press these taxel pads; default: leave them out.
    pad_steps : tuple of int
        Numbers of the steps at whose end the pads are pressed.
    go_on : bool
        Carry on after a step at which nothing is felt any more. By default the action ends there.
    watch : callable, optional
        Called with the bench and each step when it ends, as to take its picture.

    Returns
    -------
    tuple of Step
        Five steps, or fewer where nothing was felt between the digits; a hand leaves out those that it has no digits
        for.

    References
    ----------
    Kinoshita, Aida and Mori, section 3.1, "Grasping action", and Fig. 6.
    """
    design = bench.design
    steps: list[Step] = []
    for number, name in design.steps.items():
        if number == 1:
            bench.put_digits(closed_digits=dict(design.pinch))
            bench.advance(_CLOSE_S)
        elif number == 2:
            bench.advance(_LIFT_S, carriage={"wrist": design.lift_rad})
            bench.advance(_SETTLE_S)
        elif number == 3 and design.supporter is not None:
            bench.put_digits(closed_digits={design.supporter: 1.0})
            bench.advance(_ADD_S)
        elif number == 4:
            bench.put_digits(open_digits=(design.pointer,))
            bench.advance(_REMOVE_S)
        else:
            bench.close_all()
            bench.advance(_ALL_S)
        before = steps[-1] if steps else None
        pressed = pads if number in pad_steps else None
        steps.append(record_step(bench, number, name, pads=pressed, before=before))
        if watch is not None:
            watch(bench, steps[-1])
        if not steps[-1].felt and not go_on:
            break
    return tuple(steps)
