"""Whether a touch moves or tips, from frame to frame."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from varishold.touch.tracking.change import Pattern
from varishold.touch.tracking.excursion import Excursion, Step
from varishold.touch.tracking.felt import Felt

__all__ = ["Motion", "Told"]

Point = tuple[float, float]
# A contact has moved from so far on, and is told again after so much more. Taxels.
_MOVED, _AGAIN = 0.2, 1.0
# The load has moved within the outline from so far on, as a share of the load's own half-breadth.
_TIPPED, _TIPPED_AGAIN = 0.15, 1.0
# Beyond so much of a change the next frames are compared with the newest one.
_FAR, _LOADED, _LEANED = 0.5, 0.2, 0.25


@dataclass(frozen=True)
class Told:
    """A motion or a tip; its way in taxels."""

    kind: Literal["moved", "tipped"]
    step: Step


class Motion:
    """What one touch does while it lasts."""

    def __init__(self) -> None:
        self._pattern: Pattern | None = None
        self._place: Point = (0.0, 0.0)
        self._lean: Point = (0.0, 0.0)
        self._moves = Excursion(_MOVED, _AGAIN)
        self._tips = Excursion(_TIPPED, _TIPPED_AGAIN)

    @property
    def is_moving(self) -> bool:
        """Whether the touch is on its way."""
        return self._moves.is_moving

    def restart(self) -> None:
        """Forget with what frames were compared: the contact is no longer the same."""
        self._pattern = None
        self._moves.shift((0.0, 0.0))
        self._tips.shift((0.0, 0.0))

    def update(self, time_s: float, felt: Felt, frame: NDArray[np.float64]) -> list[Told]:
        """Return what is to be told of a new frame."""
        if self._pattern is None:
            self._pattern = Pattern(felt.contact)
            self._place = self._lean = (0.0, 0.0)
            return []
        change = self._pattern.change(frame, felt.sigma)
        place = _plus(self._place, change.shift)
        lean = _plus(self._lean, change.lean)
        told = []
        step = self._moves.update(time_s, place, math.hypot(*change.shift_sigma))
        if step is not None:
            told.append(Told("moved", step))
        step = self._tips.update(time_s, lean, math.hypot(*change.lean_sigma))
        if step is not None:
            told.append(Told("tipped", step))
        if math.hypot(*change.shift) > _FAR or abs(change.load - 1) > _LOADED or math.hypot(*change.lean) > _LEANED:
            self._pattern = Pattern(felt.contact)
            self._place, self._lean = place, lean
        return told


def _plus(one: Point, other: Point) -> Point:
    return one[0] + other[0], one[1] + other[1]
