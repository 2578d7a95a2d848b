"""A fingertip that comes down on the object's top."""

from __future__ import annotations

from dataclasses import dataclass

from varishold.exploration.touch import Felt, PadSurfaces, PoseEstimate, Touch, surfaces_of
from varishold.hand import Bench, HandSetting
from varishold.hand.actions import fingertip, let_go, move_round, object_middle
from varishold.hand.hand import Hand
from varishold.perceive import Evidence, pad_values

__all__ = ["Fingertip"]

# The height of a fingertip that met nothing: below every object.
_NOTHING_M = -0.1


@dataclass(frozen=True, kw_only=True)
class Fingertip(Touch):
    """The pointing finger's end comes down from above; the other digits stay out of the way.

    Parameters
    ----------
    inward : float
        Where on the top: parts of the object's felt breadth behind its near side.
    """

    inward: float

    def fits(self, hand: Hand) -> bool:
        return hand.tip is not None

    def make(self, bench: Bench, pose: PoseEstimate, setting: HandSetting) -> Felt:
        let_go(bench)
        move_round(bench, pose.middle_m or object_middle(bench), turn_rad=pose.turn_rad, raise_m=pose.raise_m)
        tip = fingertip(bench, inward_m=self.inward * pose.breadth_m, pads=setting.pads)
        return Felt(self, tip.step, tip.height_m if tip.touched else None)

    def evidence(self, felt: Felt, setting: HandSetting) -> tuple[Evidence, PadSurfaces]:
        pads = tuple(pad for pad in setting.design.pads if pad == setting.design.tip)
        surfaces = surfaces_of(felt.step, setting, pads)
        values = {
            "tip.touched": float(felt.height_m is not None),
            "tip.height": _NOTHING_M if felt.height_m is None else felt.height_m,
        }
        for name, surface in surfaces.items():
            values |= pad_values(name, surface)
        return Evidence(self.name, values, felt.missing(surfaces, pads)), surfaces

    @property
    def done(self) -> str:
        where = "in the middle"
        if self.inward != 0.5:
            where = f"{100 * self.inward:.0f} % of its breadth behind the near side"
        return f"came down on its top with a fingertip, {where}"

    def felt_in_words(self, felt: Felt, surfaces: PadSurfaces) -> str:
        if felt.height_m is None:
            return "met nothing"
        side = "above" if felt.height_m >= 0 else "below"
        return f"came to rest {1e3 * abs(felt.height_m):.0f} mm {side} the palm's middle"
