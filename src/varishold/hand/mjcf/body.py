"""An MJCF below the carriage's palm: stripped to what the hand moves by, with our contacts, motors and buttons."""

from __future__ import annotations

import warnings
from collections.abc import Mapping, Sequence
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from varishold.errors import FormatError, InputError
from varishold.hand.contact_bits import BUTTON_RGBA, FINGER, THUMB, WORLD
from varishold.hand.hand import Wiring
from varishold.hand.layouts import Layout
from varishold.hand.mjcf.pieces import Pieces
from varishold.hand.mjcf.source import MjcfSource
from varishold.hand.model import require_mujoco

__all__ = ["PREFIX", "Skeleton", "add_hand", "add_motors", "colliding", "compiled", "prepared", "skeleton", "wire"]

Floats = NDArray[np.float64]

#: Before every name of the user's, so that none is one of ours.
PREFIX = "hand/"
_MOTOR, _BUTTON = "motor/", "button/"

# Least mass of the palm, which moves; the hand's own comes on top. Kilograms.
_PALM_KG = 0.05

# A hinge closes at no more than this speed where nothing stops it (rad/s), and what slides takes so long from open to
# closed (s). Their inertia is this part of their torque (s^2) at least, so that the simulation's steps follow them.
_SPEED, _TRAVEL_S, _INERTIA = 9.0, 0.12, {True: 2e-4, False: 2e-3}

# Stiffness of a joint that is held at one angle. N m/rad, N/m.
_HELD = {True: 5.0, False: 3000.0}


def prepared(mj: Any, source: MjcfSource, palm: str, kept: Sequence[str] = ()) -> tuple[Any, Any]:
    """Return a model's specification and the body at the root of the hand, free of what is not the hand's own.

    Sensors, keys and actuators that are not among the `kept` are gone, and so are the joints between the world
    and the palm: our carriage moves it.
    """
    try:
        spec = mj.MjSpec.from_string(source.xml, assets=dict(source.files))
    except Exception as error:  # MuJoCo raises ValueError, and others where a file is damaged
        raise FormatError(f"{source.path}: MuJoCo cannot read it: {error}") from None
    body = spec.body(palm)
    if body is None:
        names = [each.name for each in spec.bodies if each.name and each.name != "world"]
        raise InputError(f"{source.path}: has no body {palm!r}; it has {listed(names)}")
    if palm == "world":
        raise InputError(f"{source.path}: the palm cannot be the world; put the hand into a body of its own")
    for each in (*spec.keys, *spec.sensors, *(a for a in spec.actuators if a.name not in kept)):
        spec.delete(each)
    root = body
    while True:
        for joint in list(root.joints):
            spec.delete(joint)
        if root.parent.name == "world":
            break
        root = root.parent
    for kind, elements in (("body", spec.bodies), ("joint", spec.joints), ("geom", spec.geoms)):
        for k, each in enumerate(elements):
            if not each.name:
                each.name = f"{kind}~{k}"
    return spec, root


def listed(names: Sequence[str]) -> str:
    """Some names, to be told."""
    return ", ".join(names[:40]) + (" ..." if len(names) > 40 else "") if names else "none with a name"


def colliding(geom: Any) -> bool:
    """Whether a geom touches anything as the model's author has it; what does not is there to be seen."""
    return bool(geom.contype or geom.conaffinity)


def compiled(source: MjcfSource, spec: Any) -> Any:
    """Compile; what MuJoCo refuses is told in one line."""
    try:
        # What MuJoCo warns of here is what our scene and the model say differently, where ours counts.
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", UserWarning)
            model = spec.compile()
    except Exception as error:  # as in `prepared`
        raise FormatError(f"{source.path}: MuJoCo cannot compile it: {error}") from None
    # MuJoCo takes them, and whatever is measured of the hand is then no number either.
    for kind, places in (("body", model.body_pos), ("joint", model.jnt_pos), ("geom", model.geom_pos)):
        lost = np.flatnonzero(~np.isfinite(places).all(axis=1))
        if lost.size:
            name = getattr(model, kind)(int(lost[0])).name.removeprefix(PREFIX)
            raise FormatError(f"{source.path}: pos of {kind} {name!r} is no number")
    return model


def add_hand(
    mj: Any, spec: Any, palm: Any, hand: Pieces, layout: Layout, contact: Mapping[str, Any] | None = None
) -> None:
    """Put the hand below our palm, so that its palm's frame is ours."""
    child, root = prepared(mj, hand.source, hand.palm.body, hand.actuators)
    part_of = {geom: k for k, part in enumerate(hand.limbs) for geom in part.geoms}
    first = {digit.parts[0] for digit in hand.digits.values()}
    for body in child.bodies:
        if body.name != "world":
            body.gravcomp = 1.0
    for geom in child.geoms:
        if not colliding(geom):
            continue
        geom.contype, geom.conaffinity = 0, WORLD
        if geom.name in part_of:
            part = hand.limbs[part_of[geom.name]]
            if part.name not in first:
                geom.contype = THUMB if part.opposed else FINGER
                geom.conaffinity = WORLD | (FINGER | THUMB) & ~geom.contype
        geom.margin, geom.gap, geom.priority = 0.0, 0.0, 0
        for name, value in (contact or {}).items():
            setattr(geom, name, value)
    for digit in hand.digits.values():
        if not digit.actuators:
            for k, name in enumerate(digit.joints):
                _set_joint(mj, child.joint(name), digit.open[k], digit.closed[k], digit.torque[k])
    palm.add_geom(
        type=mj.mjtGeom.mjGEOM_SPHERE, size=[0.001], mass=_PALM_KG, contype=0, conaffinity=0, rgba=[0, 0, 0, 0]
    )
    for switch in layout.switches:
        if switch.part == "palm":
            palm.add_geom(
                name=_BUTTON + switch.name,
                type=mj.mjtGeom.mjGEOM_SPHERE,
                size=[hand.button_radius_m],
                pos=[-hand.button_radius_m, switch.y_m, switch.z_m],
                mass=0.001,
                contype=0,
                conaffinity=WORLD,
                rgba=BUTTON_RGBA,
                **(contact or {}),
            )
    frame = palm.add_frame(pos=list(hand.palm.place_m), quat=list(hand.palm.quaternion))
    frame.attach_body(root, PREFIX, "")
    spec.assets = {**spec.assets, **dict(hand.source.files)}


def _set_joint(mj: Any, joint: Any, opened: float, closed: float, torque: float) -> None:
    """Let a joint move between open and closed, no faster than a hand does; or hold it."""
    hinge = joint.type == mj.mjtJoint.mjJNT_HINGE
    if opened == closed:
        joint.stiffness, joint.springref = _first(joint.stiffness, _HELD[hinge]), opened
        joint.damping = _first(joint.damping, max(float(joint.damping[0]), _HELD[hinge] / 50))
        return
    joint.limited = mj.mjtLimited.mjLIMITED_TRUE
    joint.range = [min(opened, closed), max(opened, closed)]
    joint.stiffness = _first(joint.stiffness, 0.0)
    speed = _SPEED if hinge else abs(closed - opened) / _TRAVEL_S
    joint.damping = _first(joint.damping, max(float(joint.damping[0]), torque / speed))
    joint.armature = max(float(joint.armature), torque * _INERTIA[hinge])


def _first(array: Floats, value: float) -> Floats:
    out = np.zeros_like(array)
    out[0] = value
    return out


def add_motors(mj: Any, spec: Any, hand: Pieces) -> None:
    """Add a motor a joint to digits without actuators of their own."""
    for digit in hand.digits.values():
        for joint in () if digit.actuators else digit.joints:
            motor = spec.add_actuator(name=_MOTOR + joint, target=PREFIX + joint, trntype=mj.mjtTrn.mjTRN_JOINT)
            motor.set_to_motor()


class Skeleton:
    """The hand alone, to place its parts from its joints' angles; its palm's frame is the world's."""

    def __init__(self, mj: Any, hand: Pieces) -> None:
        self._mj = mj
        spec = mj.MjSpec()
        spec.compiler.degree = False
        add_hand(mj, spec, spec.worldbody.add_body(name="palm"), hand, Layout("", ()))
        self.model = compiled(hand.source, spec)
        self.data = mj.MjData(self.model)

    def address(self, joint: str) -> int:
        """Where a joint's angle stands."""
        return int(self.model.joint(PREFIX + joint).qposadr[0])

    def put(self, angles: Mapping[str, float]) -> None:
        """Place all bodies with these joints at these angles, and the others as the model has them."""
        self.data.qpos[:] = self.model.qpos0
        for joint, angle in angles.items():
            self.data.qpos[self.address(joint)] = angle
        self._mj.mj_kinematics(self.model, self.data)

    def body(self, name: str) -> tuple[Floats, Floats]:
        """Origin (metres) and axes (columns) of a body."""
        body = self.data.body(PREFIX + name)
        return body.xpos.copy(), body.xmat.reshape(3, 3).copy()


@lru_cache(maxsize=8)
def skeleton(hand: Pieces) -> Skeleton:
    """Return the hand's skeleton, made once in a process."""
    return Skeleton(require_mujoco(), hand)


def wire(model: Any, hand: Pieces, layout: Layout) -> Wiring:
    """Find the hand in a compiled model."""
    angles = {
        digit.name: np.array([model.joint(PREFIX + joint).qposadr[0] for joint in digit.joints])
        for digit in hand.digits.values()
    }
    motors = {
        digit.name: np.array(
            [model.actuator(PREFIX + name).id for name in digit.actuators]
            or [model.actuator(_MOTOR + joint).id for joint in digit.joints]
        )
        for digit in hand.digits.values()
    }
    part_of = np.full(model.ngeom, -1)
    owner = np.full(model.ngeom, -1)
    for k, part in enumerate(hand.limbs):
        for geom in part.geoms:
            part_of[model.geom(PREFIX + geom).id] = owner[model.geom(PREFIX + geom).id] = k
    palm = len(hand.limbs)
    for k in range(model.ngeom):
        if part_of[k] < 0 and model.geom(k).name.startswith(PREFIX) and model.geom_conaffinity[k]:
            part_of[k] = palm
    shown, group = {}, []
    for k, switch in enumerate(layout.switches):
        if switch.part == "palm":
            geom = model.geom(_BUTTON + switch.name).id
            part_of[geom], owner[geom] = palm, palm + 1 + k
            shown[switch.name] = np.array([geom])
            group.append(palm + 1 + k)
        else:
            group.append(hand.parts.index(switch.part))
            shown[switch.name] = np.flatnonzero(part_of == group[-1])
    return Wiring(
        angles,
        motors,
        np.array([model.joint(PREFIX + joint).qposadr[0] for joint in hand.joints]),
        part_of,
        shown,
        _Forces(owner, np.array(group), palm + 1 + len(layout.switches)),
    )


class _Forces:
    """The force on each switch: of all contacts of what carries it."""

    def __init__(self, owner: NDArray[np.int64], group: NDArray[np.int64], n: int) -> None:
        self._owner, self._group, self._n = owner, group, n

    def __call__(self, data: Any) -> Floats:
        contact = data.contact
        active = contact.efc_address >= 0
        # The first of a contact's rows is along its normal.
        normal = data.efc_force[contact.efc_address[active]] if active.any() else np.zeros(0)
        owner = self._owner[contact.geom[active]].reshape(-1, 2)
        felt = np.zeros(self._n)
        for side in (0, 1):
            on = owner[:, side] >= 0
            np.add.at(felt, owner[on, side], normal[on])
        forces: Floats = felt[self._group]
        return forces
