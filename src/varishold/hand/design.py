"""The hand's proportions and strengths: every number of the model that is not an object or chance."""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from typing import Self

import numpy as np

from varishold.errors import InputError

__all__ = ["FINGERS", "PHALANGES", "HandDesign"]

#: The four fingers from the upper edge of the palm to the lower.
FINGERS = ("index", "middle", "ring", "little")

#: The phalanges of a finger and of the thumb, from the palm outward.
PHALANGES = ("proximal", "middle", "distal")


@dataclass(frozen=True)
class HandDesign:
    """A palm, four fingers of three phalanges, an opposed thumb, and a wrist that lifts.

    The palm's frame: x points out of the palm toward the object, y toward the fingers' side, z up along
    the palm; its origin is the middle of the plane that the palm's buttons stand up to. Fingers bend about z.

    Parameters
    ----------
    finger_scale : float
        Multiplies every phalanx length, the thumb's included.
    index_m, thumb_m : tuple of 3 floats
        Lengths of the index finger's and the thumb's phalanges from the palm outward. Metres.
    relative_lengths : tuple of 4 floats
        Length of index, middle, ring and little finger as parts of the index finger's.
    finger_radius_m, thumb_radius_m : float
        Radii of the phalanges, which are capsules. Metres.
    thumb_breadth_m : float
        Distance between the thumb's two parallel capsules, along z. Metres.
    finger_pitch_m : float
        Distance between neighbouring fingers, along z. Metres.
    palm_m : tuple of 3 floats
        Thickness (x), breadth (y) and height (z) of the palm. Metres.
    knuckle_m : tuple of 2 floats
        The first joints stand at (x, +y) for the fingers and (x, -y) for the thumb. Metres.
    thumb_height_m : float
        Height (z) of the thumb's middle line. Metres.
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
    joint_damping, joint_armature : float
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
    >>> HandDesign().scaled(1.1).finger_lengths_m("index")[0].round(4)
    np.float64(0.0506)
    """

    finger_scale: float = 1.0
    index_m: tuple[float, float, float] = (0.046, 0.030, 0.026)
    thumb_m: tuple[float, float, float] = (0.040, 0.034, 0.028)
    relative_lengths: tuple[float, float, float, float] = (1.0, 1.05, 1.0, 0.92)
    finger_radius_m: float = 0.008
    thumb_radius_m: float = 0.009
    thumb_breadth_m: float = 0.028
    finger_pitch_m: float = 0.022
    palm_m: tuple[float, float, float] = (0.024, 0.084, 0.088)
    knuckle_m: tuple[float, float] = (-0.012, 0.052)
    thumb_height_m: float = 0.006
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
    joint_damping: float = 0.06
    joint_armature: float = 1e-4
    friction: float = 0.8
    torsion_m: float = 0.006

    def __post_init__(self) -> None:
        signed = {"knuckle_m", "thumb_height_m", "palm_above_middle_m", "open_rad"}
        for field in fields(self):
            values = np.atleast_1d(getattr(self, field.name))
            if not np.all(np.isfinite(values)) or (field.name not in signed and np.any(values <= 0)):
                raise InputError(f"{field.name} of a hand must be positive and finite, got {values.tolist()}")
        if not 0.5 <= self.finger_scale <= 2.0:
            raise InputError(f"finger_scale must lie in [0.5, 2], got {self.finger_scale!r}")

    def scaled(self, finger_scale: float) -> Self:
        """Return the same hand with its digits `finger_scale` times the usual length."""
        return replace(self, finger_scale=finger_scale)

    def finger_lengths_m(self, digit: str) -> np.ndarray[tuple[int], np.dtype[np.float64]]:
        """Lengths of a digit's three phalanges ("thumb" or one of `FINGERS`), from the palm outward, metres."""
        if digit == "thumb":
            return self.finger_scale * np.array(self.thumb_m)
        relative = self.relative_lengths[FINGERS.index(digit)]
        return self.finger_scale * relative * np.array(self.index_m)

    def height_of(self, digit: str) -> float:
        """Height (z) of a digit in the palm's frame, metres."""
        if digit == "thumb":
            return self.thumb_height_m
        return (1.5 - FINGERS.index(digit)) * self.finger_pitch_m

    def radius_of(self, digit: str) -> float:
        """Radius of a digit's phalanges, metres."""
        return self.thumb_radius_m if digit == "thumb" else self.finger_radius_m
