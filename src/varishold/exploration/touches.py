"""What the automatic loop can do next: each touch as one named plan that the simulated hand carries out."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from varishold.hand import (
    Bench,
    Fingertip,
    HandSetting,
    Step,
    come_before,
    fingertip,
    five_step,
    gripped,
    let_go,
    move_round,
    object_middle,
    regrasp,
    squeeze,
)

__all__ = ["PLANS", "Felt", "Station", "TouchPlan", "make_touch"]


@dataclass(frozen=True)
class TouchPlan:
    """One touch that can be made.

    Parameters
    ----------
    name : str
    kind : {"grasp", "squeeze", "regrasp", "fingertip"}
    turn_rad : float
        How far round the object from where it was first grasped, from +x toward +y.
    raise_m : float
        How far above where it was first grasped. Metres.
    inward : float
        Where on the top a fingertip comes down: parts of the object's felt breadth behind its near side.
    cost : float
        What it takes, in parts of a grasp's.
    """

    name: str
    kind: str
    turn_rad: float = 0.0
    raise_m: float = 0.0
    inward: float = 0.0
    cost: float = 1.0


#: The touches by name. The first is the paper's; a squeeze takes its place after a fall.
PLANS: dict[str, TouchPlan] = {
    plan.name: plan
    for plan in (
        TouchPlan("grasp", "grasp"),
        TouchPlan("squeeze", "squeeze"),
        TouchPlan("regrasp-higher", "regrasp", raise_m=0.02),
        TouchPlan("regrasp-lower", "regrasp", raise_m=-0.02),
        TouchPlan("regrasp-turned-45", "regrasp", turn_rad=float(np.pi / 4)),
        TouchPlan("regrasp-turned-90", "regrasp", turn_rad=float(np.pi / 2)),
        TouchPlan("fingertip-edge", "fingertip", inward=0.15),
        TouchPlan("fingertip-middle", "fingertip", inward=0.5),
        # Behind what is as deep as it is broad, and still on what is deeper.
        TouchPlan("fingertip-beyond", "fingertip", inward=1.2),
    )
}


@dataclass
class Station:
    """Where the hand believes the object to be: what it needs to find it again from another side.

    Parameters
    ----------
    turn_rad, raise_m : float
        Turn and height of the palm at the first grasp.
    middle_m : (float, float)
        The object's middle, as last felt, in the palm's zero frame. Metres.
    """

    turn_rad: float = 0.0
    raise_m: float = 0.0
    middle_m: tuple[float, float] | None = None
    breadth_m: float = 0.08


@dataclass(frozen=True)
class Felt:
    """What a touch felt.

    Parameters
    ----------
    plan : TouchPlan
    step : Step
        Everything felt at its end.
    height_m : float or None
        Of a fingertip: height over the palm's zero where it came to rest; None where it met nothing. Metres.
    """

    plan: TouchPlan
    step: Step
    height_m: float | None = None


def make_touch(
    bench: Bench,
    plan: TouchPlan,
    station: Station,
    setting: HandSetting,
    watch: Callable[[Bench, Step], None] | None = None,
) -> Felt | None:
    """Carry a touch out.

    Parameters
    ----------
    bench : Bench
    plan : TouchPlan
    station : Station
        Changed: what the touch says about the object's place.
    setting : HandSetting
    watch : callable, optional
        Called with the bench and the step when the touch is complete.

    Returns
    -------
    Felt or None
        None where the hand felt that it missed or dropped the object.
    """
    height_m = None
    if plan.kind == "fingertip":
        tip = _fingertip(bench, plan, station, setting)
        step, height_m = tip.step, tip.height_m if tip.touched else None
    else:
        steps = _grip(bench, plan, station, setting)
        if not steps or not steps[-1].felt:
            return None
        step = steps[-1]
        grip = gripped(step.sensed, bench.design, bench.layout)
        station.middle_m = object_middle(bench)
        station.breadth_m = station.breadth_m if grip is None else grip[0]
    if watch is not None:
        watch(bench, step)
    return Felt(plan, step, height_m)


def _grip(bench: Bench, plan: TouchPlan, station: Station, setting: HandSetting) -> tuple[Step, ...]:
    if plan.kind == "regrasp":
        now = bench.target
        return regrasp(
            bench,
            turn_rad=station.turn_rad + plan.turn_rad - now["turn"],
            raise_m=station.raise_m + plan.raise_m - now["raise"],
            by="squeeze",
            middle_m=station.middle_m,
            pads=setting.pads,
        )
    found = come_before(bench, setting)
    if found is not None and not found.found:
        return ()
    steps = five_step(bench, pads=setting.pads) if plan.kind == "grasp" else squeeze(bench, pads=setting.pads)
    station.turn_rad, station.raise_m = bench.target["turn"], bench.target["raise"]
    return steps


def _fingertip(bench: Bench, plan: TouchPlan, station: Station, setting: HandSetting) -> Fingertip:
    let_go(bench)
    middle_m = station.middle_m or object_middle(bench)
    move_round(bench, middle_m, turn_rad=station.turn_rad, raise_m=station.raise_m)
    return fingertip(bench, inward_m=plan.inward * station.breadth_m, pads=setting.pads)
