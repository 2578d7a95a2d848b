"""The objects that the hand grips: solids in proportions that four stacked fingers can hold."""

from __future__ import annotations

import re
from collections.abc import Callable

from varishold.errors import InputError
from varishold.solids import (
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

#: Height of an upright object: the palm's height and a margin above and below it. Metres.
_TALL_M = 0.16

#: Sizes that the default hand can close on and open around. Metres.
SIZE_RANGE_M = (0.035, 0.125)

#: Each object's solid from its size (diameter or breadth, metres), by the name that commands use.
OBJECTS: dict[str, Callable[[float], Solid]] = {
    "cylinder": lambda size_m: Cylinder(size_m, _TALL_M),
    "square-pillar": lambda size_m: SquarePillar(size_m, _TALL_M),
    "box": lambda size_m: Box(1.4 * size_m, size_m, _TALL_M),
    "hexagonal-prism": lambda size_m: HexagonalPrism(size_m, _TALL_M),
    "triangular-prism": lambda size_m: TriangularPrism(size_m, _TALL_M),
    "sphere": lambda size_m: Sphere(size_m),
    "cone": lambda size_m: Cone(size_m, 2.0 * size_m),
    "pyramid": lambda size_m: Pyramid(size_m, 2.0 * size_m),
    "cone-frustum": lambda size_m: ConeFrustum(size_m, 0.6 * size_m, _TALL_M),
    "pyramid-frustum": lambda size_m: PyramidFrustum(size_m, 0.6 * size_m, _TALL_M),
}

#: Objects that the hand can grip and that are in no library, to see who notices; otherwise as `OBJECTS`.
STRANGERS: dict[str, Callable[[float], Solid]] = {
    "half-cylinder": lambda size_m: HalfCylinder(size_m, _TALL_M),
    "l-block": lambda size_m: LBlock(size_m, _TALL_M),
    "torus": Torus.of_size,
    "ellipsoid": Ellipsoid.of_size,
}

#: The ten objects of the paper's Table 5 (C1 .. C5, S1 .. S5): name and size, metres.
TABLE_5_OBJECTS = (
    *(("cylinder", size_m) for size_m in (0.07, 0.08, 0.09, 0.10, 0.11)),
    *(("square-pillar", size_m) for size_m in (0.05, 0.06, 0.07, 0.08, 0.09)),
)


def graspable(name: str, size_m: float) -> Solid:
    """Make the object called `name` for the hand to grip: a key of `OBJECTS` or `STRANGERS`, or ``lump-`` and a number.

    Parameters
    ----------
    name : str
    size_m : float
        Diameter or breadth of the base. Metres.

    Raises
    ------
    InputError
        If there is no such object, or it is too small or too large for the hand.

    Examples
    --------
    >>> graspable("cylinder", 0.09).top_m
    0.16
    """
    known = OBJECTS | STRANGERS
    lump = re.fullmatch(r"lump-(\d{1,9})", name)
    if lump is not None:
        known = {name: lambda size: Lump(size, int(lump[1]))}
    if name not in known:
        raise InputError(f"unknown object {name!r}; the hand can grip {', '.join(known)}, lump-NUMBER")
    low, high = SIZE_RANGE_M
    if not low <= size_m <= high:
        raise InputError(
            f"size of the {name} must lie in [{low:g}, {high:g}] m for the hand to grip it, got {size_m:g} m"
        )
    return known[name](size_m)
