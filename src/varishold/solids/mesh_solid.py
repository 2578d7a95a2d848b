"""A thing of a mesh: convex parts that together fill what the mesh encloses."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar, Self

import numpy as np
from numpy.typing import NDArray

from varishold.errors import InputError, require
from varishold.solids.body import Part
from varishold.solids.body_height import height_of, top_of
from varishold.solids.solid import Solid

__all__ = ["MeshSolid"]

# What stands on its lowest points, told within this (metres), on less than this share of its breadth either way, rolls.
_FOOT_M, _ROLLS = 0.0005, 0.3


@dataclass(frozen=True)
class MeshSolid(Solid):
    """A thing that was read from a mesh; it stands as in its file, the middle of its base at the origin.

    Parameters
    ----------
    called : str
        What it is.
    parts : tuple of Part
        Convex, together its body.
    remarks : tuple of str
        What was mended in the mesh.

    Raises
    ------
    InputError
        If it has no name or no part.

    Examples
    --------
    >>> brick = MeshSolid("brick", (Part.box(0.08, 0.04, 0.03),))
    >>> brick.size_m, brick.top_m
    (0.08, 0.03)
    """

    name: ClassVar[str] = "mesh"

    called: str
    parts: tuple[Part, ...]
    remarks: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        require(self.called.strip(), f"a thing of a mesh needs a name, got {self.called!r}")
        require(self.parts, f"the mesh of {self.called!r} has no part")

    @classmethod
    def of_size(cls, size_m: float) -> Self:
        """Refuse: a mesh has proportions of its own.

        Raises
        ------
        InputError
            Always.
        """
        raise InputError("a mesh has no usual proportions: read it from its file, with its size")

    @cached_property
    def extents_m(self) -> tuple[float, float, float]:
        """Lengths of its bounding box along x, y and z. Metres."""
        low, high = (
            np.array([np.array(part.centre_m) + sign * np.array(part.half_m) for part in self.parts])
            for sign in (-1.0, 1.0)
        )
        x_m, y_m, z_m = (high.max(axis=0) - low.min(axis=0)).tolist()
        return x_m, y_m, z_m

    @property
    def size_m(self) -> float:
        """The larger of its level extents. Metres."""
        return max(self.extents_m[:2])

    @property
    def top_m(self) -> float:
        return top_of(self.parts)

    @property
    def rolls(self) -> bool:
        """Whether it stands on so little that it would roll away on a bare table."""
        corners = np.array([corner for part in self.parts for corner in part.corners_m]).reshape(-1, 3)
        foot = corners[corners[:, 2] < _FOOT_M] if len(corners) else corners
        return len(foot) > 0 and bool((np.ptp(foot, axis=0) < _ROLLS * np.array(self.extents_m))[:2].any())

    def height(self, x: NDArray[np.float64], y: NDArray[np.float64]) -> NDArray[np.float64]:
        return height_of(self.parts, x, y)

    def body(self) -> tuple[Part, ...]:
        return self.parts
