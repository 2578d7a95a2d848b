"""Upright solids on a disc or a square: whole, pointed, or cut off level."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import astuple
from typing import ClassVar, Self

import numpy as np
from numpy.typing import NDArray

from varishold.solids.body import Part, regular_polygon
from varishold.solids.chance import GOES_ON, Chance
from varishold.solids.raised import GRIP_HEIGHT_M, Raised
from varishold.solids.solid import Drawn

__all__ = ["Disc", "Frustum", "Pillar", "Section", "Square", "Tip"]

Floats = NDArray[np.float64]


class Section(ABC):
    """The form of a solid's sections."""

    @abstractmethod
    def reach(self, x: Floats, y: Floats) -> Floats:
        """Half the breadth of the section on whose border a point of the solid's own axes lies."""

    @abstractmethod
    def outline(self, breadth_m: float) -> Floats:
        """Corners of a section of this breadth. Metres."""


class Disc(Section):
    """Sections that are circles."""

    round: ClassVar[bool] = True

    def reach(self, x: Floats, y: Floats) -> Floats:
        return np.hypot(x, y)

    def outline(self, breadth_m: float) -> Floats:
        return regular_polygon(48, breadth_m / 2)


class Square(Section):
    """Sections that are squares."""

    def reach(self, x: Floats, y: Floats) -> Floats:
        return np.maximum(np.abs(x), np.abs(y))

    def outline(self, breadth_m: float) -> Floats:
        return regular_polygon(4, breadth_m / np.sqrt(2), turn_rad=np.pi / 4)


class Upright(Raised):
    """A solid that a subclass gives its fields: one breadth or more, and the height."""

    @classmethod
    def made(cls, *lengths_m: float) -> Self:
        return cls(*lengths_m)

    @property
    def lengths_m(self) -> tuple[float, ...]:
        """The values of its fields. Metres."""
        return astuple(self)


class Pillar(Upright):
    """A face as broad as its base; its fields are the breadth and the height."""

    @classmethod
    def of_size(cls, size_m: float) -> Self:
        return cls.made(size_m, size_m)

    @classmethod
    def to_grip(cls, size_m: float) -> Self:
        return cls.made(size_m, GRIP_HEIGHT_M)

    @classmethod
    def to_lie(cls, size_m: float, aspects: tuple[float, float]) -> Self:
        return cls.made(size_m, aspects[0] * size_m)

    @classmethod
    def drawn(cls, chance: Chance) -> Drawn:
        depth_m = chance.depth_m(chance.size_m)
        return cls.made(chance.size_m, GOES_ON * depth_m).at_random(chance, depth_m, chance.size_m, chance.size_m)


class Tip(Section, Upright):
    """A face that rises to a point; its fields are the breadth of the base and the height."""

    @classmethod
    def of_size(cls, size_m: float) -> Self:
        return cls.made(size_m, 0.5 * size_m)

    @classmethod
    def to_grip(cls, size_m: float) -> Self:
        return cls.made(size_m, 2.0 * size_m)

    @classmethod
    def to_lie(cls, size_m: float, aspects: tuple[float, float]) -> Self:
        return cls.made(size_m, aspects[0] * size_m)

    @classmethod
    def drawn(cls, chance: Chance) -> Drawn:
        depth_m = chance.depth_m(chance.size_m)
        whole = cls.made(GOES_ON * chance.size_m, GOES_ON * depth_m)
        return whole.at_random(chance, depth_m, chance.size_m, chance.size_m)

    def rise(self, x: Floats, y: Floats) -> Floats:
        breadth_m, _ = self.lengths_m
        return 1 - self.reach(x, y) / (breadth_m / 2)

    def body(self) -> tuple[Part, ...]:
        breadth_m, height_m = self.lengths_m
        return (Part.prism(self.outline(breadth_m), height_m, top_scale=0.0),)


class Frustum(Section, Upright):
    """A pointed face that is cut off level; its fields are the breadths of base and top, and the height."""

    @classmethod
    def of_size(cls, size_m: float) -> Self:
        return cls.made(size_m, 0.45 * size_m, 0.3 * size_m)

    @classmethod
    def to_grip(cls, size_m: float) -> Self:
        return cls.made(size_m, 0.6 * size_m, GRIP_HEIGHT_M)

    @classmethod
    def to_lie(cls, size_m: float, aspects: tuple[float, float]) -> Self:
        return cls.made(size_m, 0.6 * size_m, aspects[0] * size_m)

    @classmethod
    def drawn(cls, chance: Chance) -> Drawn:
        size_m, top_m = chance.size_m, chance.size_m * chance.top
        depth_m = chance.depth_m(size_m)
        base_m = size_m + (GOES_ON - 1) * size_m * (1 - chance.top)
        return cls.made(base_m, top_m, GOES_ON * depth_m).at_random(chance, depth_m, size_m, size_m)

    def true_size_m(self, contact_m: tuple[float, float]) -> tuple[float, float]:
        _, top_m, _ = self.lengths_m
        return top_m, top_m

    def rise(self, x: Floats, y: Floats) -> Floats:
        base_m, top_m, _ = self.lengths_m
        return (base_m / 2 - self.reach(x, y)) / ((base_m - top_m) / 2)

    def body(self) -> tuple[Part, ...]:
        base_m, top_m, height_m = self.lengths_m
        return (Part.prism(self.outline(base_m), height_m, top_scale=top_m / base_m),)
