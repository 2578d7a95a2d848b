"""What an MJCF says of a hand by itself: where its palm is, how its joints open and close, what its parts are like."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from varishold.errors import InputError
from varishold.hand.mjcf.body import PREFIX, colliding, compiled, listed, prepared
from varishold.hand.mjcf.hand import open_angles
from varishold.hand.mjcf.likely import LARGEST_M
from varishold.hand.mjcf.part_geoms import geoms_by_part, welded
from varishold.hand.mjcf.pieces import MjcfDigit, MjcfPalm, MjcfPart
from varishold.hand.mjcf.said import Table
from varishold.hand.mjcf.shapes import Capsule, Piece, bounding_capsule, pieces_of
from varishold.hand.mjcf.source import MjcfSource

__all__ = ["Measured"]

Floats = NDArray[np.float64]

# A palm's button stands out of it by this. Metres.
_RISE_M = 0.003

# A joint opens and closes where it moves the digit's end to the side by this part of its way at least.
_ASIDE = 0.25

# A closing digit is moved by this part of the way from open to closed, to see which way its parts go.
_STEP = 1e-3


class Measured:
    """An MJCF, compiled alone.

    Parameters
    ----------
    mj : module
    source : MjcfSource
    palm : str
        The palm's body.
    actuators : sequence of str
        The model's own that stay.
    """

    def __init__(self, mj: Any, source: MjcfSource, palm: str, actuators: Sequence[str]) -> None:
        self._mj, self._source, self._palm = mj, source, palm
        # What is attached gets other names: its own are asked of a second one.
        self._spec, _ = prepared(mj, source, palm, actuators)
        _, root = prepared(mj, source, palm, actuators)
        self._whole = mj.MjSpec.from_string(source.xml, assets=dict(source.files))
        world = mj.MjSpec()
        world.compiler.degree = False
        world.worldbody.add_frame().attach_body(root, PREFIX, "")
        world.assets = dict(source.files)
        self.model = compiled(source, world)
        self.data = mj.MjData(self.model)
        self._joints = [
            self.model.joint(k).name.removeprefix(PREFIX)
            for k in range(self.model.njnt)
            if self.model.joint(k).name.startswith(PREFIX)
        ]
        self._hinge, self._slide = int(mj.mjtJoint.mjJNT_HINGE.value), int(mj.mjtJoint.mjJNT_SLIDE.value)
        self._turn, self._origin = np.eye(3), np.zeros(3)
        self._put({})

    def _put(self, angles: Mapping[str, float]) -> None:
        self.data.qpos[:] = self.model.qpos0
        for joint, angle in angles.items():
            self.data.qpos[self._joint(joint).qposadr[0]] = angle
        self._mj.mj_kinematics(self.model, self.data)

    def _joint(self, name: str) -> Any:
        return self.model.joint(PREFIX + name)

    def _kind(self, joint: str) -> int:
        return int(self._joint(joint).type[0])

    def place_palm(
        self, out: tuple[float, ...], up: tuple[float, ...], origin_m: tuple[float, ...] | None, table: Table
    ) -> MjcfPalm:
        """Return the palm and where the model lies in its frame."""
        body = self.data.body(PREFIX + self._palm)
        self._turn = (body.xmat.reshape(3, 3) @ _axes(out, up, table)).T
        if origin_m is None:
            self._origin = body.xpos + self._turn.T @ self._before_palm(body.xpos)
        else:
            self._origin = body.xpos + body.xmat.reshape(3, 3) @ np.array(origin_m)
        quaternion = np.zeros(4)
        self._mj.mju_mat2Quat(quaternion, np.ascontiguousarray(self._turn).ravel())
        place = -self._turn @ self._origin
        return MjcfPalm(self._palm, tuple(place.tolist()), tuple(quaternion.tolist()))

    def _before_palm(self, place: Floats) -> Floats:
        """A button's rise before the middle of the palm's face: counted from a place, along the palm's axes."""
        pieces = self._pieces(self._geoms_of(self._below_palm()))
        points = np.vstack([piece.points_m for piece in pieces]) if pieces else place[None, :]
        lying = (points - place) @ self._turn.T
        radii = np.concatenate([np.full(len(piece.points_m), piece.radius_m) for piece in pieces] or [np.zeros(1)])
        low, high = (lying - radii[:, None]).min(axis=0), (lying + radii[:, None]).max(axis=0)
        return np.array([high[0] + _RISE_M, *((low + high) / 2)[1:]])

    def _in_palm(self, points: Floats) -> Floats:
        lying: Floats = (points - self._origin) @ self._turn.T
        return lying

    def _below_palm(self) -> list[str]:
        """The palm's body and those that are welded to it."""
        return [self._palm, *welded(self._spec, self._palm)]

    def _geoms_of(self, bodies: Sequence[str]) -> list[int]:
        return [
            self.model.geom(PREFIX + geom.name).id
            for body in bodies
            for geom in self._spec.body(body).geoms
            if colliding(geom)
        ]

    def _pieces(self, geoms: list[int]) -> list[Piece]:
        """Geoms as points in the world, as the joints stand now."""
        return pieces_of(self._mj, self.model, self.data, geoms)

    def require_joint(self, name: str, table: Table) -> None:
        """Refuse a joint that the hand has not, or that has no single angle."""
        if name not in self._joints:
            raise table.wrong(
                "joints",
                f"names {name!r}, which {self._source.path} has not beyond its palm; it has {listed(self._joints)}",
            )
        if self._kind(name) not in (self._hinge, self._slide):
            raise table.wrong("joints", f"names {name!r}, which neither turns about an axis nor slides along one")

    def require_actuator(self, name: str, table: Table) -> None:
        """Refuse an actuator that the model has not."""
        names = [each.name for each in self._whole.actuators]
        if name not in names:
            raise table.wrong("actuators", f"names {name!r}, which {self._source.path} has not; it has {listed(names)}")

    def slides(self, joint: str) -> bool:
        """Whether a joint slides along its axis."""
        return self._kind(joint) == self._slide

    def joint_range(self, joint: str) -> tuple[float, float]:
        """Where a joint may be: its own range, or what no hand exceeds. Radians, or metres of one that slides."""
        if not self.model.jnt_limited[self._joint(joint).id]:
            most = LARGEST_M if self.slides(joint) else 2 * np.pi
            return -most, most
        low, high = self._joint(joint).range
        return float(low), float(high)

    def actuator_range(self, name: str) -> tuple[float, float]:
        """What an actuator of the model's own may be told."""
        own = self.model.actuator(PREFIX + name)
        if not self.model.actuator_ctrllimited[own.id]:
            return -np.inf, np.inf
        low, high = own.ctrlrange
        return float(low), float(high)

    def torque(self, joint: str) -> float | None:
        """The largest torque that the model's own actuator has at a joint; None where that is not said."""
        own = self._whole.joint(joint)
        limits = [np.abs(own.actfrcrange).max()] if own is not None else []
        for each in self._whole.actuators:
            if each.target == joint:
                gear = abs(float(each.gear[0]))
                limits.append(gear * float(np.abs(each.forcerange).max()))
                if each.biastype == self._mj.mjtBias.mjBIAS_NONE:
                    limits.append(gear * float(abs(each.gainprm[0]) * np.abs(each.ctrlrange).max()))
        said = [float(limit) for limit in limits if 0 < limit < 1e4]
        return min(said) if said else None

    def open_and_closed(
        self, joints: tuple[str, ...], opposed: bool, table: Table
    ) -> tuple[tuple[float, ...], tuple[float, ...]]:
        """Ends of the joints' ranges: open is the one that takes the digit's end farther to its own side.

        A joint that moves it up and down rather than aside is held where the model has it.
        """
        side, end = -1.0 if opposed else 1.0, self._spec.joint(joints[-1]).parent.name
        out = []
        for joint in joints:
            low, high = (float(each) for each in self._joint(joint).range)
            if not self.model.jnt_limited[self._joint(joint).id] or not low < high:
                raise InputError(
                    f"{table.where}: joint {joint!r} has no range in the MJCF; say open and closed, an angle a joint"
                )
            ways = []
            for angle in (low, high):
                self._put({joint: angle})
                ways.append(self._middle(end))
            aside, way = side * float((ways[0] - ways[1])[1]), float(np.linalg.norm(ways[0] - ways[1]))
            if abs(aside) < max(_ASIDE * way, 1e-6):
                held = float(np.clip(self.model.qpos0[self._joint(joint).qposadr[0]], low, high))
                out.append((held, held))
            else:
                out.append((low, high) if aside > 0 else (high, low))
        return tuple(each[0] for each in out), tuple(each[1] for each in out)

    def _middle(self, body: str) -> Floats:
        """Middle of what a body and those welded to it collide with, in the palm's frame."""
        pieces = self._pieces(self._geoms_of([body, *welded(self._spec, body)]))
        if not pieces:
            return self._in_palm(self.data.body(PREFIX + body).xpos)
        points = np.vstack([piece.points_m for piece in pieces])
        return self._in_palm((points.min(axis=0) + points.max(axis=0)) / 2)

    def parts(self, digits: list[MjcfDigit], said: Mapping[str, Table]) -> tuple[list[MjcfPart], list[MjcfDigit]]:
        """Return the parts of all digits, and the digits with their parts' names and their height."""
        named = [geoms_by_part(self._spec, digit, said[digit.name]) for digit in digits]
        taken: dict[str, str] = {}
        limbs, made = [], []
        angles = open_angles(tuple(digits))
        closer = {
            joint: opened + _STEP * (closed - opened)
            for digit in digits
            if not digit.actuators
            for joint, opened, closed in zip(digit.joints, digit.open, digit.closed, strict=True)
        }
        for digit, parts in zip(digits, named, strict=True):
            own = []
            for name, (body, geoms) in parts.items():
                twice = next((geom for geom in geoms if geom in taken), None)
                if twice is not None:
                    raise said[digit.name].wrong("parts", f"{name!r} has a geom that is {taken[twice]}'s already")
                taken |= dict.fromkeys(geoms, name)
                own.append(
                    MjcfPart(name, digit.opposed, body, geoms, self._capsule(digit, body, geoms, angles, closer))
                )
            self._put(angles)
            height = float(np.mean([self._start(part)[2] for part in own]))
            made.append(replace(digit, parts=tuple(part.name for part in own), height_m=height))
            limbs += own
        return limbs, made

    def _start(self, part: MjcfPart) -> Floats:
        body = self.data.body(PREFIX + part.body)
        return self._in_palm(body.xpos + body.xmat.reshape(3, 3) @ part.capsule.start_m)

    def _capsule(
        self,
        digit: MjcfDigit,
        body: str,
        geoms: tuple[str, ...],
        angles: Mapping[str, float],
        closer: Mapping[str, float],
    ) -> Capsule:
        numbers = [self.model.geom(PREFIX + geom).id for geom in geoms]
        middles = []
        for each in (closer, angles):
            self._put(each)
            pieces = self._pieces(numbers)
            if not pieces:
                raise InputError(
                    f"{self._source.path}: geoms of {digit.name!r} are planes or fields; give it solid ones"
                )
            pieces = [replace(piece, points_m=self._in_palm(piece.points_m)) for piece in pieces]
            points = np.vstack([piece.points_m for piece in pieces])
            middles.append((points.min(axis=0) + points.max(axis=0)) / 2)
        own = self.data.body(PREFIX + body)
        start, along, inward, (length, radius, half_breadth) = bounding_capsule(
            pieces, self._in_palm(own.xpos), middles[0] - middles[1], digit.side
        )
        to_body = own.xmat.reshape(3, 3).T
        at = to_body @ (self._origin + self._turn.T @ start - own.xpos)
        return Capsule(
            _three(at),
            _three(to_body @ self._turn.T @ along),
            _three(to_body @ self._turn.T @ inward),
            float(length),
            float(radius),
            float(half_breadth),
        )

    def palm_face(self) -> tuple[float, float, tuple[float, float]]:
        """Return height and breadth (metres) of the palm's face, and its middle (y, z)."""
        self._put({})
        pieces = self._pieces(self._geoms_of(self._below_palm()))
        if not pieces:
            return 0.01, 0.01, (0.0, 0.0)
        low = np.min([self._in_palm(piece.points_m).min(axis=0) - piece.radius_m for piece in pieces], axis=0)
        high = np.max([self._in_palm(piece.points_m).max(axis=0) + piece.radius_m for piece in pieces], axis=0)
        breadth, height = (high - low)[1:].tolist()
        y, z = ((low + high) / 2)[1:].tolist()
        return float(height), float(breadth), (float(y), float(z))

    def moving(self, first: Sequence[str]) -> tuple[str, ...]:
        """All joints beyond the palm: these first."""
        one_angle = (self._hinge, self._slide)
        rest = [name for name in self._joints if name not in first and self._kind(name) in one_angle]
        return (*first, *rest)


def _axes(out: tuple[float, ...], up: tuple[float, ...], table: Table) -> Floats:
    """Return a palm's axes as columns: x is out, z is up as far as that lies across."""
    x, z = np.array(out), np.array(up)
    for key, axis in (("out", x), ("up", z)):
        if np.linalg.norm(axis) < 0.1:
            raise table.wrong(key, f"must be a direction in the palm's body, as in [1, 0, 0], got {axis.tolist()}")
    x /= np.linalg.norm(x)
    z = z - (z @ x) * x
    if np.linalg.norm(z) < 0.1:
        raise table.wrong("up", "points the same way as out; it must lie across")
    z /= np.linalg.norm(z)
    return np.column_stack([x, np.cross(z, x), z])


def _three(vector: Floats) -> tuple[float, float, float]:
    x, y, z = vector.tolist()
    return x, y, z
