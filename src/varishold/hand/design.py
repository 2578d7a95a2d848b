"""The hand's proportions and strengths: every number of the model that is not an object or chance."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields, replace
from functools import cached_property
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from varishold.errors import InputError
from varishold.hand import design_body
from varishold.hand.digit import PHALANGES, Digit
from varishold.hand.hand import FIVE_STEPS, Wiring
from varishold.hand.layouts import Layout
from varishold.hand.phalanges import Phalanges

__all__ = ["PHALANGES", "Digit", "HandDesign"]

# Distance between neighbouring fingers along z. Metres.
_PITCH_M = 0.022

_THUMB = Digit("thumb", 0.006, (0.040, 0.034, 0.028), radius_m=0.009, breadth_m=0.028, opposed=True)

#: Sizes that the usual hand can close on and open around. Metres.
_SIZES_M = (0.035, 0.125)

#: Stiffness of a joint that holds an angle. Newton metres per radian.
_POSE_NM_RAD = 0.6

#: While its tip comes down the pointing finger is held straight; the thumb stays out of its way.
_STRAIGHT_RAD, _FOLDED_RAD = (0.0, 0.0, 0.0), (1.7, 1.9, 1.5)


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
    thumb: Digit = _THUMB
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
    def pads(self) -> tuple[str, ...]:
        """The parts that can carry a pad: all."""
        return self.parts

    @property
    def identity(self) -> str:
        """The hand that felt the shipped library."""
        return "five-finger"

    @property
    def opposers(self) -> tuple[Digit, ...]:
        """The digits that close toward the fingers."""
        return (self.thumb,)

    @property
    def steps(self) -> Mapping[int, str]:
        """The paper's five steps."""
        return dict(enumerate(FIVE_STEPS, start=1))

    @property
    def pinch(self) -> Mapping[str, float]:
        """Gains of pointer and thumb against each other."""
        return {self.pointer: 1.0, self.thumb.name: self.thumb_gain}

    @property
    def grip(self) -> Mapping[str, float]:
        """Gains of all digits, the thumb's as it holds against all fingers."""
        return dict.fromkeys((finger.name for finger in self.fingers), 1.0) | {self.thumb.name: self.thumb_gain_all}

    @property
    def sizes_m(self) -> tuple[float, float]:
        """Sizes that it can close on and open around. Metres."""
        return _SIZES_M

    @property
    def longer_m(self) -> float:
        """It reaches as far as the usual hand."""
        return 0.0

    @property
    def tip_place_m(self) -> tuple[float, float]:
        """Where the tip's middle is (x, z) while the pointer is straight. Metres."""
        knuckle_m, _ = self.knuckle_m
        *others_m, last_m = self.lengths_m(self.pointer).tolist()
        return knuckle_m + (sum(others_m) + last_m / 2), self.digits[self.pointer].height_m

    @property
    def palm_middle_m(self) -> tuple[float, float]:
        """The pad's middle is the palm's frame's."""
        return 0.0, 0.0

    def opened(self) -> NDArray[np.float64]:
        """Angles of all joints of the open hand. Radians."""
        return np.tile(np.array(self.open_rad, dtype=np.float64), len(self.digits))

    def closing(self, digit: str) -> NDArray[np.float64]:
        """Torques that close a digit. Newton metres."""
        return np.array(self.torque_nm, dtype=np.float64)

    def opening(self, digit: str) -> NDArray[np.float64]:
        """Torques that open a digit. Newton metres."""
        return np.full(len(PHALANGES), -self.opening_nm)

    def holding(self, digit: str) -> tuple[NDArray[np.float64] | float, NDArray[np.float64]]:
        """Stiffness of a joint that holds an angle (N m/rad), and the largest torques (N m)."""
        return _POSE_NM_RAD, self.closing(digit)

    def driven(self, digit: str) -> bool:
        """Its motors are told torques."""
        return False

    def to_come_down(self) -> Mapping[str, tuple[float, ...] | None]:
        """The pointer straight, the thumb folded, the others open."""
        posed = {self.pointer: _STRAIGHT_RAD, self.thumb.name: _FOLDED_RAD}
        return {digit: posed.get(digit) for digit in self.digits}

    def phalanges(self, angles_rad: NDArray[np.float64]) -> Phalanges:
        """Place every phalanx from the angles of `joints`, radians."""
        n = len(self.joints)
        start, along, inward = np.zeros((n, 3)), np.zeros((n, 3)), np.zeros((n, 3))
        length = np.array([self.length_m(part) for part in self.joints])
        digits = [self.digit_of[part] for part in self.joints]
        x, y = self.knuckle_m
        for digit in self.digits.values():
            rows = np.array([part in digit.parts for part in self.joints])
            heading = -digit.side * np.cumsum(angles_rad[rows])
            along[rows, 0], along[rows, 1] = np.cos(heading), np.sin(heading)
            inward[rows, 0], inward[rows, 1] = digit.side * np.sin(heading), -digit.side * np.cos(heading)
            steps = length[rows, None] * along[rows]
            start[rows] = np.array([x, digit.side * y, digit.height_m]) + np.cumsum(steps, axis=0) - steps
        return Phalanges(
            self.joints,
            start,
            along,
            inward,
            length,
            np.array([digit.radius_m for digit in digits]),
            np.array([digit.breadth_m / 2 for digit in digits]),
            np.array([digit.opposed for digit in digits]),
        )

    def add_body(self, mj: Any, spec: Any, palm: Any, layout: Layout, contact: Mapping[str, Any]) -> None:
        """Add palm, digits and switches below the carriage's body "palm"."""
        design_body.add_body(mj, spec, palm, self, layout, dict(contact))

    def add_motors(self, mj: Any, spec: Any) -> None:
        """Add a motor a joint."""
        for joint in self.joints:
            spec.add_actuator(name=joint, target=joint, trntype=mj.mjtTrn.mjTRN_JOINT).set_to_motor()

    def wire(self, model: Any, layout: Layout) -> Wiring:
        """Find it in a compiled model."""
        return design_body.wire(model, self, layout)

    def pad_frame(self, data: Any, part: str) -> tuple[NDArray[np.float64], ...]:
        """Middle of a part's pad and its unit vectors along columns, along rows and out of it, in the world."""
        body = data.body(part)
        turn = body.xmat.reshape(3, 3)
        if part == "palm":
            return body.xpos.copy(), turn[:, 1].copy(), turn[:, 2].copy(), turn[:, 0].copy()
        digit = self.digit_of[part]
        outward = -digit.side * turn[:, 1]
        middle = body.xpos + self.length_m(part) / 2 * turn[:, 0] + digit.radius_m * outward
        return middle, turn[:, 0].copy(), turn[:, 2].copy(), outward.copy()

    def pad_size_m(self, part: str) -> tuple[float, float]:
        """Height (along rows) and length (along columns) of a part's pad. Metres."""
        if part == "palm":
            _, breadth, height = self.palm_m
            return height, breadth
        return 2 * self.digit_of[part].radius_m + self.digit_of[part].breadth_m, self.length_m(part)

    def pad_pitch_m(self, part: str) -> float | None:
        """The pads' setting says it."""
        return None

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
