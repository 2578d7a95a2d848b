"""A thing of a mesh for the hand: as large as the hand can hold, standing before it."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from varishold._name import plain_name, refuse_name_of_strangers
from varishold.errors import FormatError, InputError
from varishold.hand.objects import SIZE_RANGE_M
from varishold.solids.body import Part
from varishold.solids.mesh_file import read_mesh
from varishold.solids.mesh_parts import convex_parts
from varishold.solids.mesh_solid import MeshSolid

__all__ = ["LOWEST_M", "NARROWEST_M", "TALLEST_M", "check_name", "mesh_to_grip"]

#: What the hand reaches over the table: nothing lower, nothing taller; nor narrower the other way. Metres.
LOWEST_M, TALLEST_M, NARROWEST_M = 0.015, 0.3, 0.012

_LONGEST_NAME = 100

# Parts of which the boxes are so far apart, in parts of the whole, do not touch.
_APART = 0.005

# Units that a file's numbers may be in, by how many of them are a metre.
_UNITS = {"millimetres": 1000.0, "centimetres": 100.0, "inches": 1 / 0.0254}


def check_name(name: str) -> str:
    """Return the name of an object as it is kept.

    Raises
    ------
    InputError
        If it is empty, longer than 100 characters, cannot be printed, or is what strangers are called.
    """
    kept = plain_name(name)
    if kept is None or len(kept) > _LONGEST_NAME:
        raise InputError(
            f"an object's name must be 1 to {_LONGEST_NAME} printable characters, got {name[:_LONGEST_NAME]!r}",
            parameter="name",
        )
    refuse_name_of_strangers(kept, "object", parameter="name")
    return kept


def mesh_to_grip(path: str | os.PathLike[str], *, size_m: float | None = None, name: str | None = None) -> MeshSolid:
    """Read a mesh as a thing that the hand can grip.

    It stands on the table as in the file, z up.

    Parameters
    ----------
    path : str or path-like
        STL, OBJ or PLY.
    size_m : float, optional
        The larger of its level extents (x or y), to which it is scaled. Metres. Default: the file's numbers are metres.
    name : str, optional
        Default: the file's name without its ending.

    Raises
    ------
    InputError
        If the name cannot be kept, the file is no closed mesh, or the thing is too small or too large for the hand.
    MissingExtraError
        If ``trimesh`` or ``coacd`` is not installed.
    """
    called = check_name(Path(path).stem if name is None else name)
    low, high = SIZE_RANGE_M
    if size_m is not None and not low <= size_m <= high:
        raise InputError(
            f"the larger level extent of {called!r} must lie in [{low:g}, {high:g}] m for the hand to grip it, "
            f"got {size_m:g} m",
            parameter="size_m",
        )
    mesh = read_mesh(path)
    extent = float(mesh.extents[:2].max())
    _check_unit(path, extent, scaled=size_m is not None)
    standing = mesh.standing(1.0 if size_m is None else size_m / extent)
    _check_extents(path, standing.extents)
    try:
        parts = convex_parts(standing)
    except FormatError as error:
        raise FormatError(f"{path}: {error}") from None
    return MeshSolid(called, parts, (*standing.remarks, *_loose(parts)))


def _loose(parts: Sequence[Part]) -> tuple[str, ...]:
    """Remark that a thing is several which surely do not touch: the boxes about them are apart."""
    from scipy.sparse.csgraph import connected_components

    half, centre = np.array([part.half_m for part in parts]), np.array([part.centre_m for part in parts])
    gap = np.abs(centre[:, None] - centre) - half[:, None] - half
    touching = gap.max(axis=2) <= _APART * (centre + half).max()
    things, _ = connected_components(touching, directed=False)
    if things == 1:
        return ()
    return (f"it is {things} things that do not touch, and is felt as one; leave out of the file what does not belong",)


def _check_unit(path: str | os.PathLike[str], extent: float, *, scaled: bool) -> None:
    """Refuse numbers that are no metres, where they are taken for such."""
    low, high = SIZE_RANGE_M
    if scaled or low <= extent <= high:
        return
    looks = [
        f"{name}: give {extent / a_metre:.3g}" for name, a_metre in _UNITS.items() if low <= extent / a_metre <= high
    ]
    why = f"its numbers look like {looks[0]}" if looks else f"give a size in [{low:g}, {high:g}]"
    raise InputError(
        f"{path}: is {extent:g} m broad, and the hand grips {low:g} to {high:g} m; {why}", parameter="size_m"
    )


def _check_extents(path: str | os.PathLike[str], extents_m: np.ndarray[tuple[int, ...], np.dtype[np.float64]]) -> None:
    """Refuse what is too low, too tall or too narrow."""
    narrow_m, tall_m = float(extents_m[:2].min()), float(extents_m[2])
    for what, value, (low, high) in (
        ("tall", tall_m, (LOWEST_M, TALLEST_M)),
        ("broad at its narrower side", narrow_m, (NARROWEST_M, SIZE_RANGE_M[1])),
    ):
        if not low <= value <= high:
            raise InputError(
                f"{path}: would be {value:.3g} m {what}, and the hand grips {low:g} to {high:g} m; "
                "give another size, or lay it down in its file: z points up",
                parameter="size_m",
            )
