"""What a mesh encloses as convex parts."""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from varishold.errors import FormatError
from varishold.solids.body import Part
from varishold.solids.mesh_apart import taken_apart
from varishold.solids.mesh_file import TriangleMesh, require_meshes

__all__ = ["MOST_PARTS", "convex_parts"]

Floats = NDArray[np.float64]

#: Parts of which a thing is made at most: more make the simulation slow.
MOST_PARTS = 128

# What fills its hull but for this is convex: less than a pad feels.
_CONVEX = 0.01

# A cut is made where a part strays from its hull by this share of the thing; corners that a part keeps at most.
_CONCAVITY, _MOST_CORNERS, _ROUND_CORNERS = 0.03, 64, 400

# No body is told to be rounder than this.
_MOST_CONCAVITY = 0.3

# Parts of less than this share of the whole are crumbs, which the simulation cannot weigh.
_CRUMB = 1e-6


def convex_parts(mesh: TriangleMesh) -> tuple[Part, ...]:
    """Take a closed mesh apart into convex hulls; the same mesh gives the same parts.

    Parameters
    ----------
    mesh : TriangleMesh
        In metres.

    Raises
    ------
    FormatError
        If it has no volume, or so many hollows that `MOST_PARTS` do not do.
    MissingExtraError
        If ``trimesh`` or ``coacd`` is not installed.
    """
    trimesh = require_meshes("trimesh")
    from scipy.spatial import QhullError

    size = float(mesh.extents.max())
    # At size one, so that what is too small to matter is the same for all.
    whole = trimesh.Trimesh(mesh.vertices / size, mesh.faces, process=False)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        bodies = whole.split(only_watertight=False)
        # A body within another, turned inside out, is a hollow of that one.
        separate = len(bodies) > 1 and all(body.is_watertight and body.volume > 0 for body in bodies)
        _check_number(len(bodies) if separate else 1)
        try:
            hulls = [hull for body in (bodies if separate else [whole]) for hull in _hulls(trimesh, body)]
        except (QhullError, ArithmeticError, ValueError, IndexError) as error:
            raise FormatError(
                f"cannot be taken apart into convex parts: {str(error).strip().splitlines()[0]}"
            ) from None
    least = _CRUMB * sum(volume for _, volume in hulls)
    parts = [corners for corners, volume in hulls if volume > least]
    _check_number(len(parts))
    return tuple(Part.hull(np.round(corners * size, 9)) for corners in parts)


def _check_number(parts: int) -> None:
    if not 1 <= parts <= MOST_PARTS:
        raise FormatError(f"a mesh of {parts} convex parts cannot be gripped; at most {MOST_PARTS} can")


def _hulls(trimesh: Any, body: Any) -> Iterator[tuple[Floats, float]]:
    """Corners and volume of convex hulls that fill a body."""
    hull = body.convex_hull
    if body.volume >= (1 - _CONVEX) * hull.volume:
        yield _fewer(np.asarray(hull.vertices, dtype=np.float64)), float(hull.volume)
        return
    require_meshes("coacd")
    pieces = taken_apart(
        np.asarray(body.vertices, dtype=np.float64),
        np.asarray(body.faces, dtype=np.int64),
        # It takes each body for as large as another.
        threshold=min(_CONCAVITY / float(body.extents.max()), _MOST_CONCAVITY),
        preprocess_mode="off",
        resolution=1000,
        mcts_nodes=10,
        mcts_iterations=30,
        mcts_max_depth=2,
        max_ch_vertex=_MOST_CORNERS,
        seed=1,
    )
    for corners in pieces:
        if len(corners) >= 4:
            yield corners, float(trimesh.convex.convex_hull(corners).volume)


def _fewer(corners: Floats) -> Floats:
    """Return the corners of a hull, or of many those that reach farthest in as many directions."""
    if len(corners) <= _ROUND_CORNERS:
        return corners
    turn = np.arange(_ROUND_CORNERS) + 0.5
    up = 1 - 2 * turn / _ROUND_CORNERS
    way = np.pi * (1 + np.sqrt(5)) * turn
    level = np.sqrt(1 - up**2)
    directions = np.vstack([np.column_stack([level * np.cos(way), level * np.sin(way), up]), np.eye(3), -np.eye(3)])
    farthest = np.unique((corners @ directions.T).argmax(axis=0))
    return np.asarray(corners[farthest])
