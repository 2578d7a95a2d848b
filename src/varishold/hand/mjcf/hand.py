"""A hand that a user describes: what its file says and its MJCF holds, worked out once."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from varishold.hand.layouts import Layout
from varishold.hand.mjcf import body as mjcf_body
from varishold.hand.mjcf.pieces import MjcfDigit, MjcfPad, MjcfPalm, MjcfPart
from varishold.hand.mjcf.source import MjcfSource
from varishold.hand.phalanges import Phalanges

__all__ = ["MjcfHand"]

Floats = NDArray[np.float64]

# Stiffness of a joint that holds an angle, in its largest torque a radian, or a metre.
_HINGE_STIFF, _SLIDE_STIFF = 1.1, 200.0

# Part of the closing torque that holds a digit open.
_OPENING = 0.3


@dataclass(frozen=True)
class MjcfHand:
    """A hand of a user's; `read_hand` makes it. What it does is told in `varishold.hand.hand.Hand`.

    Parameters
    ----------
    name, identity : str
        What it is called, and what tells it from a hand of another content.
    source : MjcfSource
    palm : MjcfPalm
    all_digits : tuple of MjcfDigit
        Fingers before opposed ones.
    limbs : tuple of MjcfPart
    all_pads : tuple of MjcfPad
    joints : tuple of str
        All that move: the digits', then what moves with them.
    layout : Layout
        Its switches.
    pointer, supporter, tip : str or None
    tip_place_m : tuple of 2 floats
    library : str or None
        The file of what it knows, where its own file names one.
    pinch_gain, grip_gain : float
        Gain of opposed digits against the pointer, and against all fingers.
    sizes_m : tuple of 2 floats
    longer_m, search_gain, lift_rad, wrist_m, friction, torsion_m, palm_above_middle_m, button_radius_m : float
    """

    name: str
    identity: str
    source: MjcfSource
    palm: MjcfPalm
    all_digits: tuple[MjcfDigit, ...]
    limbs: tuple[MjcfPart, ...]
    all_pads: tuple[MjcfPad, ...]
    joints: tuple[str, ...]
    layout: Layout
    pointer: str
    supporter: str | None
    tip: str | None = None
    tip_place_m: tuple[float, float] = (0.0, 0.0)
    library: str | None = field(default=None, repr=False)
    pinch_gain: float = 1.0
    grip_gain: float = 1.0
    sizes_m: tuple[float, float] = (0.035, 0.125)
    longer_m: float = 0.0
    search_gain: float = 0.3
    lift_rad: float = 0.5
    wrist_m: float = 0.10
    friction: float = 0.8
    torsion_m: float = 0.006
    palm_above_middle_m: float = 0.005
    button_radius_m: float = 0.007
    finger_scale: float = 1.0

    @cached_property
    def digits(self) -> dict[str, MjcfDigit]:
        """All digits by name."""
        return {digit.name: digit for digit in self.all_digits}

    @property
    def fingers(self) -> tuple[MjcfDigit, ...]:
        """The digits that are not opposed."""
        return tuple(digit for digit in self.all_digits if not digit.opposed)

    @property
    def opposers(self) -> tuple[MjcfDigit, ...]:
        """The digits that close toward the fingers."""
        return tuple(digit for digit in self.all_digits if digit.opposed)

    @cached_property
    def parts(self) -> tuple[str, ...]:
        """All phalanges, and the palm."""
        return (*(part.name for part in self.limbs), "palm")

    @cached_property
    def pads(self) -> tuple[str, ...]:
        """The parts that carry a pad."""
        return tuple(pad.part for pad in self.all_pads)

    @property
    def actuators(self) -> tuple[str, ...]:
        """The model's own actuators that move digits."""
        return tuple(dict.fromkeys(name for digit in self.all_digits for name in digit.actuators))

    @property
    def steps(self) -> Mapping[int, str]:
        """The steps of the grasp: without a finger that joins, the third and the fourth are left out."""
        thumbs = " and ".join(digit.name for digit in self.opposers)
        steps = {1: f"{thumbs} and {self.pointer} grasp", 2: "the wrist lifts"}
        if self.supporter is not None:
            steps |= {3: f"{self.supporter} grasps too", 4: f"{self.pointer} is removed"}
        return steps | {5: "all digits grasp"}

    @property
    def pinch(self) -> Mapping[str, float]:
        """Gains of pointer and opposed digits."""
        return {self.pointer: 1.0} | dict.fromkeys((digit.name for digit in self.opposers), self.pinch_gain)

    @property
    def grip(self) -> Mapping[str, float]:
        """Gains of all digits."""
        return {digit.name: self.grip_gain if digit.opposed else 1.0 for digit in self.all_digits}

    @property
    def palm_middle_m(self) -> tuple[float, float]:
        """Middle of the palm's face."""
        return self.palm.middle_m

    def opened(self) -> Floats:
        """Angles of all joints of the open hand."""
        angles = open_angles(self.all_digits)
        bones = mjcf_body.skeleton(self)
        return np.array([angles.get(joint, bones.model.qpos0[bones.address(joint)]) for joint in self.joints])

    def driven(self, digit: str) -> bool:
        """Whether a digit has actuators of its own."""
        return bool(self.digits[digit].actuators)

    def closing(self, digit: str) -> Floats:
        """Torques that close a digit, or where its own actuators are told to go."""
        of = self.digits[digit]
        if of.actuators:
            return np.array(of.closed)
        return np.sign(np.array(of.closed) - of.open) * of.torque

    def opening(self, digit: str) -> Floats:
        """Torques that open a digit, or where its own actuators are told to go."""
        of = self.digits[digit]
        return np.array(of.open) if of.actuators else -_OPENING * self.closing(digit)

    def holding(self, digit: str) -> tuple[Floats | float, Floats]:
        """Stiffness and largest torque of joints that hold an angle."""
        of = self.digits[digit]
        limit = np.array(of.torque)
        return limit * np.where(of.slides, _SLIDE_STIFF, _HINGE_STIFF), limit

    def to_come_down(self) -> Mapping[str, tuple[float, ...] | None]:
        """The pointer straight, opposed digits closed, the others open."""
        out: dict[str, tuple[float, ...] | None] = dict.fromkeys(self.digits)
        for digit in self.all_digits:
            if digit.name == self.pointer:
                out[digit.name] = digit.straight
            elif digit.opposed:
                out[digit.name] = digit.closed
        return out

    def phalanges(self, angles_rad: Floats) -> Phalanges:
        """Place every phalanx from the angles of `joints`."""
        bones = mjcf_body.skeleton(self)
        bones.put(dict(zip(self.joints, np.asarray(angles_rad).tolist(), strict=True)))
        start, along, inward = (np.zeros((len(self.limbs), 3)) for _ in range(3))
        for k, part in enumerate(self.limbs):
            place, turn = bones.body(part.body)
            start[k] = place + turn @ part.capsule.start_m
            along[k], inward[k] = turn @ part.capsule.along, turn @ part.capsule.inward
        capsules = [part.capsule for part in self.limbs]
        return Phalanges(
            self.parts[:-1],
            start,
            along,
            inward,
            np.array([each.length_m for each in capsules]),
            np.array([each.radius_m for each in capsules]),
            np.array([each.half_breadth_m for each in capsules]),
            np.array([part.opposed for part in self.limbs]),
        )

    def add_body(self, mj: Any, spec: Any, palm: Any, layout: Layout, contact: Mapping[str, Any]) -> None:
        """Put the model below the carriage's body "palm"."""
        mjcf_body.add_hand(mj, spec, palm, self, layout, contact)

    def add_motors(self, mj: Any, spec: Any) -> None:
        """Add a motor a joint, to digits without actuators of their own."""
        mjcf_body.add_motors(mj, spec, self)

    def wire(self, model: Any, layout: Layout) -> Any:
        """Find it in a compiled model."""
        return mjcf_body.wire(model, self, layout)

    def pad_frame(self, data: Any, part: str) -> tuple[Floats, ...]:
        """Middle of a part's pad and its unit vectors along columns, along rows and out of it, in the world."""
        if part == "palm":
            body = data.body("palm")
            turn = body.xmat.reshape(3, 3)
            y, z = self.palm.middle_m
            middle = body.xpos + y * turn[:, 1] + z * turn[:, 2]
            return middle, turn[:, 1].copy(), turn[:, 2].copy(), turn[:, 0].copy()
        of = self.limbs[self.parts.index(part)]
        body = data.body(mjcf_body.PREFIX + of.body)
        turn = body.xmat.reshape(3, 3)
        along, outward = turn @ of.capsule.along, turn @ of.capsule.inward
        middle = body.xpos + turn @ of.capsule.start_m + of.capsule.length_m / 2 * along + of.capsule.radius_m * outward
        up = np.cross(along, outward)
        palm_up = data.body("palm").xmat.reshape(3, 3)[:, 2]
        return middle, along, up if up @ palm_up >= 0 else -up, outward

    def pad_size_m(self, part: str) -> tuple[float, float]:
        """Height and length of a part's pad."""
        length, height = self.all_pads[self.pads.index(part)].size_m
        return height, length

    def pad_pitch_m(self, part: str) -> float | None:
        """Taxel spacing of a part's pad, where its own."""
        return self.all_pads[self.pads.index(part)].pitch_m


def open_angles(digits: tuple[MjcfDigit, ...]) -> dict[str, float]:
    """Angles of the joints of open digits; those of own actuators are as the model has them."""
    return {
        joint: angle
        for digit in digits
        if not digit.actuators
        for joint, angle in zip(digit.joints, digit.open, strict=True)
    }
