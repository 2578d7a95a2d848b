"""Things that nobody knows, for measuring alone: four that commands name too, and nineteen whose bodies are made here.

Nothing is learned from any of them. The first nine had been measured when it was last decided how strangers are told;
the fourteen others were thought of apart from that, and by somebody who did not know what other things the library had
felt.
"""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from varishold.hand.objects import STRANGERS as NAMED
from varishold.solids import MeshSolid
from varishold.solids.body import Part

__all__ = ["KNOWN_BEFORE", "NEW", "STRANGERS", "to_touch"]

Floats = NDArray[np.float64]

# As tall as the prisms that are known (metres), and corners of a whole circle.
_TALL_M, _ROUND = 0.16, 48


def _prism(section: Floats) -> Part:
    return Part.prism(section, _TALL_M)


def _circle(radius_m: float, corners: int = _ROUND) -> Floats:
    turn = 2 * np.pi * np.arange(corners) / corners
    return radius_m * np.column_stack([np.cos(turn), np.sin(turn)])


def _at(section: Floats, height_m: float) -> Floats:
    return np.column_stack([section, np.full(len(section), height_m)])


def _between(low: Floats, low_m: float, high: Floats, high_m: float) -> Part:
    """The hull of one section at one height and another at another."""
    return Part.hull(np.vstack([_at(low, low_m), _at(high, high_m)]))


def _turned(radii_m: Floats, heights_m: Floats) -> Part:
    """A round convex body from its radii at some heights."""
    return Part.hull(
        np.vstack([_at(_circle(radius), height) for radius, height in zip(radii_m, heights_m, strict=True)])
    )


def _lathed(*rings_m: tuple[float, float]) -> tuple[Part, ...]:
    """A round body from its radii at rising heights, one convex part between each two."""
    return tuple(
        _between(_circle(radius), low, _circle(above), high) for (radius, low), (above, high) in pairwise(rings_m)
    )


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


def _bottle(size_m: float) -> tuple[Part, ...]:
    """Round, straight up to half its height of 0.16 m, then a slanting shoulder; from 0.65 on a neck 0.4 as broad."""
    radius = size_m / 2
    return _lathed((radius, 0.0), (radius, 0.5 * _TALL_M), (0.4 * radius, 0.65 * _TALL_M), (0.4 * radius, _TALL_M))


def _hourglass(size_m: float) -> tuple[Part, ...]:
    """Two round frusta tip to tip, 0.16 m tall: as broad as its size below and above, half as broad in the middle."""
    radius = size_m / 2
    return _lathed((radius, 0.0), (0.5 * radius, 0.5 * _TALL_M), (radius, _TALL_M))


def _cake(size_m: float) -> tuple[Part, ...]:
    """A wedding cake of three round tiers, 1, 0.75 and 0.5 of its size broad and each 0.4 of its size tall."""
    steps = [(share * size_m / 2, 0.4 * size_m * k) for k, share in enumerate((1.0, 0.75, 0.5))]
    return tuple(part for radius, low in steps for part in _lathed((radius, low), (radius, low + 0.4 * size_m)))


def _cross_bar(size_m: float) -> tuple[Part, ...]:
    """A bar 0.16 m tall with the section of a plus; each arm is a third as broad as the whole."""
    half, arm = size_m / 2, size_m / 6
    corners = np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
    side = np.array([[arm, half], [-arm, half], [-arm, arm], [arm, arm]])
    return tuple(Part.prism(section, _TALL_M) for section in (corners * (half, arm), side, -side))


def _rotor(size_m: float) -> tuple[Part, ...]:
    """A bar 0.16 m tall on a Reuleaux triangle: three bulging sides, three blunt edges, as broad from all sides."""
    tips = size_m / np.sqrt(3) * np.array([[1.0, 0.0], [-0.5, np.sqrt(0.75)], [-0.5, -np.sqrt(0.75)]])
    # About each tip an arc of a sixth of a circle, from one other tip to the next.
    turn = np.linspace(-np.pi / 6, np.pi / 6, 17)[:-1]
    sides = [
        tip + size_m * np.column_stack([np.cos(turn + facing), np.sin(turn + facing)])
        for tip, facing in zip(tips, np.pi + np.array([0.0, 2.0, 4.0]) * np.pi / 3, strict=True)
    ]
    return (Part.prism(np.vstack(sides), _TALL_M),)


def _flask(size_m: float) -> tuple[Part, ...]:
    """A bar 0.16 m tall with two flat sides and two half-round ends, 1.5 times as long as broad."""
    radius = size_m / 2
    turn = np.linspace(-np.pi / 2, np.pi / 2, _ROUND // 2 + 1)
    end = radius * np.column_stack([np.cos(turn), np.sin(turn)]) + (0.25 * size_m, 0.0)
    return (Part.prism(np.vstack([end, -end]), _TALL_M),)


def _twisted_pillar(size_m: float) -> tuple[Part, ...]:
    """A square pillar 0.16 m tall that is twisted by a quarter turn; its size is its section's diagonal."""
    turn = np.linspace(0.0, np.pi / 2, 13)
    heights = np.linspace(0.0, _TALL_M, 13)
    corner = np.pi / 4 + np.pi / 2 * np.arange(4)
    sections = [size_m / 2 * np.column_stack([np.cos(corner + angle), np.sin(corner + angle)]) for angle in turn]
    return tuple(_between(sections[k], heights[k], sections[k + 1], heights[k + 1]) for k in range(12))


def _toy_house(size_m: float) -> tuple[Part, ...]:
    """Upright walls as tall as broad, 1.2 times as long, and a gable roof of 45 degrees with its crest along x."""
    long, half = 0.6 * size_m, size_m / 2
    gable = np.array([[-half, 0.0], [half, 0.0], [half, size_m], [-half, size_m], [0.0, 1.5 * size_m]])
    return (Part.hull(np.vstack([np.column_stack([np.full(5, end), gable]) for end in (-long, long)])),)


def _barrel(size_m: float) -> tuple[Part, ...]:
    """A cask 0.16 m tall: round, as broad as its size at half its height, 0.7 as broad at both ends."""
    along = np.linspace(-1.0, 1.0, 17)
    return (_turned(size_m / 2 * (1 - 0.3 * along**2), _TALL_M / 2 * (1 + along)),)


def _tube(size_m: float) -> tuple[Part, ...]:
    """A squeezed-out tube on its cap, 0.16 m tall: round below, then flattened to a straight edge along x on top."""
    foot, edge = _circle(size_m / 2), size_m / 2 * np.array([[-1.0, -0.03], [1.0, -0.03], [1.0, 0.03], [-1.0, 0.03]])
    return (Part.hull(np.vstack([_at(foot, 0.0), _at(foot, 0.15 * _TALL_M), _at(edge, _TALL_M)])),)


def _mug(size_m: float) -> tuple[Part, ...]:
    """A round mug, 0.7 of its size broad and 1.1 tall, and on its +y side a square handle of three bars, 0.3 out."""
    radius, tall, thick = 0.35 * size_m, 1.1 * size_m, 0.12 * size_m
    # The round body reaches from -0.5 of the size to 0.2, the handle to 0.5.
    body = _circle(radius) + np.array([0.0, -0.15 * size_m])

    def bar(inner: float, low: float, high: float) -> Part:
        ys, xs = (inner * size_m, 0.5 * size_m), (-thick / 2, thick / 2)
        section = np.array([[x, y] for x in xs for y in ys])
        return Part.hull(np.vstack([_at(section, low * tall), _at(section, high * tall)]))

    return (
        Part.prism(body, tall),
        bar(0.15, 0.76, 0.88),
        bar(0.15, 0.14, 0.26),
        bar(0.38, 0.14, 0.88),
    )


def _die(size_m: float) -> tuple[Part, ...]:
    """A regular twelve-sided die (dodecahedron) that lies on one of its faces."""
    gold = (1 + np.sqrt(5)) / 2
    # Seen along a face's axis: two outer pentagons, and two inner ones turned and larger.
    five = np.pi / 10 + 2 * np.pi * np.arange(5) / 5
    small = np.column_stack([np.cos(five), np.sin(five)])
    corners = np.vstack([_at(small, 0.0), _at(gold * small, 1.0), _at(-gold * small, gold), _at(-small, 1 + gold)])
    return (Part.hull(corners * (size_m / np.ptp(corners[:, 1]))),)


def _pepper(size_m: float) -> tuple[Part, ...]:
    """A bell pepper of four lobes about its axis, 1.1 times as tall as broad, broadest above; its stalk to 1.25."""
    along = np.array([0.0, 0.05, 0.15, 0.3, 0.5, 0.7, 0.85, 0.95, 1.0])
    across = np.array([0.45, 0.6, 0.74, 0.86, 0.95, 1.0, 0.94, 0.78, 0.55])
    lobe, out = 0.22 * size_m, 0.28 * size_m
    heights = 1.1 * size_m * along
    lobes = [
        Part.hull(
            np.vstack(
                [
                    _at(share * (_circle(lobe, 24) + out * np.array([np.cos(way), np.sin(way)])), height)
                    for share, height in zip(across, heights, strict=True)
                ]
            )
        )
        for way in np.pi / 2 * np.arange(4)
    ]
    core = _turned(0.2 * size_m * across, heights)
    stalk = Part.hull(np.vstack([_at(_circle(0.07 * size_m), z * size_m) for z in (1.0, 1.25)]))
    return (*lobes, core, stalk)


def _mushroom(size_m: float) -> tuple[Part, ...]:
    """A round stem, 0.6 of its size broad and 0.8 tall, under a cap as broad as its size, domed as half a ball."""
    radius, stem_m = size_m / 2, 0.8 * size_m
    angle = np.linspace(0.0, 0.49 * np.pi, 13)
    stem = _turned(np.array([0.6, 0.6]) * radius, np.array([0.0, stem_m]))
    return (stem, _turned(radius * np.cos(angle), stem_m + radius * np.sin(angle)))


_FIRST: dict[str, Callable[[float], tuple[Part, ...]]] = {
    "star prism": _star_prism,
    "drop-shaped prism": _drop_prism,
    "egg": _egg,
    "capsule": _capsule,
    "slanting pillar": _slant_pillar,
}
_NEW: dict[str, Callable[[float], tuple[Part, ...]]] = {
    "bottle": _bottle,
    "hourglass": _hourglass,
    "tiered cake": _cake,
    "cross-shaped bar": _cross_bar,
    "rotor prism": _rotor,
    "flask": _flask,
    "twisted pillar": _twisted_pillar,
    "toy house": _toy_house,
    "barrel": _barrel,
    "squeezed tube": _tube,
    "mug": _mug,
    "twelve-sided die": _die,
    "bell pepper": _pepper,
    "mushroom": _mushroom,
}

#: Kinds that had been measured before it was last decided how strangers are told, and kinds that had not.
KNOWN_BEFORE: tuple[str, ...] = (*NAMED, *_FIRST)
NEW: tuple[str, ...] = tuple(_NEW)

#: The names of all strangers.
STRANGERS: tuple[str, ...] = (*KNOWN_BEFORE, *NEW)


def to_touch(name: str, size_m: float) -> str | MeshSolid:
    """Return what the hand is given for a name: a body where none of its own objects is called so."""
    make = (_FIRST | _NEW).get(name)
    return name if make is None else MeshSolid(name, make(size_m))
