"""What stands there at one moment: every body of the bench in the carriage's frame, to be drawn from any side."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

import numpy as np
from numpy.typing import NDArray

from varishold.hand.model import require_mujoco

if TYPE_CHECKING:
    from varishold.hand.bench import Bench

__all__ = ["Scene", "SceneBody", "colour_switches", "take_scene"]

Floats = NDArray[np.float64]
BodyKind = Literal["sphere", "capsule", "ellipsoid", "cylinder", "box", "mesh"]

# Colours of a closed switch, and of a phalanx and a palm's button whose switch is open.
_CLOSED, _SKIN, _BUTTON = (0.86, 0.27, 0.22, 1), (0.38, 0.50, 0.66, 1), (0.22, 0.28, 0.36, 1)


@dataclass(frozen=True, eq=False)
class SceneBody:
    """One rigid body.

    Parameters
    ----------
    kind : {"sphere", "capsule", "ellipsoid", "cylinder", "box", "mesh"}
    half_m : (float, float, float)
        Radius of a sphere; radius and half of the straight length (along z) of a capsule or cylinder; half axes of the
        others. Metres.
    place_m : ndarray of shape (3,), float64
    turn : ndarray of shape (3, 3), float64
        Its own axes are the columns.
    colour : (int, int, int)
        Red, green, blue, 0 to 255.
    corners_m : ndarray of shape (n_corners, 3), float64, or None
        Of a mesh, about its place; metres.
    faces : ndarray of shape (n_faces, 3), int64, or None
        Of a mesh: corners of each triangle, counterclockwise from outside.
    """

    kind: BodyKind
    half_m: tuple[float, float, float]
    place_m: Floats
    turn: Floats
    colour: tuple[int, int, int]
    corners_m: Floats | None = None
    faces: NDArray[np.int64] | None = None


Scene = tuple[SceneBody, ...]


def colour_switches(bench: Bench) -> None:
    """Paint what carries a closed switch red, and what carries an open one as usual."""
    model = bench.model
    for switch, closed in zip(bench.layout.switches, bench.closed, strict=True):
        usual = _BUTTON if switch.part == "palm" else _SKIN
        model.geom_rgba[bench.wiring.shown[switch.name]] = _CLOSED if closed else usual


def take_scene(bench: Bench) -> Scene:
    """Return every body that can be seen, as it lies now; closed switches are red.

    The frame goes with the carriage, as the pictures' camera does: x out of the palm, z up from the palm's zero.
    """
    mj = require_mujoco()
    kinds: dict[int, BodyKind] = {
        mj.mjtGeom.mjGEOM_SPHERE.value: "sphere",
        mj.mjtGeom.mjGEOM_CAPSULE.value: "capsule",
        mj.mjtGeom.mjGEOM_ELLIPSOID.value: "ellipsoid",
        mj.mjtGeom.mjGEOM_CYLINDER.value: "cylinder",
        mj.mjtGeom.mjGEOM_BOX.value: "box",
        mj.mjtGeom.mjGEOM_MESH.value: "mesh",
    }
    colour_switches(bench)
    model, data, place = bench.model, bench.data, bench.target
    c, s = np.cos(place["turn"]), np.sin(place["turn"])
    carriage = np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])
    origin = np.array([place["reach"], place["shift"], 0.0])
    out = []
    for k in range(model.ngeom):
        kind, rgba = kinds.get(int(model.geom_type[k])), model.geom_rgba[k]
        if kind is None or rgba[3] <= 0:
            continue
        corners = faces = None
        if kind == "mesh":
            mesh = int(model.geom_dataid[k])
            first, count = int(model.mesh_vertadr[mesh]), int(model.mesh_vertnum[mesh])
            corners = model.mesh_vert[first : first + count].astype(np.float64)
            first, count = int(model.mesh_faceadr[mesh]), int(model.mesh_facenum[mesh])
            faces = model.mesh_face[first : first + count].astype(np.int64)
        red, green, blue = (round(255 * float(part)) for part in rgba[:3])
        half = tuple(float(length) for length in model.geom_size[k])
        turn = carriage @ data.geom_xmat[k].reshape(3, 3)
        out.append(
            SceneBody(
                kind,
                (half[0], half[1], half[2]),
                carriage @ (data.geom_xpos[k] - origin),
                turn,
                (red, green, blue),
                corners,
                faces,
            )
        )
    return tuple(out)
