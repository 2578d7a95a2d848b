"""The hand, an object and a table as a MuJoCo model, built from Python."""

from __future__ import annotations

import os
import warnings
from typing import Any

import numpy as np

from varishold._lazy import to_install
from varishold.errors import MissingExtraError
from varishold.hand.contact_bits import WORLD
from varishold.hand.hand import Hand
from varishold.hand.layouts import Layout
from varishold.hand.randomization import Circumstances
from varishold.solids import Part, Solid

__all__ = ["CARRIAGE", "build", "require_mujoco"]

#: The joints that carry the palm: along x, along y, up, turn about z, roll about x, and the wrist that lifts.
CARRIAGE = ("reach", "shift", "raise", "turn", "roll", "wrist")

#: Stiffness and damping of the carriage's drives along an axis (N/m, N s/m) and about one (N m/rad, N m s/rad).
_STIFF_SLIDE, _STIFF_HINGE = (6000.0, 220.0), (200.0, 8.0)

#: Density of an object, kg/m^3: light wood or a hollow body.
_DENSITY = 300.0

#: Rolling resistance of a ball's stand: radius of a contact patch, metres.
_FELT_M = 0.003

#: Inertia and damping of a clamped object's joint: a hand moves it by less than a hundredth of a millimetre. kg, N s/m.
_CLAMPED = (1e4, [1e7, 0.0, 0.0])

#: Time constant of a contact, seconds; at least two time steps.
_SOFTNESS_S = 0.007

_GREY, _WOOD = (0.82, 0.83, 0.85, 1), (0.86, 0.70, 0.48, 1)


def require_mujoco() -> Any:
    """Import MuJoCo.

    Raises
    ------
    MissingExtraError
        If it is not installed, or cannot load what MUJOCO_GL asks for.
    """
    try:
        import mujoco
    except ImportError:
        raise MissingExtraError(f"the hand needs MuJoCo; run: {to_install('sim')}") from None
    except Exception as error:  # MuJoCo loads what MUJOCO_GL names as it is imported, and fails in any way
        raise MissingExtraError(
            f"MuJoCo cannot draw with MUJOCO_GL={os.environ.get('MUJOCO_GL', '')} here ({error}); "
            "unset it, or set it to egl with libegl1 installed"
        ) from None
    # What is unstable is told in one line by who advances it, not in a file in the folder.
    mujoco.set_mju_user_warning(lambda text: None)
    return mujoco


def build(design: Hand, layout: Layout, solid: Solid, chance: Circumstances, *, clamped: bool = False) -> Any:
    """Compile the scene: a hand before an object that stands free on a table.

    Parameters
    ----------
    design : Hand
    layout : Layout
    solid : Solid
    chance : Circumstances
        Its factors on the hand's friction, the object's density and the contacts' time constant.
    clamped : bool
        Whether the object stays where it is put, whatever pushes it.

    Returns
    -------
    mujoco.MjModel
        The palm's frame is the world's when every joint is at zero; the object is the free body "object". The
        table stands so low that the palm is `Hand.palm_above_middle_m` above the object's middle of mass.
        It holds the object up and nothing else, like a stand that is narrower than the object.

    Raises
    ------
    MissingExtraError
        If MuJoCo is not installed.
    """
    mj = require_mujoco()
    spec = mj.MjSpec()
    spec.compiler.degree = False
    option = spec.option
    option.timestep = 0.002
    option.integrator = mj.mjtIntegrator.mjINT_IMPLICITFAST
    option.cone = mj.mjtCone.mjCONE_ELLIPTIC
    option.impratio = 10
    option.iterations = 30
    option.ls_iterations = 20
    friction = [design.friction * chance.friction, design.torsion_m, 0.0001]
    contact: dict[str, Any] = {
        "condim": 4,
        "friction": friction,
        "solref": [_SOFTNESS_S * chance.softness, 1.0],
        "solimp": [0.9, 0.95, 0.001, 0.5, 2],
    }
    _add_table(mj, spec, solid)
    _add_hand(mj, spec, design, layout, contact)
    _add_object(mj, spec, solid, _DENSITY * chance.density, contact, clamped)
    with warnings.catch_warnings():
        # As of `mjcf.body.compiled`.
        warnings.simplefilter("ignore", UserWarning)
        model = spec.compile()
    middle_m = float(model.body("object").ipos[2])
    model.body("table").pos[2] = -middle_m - design.palm_above_middle_m
    return model


def _add_table(mj: Any, spec: Any, solid: Solid) -> None:
    table = spec.worldbody.add_body(name="table")
    table.add_geom(
        name="table",
        type=mj.mjtGeom.mjGEOM_PLANE,
        size=[1, 1, 0.1],
        contype=0,
        conaffinity=WORLD,
        # A ball would roll away on a bare table; its stand is felt.
        friction=[0.4, 0.005, _FELT_M if solid.rolls else 0.0001],
        condim=6 if solid.rolls else 3,
        rgba=[0, 0, 0, 0],
    )
    # What is seen of it: a round top.
    table.add_geom(
        type=mj.mjtGeom.mjGEOM_CYLINDER,
        size=[0.16, 0.004, 0],
        pos=[0.08, 0, -0.0045],
        contype=0,
        conaffinity=0,
        rgba=_GREY,
    )
    spec.add_texture(
        name="sky",
        type=mj.mjtTexture.mjTEXTURE_SKYBOX,
        builtin=mj.mjtBuiltin.mjBUILTIN_GRADIENT,
        rgb1=[1, 1, 1],
        rgb2=[0.93, 0.94, 0.96],
        width=64,
        height=64,
    )
    spec.visual.headlight.ambient = [0.45, 0.45, 0.45]
    spec.visual.headlight.diffuse = [0.55, 0.55, 0.55]
    spec.visual.headlight.specular = [0.1, 0.1, 0.1]


def _add_hand(mj: Any, spec: Any, design: Hand, layout: Layout, contact: dict[str, Any]) -> None:
    hinge, slide = mj.mjtJoint.mjJNT_HINGE, mj.mjtJoint.mjJNT_SLIDE
    # A stiff carriage stands for the arm; its own mass keeps the grip's reactions from shaking it.
    arm = spec.worldbody.add_body(name="arm")
    arm.add_geom(
        type=mj.mjtGeom.mjGEOM_SPHERE, size=[0.012], pos=[-design.wrist_m, 0, 0], mass=1.0, contype=0, conaffinity=0,
        rgba=_GREY,
    )  # fmt: skip
    arm.gravcomp = 1.0
    for name, axis in (("reach", [1, 0, 0]), ("shift", [0, 1, 0]), ("raise", [0, 0, 1])):
        arm.add_joint(name=name, type=slide, axis=axis, armature=1.0)
    for name, axis in (("turn", [0, 0, 1]), ("roll", [1, 0, 0])):
        arm.add_joint(name=name, type=hinge, axis=axis, armature=0.05)
    palm = arm.add_body(name="palm", gravcomp=1.0)
    palm.add_joint(name="wrist", type=hinge, axis=[0, -1, 0], pos=[-design.wrist_m, 0, 0], armature=0.05)
    design.add_body(mj, spec, palm, layout, contact)
    for name in CARRIAGE:
        stiffness, damping = _STIFF_SLIDE if name in ("reach", "shift", "raise") else _STIFF_HINGE
        drive = spec.add_actuator(name=name, target=name, trntype=mj.mjtTrn.mjTRN_JOINT)
        drive.set_to_position(kp=stiffness, kv=damping)
    design.add_motors(mj, spec)


def _add_object(mj: Any, spec: Any, solid: Solid, density: float, contact: dict[str, Any], clamped: bool) -> None:
    body = spec.worldbody.add_body(name="object", pos=[0.1, 0, 0])
    joint = body.add_freejoint(name="object")
    if clamped:
        joint.armature, joint.damping = _CLAMPED
    for k, part in enumerate(solid.body()):
        body.add_geom(
            name=f"object.{k}",
            contype=WORLD,
            conaffinity=0,
            density=density,
            rgba=_WOOD,
            **_geom(mj, spec, f"object.{k}", part),
            **contact,
        )


def _geom(mj: Any, spec: Any, name: str, part: Part) -> dict[str, Any]:
    kinds = mj.mjtGeom
    if part.kind == "hull":
        spec.add_mesh(name=name, uservert=np.array(part.corners_m).ravel())
        return {"type": kinds.mjGEOM_MESH, "meshname": name}
    centre = list(part.centre_m)
    if part.kind == "box":
        return {"type": kinds.mjGEOM_BOX, "size": list(part.half_m), "pos": centre}
    if part.kind == "cylinder":
        return {"type": kinds.mjGEOM_CYLINDER, "size": [part.half_m[0], part.half_m[2], 0], "pos": centre}
    if len(set(part.half_m)) == 1:
        return {"type": kinds.mjGEOM_SPHERE, "size": list(part.half_m), "pos": centre}
    return {"type": kinds.mjGEOM_ELLIPSOID, "size": list(part.half_m), "pos": centre}
