"""What a hand of a user's is made of: its palm, digits, phalanges and pads, as they stand in the model."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Protocol

from varishold.hand.mjcf.shapes import Capsule
from varishold.hand.mjcf.source import MjcfSource

__all__ = ["MjcfDigit", "MjcfPad", "MjcfPalm", "MjcfPart", "Pieces"]


@dataclass(frozen=True)
class MjcfPalm:
    """The palm: a body of the model, and our frame in it.

    Parameters
    ----------
    body : str
    place_m, quaternion : tuple of floats
        Of the model's root in the palm's frame.
    middle_m : tuple of 2 floats
        Middle of its face, y and z. Metres.
    size_m : tuple of 2 floats
        Height (z) and breadth (y) of its face. Metres.
    """

    body: str
    place_m: tuple[float, ...]
    quaternion: tuple[float, ...]
    middle_m: tuple[float, float] = (0.0, 0.0)
    size_m: tuple[float, float] = (0.0, 0.0)


@dataclass(frozen=True)
class MjcfDigit:
    """A digit.

    Parameters
    ----------
    name : str
    joints : tuple of str
        From the palm outward.
    parts : tuple of str
        Its phalanges, from the palm outward.
    opposed : bool
    open, closed, straight : tuple of float
        Angles of its joints (radians, or metres of one that slides); what its own actuators are told, where it has
        such, but for `straight`.
    torque : tuple of float
        With which each joint closes, by amount. Newton metres, or newtons.
    slides : tuple of bool
        Which joints slide.
    actuators : tuple of str
        Its own, by the model's names; none: a motor a joint.
    height_m : float
        Of its middle line in the palm's frame. Metres.
    """

    name: str
    joints: tuple[str, ...]
    parts: tuple[str, ...]
    opposed: bool
    open: tuple[float, ...]
    closed: tuple[float, ...]
    straight: tuple[float, ...]
    torque: tuple[float, ...]
    slides: tuple[bool, ...]
    actuators: tuple[str, ...] = ()
    height_m: float = 0.0

    @property
    def side(self) -> float:
        """-1 for an opposed digit, 1 for the others."""
        return -1.0 if self.opposed else 1.0


@dataclass(frozen=True)
class MjcfPart:
    """A phalanx: geoms of the model, and the capsule that stands for them in the frame of a body."""

    name: str
    opposed: bool
    body: str
    geoms: tuple[str, ...]
    capsule: Capsule


@dataclass(frozen=True)
class MjcfPad:
    """A pad: its part, its length along the part and height across (metres), and its pitch where it has its own."""

    part: str
    size_m: tuple[float, float]
    pitch_m: float | None = None


class Pieces(Protocol):
    """All pieces of a hand, and the model that they stand in; `MjcfHand` tells what each is."""

    @property
    def source(self) -> MjcfSource: ...
    @property
    def palm(self) -> MjcfPalm: ...
    @property
    def limbs(self) -> tuple[MjcfPart, ...]: ...
    @property
    def digits(self) -> Mapping[str, MjcfDigit]: ...
    @property
    def parts(self) -> tuple[str, ...]: ...
    @property
    def joints(self) -> tuple[str, ...]: ...
    @property
    def actuators(self) -> tuple[str, ...]: ...
    @property
    def button_radius_m(self) -> float: ...
