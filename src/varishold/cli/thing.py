"""What the hand is to touch: an object by its name, or a mesh's file."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING

import click

from varishold.cli.printing import printable

if TYPE_CHECKING:
    from varishold.hand import Hand
    from varishold.solids import MeshSolid

__all__ = ["tell_remarks", "thing_to_touch"]


def tell_remarks(path: str | os.PathLike[str], thing: MeshSolid) -> None:
    """Say what was mended in a mesh."""
    for remark in thing.remarks:
        click.echo(printable(f"note: {path}: {remark}"), err=True)


def thing_to_touch(
    name: str, size_m: float | None, called: str | None, *, quiet: bool, hand: Hand | None = None
) -> tuple[str | MeshSolid, float]:
    """Return what is to be touched and its size in metres, checked before anything is touched.

    Parameters
    ----------
    name : str
        An object's name, or a mesh's file.
    size_m : float or None
        None: as the mesh's file says.
    called : str or None
        What a mesh truly is; None: its file's name.
    quiet : bool
        Whether not to tell what was mended in a mesh.
    hand : Hand, optional
        What grips it. Default: the built-in hand.
    """
    from varishold.errors import InputError
    from varishold.exploration import mesh_to_grip
    from varishold.hand.objects import SIZE_RANGE_M, graspable
    from varishold.solids.mesh_file import is_mesh_file

    # No object's name has an ending: what has one is a file, of a mesh or of something else.
    if is_mesh_file(name) or os.path.splitext(name)[1]:
        thing = mesh_to_grip(name, size_m=size_m, name=called)
        if not quiet:
            tell_remarks(name, thing)
        return thing, thing.size_m
    if called is not None:
        raise InputError("--name says what a mesh is: name a mesh's file (.stl, .obj, .ply), or leave it out")
    if size_m is None:
        raise click.UsageError("of what is no mesh the size is needed: diameter or breadth in metres (--size-m)")
    name = name.replace("_", "-")
    graspable(name, size_m, SIZE_RANGE_M if hand is None else hand.sizes_m)
    return name, size_m
