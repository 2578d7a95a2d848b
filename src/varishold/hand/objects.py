"""The objects that the hand grips: solids in proportions that four stacked fingers can hold."""

from __future__ import annotations

import re
from dataclasses import astuple
from itertools import combinations
from typing import Literal, get_args

import numpy as np

from varishold.errors import InputError
from varishold.frame.checks import as_array
from varishold.solids import (
    SOLIDS,
    Assembly,
    Box,
    Cone,
    ConeFrustum,
    Cylinder,
    Ellipsoid,
    HalfCylinder,
    HexagonalPrism,
    Laid,
    LBlock,
    Lump,
    MeshSolid,
    Pyramid,
    PyramidFrustum,
    Solid,
    Sphere,
    SquarePillar,
    Torus,
    TriangularPrism,
    Variant,
    lay_down,
)

__all__ = [
    "OBJECTS",
    "POSES",
    "SIZE_RANGE_M",
    "STRANGERS",
    "TABLE_5_OBJECTS",
    "Pose",
    "graspable",
    "laid_to_grip",
    "right_names",
]

#: How an object can be set up: on its base, or on its side.
Pose = Literal["upright", "lying"]
POSES: tuple[Pose, ...] = get_args(Pose)

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

# What is made by chance, by the name that stands before its number.
_BY_CHANCE: dict[str, type[Lump | Assembly | Variant]] = {each.name: each for each in (Lump, Assembly, Variant)}

#: The ten objects of the paper's Table 5 (C1 .. C5, S1 .. S5): name and size, metres.
TABLE_5_OBJECTS = (
    *(("cylinder", size_m) for size_m in (0.07, 0.08, 0.09, 0.10, 0.11)),
    *(("square-pillar", size_m) for size_m in (0.05, 0.06, 0.07, 0.08, 0.09)),
)


# What lies is one to three times as long as its size, and no longer than this (metres).
_ASPECT, _LONGEST_M = 3.0, 0.2
# Lengths within this factor are told apart by nobody.
_ALIKE = 1.2


def graspable(name: str, size_m: float, sizes_m: tuple[float, float] = SIZE_RANGE_M) -> Solid:
    """Make the object called `name` for the hand to grip: a solid's name, or ``lump-``,
    ``assembly-`` or ``variant-`` and a number.

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
    kind, number = _kind(name)
    if kind is None:
        known = ", ".join([*OBJECTS, *STRANGERS, *(f"{each}-NUMBER" for each in _BY_CHANCE)])
        raise InputError(f"unknown object {name!r}; the hand can grip {known} and any solid with a body")
    low, high = sizes_m
    given = as_array(size_m)
    if given.shape != ():
        raise InputError(f"size of the {name} must be one number of metres, got {size_m!r}")
    size_m = float(given)
    if not low <= size_m <= high:
        raise InputError(
            f"size of the {name} must lie in [{low:g}, {high:g}] m for the hand to grip it, got {size_m:g} m"
        )
    made = kind.to_grip(size_m) if number is None else _BY_CHANCE[kind.name](size_m, number)
    made.body()
    return made


def laid_to_grip(name: str | MeshSolid, size_m: float, *, seed: int) -> Laid:
    """Lay the object called `name` on its side, in proportions and on a side that belong to the seed.

    Parameters
    ----------
    name : str
        As of `graspable`. A mesh lies as in its file, and is refused.
    size_m : float
        Metres; of a box the shortest of its three lengths.
    seed : int

    Raises
    ------
    InputError
        If there is no such object, or it has no side that it rests on.

    Examples
    --------
    >>> round(laid_to_grip("cylinder", 0.06, seed=1).top_m, 6)
    0.06
    """
    if not isinstance(name, str):
        raise InputError("a thing of a mesh lies as in its file: turn it there")
    rng = np.random.default_rng([seed, 17])
    most = max(1.0, min(_ASPECT, _LONGEST_M / size_m))
    first, second = np.exp(rng.uniform(0.0, np.log(most), 2)).tolist()
    roll_rad = float(rng.uniform(-np.pi, np.pi))
    kind, number = _kind(name)
    if kind is None or number is not None:
        return lay_down(graspable(name, size_m), roll_rad)
    return lay_down(kind.to_lie(size_m, (first, second)), roll_rad)


def right_names(name: str | MeshSolid, size_m: float, *, seed: int, pose: Pose) -> tuple[str, ...]:
    """Return every name that is right for an object as it was set up, its own first.

    A pillar that lies is a box as well, and a lying box of which two lengths are within a fifth a pillar.

    Parameters
    ----------
    name, size_m, seed
        As of `laid_to_grip`.
    pose : {"upright", "lying"}

    Examples
    --------
    >>> right_names("square-pillar", 0.06, seed=1, pose="lying")
    ('square-pillar', 'box')
    """
    own = name if isinstance(name, str) else name.called
    if pose == "lying" and own == "square-pillar":
        return own, "box"
    if pose == "lying" and own == "box":
        lying = laid_to_grip(own, size_m, seed=seed).upright
        if any(max(pair) < _ALIKE * min(pair) for pair in combinations(astuple(lying), 2)):
            return own, "square-pillar"
    return (own,)


def _kind(name: str) -> tuple[type[Solid] | None, int | None]:
    """The class of an object, and the number of one that is made by chance."""
    numbered = re.fullmatch(rf"({'|'.join(_BY_CHANCE)})-(\d{{1,9}})", name)
    if numbered:
        return (_BY_CHANCE[numbered[1]], int(numbered[2]))
    return ({**SOLIDS, **OBJECTS, **STRANGERS}.get(name), None)
