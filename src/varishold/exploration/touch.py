"""What every touch of the exploring hand can do: make itself, give its evidence, and say in words what was done."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np

from varishold.hand import Bench, HandSetting, PadSetting, Step
from varishold.hand.hand import Hand
from varishold.perceive import Evidence
from varishold.touch import PadSurface, feel_surface

__all__ = ["Felt", "PadSurfaces", "PoseEstimate", "Touch", "surfaces_of"]

#: The surface under each pad; None where nothing presses it.
PadSurfaces = dict[str, PadSurface | None]


@dataclass
class PoseEstimate:
    """Where the hand believes the object to be: what it needs to find it again from another side.

    Parameters
    ----------
    turn_rad, raise_m : float
        Turn and height of the palm at the first grasp.
    middle_m : (float, float) or None
        The object's middle, as last felt, in the palm's zero frame. Metres.
    breadth_m : float
        The object's breadth, as last felt. Metres.
    """

    turn_rad: float = 0.0
    raise_m: float = 0.0
    middle_m: tuple[float, float] | None = None
    breadth_m: float = 0.08


def surfaces_of(step: Step, setting: HandSetting, pads: tuple[str, ...] | None = None) -> PadSurfaces:
    """Return the surface under each of these pads, or under all; a pad with a value that is none is left out."""
    felt, skin = step.pads, (setting.pads or PadSetting()).skin
    if felt is None:
        return {}
    return {
        name: feel_surface(frame, skin, pitch_m=felt.pitch_m[name]) if frame.any() else None
        for name, frame in felt.frames.items()
        if (pads is None or name in pads) and np.isfinite(frame).all()
    }


@dataclass(frozen=True)
class Felt:
    """What a touch felt.

    Parameters
    ----------
    touch : Touch
    step : Step
        Everything felt at its end.
    height_m : float or None
        Of a fingertip: height over the palm's zero where it came to rest; None where it met nothing. Metres.
    seconds : float or None
        What it took the hand, from the end of the touch before; None where nobody looked at the clock.
    """

    touch: Touch
    step: Step
    height_m: float | None = None
    seconds: float | None = None

    def missing(self, surfaces: PadSurfaces, pads: tuple[str, ...]) -> tuple[str, ...]:
        """Return a remark on those of these pads that said nothing."""
        names = [name for name in pads if name not in surfaces]
        if not names:
            return ()
        which = "all pads" if len(names) == len(pads) else f"pad {', '.join(names)}"
        return (f"{self.touch.name}: nothing is known of {which}",)


@dataclass(frozen=True, kw_only=True)
class Touch(ABC):
    """One touch that the hand can make.

    Parameters
    ----------
    name : str
        Touches are compared with those of the same name.
    cost : float
        What it takes, in parts of a grasp's.
    """

    #: Whether it can be made while nothing is held yet.
    begins: ClassVar[bool] = False

    name: str
    cost: float = 1.0

    def fits(self, hand: Hand) -> bool:
        """Tell whether a hand can make it."""
        return True

    @abstractmethod
    def make(self, bench: Bench, pose: PoseEstimate, setting: HandSetting) -> Felt | None:
        """Carry the touch out and keep in `pose` what it says about the object's place.

        Returns
        -------
        Felt or None
            None where the hand felt that it missed or dropped the object.
        """

    def make_timed(self, bench: Bench, pose: PoseEstimate, setting: HandSetting) -> Felt | None:
        """Carry the touch out as `make`, and look at the clock: letting go, coming there and lifting are part of it."""
        begun_s = bench.time_s
        felt = self.make(bench, pose, setting)
        return None if felt is None else replace(felt, seconds=bench.time_s - begun_s)

    @abstractmethod
    def evidence(self, felt: Felt, setting: HandSetting) -> tuple[Evidence, PadSurfaces]:
        """Return what was felt as evidence, and the surface under each pad."""

    @property
    @abstractmethod
    def done(self) -> str:
        """What the hand did, as in "gripped it 20 mm higher"."""

    @abstractmethod
    def felt_in_words(self, felt: Felt, surfaces: PadSurfaces) -> str:
        """Return in words what the hand felt at once."""
