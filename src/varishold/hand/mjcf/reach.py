"""How far a hand reaches: the sizes that it grips, how long it is, and whether a fingertip can come down."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from varishold.hand.mjcf.hand import MjcfHand
from varishold.hand.phalanges import Phalanges

__all__ = ["Reach", "reach_of"]

#: The open digits of the usual hand reach so far before its palm. Metres.
_USUAL_M = 0.085

# A hand grips what is up to this part of its opening, at most so large; and not less than that.
_PART, _LARGEST_M, _LEAST_M, _LEAST_PART = 0.92, 0.125, 0.035, 0.4

# Nothing else of the hand may be lower than the tip's pad farther out than so much before it, nor the tip nearer to the
# palm or lower under its middle. Metres.
_AROUND_M, _LEAST_TIP_M, _LOWEST_M, _HIGHEST_M = 0.03, 0.04, 0.0, 0.15

# The pad looks down, by at least this cosine.
_DOWN = 0.7


@dataclass(frozen=True)
class Reach:
    """Sizes (metres), how much longer than usual (metres), and about the pointer's tip."""

    sizes_m: tuple[float, float]
    longer_m: float
    tip_place_m: tuple[float, float]
    comes_down: bool
    can_be_held: bool


def reach_of(hand: MjcfHand) -> Reach:
    """Measure it, open and as it is for a fingertip."""
    opened = hand.phalanges(hand.opened())
    far = _ends(opened)[..., 0].max(axis=0) + opened.radius_m
    last = np.array([part in {digit.parts[-1] for digit in hand.all_digits} for part in opened.parts])
    inner = opened.middle_m[:, 1]
    gap = float(inner[last & ~opened.opposed].min() - inner[last & opened.opposed].max())
    high = float(np.clip(_PART * gap, 0.01, _LARGEST_M))
    wanted = hand.to_come_down()
    can = not any(digit.actuators for digit in hand.all_digits)
    angles = dict(zip(hand.joints, hand.opened().tolist(), strict=True))
    for digit in hand.all_digits:
        posed = wanted[digit.name]
        if can and posed is not None:
            angles |= dict(zip(digit.joints, posed, strict=True))
    down = hand.phalanges(np.array([angles[joint] for joint in hand.joints]))
    tip = down.parts.index(hand.digits[hand.pointer].parts[-1])
    x, y, z = down.middle_m[tip].tolist()
    others = np.array([part not in hand.digits[hand.pointer].parts for part in down.parts])
    lowest = _ends(down)[..., 1].min(axis=0) - down.radius_m
    reaches = _ends(down)[..., 0].max(axis=0) + down.radius_m
    free = not bool((others & (reaches > x - _AROUND_M) & (lowest < y)).any())
    looks_down = bool(down.inward[tip] @ np.array([0.0, -1.0, 0.0]) > _DOWN)
    comes = can and free and looks_down and x > _LEAST_TIP_M and _LOWEST_M <= y <= _HIGHEST_M
    return Reach(
        (min(_LEAST_M, _LEAST_PART * high), high),
        max(0.0, float(far.max()) - _USUAL_M),
        (x, z),
        comes,
        can,
    )


def _ends(place: Phalanges) -> np.ndarray[tuple[int, ...], np.dtype[np.float64]]:
    """Both ends of every phalanx, shape (2, n, 3)."""
    return np.stack([place.start_m, place.start_m + place.length_m[:, None] * place.along])
