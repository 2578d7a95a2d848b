"""The objects that the hand grips: solids in proportions that four stacked fingers can hold."""

from __future__ import annotations

import re

from varishold.errors import InputError
from varishold.solids import (
    SOLIDS,
    Box,
    Cone,
    ConeFrustum,
    Cylinder,
    Ellipsoid,
    HalfCylinder,
    HexagonalPrism,
    LBlock,
    Lump,
    Pyramid,
    PyramidFrustum,
    Solid,
    Sphere,
    SquarePillar,
    Torus,
    TriangularPrism,
)

__all__ = ["OBJECTS", "SIZE_RANGE_M", "STRANGERS", "TABLE_5_OBJECTS", "graspable"]

#: Sizes that the default hand can close on and open around. Metres.
SIZE_RANGE_M = (0.035, 0.125)

#: The objects that the shipped library knows, by the name that commands use.
OBJECTS: dict[str, type[Solid]] = {
    "cylinder": Cylinder,
    "square-pillar": SquarePillar,
    "box": Box,
    "hexagonal-prism": HexagonalPrism,
    "triangular-prism": TriangularPrism,
    "sphere": Sphere,
    "cone": Cone,
    "pyramid": Pyramid,
    "cone-frustum": ConeFrustum,
    "pyramid-frustum": PyramidFrustum,
}

#: Objects that the hand can grip and that are in no library, to see who notices.
STRANGERS: dict[str, type[Solid]] = {
    "half-cylinder": HalfCylinder,
    "l-block": LBlock,
    "torus": Torus,
    "ellipsoid": Ellipsoid,
}

#: The ten objects of the paper's Table 5 (C1 .. C5, S1 .. S5): name and size, metres.
TABLE_5_OBJECTS = (
    *(("cylinder", size_m) for size_m in (0.07, 0.08, 0.09, 0.10, 0.11)),
    *(("square-pillar", size_m) for size_m in (0.05, 0.06, 0.07, 0.08, 0.09)),
)


def graspable(name: str, size_m: float, sizes_m: tuple[float, float] = SIZE_RANGE_M) -> Solid:
    """Make the object called `name` for the hand to grip: a solid's name, or ``lump-`` and a number.

    Parameters
    ----------
    name : str
    size_m : float
        Diameter or breadth of the base. Metres.
    sizes_m : (float, float)
        The least and the largest that the hand grips. Metres.

    Raises
    ------
    InputError
        If there is no such object, it is only a face, or it is too small or too large for the hand.

    Examples
    --------
    >>> graspable("cylinder", 0.09).top_m
    0.16
    """
    lump = re.fullmatch(r"lump-(\d{1,9})", name)
    solid = Lump if lump else {**SOLIDS, **OBJECTS, **STRANGERS}.get(name)
    if solid is None:
        known = ", ".join(OBJECTS | STRANGERS)
        raise InputError(f"unknown object {name!r}; the hand can grip {known}, lump-NUMBER, and any solid with a body")
    low, high = sizes_m
    if not low <= size_m <= high:
        raise InputError(
            f"size of the {name} must lie in [{low:g}, {high:g}] m for the hand to grip it, got {size_m:g} m"
        )
    made = Lump(size_m, int(lump[1])) if lump else solid.to_grip(size_m)
    made.body()
    return made
