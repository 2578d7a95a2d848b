"""A grip at another height or from another side."""

from __future__ import annotations

import math
from dataclasses import dataclass

from varishold.exploration.touch import PoseEstimate
from varishold.exploration.touches.grip import Grip
from varishold.hand import Bench, HandSetting, Step
from varishold.hand.actions import regrasp

__all__ = ["Regrasp"]


@dataclass(frozen=True, kw_only=True)
class Regrasp(Grip):
    """A grip of the object that was gripped before, elsewhere.

    Parameters
    ----------
    turn_rad : float
        How far round the object from where it was first grasped, from +x toward +y.
    raise_m : float
        How far above where it was first grasped. Metres.
    """

    turn_rad: float = 0.0
    raise_m: float = 0.0

    def close(self, bench: Bench, pose: PoseEstimate, setting: HandSetting) -> tuple[Step, ...]:
        now = bench.target
        return regrasp(
            bench,
            turn_rad=pose.turn_rad + self.turn_rad - now["turn"],
            raise_m=pose.raise_m + self.raise_m - now["raise"],
            by="squeeze",
            middle_m=pose.middle_m,
            pads=setting.pads,
        )

    @property
    def done(self) -> str:
        moves = []
        if self.turn_rad:
            moves.append(f"from {math.degrees(self.turn_rad):.0f}° round")
        if self.raise_m:
            moves.append(f"{1e3 * abs(self.raise_m):.0f} mm {'higher' if self.raise_m > 0 else 'lower'}")
        return f"gripped it {' and '.join(moves) or 'again'}"
