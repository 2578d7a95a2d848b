"""The surface where a field on a grid is zero, as a closed mesh: marching tetrahedra; and its file."""

from __future__ import annotations

import os
from dataclasses import dataclass
from itertools import permutations

import numpy as np
from numpy.typing import NDArray

from varishold.errors import require, require_a

__all__ = ["SurfaceMesh", "contour_mesh", "write_stl"]

Floats = NDArray[np.float64]

#: What stands at the head of the files: STL has 80 bytes for it, and must not begin with "solid".
STL_HEAD = b"varishold surface, metres"

# Six tetrahedra fill a cube; each goes from its first to its last corner by steps along the axes.
_TETRAHEDRA = np.array(
    [[np.eye(3, dtype=int)[list(order[:k])].sum(axis=0) for k in range(4)] for order in permutations(range(3))]
)

# A surface passes corners of the grid by this part of a step at least, so that no triangle is nothing.
_LEAST_PART = 0.01


@dataclass(frozen=True)
class SurfaceMesh:
    """A closed mesh of triangles.

    Parameters
    ----------
    vertices_m : ndarray of shape (n, 3)
        Metres.
    faces : ndarray of shape (k, 3), int64
        Corners of each triangle, anticlockwise as seen from outside.
    sigma_m : ndarray of shape (n,)
        Standard deviation of the surface at each vertex, along its normal. Metres.
    """

    vertices_m: Floats
    faces: NDArray[np.int64]
    sigma_m: Floats

    @property
    def volume_m3(self) -> float:
        """The volume within, cubic metres."""
        a, b, c = np.moveaxis(self.vertices_m[self.faces], 1, 0)
        return float((a * np.cross(b, c)).sum() / 6)

    @property
    def face_normals(self) -> Floats:
        """Outward normals of the triangles, as long as twice their area; shape (k, 3), square metres."""
        a, b, c = np.moveaxis(self.vertices_m[self.faces], 1, 0)
        return np.cross(b - a, c - a)

    @property
    def vertex_normals(self) -> Floats:
        """Outward unit normals at the vertices; shape (n, 3)."""
        summed = [
            np.bincount(self.faces.ravel(), np.repeat(way, 3), len(self.vertices_m)) for way in self.face_normals.T
        ]
        out = np.stack(summed, axis=1)
        unit: Floats = out / np.maximum(np.linalg.norm(out, axis=1, keepdims=True), 1e-30)
        return unit

    @property
    def vertex_areas_m2(self) -> Floats:
        """A third of the area of the triangles about each vertex; shape (n,), square metres."""
        area = np.linalg.norm(self.face_normals, axis=1) / 6
        out: Floats = np.bincount(self.faces.ravel(), np.repeat(area, 3), len(self.vertices_m)).astype(np.float64)
        return out


def contour_mesh(level: Floats, origin_m: Floats, pitch_m: float) -> tuple[Floats, NDArray[np.int64]]:
    """Return vertices and triangles where a field on a grid is zero, of the largest piece below zero.

    Parameters
    ----------
    level : ndarray of shape (nx, ny, nz)
        Negative inside. The border counts as outside, so that the mesh is closed.
    origin_m : ndarray of shape (3,)
        The first corner. Metres.
    pitch_m : float
        Metres.

    Raises
    ------
    InputError
        If nothing is inside.

    References
    ----------
    A. Doi and A. Koide, "An efficient method of triangulating equi-valued surfaces by using tetrahedral cells", 1991.
    """
    from scipy.ndimage import label

    level = level.copy()
    border = np.ones(level.shape, bool)
    border[1:-1, 1:-1, 1:-1] = False
    level[border] = np.maximum(level[border], pitch_m)
    pieces, count = label(level < 0)
    require(count, "the field is nowhere below zero: there is no surface")
    largest = np.bincount(pieces.ravel())[1:].argmax() + 1
    inside = pieces == largest
    size = np.where(inside, np.maximum(-level, 1e-12), np.maximum(level, 1e-12))
    cells = np.argwhere(np.ones([n - 1 for n in level.shape], bool))
    sums = sum(inside[tuple((cells + corner).T)].astype(int) for corner in np.ndindex(2, 2, 2))
    corners = cells[(sums > 0) & (sums < 8)][:, None, None, :] + _TETRAHEDRA
    ids = np.ravel_multi_index(tuple(np.moveaxis(corners, -1, 0)), level.shape).reshape(-1, 4)
    edges = _crossed(ids, inside.ravel()[ids])
    keys, faces = np.unique(edges.reshape(-1, 2), axis=0, return_inverse=True)
    part = size.ravel()[keys[:, 0]] / size.ravel()[keys].sum(axis=1)
    places = np.stack(np.unravel_index(keys, level.shape), axis=-1).astype(np.float64)
    at = np.clip(part, _LEAST_PART, 1 - _LEAST_PART)[:, None]
    vertices: Floats = origin_m + pitch_m * (places[:, 0] * (1 - at) + places[:, 1] * at)
    return vertices, _outward(vertices, faces.reshape(-1, 3), places)


def _crossed(ids: NDArray[np.int64], inside: NDArray[np.bool_]) -> NDArray[np.int64]:
    """Edges (inner corner, outer corner) under the corners of each triangle, shape (n, 3, 2)."""
    order = np.argsort(~inside, axis=1, kind="stable")
    a, b, c, d = np.take_along_axis(ids, order, axis=1).T
    count = inside.sum(axis=1)

    def triangles(chosen: NDArray[np.bool_], *edges: tuple[NDArray[np.int64], NDArray[np.int64]]) -> NDArray[np.int64]:
        return np.stack([np.stack([p[chosen], q[chosen]], axis=-1) for p, q in edges], axis=1)

    one, two, three = (count == k for k in (1, 2, 3))
    return np.concatenate(
        [
            triangles(one, (a, b), (a, c), (a, d)),
            triangles(two, (a, c), (a, d), (b, d)),
            triangles(two, (a, c), (b, d), (b, c)),
            triangles(three, (a, d), (b, d), (c, d)),
        ]
    )


def _outward(vertices: Floats, faces: NDArray[np.int64], places: Floats) -> NDArray[np.int64]:
    """The triangles turned so that their normals look from the inner corners of the grid to the outer ones."""
    a, b, c = np.moveaxis(vertices[faces], 1, 0)
    out = (places[:, 1] - places[:, 0])[faces].sum(axis=1)
    wrong = (np.cross(b - a, c - a) * out).sum(axis=1) < 0
    return np.where(wrong[:, None], faces[:, ::-1], faces)


def write_stl(path: str | os.PathLike[str], mesh: SurfaceMesh) -> None:
    """Write a mesh as binary STL, lengths in metres.

    Raises
    ------
    InputError
        If the file cannot be written.
    """
    from varishold.files import atomic_write

    require_a(SurfaceMesh, mesh, "mesh", "as ImplicitSurface.mesh makes it")
    rows = np.zeros(len(mesh.faces), [("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("more", "<u2")])
    normal = mesh.face_normals
    rows["normal"] = normal / np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-30)
    rows["corners"] = mesh.vertices_m[mesh.faces]
    with atomic_write(path) as file:
        file.write(STL_HEAD.ljust(80) + np.uint32(len(rows)).astype("<u4").tobytes() + rows.tobytes())
