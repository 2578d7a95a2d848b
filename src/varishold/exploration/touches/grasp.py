"""The first grips: the paper's grasp in five steps, and a grip by all digits at once."""

from __future__ import annotations

from typing import ClassVar

from varishold.exploration.touch import PoseEstimate
from varishold.exploration.touches.grip import Grip
from varishold.hand import Bench, HandSetting, Step
from varishold.hand.actions import five_step, squeeze
from varishold.hand.grasping import come_before

__all__ = ["Grasp", "Squeeze"]


class Grasp(Grip):
    """The search for the object, and the paper's five steps."""

    begins: ClassVar[bool] = True
    done = "grasped it in five steps and lifted it"

    def grip(self, bench: Bench, setting: HandSetting) -> tuple[Step, ...]:
        """Grip what stands before the palm."""
        return five_step(bench, pads=setting.pads)

    def close(self, bench: Bench, pose: PoseEstimate, setting: HandSetting) -> tuple[Step, ...]:
        found = come_before(bench, setting)
        if found is not None and not found.found:
            return ()
        steps = self.grip(bench, setting)
        pose.turn_rad, pose.raise_m = bench.target["turn"], bench.target["raise"]
        return steps


class Squeeze(Grasp):
    """The search, and all digits at once, where the object stands: what five steps would drop, all digits can hold."""

    done = "closed all digits about it"

    def grip(self, bench: Bench, setting: HandSetting) -> tuple[Step, ...]:
        return squeeze(bench, pads=setting.pads)
