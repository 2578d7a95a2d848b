"""A solid that lies on its side."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Self

import numpy as np
from numpy.typing import NDArray

from varishold.errors import InputError
from varishold.solids.body import Part, regular_polygon
from varishold.solids.body_height import height_of, top_of
from varishold.solids.solid import Solid

__all__ = ["Laid", "lay_down"]

Floats = NDArray[np.float64]

# Corners of a lying cylinder's ends.
_CORNERS = 96
# A side looks level at least so far: the level part of its outward normal.
_SIDE = 0.7
# A body rests on a side where its middle of mass stands over that, or as little beside it as rounding makes. Metres.
_BESIDE_M = 1e-6
# Corners so near to a side's plane are the side's. Metres.
_ON_SIDE_M = 1e-6


@dataclass(frozen=True)
class Laid(Solid):
    """A solid that rests on one of its sides; the middle of what it covers is the origin.

    Parameters
    ----------
    upright : Solid
        As it would stand.
    parts : tuple of Part
        Its body as it lies.

    Examples
    --------
    >>> from varishold.solids import Cylinder
    >>> lay_down(Cylinder(0.06, 0.15)).top_m
    0.06
    """

    name: ClassVar[str] = "lying solid"

    upright: Solid
    parts: tuple[Part, ...]

    def __post_init__(self) -> None:
        """Nothing is left to check: its lengths are those of a solid."""

    @classmethod
    def of_size(cls, size_m: float) -> Self:
        """Refuse: it is made of another solid.

        Raises
        ------
        InputError
            Always.
        """
        raise InputError("what lies is a solid that was laid down: give that one")

    @property
    def top_m(self) -> float:
        return top_of(self.parts)

    @property
    def rolls(self) -> bool:
        """Whether it rests on a line, so that it would roll away on a bare table."""
        return self.upright.round

    def height(self, x: Floats, y: Floats) -> Floats:
        return height_of(self.parts, x, y)

    def body(self) -> tuple[Part, ...]:
        return self.parts


def lay_down(solid: Solid, roll_rad: float = 0.0) -> Laid:
    """Lay a solid down on the side nearest to one of its own level directions on which it comes to rest.

    Parameters
    ----------
    solid : Solid
    roll_rad : float
        The direction, from its own -x toward -y. Radians.

    Raises
    ------
    InputError
        If it is only a face, or has no side to lie on, as a ball.
    """
    if any(part.kind == "ellipsoid" for part in solid.body()):
        raise InputError(f"a {solid.name} has no side to lie on: it is as it stands")
    bodies = [_corners(part) for part in solid.body()]
    down = _resting_side(bodies, np.array([-np.cos(roll_rad), -np.sin(roll_rad), 0.0]))
    if down is None:
        raise InputError(f"a {solid.name} has no side that it would rest on")
    turned = [corners @ _turn_down(down).T for corners in bodies]
    everything = np.vstack(turned)
    low, high = everything.min(axis=0), everything.max(axis=0)
    shift = np.array([*(low + high)[:2] / 2, low[2]])
    return Laid(solid, tuple(_part(corners - shift) for corners in turned))


def _corners(part: Part) -> Floats:
    """The corners of a part; a cylinder's ends are told as polygons about its circles."""
    if part.kind == "hull":
        return np.array(part.corners_m)
    x_m, _, z_m = part.half_m
    if part.kind == "box":
        signs = np.array(np.meshgrid([-1, 1], [-1, 1], [-1, 1])).reshape(3, -1).T
        return np.asarray(signs * np.array(part.half_m) + np.array(part.centre_m), dtype=np.float64)
    ring = regular_polygon(_CORNERS, x_m / np.cos(np.pi / _CORNERS), turn_rad=np.pi / _CORNERS)
    ends = [np.column_stack([ring, np.full(_CORNERS, end)]) for end in (-z_m, z_m)]
    return np.asarray(np.vstack(ends) + np.array(part.centre_m), dtype=np.float64)


def _part(corners: Floats) -> Part:
    """A part with these corners: a box where they are those of a level one."""
    low, high = corners.min(axis=0), corners.max(axis=0)
    at_ends = np.isclose(corners, low, atol=1e-9) | np.isclose(corners, high, atol=1e-9)
    if len(corners) == 8 and at_ends.all():
        half, middle = ((high - low) / 2).tolist(), ((high + low) / 2).tolist()
        return Part("box", (half[0], half[1], half[2]), (middle[0], middle[1], middle[2]))
    return Part.hull(corners)


def _resting_side(bodies: list[Floats], wanted: Floats) -> Floats | None:
    """Return the outward normal of the side nearest to a direction on which a body comes to rest."""
    from scipy.spatial import ConvexHull

    everything = np.vstack(bodies)
    volumes, middles = zip(*(_mass(corners) for corners in bodies), strict=True)
    middle = np.average(middles, axis=0, weights=volumes)
    planes = np.unique(ConvexHull(everything).equations.round(9), axis=0)
    sides = planes[np.hypot(planes[:, 0], planes[:, 1]) >= _SIDE]
    for *normal, offset in sides[np.argsort(-(sides[:, :3] @ wanted), kind="stable")].tolist():
        down = np.array(normal)
        foot = everything[np.abs(everything @ down + offset) < _ON_SIDE_M]
        if _stands_over(foot @ _turn_down(down).T[:, :2], (middle @ _turn_down(down).T)[:2]):
            return down
    return None


def _mass(corners: Floats) -> tuple[float, Floats]:
    """Volume and middle of mass of a convex body."""
    from scipy.spatial import ConvexHull

    hull, inside = ConvexHull(corners), corners.mean(axis=0)
    first, second, third = (corners[hull.simplices[:, k]] - inside for k in range(3))
    sixths = np.abs(np.einsum("ni,ni->n", np.cross(first, second), third))
    middle: Floats = inside + (sixths @ (first + second + third)) / (4 * sixths.sum())
    return float(sixths.sum()) / 6, middle


def _stands_over(foot: Floats, middle: Floats) -> bool:
    """Whether a point of the plane lies within the outline of others."""
    from scipy.spatial import ConvexHull, QhullError

    try:
        outline = ConvexHull(foot).equations
    except (QhullError, ValueError):
        return False
    return bool((outline[:, :2] @ middle + outline[:, 2] <= _BESIDE_M).all())


def _turn_down(down: Floats) -> Floats:
    """The rotation that turns a direction down and leaves what is level across it level."""
    across = np.array([-down[1], down[0], 0.0]) / np.hypot(down[0], down[1])
    along: Floats = np.cross(across, -down)
    return np.vstack([along, across, -down])
