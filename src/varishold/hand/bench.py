"""A hand at work: the model in motion, what its motors are told and what it feels."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from varishold.errors import InputError
from varishold.hand.design import HandDesign
from varishold.hand.hand import Hand
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

#: What makes the force of an actuator, by the model's arrays.
_STRENGTH = ("actuator_gainprm", "actuator_biasprm", "actuator_forcerange")


@dataclass(frozen=True)
class Sensed:
    """What the hand feels at one moment, and nothing that it could not.

    Parameters
    ----------
    switches : ndarray of shape (n_switches,), bool
    forces_n : ndarray of shape (n_switches,)
        Force on each switch. Newtons.
    angles_rad : ndarray of shape (n_joints,)
        Joint angles in the order of `Hand.joints`.
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
    design: Hand = field(default_factory=HandDesign)
    layout: Layout = PAPER_22
    setting: SwitchSetting = field(default_factory=SwitchSetting)
    seed: int = 0
    clamped: bool = False

    def __post_init__(self) -> None:
        self._mj = require_mujoco()
        chance = self.circumstances
        self.model: Any = build(self.design, self.layout, self.solid, chance, clamped=self.clamped)
        self.data: Any = self._mj.MjData(self.model)
        usual = self.setting.on_n
        on_n = np.array([usual if switch.on_n is None else switch.on_n for switch in self.layout.switches])
        self.on_n = on_n * chance.threshold * np.array(chance.switch_spread)
        self._off_n = self.setting.off_fraction * self.on_n
        kinds = self._mj.mjtWarning
        self._unstable = [kinds.mjWARN_BADQPOS.value, kinds.mjWARN_BADQVEL.value, kinds.mjWARN_BADQACC.value]
        self._usual = {array: getattr(self.model, array).copy() for array in _STRENGTH}
        #: Where the hand is in the model.
        self.wiring = self.design.wire(self.model, self.layout)
        self._angles, self._motors, self._joints = self.wiring.angles, self.wiring.motors, self.wiring.joints
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
        self.data.qpos[self._joints] = self.design.opened()
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
        posed_digits: dict[str, tuple[float, ...]] | None = None,
    ) -> None:
        """Tell motors what to do.

        Parameters
        ----------
        closed_digits : dict of str to float, optional
            Digits to close, with a gain on the usual torque.
        open_digits : tuple of str
            Digits to open.
        posed_digits : dict of str to tuple of floats, optional
            Digits whose joints to hold at these angles, radians.
        """
        design = self.design
        for digit, gain in (closed_digits or {}).items():
            strength = gain * self.circumstances.torque
            if design.driven(digit):
                self._strengthen(digit, strength)
                self.data.ctrl[self._motors[digit]] = design.closing(digit)
            else:
                self.data.ctrl[self._motors[digit]] = strength * design.closing(digit)
            self._poses.pop(digit, None)
        for digit in open_digits:
            if design.driven(digit):
                self._strengthen(digit, 1.0)
            self.data.ctrl[self._motors[digit]] = design.opening(digit)
            self._poses.pop(digit, None)
        for digit, angles in (posed_digits or {}).items():
            self._poses[digit] = np.array(angles)

    def close_all(self) -> None:
        """Close all digits, the thumb with the torque that holds against all fingers."""
        self.put_digits(closed_digits=dict(self.design.grip))

    def _strengthen(self, digit: str, strength: float) -> None:
        """Give actuators that are told where to go so many times their usual force."""
        motors = self._motors[digit]
        for array, usual in self._usual.items():
            getattr(self.model, array)[motors] = strength * usual[motors]

    def _hold_poses(self) -> None:
        for digit, wanted in self._poses.items():
            stiffness, limit = self.design.holding(digit)
            angles = self.data.qpos[self._angles[digit]]
            self.data.ctrl[self._motors[digit]] = np.clip(stiffness * (wanted - angles), -limit, limit)

    def advance(self, seconds: float, *, carriage: dict[str, float] | None = None) -> None:
        """Let time pass; the carriage moves evenly from its last target to the new one."""
        ticks = max(1, round(seconds / (_STEPS_A_TICK * self.model.opt.timestep)))
        start, goal = self.target, self.target | (carriage or {})
        for k in range(1, ticks + 1):
            self.target = {name: start[name] + (goal[name] - start[name]) * (k / ticks) for name in CARRIAGE}
            self.data.ctrl[self._drives] = list(self.target.values())
            self._hold_poses()
            self._mj.mj_step(self.model, self.data, _STEPS_A_TICK)
            if any(self.data.warning[k].number for k in self._unstable):
                raise InputError(
                    "the simulation of this hand became unstable; give its joints more damping, or less torque"
                )
            self.closed = switched(self.wiring.forces_n(self.data), self.closed, self.on_n, self._off_n)
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
            self.wiring.forces_n(self.data).copy(),
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
        names = self.design.parts
        forces = dict.fromkeys(names, 0.0)
        object_body = self.model.body("object").id
        body_of = self.model.geom_bodyid
        out = np.zeros(6)
        for k in range(self.data.ncon):
            geoms = [int(g) for g in self.data.contact.geom[k]]
            if not any(body_of[g] == object_body for g in geoms):
                continue
            other = geoms[1] if body_of[geoms[0]] == object_body else geoms[0]
            part = int(self.wiring.part_of_geom[other])
            if part >= 0:
                self._mj.mj_contactForce(self.model, self.data, k, out)
                forces[names[part]] += float(out[0])
        return forces

    def object_pose(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Origin (metres, shape (3,)) and axes (columns, shape (3, 3)) of the object's body in the world."""
        body = self.data.body("object")
        return body.xpos.copy(), body.xmat.reshape(3, 3).copy()

    def pad_frame(self, part: str) -> tuple[NDArray[np.float64], ...]:
        """Middle of a part's pad and its unit vectors along columns, along rows and out of it, in the world."""
        return self.design.pad_frame(self.data, part)

    @property
    def held(self) -> bool:
        """The truth, which the hand cannot know: whether the object hangs in the hand, off the table."""
        table = self.model.geom("table").id
        if np.any(self.data.contact.geom[: self.data.ncon] == table):
            return False
        gap = np.linalg.norm(self.data.body("object").xipos - self.data.body("palm").xpos)
        return bool(gap < _REACH_M)
