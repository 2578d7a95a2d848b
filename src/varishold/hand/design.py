"""The hand's proportions and strengths: every number of the model that is not an object or chance."""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from functools import cached_property
from typing import Self

import numpy as np
from numpy.typing import NDArray

from varishold.errors import InputError

__all__ = ["PHALANGES", "Digit", "HandDesign"]

#: The phalanges of every digit, from the palm outward.
PHALANGES = ("proximal", "middle", "distal")

# Distance between neighbouring fingers along z, and the index finger's phalanges. Metres.
_PITCH_M, _FINGER_M = 0.022, (0.046, 0.030, 0.026)


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


@dataclass(frozen=True)
class HandDesign:
    """A palm, four fingers of three phalanges, an opposed thumb, and a wrist that lifts.

    The palm's frame: x points out of the palm toward the object, y toward the fingers' side, z up along
    the palm; its origin is the middle of the plane that the palm's buttons stand up to. Fingers bend about z.

    Parameters
    ----------
    finger_scale : float
        Multiplies every phalanx length, the thumb's included.
    fingers : tuple of Digit
        From the upper edge of the palm to the lower.
    thumb : Digit
        Opposed to the fingers.
    pointer, supporter : str
        Names of the fingers that feel and grasp first, with the thumb, and that joins when the object is lifted.
    palm_m : tuple of 3 floats
        Thickness (x), breadth (y) and height (z) of the palm. Metres.
    knuckle_m : tuple of 2 floats
        The first joints stand at (x, +y) for the fingers and (x, -y) for the thumb. Metres.
    button_radius_m, button_rise_m : float
        A palm switch's button: its radius and how far it stands out of the palm. Metres.
    palm_above_middle_m : float
        Height of the palm's middle above the object's middle of mass: objects are offered at the hand's height. Metres.
    wrist_m : float
        Distance of the wrist's axis behind the palm's plane. Metres.
    lift_rad : float
        Turn of the wrist that lifts an object. Radians.
    open_rad, curl_rad : tuple of 3 floats
        Joint angles of an open digit, and the largest angles it can bend to. Radians.
    torque_nm : tuple of 3 floats
        Torque of a closing finger's joints from the palm outward; one motor a finger drives all three in these
        proportions, and each joint stops by itself where its phalanx meets something (underactuation).
    thumb_gain, thumb_gain_all : float
        The thumb's torque as a multiple of a finger's: against one finger, and against all four in the last step.
    opening_nm : float
        Torque that holds a digit open. Newton metres.
    search_gain : float
        Part of the usual torque with which index finger and thumb feel for an object.
    joint_damping_nms, joint_armature_kg_m2 : float
        Damping (N m s/rad) and rotor inertia (kg m^2) of each joint of a digit.
    friction : float
        Coefficient of sliding friction between hand and object.
    torsion_m : float
        Coefficient of torsional friction: radius of a contact patch. Metres.

    Raises
    ------
    InputError
        If a length, torque or coefficient is not positive and finite.

    Examples
    --------
    >>> float(HandDesign().scaled(1.1).lengths_m("index")[0].round(4))
    0.0506
    """

    finger_scale: float = 1.0
    fingers: tuple[Digit, ...] = (
        Digit("index", 1.5 * _PITCH_M),
        Digit("middle", 0.5 * _PITCH_M, relative_length=1.05),
        Digit("ring", -0.5 * _PITCH_M),
        Digit("little", -1.5 * _PITCH_M, relative_length=0.92),
    )
    thumb: Digit = Digit("thumb", 0.006, (0.040, 0.034, 0.028), radius_m=0.009, breadth_m=0.028, opposed=True)
    pointer: str = "index"
    supporter: str = "little"
    palm_m: tuple[float, float, float] = (0.024, 0.084, 0.088)
    knuckle_m: tuple[float, float] = (-0.012, 0.052)
    button_radius_m: float = 0.007
    button_rise_m: float = 0.003
    palm_above_middle_m: float = 0.005
    wrist_m: float = 0.10
    lift_rad: float = 0.5
    open_rad: tuple[float, float, float] = (-0.65, 0.1, 0.1)
    curl_rad: tuple[float, float, float] = (1.7, 1.9, 1.5)
    torque_nm: tuple[float, float, float] = (0.55, 0.33, 0.24)
    thumb_gain: float = 1.2
    thumb_gain_all: float = 2.6
    opening_nm: float = 0.15
    search_gain: float = 0.3
    joint_damping_nms: float = 0.06
    joint_armature_kg_m2: float = 1e-4
    friction: float = 0.8
    torsion_m: float = 0.006

    def __post_init__(self) -> None:
        signed = {"knuckle_m", "palm_above_middle_m", "open_rad"}
        for field in fields(self):
            if field.name in ("fingers", "thumb", "pointer", "supporter"):
                continue
            values = np.atleast_1d(getattr(self, field.name))
            if not np.all(np.isfinite(values)) or (field.name not in signed and np.any(values <= 0)):
                raise InputError(f"{field.name} of a hand must be positive and finite, got {values.tolist()}")
        if not 0.5 <= self.finger_scale <= 2.0:
            raise InputError(f"finger_scale must lie in [0.5, 2], got {self.finger_scale!r}")
        names = [finger.name for finger in self.fingers]
        if len({*names, self.thumb.name, "palm"}) < len(names) + 2:
            raise InputError(f"digits of a hand need names of their own, got {', '.join([*names, self.thumb.name])}")
        if not {self.pointer, self.supporter} <= set(names):
            raise InputError(
                f"pointer and supporter must be among the fingers {', '.join(names)}, "
                f"got {self.pointer!r} and {self.supporter!r}"
            )

    @cached_property
    def digits(self) -> dict[str, Digit]:
        """Fingers and thumb by name, in the order of their joints and motors."""
        return {digit.name: digit for digit in (*self.fingers, self.thumb)}

    @cached_property
    def joints(self) -> tuple[str, ...]:
        """The joints of all digits, named as the phalanx that each moves; their angles are the hand's coordinates."""
        return tuple(part for digit in self.digits.values() for part in digit.parts)

    @property
    def parts(self) -> tuple[str, ...]:
        """Every part that a pad covers: all phalanges and the palm."""
        return (*self.joints, "palm")

    @property
    def tip(self) -> str:
        """The phalanx that touches from above."""
        return f"{self.pointer}.{PHALANGES[-1]}"

    @cached_property
    def digit_of(self) -> dict[str, Digit]:
        """The digit that each phalanx belongs to."""
        return {part: digit for digit in self.digits.values() for part in digit.parts}

    def scaled(self, finger_scale: float) -> Self:
        """Return the same hand with its digits `finger_scale` times the usual length."""
        return replace(self, finger_scale=finger_scale)

    def lengths_m(self, digit: str) -> NDArray[np.float64]:
        """Lengths of a digit's phalanges from the palm outward, metres."""
        return self.finger_scale * self.digits[digit].relative_length * np.array(self.digits[digit].phalanges_m)

    def length_m(self, part: str) -> float:
        """Length of a phalanx, metres."""
        digit = self.digit_of[part]
        by_part: dict[str, float] = dict(zip(digit.parts, self.lengths_m(digit.name).tolist(), strict=True))
        return by_part[part]
