"""A mesh from a file of a user: STL, OBJ or PLY, closed, as triangles."""

from __future__ import annotations

import io
import logging
import os
import re
import warnings
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from varishold._counted import counted
from varishold._lazy import to_install
from varishold.errors import FormatError, InputError, MissingExtraError
from varishold.files import read_bytes

__all__ = ["MESH_ENDINGS", "MOST_FACES", "TriangleMesh", "is_mesh_file", "read_mesh", "require_meshes"]

Floats = NDArray[np.float64]

#: Endings of files that are read as meshes.
MESH_ENDINGS = (".stl", ".obj", ".ply")

#: A mesh of more triangles takes minutes to take apart, and no finger feels them.
MOST_FACES = 200_000

_NO_ASCII = re.compile(rb"[\x80-\xff]")
# So many triangles in the wordiest of the formats.
_MOST_BYTES = 1 << 27

# Numbers beyond this are no place in any unit, and of what is smaller corners cannot be told from one another.
_MOST_NUMBER, _LEAST_SIZE = 1e9, 1e-7

# What trimesh logs of a damaged file, in many lines, is told in one.
logging.getLogger("trimesh").addHandler(logging.NullHandler())


@dataclass(frozen=True, eq=False)
class TriangleMesh:
    """Closed surfaces of triangles.

    Parameters
    ----------
    vertices : ndarray of shape (n, 3), float64
        In the file's unit; z points up.
    faces : ndarray of shape (k, 3), int64
        Corners of each triangle, anticlockwise as seen from outside.
    remarks : tuple of str
        What was mended.
    """

    vertices: Floats
    faces: NDArray[np.int64]
    remarks: tuple[str, ...] = ()

    @property
    def extents(self) -> Floats:
        """Lengths of the bounding box along x, y and z, shape (3,), in the file's unit."""
        return np.asarray(np.ptp(self.vertices, axis=0))

    @property
    def volume(self) -> float:
        """The volume within, in the file's unit cubed."""
        a, b, c = np.moveaxis((self.vertices - self.vertices.mean(axis=0))[self.faces], 1, 0)
        return float((a * np.cross(b, c)).sum() / 6)

    def standing(self, scale: float) -> Self:
        """Return it scaled, with the middle of its base at the origin."""
        low, high = self.vertices.min(axis=0), self.vertices.max(axis=0)
        base = np.array([(low[0] + high[0]) / 2, (low[1] + high[1]) / 2, low[2]])
        return replace(self, vertices=(self.vertices - base) * scale)


def is_mesh_file(name: str | os.PathLike[str]) -> bool:
    """Tell by its ending whether a name is that of a mesh's file.

    Examples
    --------
    >>> is_mesh_file("cups/MUG.STL"), is_mesh_file("square-pillar")
    (True, False)
    """
    return Path(name).suffix.lower() in MESH_ENDINGS


def require_meshes(name: str) -> Any:
    """Import a package that meshes need: ``trimesh`` or ``coacd``.

    Raises
    ------
    MissingExtraError
        If it is not installed.
    """
    from importlib import import_module

    try:
        # What trimesh would miss in the middle of its work.
        import_module("networkx")
        import_module("scipy")
        return import_module(name)
    except ImportError as error:
        missing = error.name or name
        raise MissingExtraError(f"meshes need {missing}, which is not installed; run: {to_install('meshes')}") from None


def read_mesh(path: str | os.PathLike[str]) -> TriangleMesh:
    """Read a closed mesh; holes that can be closed are closed, which a remark tells.

    Materials and whatever else a file names beside itself are never opened.

    Parameters
    ----------
    path : str or path-like
        STL, OBJ or PLY, as its ending says.

    Raises
    ------
    InputError
        If the file cannot be opened, or its ending is none of `MESH_ENDINGS`.
    FormatError
        If it is no mesh, is damaged, has more than `MOST_FACES` triangles, or does not close.
    MissingExtraError
        If ``trimesh`` is not installed.
    """
    if not is_mesh_file(path):
        raise InputError(f"{path}: is no mesh by its name; it must end in {', '.join(MESH_ENDINGS)}")
    content = read_bytes(path, most=_MOST_BYTES)
    if not content.strip():
        raise FormatError(f"{path}: is empty; a mesh is wanted")
    ending = Path(path).suffix.lower().removeprefix(".")
    if ending == "stl":
        _check_stl(content, path)
    content = _plain_words(content, ending)
    trimesh = require_meshes("trimesh")
    try:
        with warnings.catch_warnings():
            # What it warns of is refused or mended below.
            warnings.simplefilter("ignore")
            vertices, faces = _triangles(trimesh, content, ending)
    except Exception as error:
        # Of damaged files the readers of the formats raise whatever comes.
        what = " ".join(f"{type(error).__name__}: {error}".split())[:200]
        raise FormatError(f"{path}: is no mesh that can be read, or it is damaged or cut off ({what})") from None
    if not len(faces):
        raise FormatError(f"{path}: holds no triangle: it is no mesh, or it is damaged or cut off")
    if len(faces) > MOST_FACES:
        raise FormatError(f"{path}: has {len(faces)} triangles; at most {MOST_FACES} are read: simplify it first")
    if faces.min() < 0 or faces.max() >= len(vertices):
        raise FormatError(f"{path}: a triangle names corner {faces.max()} of {len(vertices)}; it is damaged or cut off")
    far = ~(np.abs(vertices[faces]) <= _MOST_NUMBER)
    if far.any():
        k, corner, _ = np.argwhere(far)[0].tolist()
        at = ", ".join(f"{value:g}" for value in vertices[faces[k, corner]])
        finite = np.isfinite(vertices[faces]).all()
        mend = f"mend it where it was made{', or write it in another unit' if finite else ''}"
        raise FormatError(
            f"{path}: corners of triangles must be finite and within {_MOST_NUMBER:g}, got ({at}) at triangle {k} of "
            f"{len(faces)}; {mend}"
        )
    size = float(np.ptp(vertices[faces.ravel()], axis=0).max())
    if 0 < size < _LEAST_SIZE:
        raise FormatError(
            f"{path}: is {size:.3g} long at its longest, in its own unit, and at least {_LEAST_SIZE:g} is read; "
            "write it in another unit"
        )
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return _closed(trimesh, vertices, faces, path)


def _plain_words(content: bytes, ending: str) -> bytes:
    """Return a mesh whose words are ASCII: in comments and names people write in any encoding, and nothing reads it."""
    text, mark, numbers = content.partition(b"end_header") if ending == "ply" else (content, b"", b"")
    if ending == "stl":
        announced, there = _triangles_of_stl(content)
        if announced == there:
            return content
    return _NO_ASCII.sub(b"?", text) + mark + numbers


def _triangles_of_stl(content: bytes) -> tuple[int, float]:
    """Return how many triangles a binary file says that it has, and how many there are."""
    return int.from_bytes(content[80:84], "little"), (len(content) - 84) / 50


def _check_stl(content: bytes, path: str | os.PathLike[str]) -> None:
    """Refuse a binary file that is shorter or longer than it says; a text begins with its word."""
    announced, there = _triangles_of_stl(content)
    if there != announced and content.lstrip()[:5].lower() != b"solid":
        found = f"{counted(announced, 'triangle')} announced, {max(0, int(there))} there"
        raise FormatError(f"{path}: is no STL, or it is damaged or cut off: {found}")


def _triangles(trimesh: Any, content: bytes, ending: str) -> tuple[Floats, NDArray[np.int64]]:
    """Corners and faces of all that a file holds, as it has them."""
    # Without a resolver nothing is opened that the file names.
    told = {"skip_materials": True} if ending == "obj" else {}
    scene = trimesh.load_scene(io.BytesIO(content), file_type=ending, resolver=None, process=False, **told)
    meshes = [mesh for mesh in scene.dump() if isinstance(mesh, trimesh.Trimesh)]
    starts = np.cumsum([0, *(len(mesh.vertices) for mesh in meshes)])
    vertices = [np.empty((0, 3)), *(np.asarray(mesh.vertices, dtype=np.float64) for mesh in meshes)]
    faces = [np.asarray(mesh.faces, dtype=np.int64) + int(at) for mesh, at in zip(meshes, starts, strict=False)]
    return np.concatenate(vertices), np.concatenate([np.empty((0, 3), dtype=np.int64), *faces])


def _closed(trimesh: Any, vertices: Floats, faces: NDArray[np.int64], path: str | os.PathLike[str]) -> TriangleMesh:
    """Return the mesh with its holes closed, seen from outside."""
    # Corners are the same where they are within a millionth of the whole, whatever its unit.
    size = float(np.ptp(vertices[faces.ravel()], axis=0).max()) or 1.0
    digits = int(np.clip(6 - np.floor(np.log10(size)), -8, 15))
    mesh = trimesh.Trimesh(vertices, faces, process=False)
    mesh.merge_vertices(digits_vertex=digits, merge_tex=True, merge_norm=True)
    mesh.update_faces(mesh.nondegenerate_faces() & mesh.unique_faces())
    mesh.remove_unreferenced_vertices()
    remarks: tuple[str, ...] = ()
    if not mesh.is_watertight:
        before = len(mesh.faces)
        trimesh.repair.fill_holes(mesh)
        if not mesh.is_watertight:
            edges, times = np.unique(np.sort(mesh.edges, axis=1), axis=0, return_counts=True)
            open_edges = edges[times != 2]
            if not len(open_edges):
                raise FormatError(f"{path}: encloses nothing; a solid thing is wanted")
            at = ", ".join(f"{value:g}" for value in mesh.vertices[open_edges[0]].mean(axis=0))
            raise FormatError(
                f"{path}: does not close: {len(open_edges)} of its edges have not two triangles, as at ({at}); "
                "mend it where it was made"
            )
        remarks = (f"holes of the mesh were closed with {counted(len(mesh.faces) - before, 'triangle')}",)
    mesh.fix_normals()
    closed = TriangleMesh(np.array(mesh.vertices, dtype=np.float64), np.array(mesh.faces, dtype=np.int64), remarks)
    if closed.volume < 0:
        closed = replace(closed, faces=closed.faces[:, ::-1])
    if closed.volume <= 1e-9 * size**3:
        raise FormatError(f"{path}: encloses nothing; a solid thing is wanted")
    return closed
