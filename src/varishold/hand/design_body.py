"""The body of the built-in hand in a MuJoCo model: palm, buttons, digits, and the sensors of its switches."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from varishold.hand.contact_bits import BUTTON_RGBA, FINGER, SKIN_RGBA, THUMB, WORLD
from varishold.hand.digit import Digit
from varishold.hand.hand import Wiring
from varishold.hand.layouts import Layout

__all__ = ["Proportions", "add_body", "wire"]


class Proportions(Protocol):
    """What a body is built from; `HandDesign` tells what each is."""

    @property
    def palm_m(self) -> tuple[float, float, float]: ...
    @property
    def knuckle_m(self) -> tuple[float, float]: ...
    @property
    def button_radius_m(self) -> float: ...
    @property
    def button_rise_m(self) -> float: ...
    @property
    def open_rad(self) -> tuple[float, float, float]: ...
    @property
    def curl_rad(self) -> tuple[float, float, float]: ...
    @property
    def joint_damping_nms(self) -> float: ...
    @property
    def joint_armature_kg_m2(self) -> float: ...
    @property
    def digits(self) -> Mapping[str, Digit]: ...
    @property
    def parts(self) -> tuple[str, ...]: ...
    def length_m(self, part: str) -> float: ...


def add_body(mj: Any, spec: Any, palm: Any, design: Proportions, layout: Layout, contact: dict[str, Any]) -> None:
    """Add palm, digits and touch sensors, a sensor a switch in the layout's order, below the body "palm"."""
    thickness, breadth, height = design.palm_m
    palm.add_geom(
        name="palm",
        type=mj.mjtGeom.mjGEOM_BOX,
        size=[thickness / 2, breadth / 2, height / 2],
        pos=[-thickness / 2 - design.button_rise_m, 0, 0],
        mass=0.25,
        contype=0,
        conaffinity=WORLD,
        rgba=SKIN_RGBA,
        **contact,
    )
    for switch in layout.switches:
        if switch.part == "palm":
            place = [-design.button_radius_m, switch.y_m, switch.z_m]
            palm.add_geom(
                name=switch.name,
                type=mj.mjtGeom.mjGEOM_SPHERE,
                size=[design.button_radius_m],
                pos=place,
                mass=0.001,
                contype=0,
                conaffinity=WORLD,
                rgba=BUTTON_RGBA,
                **contact,
            )
            palm.add_site(name=switch.name, size=[design.button_radius_m + 0.002], pos=place, rgba=[0, 0, 0, 0])
    for digit in design.digits.values():
        _add_digit(mj, palm, design, digit, contact)
    for switch in layout.switches:
        spec.add_sensor(
            name=switch.name,
            type=mj.mjtSensor.mjSENS_TOUCH,
            objtype=mj.mjtObj.mjOBJ_SITE,
            objname=switch.name if switch.part == "palm" else switch.part,
        )


def _add_digit(mj: Any, palm: Any, design: Proportions, digit: Digit, contact: dict[str, Any]) -> None:
    radius = digit.radius_m
    x, y = design.knuckle_m
    parent, place = palm, [x, digit.side * y, digit.height_m]
    halves = (-digit.breadth_m / 2, digit.breadth_m / 2) if digit.breadth_m else (0.0,)
    bits = THUMB if digit.opposed else FINGER
    for k, name in enumerate(digit.parts):
        length = design.length_m(name)
        body = parent.add_body(name=name, pos=place, gravcomp=1.0)
        body.add_joint(
            name=name,
            type=mj.mjtJoint.mjJNT_HINGE,
            axis=[0, 0, -digit.side],
            limited=mj.mjtLimited.mjLIMITED_TRUE,
            range=[design.open_rad[k], design.curl_rad[k]],
            damping=design.joint_damping_nms,
            armature=design.joint_armature_kg_m2,
        )
        for half in halves:
            body.add_geom(
                type=mj.mjtGeom.mjGEOM_CAPSULE,
                fromto=[0, 0, half, length, 0, half],
                size=[radius, 0, 0],
                density=1000,
                contype=0 if k == 0 else bits,
                conaffinity=WORLD if k == 0 else WORLD | (FINGER | THUMB) & ~bits,
                rgba=SKIN_RGBA,
                **contact,
            )
        # The site only bounds the contacts that its touch sensor adds up: all of this phalanx's.
        body.add_site(
            name=name,
            type=mj.mjtGeom.mjGEOM_BOX,
            pos=[length / 2, 0, 0],
            size=[length / 2 + 2 * radius, 2 * radius, 2 * radius + max(halves)],
            rgba=[0, 0, 0, 0],
        )
        parent, place = body, [length, 0, 0]


def wire(model: Any, design: Proportions, layout: Layout) -> Wiring:
    """Find the hand in a compiled model: joints, motors, bodies and sites are called as its parts."""
    angles = {
        digit.name: np.array([model.joint(part).qposadr[0] for part in digit.parts]) for digit in design.digits.values()
    }
    motors = {
        digit.name: np.array([model.actuator(part).id for part in digit.parts]) for digit in design.digits.values()
    }
    place = {model.body(part).id: k for k, part in enumerate(design.parts)}
    shown = {
        switch.name: np.array([model.geom(switch.name).id])
        if switch.part == "palm"
        else model.body(switch.part).geomadr[0] + np.arange(model.body(switch.part).geomnum[0])
        for switch in layout.switches
    }
    return Wiring(
        angles,
        motors,
        np.concatenate(list(angles.values())),
        np.array([place.get(int(body), -1) for body in model.geom_bodyid]),
        shown,
        _sensors,
    )


def _sensors(data: Any) -> NDArray[np.float64]:
    forces: NDArray[np.float64] = data.sensordata
    return forces
