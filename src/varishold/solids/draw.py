"""Random contacts: a solid, its pose and its depth, drawn so that the contact has a wanted size.

The same draw serves ideal frames and presses into a skin: a solid goes on below its contact line, so
that a skin that piles up meets no end of it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from varishold.errors import InputError
from varishold.solids.cone import Cone
from varishold.solids.cone_frustum import ConeFrustum
from varishold.solids.cylinder import Cylinder
from varishold.solids.edge import Edge
from varishold.solids.hip import Hip
from varishold.solids.lying_cylinder import LyingCylinder
from varishold.solids.plane import Plane
from varishold.solids.pyramid import Pyramid
from varishold.solids.pyramid_frustum import PyramidFrustum
from varishold.solids.rectangular_pillar import RectangularPillar
from varishold.solids.ridge import Ridge
from varishold.solids.solid import Pose, Solid
from varishold.solids.sphere import Sphere
from varishold.solids.square_pillar import SquarePillar
from varishold.solids.wedge import Wedge

__all__ = ["DRAWABLE", "Drawn", "draw_contact"]

# How far a sloped solid goes on below its contact line, as a multiple of the contact's depth.
_CONTINUED = 2.0

#: Names (keys of `SOLIDS`) that `draw_contact` knows.
DRAWABLE: tuple[str, ...] = (
    "cylinder",
    "square-pillar",
    "rectangular-pillar",
    "cone-frustum",
    "pyramid-frustum",
    "sphere",
    "cone",
    "pyramid",
    "ridge",
    "hip",
    "lying-cylinder",
    "edge",
    "wedge",
    "plane",
)


@dataclass(frozen=True)
class Drawn:
    """A solid that touches a pad: which, where, and how deep.

    Parameters
    ----------
    solid : Solid
        The solid; sloped ones go on below the contact line.
    pose : Pose
        Where it lies on the pad.
    depth_m : float
        How much of it stands above the contact line, metres.
    size_m : (float, float)
        Lengths of the contact at the contact line along the solid's own x and y, metres; infinite where it
        leaves the field.
    """

    solid: Solid
    pose: Pose
    depth_m: float
    size_m: tuple[float, float]


def draw_contact(
    rng: np.random.Generator,
    name: str,
    *,
    field_m: tuple[float, float],
    size_m: tuple[float, float],
    slope: tuple[float, float] = (0.05, 0.4),
    aspect: tuple[float, float] = (1.4, 2.8),
    top: tuple[float, float] = (0.3, 0.6),
    depth_m: float | None = None,
) -> Drawn:
    """Draw a random contact of the solid called `name`.

    Parameters
    ----------
    rng : numpy.random.Generator
        Source of every random choice.
    name : str
        One of `DRAWABLE`.
    field_m : (float, float)
        Height (along y) and width (along x) of the pad, metres. The whole contact lies in it, but for plane,
        edge, wedge and lying cylinder.
    size_m : (float, float)
        Range of the contact's diameter or breadth (the longer one where there are two), metres.
    slope : (float, float)
        Range of depth over contact breadth; drawn evenly on a logarithmic scale.
    aspect : (float, float)
        Range of long over short side of what is longer than broad.
    top : (float, float)
        Range of a frustum's top over its base at the contact line.
    depth_m : float, optional
        Depth to use instead of the one that the slope gives.

    Returns
    -------
    Drawn

    Raises
    ------
    InputError
        If `name` is not drawable.
    """
    if name not in DRAWABLE:
        raise InputError(f"cannot draw a {name!r}; known are {', '.join(DRAWABLE)}")
    size = float(rng.uniform(*size_m))
    ratio = float(rng.uniform(*aspect))
    steepness = float(np.exp(rng.uniform(*np.log(slope))))
    share = float(rng.uniform(*top))
    yaw = float(rng.uniform(-np.pi / 2, np.pi / 2))
    long, short = size, size
    if name in ("rectangular-pillar", "ridge", "hip"):
        short = size / ratio
    depth = steepness * short if depth_m is None else depth_m
    k = _CONTINUED
    solid: Solid
    if name == "cylinder":
        solid = Cylinder(size, k * depth)
    elif name == "square-pillar":
        solid = SquarePillar(size, k * depth)
    elif name == "rectangular-pillar":
        solid = RectangularPillar(long, short, k * depth)
    elif name == "cone":
        solid = Cone(k * size, k * depth)
    elif name == "pyramid":
        solid = Pyramid(k * size, k * depth)
    elif name == "cone-frustum":
        solid = ConeFrustum(size + (k - 1) * size * (1 - share), size * share, k * depth)
    elif name == "pyramid-frustum":
        solid = PyramidFrustum(size + (k - 1) * size * (1 - share), size * share, k * depth)
    elif name == "ridge":
        solid = Ridge(long, k * short, k * depth)
    elif name == "hip":
        solid = Hip(long + (k - 1) * short, k * short, k * depth)
    elif name == "sphere":
        # A cap of this breadth and depth; never deeper than a hemisphere.
        depth = min(depth, size / 2)
        solid = Sphere(2 * (size * size / 4 + depth * depth) / (2 * depth))
    elif name == "lying-cylinder":
        depth = min(depth, size / 2)
        # A third leave the field at both ends; of the rest some end inside it.
        length = 4 * max(field_m) if rng.random() < 1 / 3 else float(rng.uniform(1.3, 3.0)) * size
        solid = LyingCylinder(2 * (size * size / 4 + depth * depth) / (2 * depth), length)
        long, short = length, size
    elif name == "wedge":
        solid = Wedge(k * size, k * depth)
        long = np.inf
    elif name == "edge":
        solid = Edge(k * depth)
        long, short = np.inf, np.inf
    else:
        solid = Plane(k * depth)
        long, short = np.inf, np.inf
    return Drawn(solid, _place(rng, name, field_m, long, short, yaw), depth, (long, short))


def _place(
    rng: np.random.Generator, name: str, field_m: tuple[float, float], long: float, short: float, yaw: float
) -> Pose:
    """Return a pose that keeps the contact in the field, or its middle where it may leave it."""
    height, width = field_m
    if not np.isfinite(long) or long > 2 * max(field_m) or name == "lying-cylinder":
        # Half of the field's shorter side, so that enough of the contact is seen.
        reach = 0.25 * min(field_m)
        return Pose(float(rng.uniform(-reach, reach)), float(rng.uniform(-reach, reach)), yaw)
    c, s = abs(np.cos(yaw)), abs(np.sin(yaw))
    if name in ("cylinder", "cone", "cone-frustum", "sphere"):
        half_x = half_y = long / 2
    else:
        half_x, half_y = (long * c + short * s) / 2, (long * s + short * c) / 2
    free_x, free_y = max(width / 2 - half_x, 0.0), max(height / 2 - half_y, 0.0)
    return Pose(float(rng.uniform(-free_x, free_x)), float(rng.uniform(-free_y, free_y)), yaw)
