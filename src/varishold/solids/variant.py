"""A thing that is nearly one that has a name: something was done to it by chance."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from varishold.solids.body import regular_polygon
from varishold.solids.by_chance import DrawnByChance, turn_by

__all__ = ["Variant"]

Floats = NDArray[np.float64]
Rng = np.random.Generator

# As tall as the prisms that have names, metres, or anything between these.
_TALL_M, _TALLS_M = 0.16, (0.07, 0.2)
# How many times as tall as broad a cone is.
_CONE_TALL = 2.0
# Corners of a round section, and pieces that a curved side is made of.
_ROUND, _PIECES = 24, 5
# What may be the corners of a section: round ones are as many as all others.
_SECTIONS = (3, 4, 4, 6, _ROUND, _ROUND)


@dataclass(frozen=True)
class _Stack:
    """Sections on each other, from the base to the top: those of one layer and the next are joined to hulls.

    `heights` (n,): of layers, in parts of the whole. `layers`: of each convex part of the section, its corners in every
    layer, shape (n, corners, 2). `fall`: how much of the height the top falls along x.
    """

    heights: Floats
    layers: list[Floats]
    fall: float = 0.0

    def hulls(self, tall: float) -> list[Floats]:
        """Return the corners of each hull, shape (n, 3); `tall`: in parts of the breadth along y."""
        out, y = [], np.concatenate([corners[..., 1].ravel() for corners in self.layers])
        for corners in self.layers:
            solid = np.dstack([corners, np.broadcast_to(self.heights[:, None], corners.shape[:2])])
            out += [np.vstack(pair) for pair in pairwise(solid)]
        if self.fall:
            x = np.concatenate([hull[:, 0] for hull in out])
            for hull in out:
                hull[:, 2] *= 1.0 - self.fall * (hull[:, 0] - x.min()) / np.ptp(x)
        return [hull * np.array([1.0, 1.0, tall * np.ptp(y)]) for hull in out]


@dataclass(frozen=True)
class Variant(DrawnByChance):
    """A prism, a frustum, a cone or a ball that was cut, notched, bent, twisted, pressed, or given a rib or a roof.

    Parameters
    ----------
    breadth_m : float
        Size: its breadth along its own y. Metres.
    number : int
        Which of all variants it is.
    """

    name: ClassVar[str] = "variant"

    def drawn_hulls(self) -> list[Floats]:
        rng = np.random.default_rng([self.number, 7])
        kind = rng.choice(["ball", "cone", "frustum", "prism"], p=[0.1, 0.15, 0.25, 0.5])
        if kind == "ball":
            return _of_a_ball(rng)
        section = _section(rng)
        if rng.random() < 0.3:
            section = section * np.array([rng.uniform(1.0, 1.6), 1.0])
        top = {"cone": 0.02, "frustum": float(rng.uniform(0.3, 0.8)), "prism": 1.0}[kind]
        stack = _CHANGES[int(rng.integers(len(_CHANGES)))](rng, section, top)
        tall_m = _TALL_M if rng.random() < 0.6 else float(rng.uniform(*_TALLS_M))
        return stack.hulls(_CONE_TALL if kind == "cone" else tall_m / self.breadth_m)


def _along(sections: list[Floats], top: float) -> _Stack:
    """Stand convex sections side by side, drawn in to `top` times their breadth."""
    return _Stack(np.array([0.0, 1.0]), [np.stack([section, top * section]) for section in sections])


def _shaped(section: Floats, heights: Floats, shapes: list[Floats], shifts: Floats | None = None) -> _Stack:
    """Stand a section up, under a matrix (2, 2) and a shift in each layer."""
    moved = np.zeros((len(heights), 2)) if shifts is None else shifts
    return _Stack(heights, [np.stack([section @ m + s for m, s in zip(shapes, moved, strict=True)])])


def _scaled(section: Floats, heights: Floats, breadths: Floats, shifts: Floats | None = None) -> _Stack:
    """Stand a section up, so many times as broad, and shifted, in each layer."""
    return _shaped(section, heights, [breadth * np.eye(2) for breadth in breadths], shifts)


def _cornered(rng: Rng, section: Floats, top: float) -> _Stack:
    """One or two corners are cut off; of what is round, a flat."""
    if len(section) == _ROUND:
        low = -float(rng.uniform(0.15, 0.42))
        return _along([np.maximum(section, [low, -np.inf])], top)
    gone, share = set(rng.permutation(len(section))[: int(rng.integers(1, 3))].tolist()), rng.uniform(0.2, 0.45)
    kept = []
    for k, corner in enumerate(section):
        before, after = section[k - 1], section[(k + 1) % len(section)]
        kept += [corner + share * (before - corner), corner + share * (after - corner)] if k in gone else [corner]
    return _along([np.array(kept)], top)


def _half_and_half(rng: Rng, section: Floats, top: float) -> _Stack:
    """On one side another section than on the other."""
    other = _section(rng) * np.array([rng.uniform(0.6, 1.7), 1.0])
    half = np.vstack([section[section[:, 0] >= -1e-9], other[other[:, 0] <= 1e-9]])
    return _along([half], top)


def _starred(rng: Rng, section: Floats, top: float) -> _Stack:
    """Points about a middle, between them hollows."""
    n = int(rng.integers(3, 8))
    radius = np.where(np.arange(2 * n) % 2, rng.uniform(0.45, 0.88) * np.cos(np.pi / n), 1.0)
    turn = np.pi * np.arange(2 * n) / n
    ring = 0.5 * radius[:, None] * np.column_stack([np.cos(turn), np.sin(turn)])
    kites = [np.vstack([[0.0, 0.0], ring[2 * k - 1], ring[2 * k], ring[2 * k + 1]]) for k in range(n)]
    return _along(kites, top)


def _ribbed(rng: Rng, section: Floats, top: float) -> _Stack:
    """A rib on a side, square or round, from the base to the top."""
    wide, out = rng.uniform(0.08, 0.2), rng.uniform(0.1, 0.3)
    rib = 2 * regular_polygon(4 if rng.random() < 0.6 else 12, 0.5) * np.array([out, wide])
    turn = turn_by(rng.uniform(0, 2 * np.pi))
    way = turn[0]
    reach = float((section @ way).max())
    return _along([section, rib @ turn + 0.9 * reach * way], top)


def _cut(rng: Rng, section: Floats, top: float) -> _Stack:
    """Its top is cut off slantwise."""
    stack = _along([section @ turn_by(rng.uniform(0, 2 * np.pi))], top)
    return replace(stack, fall=float(rng.uniform(0.2, 0.75)))


def _twisted(rng: Rng, section: Floats, top: float) -> _Stack:
    """Its top is turned against its base, layer by layer."""
    turn = rng.choice([-1.0, 1.0]) * rng.uniform(0.3, 1.3)
    u = np.linspace(0.0, 1.0, _PIECES + 1)
    section = section * np.array([rng.uniform(1.1, 1.6), 1.0]) if len(section) == _ROUND else section
    return _shaped(section, u, [(1 + (top - 1) * at) * turn_by(turn * at) for at in u])


def _leaning(rng: Rng, section: Floats, top: float) -> _Stack:
    """It leans to a side, evenly or in a bow."""
    u = np.linspace(0.0, 1.0, _PIECES + 1) if rng.random() < 0.5 else np.array([0.0, 1.0])
    way = rng.uniform(0, 2 * np.pi)
    off = rng.uniform(0.2, 0.6) * np.array([np.cos(way), np.sin(way)])
    return _scaled(section, u, 1 + (top - 1) * u, np.outer(u**2, off))


def _bellied(rng: Rng, section: Floats, top: float) -> _Stack:
    """It has a belly or a waist."""
    u, most = np.linspace(0.0, 1.0, _PIECES + 1), rng.choice([-1.0, 1.0]) * rng.uniform(0.12, 0.4)
    at = u ** rng.uniform(0.6, 1.6)
    return _scaled(section, u, (1 + (top - 1) * u) * (1 + most * np.sin(np.pi * at)))


def _stepped(rng: Rng, section: Floats, top: float) -> _Stack:
    """From some height on it is narrower, or broader."""
    at, factor = rng.uniform(0.3, 0.8), rng.uniform(0.6, 0.85)
    breadths = np.array([1.0, 1.0, factor, factor]) if rng.random() < 0.6 else np.array([factor, factor, 1.0, 1.0])
    heights = np.array([0.0, at, at + 1e-3, 1.0])
    return _scaled(section, heights, breadths * (1 + (top - 1) * heights))


def _roofed(rng: Rng, section: Floats, top: float) -> _Stack:
    """On top it ends in a dome, a point or a crest."""
    start, kind = rng.uniform(0.4, 0.8), int(rng.integers(3))
    u = np.linspace(0.0, 1.0, _PIECES + 1 if kind == 0 else 2)
    across = np.sqrt(1 - (0.98 * u) ** 2) if kind == 0 else 1 - 0.95 * u
    taper = 1 + (top - 1) * start
    crest = [taper * np.diag([c if kind < 2 else 1.0, c]) for c in across]
    return _shaped(section, np.concatenate([[0.0], start + (1 - start) * u]), [np.eye(2), *crest])


def _pressed(rng: Rng, section: Floats, top: float) -> _Stack:
    """Its top is pressed flat, or drawn out, one way."""
    section = section @ turn_by(rng.uniform(0, 2 * np.pi))
    way = np.diag([rng.uniform(0.25, 0.75), 1.0]) if rng.random() < 0.6 else np.diag([1.0, rng.uniform(1.2, 1.6)])
    return _shaped(section, np.array([0.0, 1.0]), [np.eye(2), top * way])


def _of_a_ball(rng: Rng) -> list[Floats]:
    """A ball that is blunt or pointed, cut off, or pressed."""
    u = np.linspace(-0.98, rng.uniform(0.3, 0.98), 2 * _PIECES)
    radii = 0.5 * np.sqrt(1 - np.abs(u) ** rng.uniform(1.3, 3.5))
    circle = 2 * regular_polygon(_ROUND, 0.5) * np.array([rng.uniform(0.7, 1.3), 1.0])
    tall = 0.5 * rng.uniform(0.8, 1.3)
    rings = [np.column_stack([r * circle, np.full(_ROUND, tall * (at + 1))]) for r, at in zip(radii, u, strict=True)]
    return [np.vstack(rings)]


_CHANGES: tuple[Callable[[Rng, Floats, float], _Stack], ...] = (
    _cornered,
    _half_and_half,
    _starred,
    _ribbed,
    _cut,
    _twisted,
    _leaning,
    _bellied,
    _stepped,
    _roofed,
    _pressed,
)


def _section(rng: Rng) -> Floats:
    """A regular section with a side, where it has sides, across x."""
    n = int(rng.choice(_SECTIONS))
    return regular_polygon(n, 0.5, turn_rad=np.pi / n)
