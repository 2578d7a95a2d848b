"""What all faces with a height of their own have in common."""

from __future__ import annotations

from abc import abstractmethod
from typing import ClassVar, Self

import numpy as np
from numpy.typing import NDArray

from varishold.solids.chance import GOES_ON, Chance
from varishold.solids.solid import Drawn, Solid

__all__ = ["GRIP_HEIGHT_M", "Endless", "Raised", "Standing"]

#: Height of an upright object for a hand: the palm's height and a margin above and below it. Metres.
GRIP_HEIGHT_M = 0.16


class Raised(Solid):
    """A face that rises from the base plane to `height_m`, the last of its fields."""

    height_m: float

    @property
    def top_m(self) -> float:
        return self.height_m

    @abstractmethod
    def rise(self, x: NDArray[np.float64], y: NDArray[np.float64]) -> NDArray[np.float64]:
        """Height at points of the solid's own axes in parts of `height_m`; it is cut to between 0 and 1."""

    def height(self, x: NDArray[np.float64], y: NDArray[np.float64]) -> NDArray[np.float64]:
        return self.height_m * np.clip(self.rise(x, y), 0.0, 1.0)


class Standing(Raised):
    """An upright object that a hand can grip; its fields are its size and its height."""

    @classmethod
    def of_size(cls, size_m: float) -> Self:
        return cls(size_m, GRIP_HEIGHT_M)  # type: ignore[call-arg]

    @classmethod
    def to_lie(cls, size_m: float, aspects: tuple[float, float]) -> Self:
        return cls(size_m, aspects[0] * size_m)  # type: ignore[call-arg]


class Endless(Raised):
    """A flat face that leaves every field; its one field is its height."""

    may_leave_field: ClassVar[bool] = True

    @classmethod
    def of_size(cls, size_m: float) -> Self:
        return cls(size_m)  # type: ignore[call-arg]

    @classmethod
    def drawn(cls, chance: Chance) -> Drawn:
        depth_m = chance.depth_m(chance.size_m)
        return cls.of_size(GOES_ON * depth_m).at_random(chance, depth_m, np.inf, np.inf)
