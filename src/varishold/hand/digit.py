"""A digit of the built-in hand: its phalanges and where it stands."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from varishold.errors import InputError

__all__ = ["PHALANGES", "Digit"]

#: The phalanges of every digit, from the palm outward.
PHALANGES = ("proximal", "middle", "distal")

# The index finger's phalanges. Metres.
_FINGER_M = (0.046, 0.030, 0.026)


@dataclass(frozen=True)
class Digit:
    """A finger, or the thumb that is opposed to the fingers.

    Parameters
    ----------
    name : str
        As "index"; its phalanges are parts of the hand, as "index.distal".
    height_m : float
        Height (z) of its middle line in the palm's frame. Metres.
    phalanges_m : tuple of 3 floats
        Lengths of its phalanges from the palm outward. Metres.
    relative_length : float
        Multiplies every one of them.
    radius_m : float
        Radius of its phalanges, which are capsules. Metres.
    breadth_m : float
        Distance between two parallel capsules, along z; 0 for a single one. Metres.
    opposed : bool
        Whether it stands on the palm's -y side and closes toward the fingers.
    """

    name: str
    height_m: float
    phalanges_m: tuple[float, float, float] = _FINGER_M
    relative_length: float = 1.0
    radius_m: float = 0.008
    breadth_m: float = 0.0
    opposed: bool = False

    def __post_init__(self) -> None:
        lengths = np.array([*self.phalanges_m, self.relative_length, self.radius_m])
        if len(lengths) != len(PHALANGES) + 2 or not np.isfinite(lengths).all() or lengths.min() <= 0:
            raise InputError(f"{self.name}: a digit needs 3 phalanges and a radius, positive and finite, got {lengths}")

    @property
    def parts(self) -> tuple[str, ...]:
        """Its phalanges by name, from the palm outward."""
        return tuple(f"{self.name}.{phalanx}" for phalanx in PHALANGES)

    @property
    def side(self) -> float:
        """-1 for an opposed digit, 1 for the others."""
        return -1.0 if self.opposed else 1.0
