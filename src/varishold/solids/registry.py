"""Every solid by the name that commands use."""

from __future__ import annotations

import math

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
from varishold.solids.solid import Solid
from varishold.solids.sphere import Sphere
from varishold.solids.square_pillar import SquarePillar
from varishold.solids.wedge import Wedge

__all__ = ["SOLIDS", "known_solid", "solid_of_size"]

#: Every solid by its name.
SOLIDS: dict[str, type[Solid]] = {
    "cylinder": Cylinder,
    "square-pillar": SquarePillar,
    "rectangular-pillar": RectangularPillar,
    "cone-frustum": ConeFrustum,
    "pyramid-frustum": PyramidFrustum,
    "sphere": Sphere,
    "cone": Cone,
    "pyramid": Pyramid,
    "ridge": Ridge,
    "hip": Hip,
    "lying-cylinder": LyingCylinder,
    "edge": Edge,
    "wedge": Wedge,
    "plane": Plane,
}


def known_solid(name: str) -> type[Solid]:
    """Return the class of the solid called `name`, a key of `SOLIDS`.

    Raises
    ------
    InputError
        If there is no such solid.
    """
    if name not in SOLIDS:
        raise InputError(f"unknown solid {name!r}; known are {', '.join(SOLIDS)}")
    return SOLIDS[name]


def solid_of_size(name: str, size_m: float) -> Solid:
    """Make the solid called `name` (a key of `SOLIDS`) of size `size_m` (diameter or breadth, metres).

    Raises
    ------
    InputError
        If there is no such solid or the size is not positive and finite.
    """
    solid = known_solid(name)
    if not 0.0 < size_m < math.inf:
        raise InputError(f"the size of a {name} must be positive and finite, got {size_m} m", parameter="size_m")
    return solid.of_size(size_m)
