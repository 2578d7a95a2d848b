"""A solid's whole surface in three dimensions, as convex parts."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Literal, Self

import numpy as np
from numpy.typing import NDArray

__all__ = ["Part", "regular_polygon"]


@dataclass(frozen=True)
class Part:
    """A convex piece of a rigid body; z points up from the base, whose centre is the origin.

    Parameters
    ----------
    kind : {"box", "cylinder", "ellipsoid", "hull"}
        A cylinder stands along z.
    half_m : tuple of 3 floats
        Half lengths along x, y and z (of a hull: of its bounding box). Metres.
    centre_m : tuple of 3 floats
        Centre of the bounding box. Metres.
    corners_m : tuple of tuples of 3 floats
        Corners of a hull; empty for the other kinds. Metres.

    Examples
    --------
    >>> ball = Part.ellipsoid(0.1, 0.1, 0.1)
    >>> ball.hits(np.array([[0.0, 0.0, 1.0]]), np.array([0.0, 0.0, -1.0])).round(3)
    array([0.9])
    """

    kind: Literal["box", "cylinder", "ellipsoid", "hull"]
    half_m: tuple[float, float, float]
    centre_m: tuple[float, float, float]
    corners_m: tuple[tuple[float, float, float], ...] = ()

    @classmethod
    def box(cls, x_m: float, y_m: float, z_m: float) -> Self:
        """Make a box of these lengths that stands on the base plane."""
        return cls("box", (x_m / 2, y_m / 2, z_m / 2), (0.0, 0.0, z_m / 2))

    @classmethod
    def cylinder(cls, diameter_m: float, height_m: float) -> Self:
        """Make an upright cylinder that stands on the base plane."""
        return cls("cylinder", (diameter_m / 2, diameter_m / 2, height_m / 2), (0.0, 0.0, height_m / 2))

    @classmethod
    def ellipsoid(cls, x_m: float, y_m: float, z_m: float) -> Self:
        """Make an ellipsoid of these axes (a sphere where they are equal) that rests on the base plane."""
        return cls("ellipsoid", (x_m / 2, y_m / 2, z_m / 2), (0.0, 0.0, z_m / 2))

    @classmethod
    def hull(cls, corners_m: NDArray[np.float64]) -> Self:
        """Make the convex hull of points, an array of shape (n, 3) in metres."""
        low, high = corners_m.min(axis=0), corners_m.max(axis=0)
        half, centre = (high - low) / 2, (high + low) / 2
        rows = tuple((float(x), float(y), float(z)) for x, y, z in corners_m)
        return cls(
            "hull",
            (float(half[0]), float(half[1]), float(half[2])),
            (float(centre[0]), float(centre[1]), float(centre[2])),
            rows,
        )

    @classmethod
    def prism(cls, section_m: NDArray[np.float64], height_m: float, *, top_scale: float = 1.0) -> Self:
        """Make the hull of a polygon on the base plane and of its copy, `top_scale` times as large, on top.

        Parameters
        ----------
        section_m : ndarray of shape (n, 2)
            Corners of the polygon. Metres.
        height_m : float
            Metres.
        top_scale : float
            0 makes a point.
        """
        low = np.column_stack([section_m, np.zeros(len(section_m))])
        top = np.zeros((1, 2)) if top_scale == 0.0 else section_m * top_scale
        high = np.column_stack([top, np.full(len(top), height_m)])
        return cls.hull(np.vstack([low, high]))

    @cached_property
    def _planes(self) -> NDArray[np.float64]:
        """Outward normals and offsets of a hull's faces, shape (n, 4): inside where n . p + d <= 0."""
        from scipy.spatial import ConvexHull

        return np.unique(ConvexHull(np.array(self.corners_m)).equations.round(12), axis=0)

    def reach(self, toward: NDArray[np.float64]) -> float:
        """How far the part reaches from the body's middle line along a level unit vector of shape (2,); metres."""
        if self.kind == "hull":
            return float((np.array(self.corners_m)[:, :2] @ toward).max())
        x_m, y_m, _ = self.half_m
        middle_m = float(np.array(self.centre_m[:2]) @ toward)
        if self.kind == "box":
            return middle_m + float(np.abs(toward) @ (x_m, y_m))
        # What is round is as broad from every side, to the last bit.
        return middle_m + (x_m if x_m == y_m else float(np.hypot(*(toward * (x_m, y_m)))))

    def hits(self, origins: NDArray[np.float64], direction: NDArray[np.float64]) -> NDArray[np.float64]:
        """Distance along rays at which they enter the part.

        Parameters
        ----------
        origins : ndarray of shape (n, 3)
            Where the rays start, in the body's frame. Metres.
        direction : ndarray of shape (3,)
            Unit vector common to all rays.

        Returns
        -------
        ndarray of shape (n,), float64
            Metres; negative where the ray starts inside or past the entry; infinite where it misses.
        """
        p = origins - np.array(self.centre_m)
        half = np.array(self.half_m)
        if self.kind == "hull":
            planes = self._planes
            return _enter(planes[:, :3], planes[:, 3], origins, direction)
        if self.kind == "box":
            normals = np.vstack([np.eye(3), -np.eye(3)])
            return _enter(normals, -np.tile(half, 2), p, direction)
        if self.kind == "cylinder":
            side = _quadric(p[:, :2] / half[0], direction[:2] / half[0])
            caps = _enter(np.array([[0.0, 0.0, 1.0], [0.0, 0.0, -1.0]]), -half[[2, 2]], p, direction)
            entry = np.maximum(side, caps)
            at = p + np.where(np.isfinite(entry), entry, 0.0)[:, None] * direction
            inside = (np.hypot(at[:, 0], at[:, 1]) <= half[0] * (1 + 1e-9)) & (np.abs(at[:, 2]) <= half[2] * (1 + 1e-9))
            return np.where(np.isfinite(entry) & inside, entry, np.inf)
        return _quadric(p / half, direction / half)


def regular_polygon(n: int, radius_m: float, *, turn_rad: float = 0.0) -> NDArray[np.float64]:
    """Corners of a regular polygon about the origin, the first one `turn_rad` from +x; shape (n, 2), metres."""
    angle = turn_rad + 2 * np.pi * np.arange(n) / n
    return radius_m * np.column_stack([np.cos(angle), np.sin(angle)])


def _enter(
    normals: NDArray[np.float64],
    offsets: NDArray[np.float64],
    origins: NDArray[np.float64],
    direction: NDArray[np.float64],
) -> NDArray[np.float64]:
    """Entry distance into the intersection of half-spaces normals . p + offsets <= 0."""
    speed = normals @ direction
    gap = origins @ normals.T + offsets
    with np.errstate(divide="ignore", invalid="ignore"):
        when = -gap / speed
    entry = np.where(speed < -1e-12, when, -np.inf).max(axis=1)
    leave = np.where(speed > 1e-12, when, np.inf).min(axis=1)
    outside = np.any((np.abs(speed) <= 1e-12) & (gap > 0), axis=1)
    return np.where((entry <= leave) & ~outside, entry, np.inf)


def _quadric(p: NDArray[np.float64], v: NDArray[np.float64]) -> NDArray[np.float64]:
    """Entry of the lines p + t v into the unit ball of as many dimensions."""
    a = float(v @ v)
    beyond = (p * p).sum(axis=1) - 1
    if a < 1e-18:
        return np.where(beyond <= 0, -np.inf, np.inf)
    b = p @ v
    root = b * b - a * beyond
    return np.where(root >= 0, (-b - np.sqrt(np.maximum(root, 0))) / a, np.inf)
