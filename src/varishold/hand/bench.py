"""A hand at work: the model in motion, what its motors are told and what it feels."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from varishold.hand.design import HandDesign
from varishold.hand.layouts import PAPER_22, Layout
from varishold.hand.model import CARRIAGE, build, require_mujoco
from varishold.hand.randomization import Circumstances
from varishold.hand.switches import SwitchSetting, switched
from varishold.solids import Solid

__all__ = ["Bench", "Sensed"]

#: Switches are read, and motors told, once in so many time steps of the simulation (10 ms).
_STEPS_A_TICK = 5

#: An object whose centre of mass is farther than this from the palm is not in the hand. Metres.
_REACH_M = 0.15

#: Stiffness of a joint that holds an angle. Newton metres per radian.
_POSE_NM_RAD = 0.6


@dataclass(frozen=True)
class Sensed:
    """What the hand feels at one moment, and nothing that it could not.

    Parameters
    ----------
    switches : ndarray of shape (n_switches,), bool
    forces_n : ndarray of shape (n_switches,)
        Force on each switch. Newtons.
    angles_rad : ndarray of shape (n_joints,)
        Joint angles in the order of `HandDesign.joints`.
    carriage : ndarray of shape (6,)
        The palm's own place in the order of `CARRIAGE`: metres and radians.
    """

    switches: NDArray[np.bool_]
    forces_n: NDArray[np.float64]
    angles_rad: NDArray[np.float64]
    carriage: NDArray[np.float64]


@dataclass
class Bench:
    """A hand, an object on a table, and time.

    Parameters
    ----------
    solid : Solid
        The object.
    circumstances : Circumstances
        This grasp's physics and the object's place.
    design, layout, setting : optional
        The hand, its switch table, and its switches' threshold.
    seed : int
        Fixes the noise of the pads' taxels.
    clamped : bool
        Whether the object stays where it is put.
    """

    solid: Solid
    circumstances: Circumstances
    design: HandDesign = field(default_factory=HandDesign)
    layout: Layout = PAPER_22
    setting: SwitchSetting = field(default_factory=SwitchSetting)
    seed: int = 0
    clamped: bool = False

    def __post_init__(self) -> None:
        self._mj = require_mujoco()
        chance = self.circumstances
        self.model: Any = build(self.design, self.layout, self.solid, chance, clamped=self.clamped)
        self.data: Any = self._mj.MjData(self.model)
        self.on_n = self.setting.on_n * chance.threshold * np.array(chance.switch_spread)
        self._off_n = self.setting.off_fraction * self.on_n
        self._angles = {
            digit.name: np.array([self.model.joint(part).qposadr[0] for part in digit.parts])
            for digit in self.design.digits.values()
        }
        self._motors = {
            digit.name: np.array([self.model.actuator(part).id for part in digit.parts])
            for digit in self.design.digits.values()
        }
        self._joints = np.concatenate(list(self._angles.values()))
        self._carriage = np.array([self.model.joint(name).qposadr[0] for name in CARRIAGE])
        self._drives = np.array([self.model.actuator(name).id for name in CARRIAGE])
        #: Height of the table in the palm's zero frame, metres.
        self.table_m = float(self.model.body("table").pos[2])
        self._object = int(self.model.joint("object").qposadr[0])
        self._parts = np.array([switch.part for switch in self.layout.switches])
        self._palm = self._parts == "palm"
        self.reset()

    def reset(self) -> None:
        """Go back to the beginning: hand open at its zero, every switch open, object wherever it is put next."""
        self._mj.mj_resetData(self.model, self.data)
        #: Where the carriage has been told to be, by name of `CARRIAGE`.
        self.target = dict.fromkeys(CARRIAGE, 0.0)
        self._poses: dict[str, NDArray[np.float64]] = {}
        self.closed = np.zeros(len(self.layout.switches), dtype=np.bool_)
        #: Switches that were closed at any moment since this was last cleared: a pushed object may slide on.
        self.seen = self.closed.copy()
        self.put_digits(open_digits=tuple(self.design.digits))
        self.data.qpos[self._joints] = np.tile(self.design.open_rad, len(self.design.digits))
        self._mj.mj_forward(self.model, self.data)

    def place_object(self, x_m: float, y_m: float, yaw_rad: float) -> None:
        """Stand the object on the table with its base's centre at (x, y) of the palm's zero frame."""
        self.data.qpos[self._object : self._object + 7] = [
            x_m, y_m, self.table_m, np.cos(yaw_rad / 2), 0.0, 0.0, np.sin(yaw_rad / 2),
        ]  # fmt: skip
        self._mj.mj_forward(self.model, self.data)

    def put_carriage(self, values: dict[str, float]) -> None:
        """Set the palm down at these values of `CARRIAGE`, at once."""
        self.target |= values
        for name, value in values.items():
            self.data.joint(name).qpos[:] = value
        self.data.ctrl[self._drives] = list(self.target.values())
        self._mj.mj_forward(self.model, self.data)

    def put_digits(
        self,
        *,
        closed_digits: dict[str, float] | None = None,
        open_digits: tuple[str, ...] = (),
        posed_digits: dict[str, tuple[float, float, float]] | None = None,
    ) -> None:
        """Tell motors what to do.

        Parameters
        ----------
        closed_digits : dict of str to float, optional
            Digits to close, with a gain on the usual torque.
        open_digits : tuple of str
            Digits to open.
        posed_digits : dict of str to tuple of 3 floats, optional
            Digits whose joints to hold at these angles, radians.
        """
        design = self.design
        for digit, gain in (closed_digits or {}).items():
            self.data.ctrl[self._motors[digit]] = gain * self.circumstances.torque * np.array(design.torque_nm)
            self._poses.pop(digit, None)
        for digit in open_digits:
            self.data.ctrl[self._motors[digit]] = -design.opening_nm
            self._poses.pop(digit, None)
        for digit, angles in (posed_digits or {}).items():
            self._poses[digit] = np.array(angles)

    def close_all(self) -> None:
        """Close all digits, the thumb with the torque that holds against all fingers."""
        fingers = dict.fromkeys((finger.name for finger in self.design.fingers), 1.0)
        self.put_digits(closed_digits=fingers | {self.design.thumb.name: self.design.thumb_gain_all})

    def _hold_poses(self) -> None:
        limit = np.array(self.design.torque_nm)
        for digit, wanted in self._poses.items():
            angles = self.data.qpos[self._angles[digit]]
            self.data.ctrl[self._motors[digit]] = np.clip(_POSE_NM_RAD * (wanted - angles), -limit, limit)

    def advance(self, seconds: float, *, carriage: dict[str, float] | None = None) -> None:
        """Let time pass; the carriage moves evenly from its last target to the new one."""
        ticks = max(1, round(seconds / (_STEPS_A_TICK * self.model.opt.timestep)))
        start, goal = self.target, self.target | (carriage or {})
        for k in range(1, ticks + 1):
            self.target = {name: start[name] + (goal[name] - start[name]) * (k / ticks) for name in CARRIAGE}
            self.data.ctrl[self._drives] = list(self.target.values())
            self._hold_poses()
            self._mj.mj_step(self.model, self.data, _STEPS_A_TICK)
            self.closed = switched(self.data.sensordata, self.closed, self.on_n, self._off_n)
            self.seen |= self.closed

    def ahead(self, forward_m: float, aside_m: float = 0.0) -> dict[str, float]:
        """Where the carriage would be so far ahead of its target along its own heading, and aside."""
        target = self.target
        c, s = np.cos(target["turn"]), np.sin(target["turn"])
        return {
            "reach": target["reach"] + float(c * forward_m - s * aside_m),
            "shift": target["shift"] + float(s * forward_m + c * aside_m),
        }

    @property
    def time_s(self) -> float:
        """Seconds that the hand has been at work since the object was set up."""
        return float(self.data.time)

    def sense(self) -> Sensed:
        """Return what the hand feels now."""
        return Sensed(
            self.closed.copy(),
            self.data.sensordata.copy(),
            self.data.qpos[self._joints],
            self.data.qpos[self._carriage],
        )

    def palm_touched(self) -> bool:
        """Whether any of the palm's switches was seen closed."""
        return bool(self.seen[self._palm].any())

    def palm_sides(self) -> tuple[bool, bool]:
        """Whether a palm switch on the fingers' side, and one on the thumb's side, was seen closed."""
        side = np.array([np.sign(switch.y_m) for switch in self.layout.switches])
        pressed = self.seen & self._palm
        return bool(pressed[side > 0].any()), bool(pressed[side < 0].any())

    def digit_touched(self, digit: str) -> bool:
        """Whether any switch of a digit is closed."""
        return any(self.part_touched(part) for part in self.design.digits[digit].parts)

    def part_touched(self, part: str) -> bool:
        """Whether any switch of a part is closed."""
        return bool(self.closed[self._parts == part].any())

    def object_forces_n(self) -> dict[str, float]:
        """Normal force of the object on each phalanx and on the palm, by part, newtons."""
        forces = dict.fromkeys(self.design.parts, 0.0)
        object_body = self.model.body("object").id
        body_of = self.model.geom_bodyid
        out = np.zeros(6)
        for k in range(self.data.ncon):
            first, second = (int(body_of[g]) for g in self.data.contact.geom[k])
            if object_body not in (first, second):
                continue
            part = self.model.body(second if first == object_body else first).name
            if part in forces:
                self._mj.mj_contactForce(self.model, self.data, k, out)
                forces[part] += float(out[0])
        return forces

    def object_pose(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Origin (metres, shape (3,)) and axes (columns, shape (3, 3)) of the object's body in the world."""
        body = self.data.body("object")
        return body.xpos.copy(), body.xmat.reshape(3, 3).copy()

    def pad_frame(self, part: str) -> tuple[NDArray[np.float64], ...]:
        """Middle of a part's pad and its unit vectors along columns, along rows and out of it, in the world."""
        body = self.data.body(part)
        turn = body.xmat.reshape(3, 3)
        if part == "palm":
            return body.xpos.copy(), turn[:, 1].copy(), turn[:, 2].copy(), turn[:, 0].copy()
        digit = self.design.digit_of[part]
        outward = -digit.side * turn[:, 1]
        middle = body.xpos + self.design.length_m(part) / 2 * turn[:, 0] + digit.radius_m * outward
        return middle, turn[:, 0].copy(), turn[:, 2].copy(), outward.copy()

    @property
    def held(self) -> bool:
        """The truth, which the hand cannot know: whether the object hangs in the hand, off the table."""
        table = self.model.geom("table").id
        if np.any(self.data.contact.geom[: self.data.ncon] == table):
            return False
        gap = np.linalg.norm(self.data.body("object").xipos - self.data.body("palm").xpos)
        return bool(gap < _REACH_M)
