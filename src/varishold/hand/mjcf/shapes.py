"""The capsule that stands for a part of a hand: from its geoms, in the frame of its body."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

__all__ = ["Capsule", "Piece", "bounding_capsule", "pieces_of"]

Floats = NDArray[np.float64]

# Points round a rim, and the least share by which a part is longer than broad for its longest line to be its own.
_RIM, _LONGER = 16, 1.3
# A movement that is shorter than this says nothing of a side. Metres.
_LEAST_WAY_M = 1e-7


@dataclass(frozen=True)
class Piece:
    """A geom as points, each with so much round it; `domed`: its ends are taken for round.

    Parameters
    ----------
    points_m : ndarray of shape (n, 3)
        Metres, in the palm's frame.
    radius_m : float
        Metres.
    domed : bool
    """

    points_m: Floats
    radius_m: float = 0.0
    domed: bool = False


@dataclass(frozen=True)
class Capsule:
    """A straight line with a radius and, across, a breadth; unit vectors and metres in the frame of its body.

    Parameters
    ----------
    start_m, along, inward : tuple of 3 floats
        Near end of its middle line, direction to its far end, direction of its inner side.
    length_m, radius_m, half_breadth_m : float
    """

    start_m: tuple[float, float, float]
    along: tuple[float, float, float]
    inward: tuple[float, float, float]
    length_m: float
    radius_m: float
    half_breadth_m: float


def pieces_of(mj: Any, model: Any, data: Any, geoms: list[int]) -> list[Piece]:
    """Return geoms as points in the world of `data`; what has no bounded surface is left out."""
    kinds = mj.mjtGeom
    out = []
    for k in geoms:
        kind, size = int(model.geom_type[k]), model.geom_size[k].astype(np.float64)
        place, turn = data.geom_xpos[k], data.geom_xmat[k].reshape(3, 3)
        radius, domed = 0.0, False
        if kind == kinds.mjGEOM_SPHERE.value:
            local, radius = np.zeros((1, 3)), float(size[0])
        elif kind == kinds.mjGEOM_CAPSULE.value:
            local, radius = np.array([[0, 0, -size[1]], [0, 0, size[1]]]), float(size[0])
        elif kind == kinds.mjGEOM_CYLINDER.value:
            angle = 2 * np.pi * np.arange(_RIM) / _RIM
            rim = size[0] * np.column_stack([np.cos(angle), np.sin(angle), 0 * angle])
            local = np.vstack([rim + np.array([0, 0, z]) for z in (-size[1], size[1])])
        elif kind == kinds.mjGEOM_BOX.value:
            local = size * np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])
        elif kind == kinds.mjGEOM_ELLIPSOID.value:
            local, domed = np.vstack([np.diag(size), -np.diag(size)]), True
        elif kind == kinds.mjGEOM_MESH.value:
            mesh = int(model.geom_dataid[k])
            first, count = int(model.mesh_vertadr[mesh]), int(model.mesh_vertnum[mesh])
            local, domed = model.mesh_vert[first : first + count].astype(np.float64), True
        else:
            continue
        out.append(Piece(place + local @ turn.T, radius, domed))
    return out


def bounding_capsule(pieces: list[Piece], joint_m: Floats, way_m: Floats, side: float) -> tuple[Floats, ...]:
    """Return the capsule about pieces, in the frame that they are given in.

    Parameters
    ----------
    pieces : list of Piece
    joint_m : ndarray of shape (3,)
        Where its body turns: its near end is there. Metres.
    way_m : ndarray of shape (3,)
        Where its middle goes as the digit closes. Metres.
    side : float
        -1 for an opposed digit, 1 for the others.

    Returns
    -------
    tuple of ndarray
        Start, along, inward, and (length, radius, half breadth).
    """
    points = np.vstack([piece.points_m for piece in pieces])
    along = _along(pieces, points, joint_m)
    up = np.array([0.0, 0.0, 1.0]) - along[2] * along
    if np.linalg.norm(up) < 0.3:
        up = np.array([1.0, 0.0, 0.0]) - along[0] * along
    up /= np.linalg.norm(up)
    inward = np.cross(up, along)
    # A way that leads mostly along or across the part tells nothing of its inner side; then it is that to the others.
    aside, way = abs(float(way_m @ inward)), float(np.linalg.norm(way_m))
    told = way_m if aside > max(_LEAST_WAY_M, 0.3 * way) else np.array([0, -side, 0])
    inward = inward if told @ inward >= 0 else -inward
    (low, high), (inner, outer), (below, above) = (_extent(pieces, axis) for axis in (along, inward, up))
    radius = (outer - inner) / 2
    ends = np.array([float((piece.points_m @ along).min()) for piece in pieces])
    far = np.array([float((piece.points_m @ along).max()) for piece in pieces])
    domed = np.array([piece.domed for piece in pieces])
    first, last = float((ends + radius * domed).min()), float((far - radius * domed).max())
    if last <= first:
        first = last = (low + high) / 2
    start = first * along + (inner + outer) / 2 * inward + (below + above) / 2 * up
    half_breadth = max(0.0, (above - below) / 2 - radius)
    return start, along, inward, np.array([last - first, radius, half_breadth])


def _extent(pieces: list[Piece], axis: Floats) -> tuple[float, float]:
    low = min(float((piece.points_m @ axis).min()) - piece.radius_m for piece in pieces)
    high = max(float((piece.points_m @ axis).max()) + piece.radius_m for piece in pieces)
    return low, high


def _along(pieces: list[Piece], points: Floats, joint_m: Floats) -> Floats:
    """The direction of a part's middle line, away from where it turns."""
    middle = (points.min(axis=0) + points.max(axis=0)) / 2
    away = middle - joint_m
    if len(pieces) == 1 and len(points) == 2:
        axis = points[1] - points[0]
    else:
        # Objects stand upright and fingers lie across them: a part's own line is the longest that lies level.
        level = (points - points.mean(axis=0))[:, :2]
        values, vectors = np.linalg.eigh(level.T @ level)
        axis = np.array([*vectors[:, 1], 0.0])
        if values[1] < _LONGER**2 * values[0]:
            axis = np.array([away[0], away[1], 0.0])
    length = float(np.linalg.norm(axis))
    axis = axis / length if length > 1e-9 else np.array([1.0, 0.0, 0.0])
    toward = float(away @ axis)
    return axis if toward > 1e-9 or (abs(toward) <= 1e-9 and axis[0] >= 0) else -axis
