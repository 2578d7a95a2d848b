"""Things that nobody knows, for measuring alone: four that commands name too, and five whose bodies are made here.

Nothing is learned from them, and nothing is chosen on them.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from varishold.hand.objects import STRANGERS as NAMED
from varishold.solids import MeshSolid
from varishold.solids.body import Part

__all__ = ["STRANGERS", "to_touch"]

Floats = NDArray[np.float64]

# As tall as the prisms that are known (metres), and corners of a whole circle.
_TALL_M, _ROUND = 0.16, 48


def _prism(section: Floats) -> Part:
    return Part.prism(section, _TALL_M)


def _turned(radii_m: Floats, heights_m: Floats) -> Part:
    """A round convex body from its radii at some heights."""
    turn = 2 * np.pi * np.arange(_ROUND) / _ROUND
    rings = [
        np.column_stack([radius * np.cos(turn), radius * np.sin(turn), np.full(_ROUND, height)])
        for radius, height in zip(radii_m, heights_m, strict=True)
    ]
    return Part.hull(np.vstack(rings))


def _star_prism(size_m: float) -> tuple[Part, ...]:
    """Five points about a middle, each a kite; the inner corners lie on a circle of half the breadth."""
    radius = size_m / 2 * np.where(np.arange(10) % 2, 0.5, 1.0)
    turn = 2 * np.pi * np.arange(10) / 10
    corners = np.column_stack([radius * np.cos(turn), radius * np.sin(turn)])
    return tuple(
        _prism(np.vstack([[0.0, 0.0], corners[2 * k - 1], corners[2 * k], corners[2 * k + 1]])) for k in range(5)
    )


def _drop_prism(size_m: float) -> tuple[Part, ...]:
    """Half round, and on the other side pointed at a right angle."""
    radius = size_m / 2
    turn = np.linspace(np.pi / 4, 2 * np.pi - np.pi / 4, 37)
    round_side = radius * np.column_stack([np.cos(turn), np.sin(turn)])
    return (_prism(np.vstack([round_side, [[np.sqrt(2) * radius, 0.0]]])),)


def _egg(size_m: float) -> tuple[Part, ...]:
    """Blunt below, pointed above, 1.6 times as tall as broad."""
    along = np.linspace(0.02, 1.0, 25)
    # Widest at two fifths of its height.
    across = np.where(along < 0.4, (along - 0.4) / 0.4, (along - 0.4) / 0.6)
    radii = size_m / 2 * np.sqrt(np.maximum(1 - across**2, 0.0)) * (1 - 0.2 * np.maximum(across, 0.0))
    return (_turned(radii + 1e-5, 1.6 * size_m * (along - along[0])),)


def _capsule(size_m: float) -> tuple[Part, ...]:
    """A round bar with half balls for its ends."""
    radius = size_m / 2
    angle = np.linspace(-0.45 * np.pi, 0.5 * np.pi, 21)
    below = angle < 0
    heights = np.where(below, radius, _TALL_M - radius) + radius * np.sin(angle)
    return (_turned(radius * np.cos(angle) + 1e-5, heights - heights[0]),)


def _slant_pillar(size_m: float) -> tuple[Part, ...]:
    """A square pillar cut off slantwise, from all of its height down to a third of it."""
    half = size_m / 2
    foot = np.array([[x, y, 0.0] for x in (-half, half) for y in (-half, half)])
    top = foot + np.where(foot[:, :1] < 0, _TALL_M, _TALL_M / 3) * np.array([0.0, 0.0, 1.0])
    return (Part.hull(np.vstack([foot, top])),)


_OWN = {
    "star prism": _star_prism,
    "drop-shaped prism": _drop_prism,
    "egg": _egg,
    "capsule": _capsule,
    "slanting pillar": _slant_pillar,
}

#: The names of all strangers.
STRANGERS: tuple[str, ...] = (*NAMED, *_OWN)


def to_touch(name: str, size_m: float) -> str | MeshSolid:
    """Return what the hand is given for a name: a body where none of its own objects is called so."""
    make = _OWN.get(name)
    return name if make is None else MeshSolid(name, make(size_m))
