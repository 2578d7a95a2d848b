"""The true surface of a solid as points with normals, and exact distances from points to a mesh of triangles."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import ConvexHull, cKDTree

from varishold.perceive import SurfaceMesh
from varishold.solids import Part, Solid

__all__ = ["corners_of", "distances_m", "mesh_points_m", "true_points"]

Floats = NDArray[np.float64]

_ROUND, _BALL = 400, 4000
# Triangles about a point that are looked at exactly.
_NEAREST = 24
# A point whose outer side lies in another part is none of the surface. Metres.
_OUTER_M = 1e-5


def true_points(solid: Solid, n: int, *, seed: int = 0) -> tuple[Floats, Floats]:
    """Return about n points drawn evenly by area from a solid's surface, and their outward normals, in its own axes."""
    rng = np.random.default_rng(seed)
    hulls = [ConvexHull(corners_of(part)) for part in solid.body()]
    area = sum(hull.area for hull in hulls)
    points, normals = [], []
    for k, hull in enumerate(hulls):
        triangles = hull.points[hull.simplices]
        share = np.linalg.norm(np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0]), axis=1)
        which = rng.choice(len(share), round(n * hull.area / area), p=share / share.sum())
        at = (rng.dirichlet([1, 1, 1], len(which))[:, :, None] * triangles[which]).sum(axis=1)
        out = hull.equations[which, :3]
        open_ = np.ones(len(which), bool)
        for other in (*hulls[:k], *hulls[k + 1 :]):
            off = (at + _OUTER_M * out) @ other.equations[:, :3].T + other.equations[:, 3]
            open_ &= off.max(axis=1) > 0
        points.append(at[open_])
        normals.append(out[open_])
    return np.vstack(points), np.vstack(normals)


def corners_of(part: Part) -> Floats:
    """Return corners whose convex hull is the part; of what is round, many. Metres."""
    half, centre = np.array(part.half_m), np.array(part.centre_m)
    if part.kind == "hull":
        return np.array(part.corners_m)
    if part.kind == "box":
        return centre + half * (2 * np.array(list(np.ndindex(2, 2, 2))) - 1)
    if part.kind == "cylinder":
        turn = 2 * np.pi * np.arange(_ROUND) / _ROUND
        return centre + half * np.vstack([np.column_stack([np.cos(turn), np.sin(turn), 0 * turn + z]) for z in (-1, 1)])
    k = np.arange(_BALL) + 0.5
    z, turn = 1 - 2 * k / _BALL, np.pi * (1 + np.sqrt(5)) * k
    across = np.sqrt(1 - z * z)
    return centre + half * np.column_stack([across * np.cos(turn), across * np.sin(turn), z])


def mesh_points_m(mesh: SurfaceMesh, n: int, *, seed: int = 0) -> Floats:
    """Return n points drawn evenly by area from a mesh. Metres."""
    rng = np.random.default_rng(seed)
    area = np.linalg.norm(mesh.face_normals, axis=1)
    which = rng.choice(len(area), n, p=area / area.sum())
    out: Floats = (rng.dirichlet([1, 1, 1], n)[:, :, None] * mesh.vertices_m[mesh.faces[which]]).sum(axis=1)
    return out


def distances_m(points: Floats, mesh: SurfaceMesh) -> Floats:
    """Return the distance of points (n, 3) from a mesh; metres."""
    triangles = mesh.vertices_m[mesh.faces]
    _, near = cKDTree(triangles.mean(axis=1)).query(points, k=min(_NEAREST, len(triangles)))
    out: Floats = np.min(
        [_off(points, *np.moveaxis(triangles[near[:, k]], 1, 0)) for k in range(near.shape[1])], axis=0
    )
    return out


def _off(p: Floats, a: Floats, b: Floats, c: Floats) -> Floats:
    """Distance of each point from its triangle."""
    sides = ((a, b), (b, c), (c, a))
    off = np.min([_off_side(p, q, r) for q, r in sides], axis=0)
    normal = np.cross(b - a, c - a)
    normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-30)
    above = ((p - a) * normal).sum(axis=1)
    foot = p - above[:, None] * normal
    within = np.all([(np.cross(r - q, foot - q) * normal).sum(axis=1) >= 0 for q, r in sides], axis=0)
    return np.where(within, np.minimum(off, np.abs(above)), off)


def _off_side(p: Floats, q: Floats, r: Floats) -> Floats:
    way = r - q
    part = np.clip(((p - q) * way).sum(axis=1) / np.maximum((way * way).sum(axis=1), 1e-30), 0, 1)
    out: Floats = np.linalg.norm(p - q - part[:, None] * way, axis=1)
    return out
