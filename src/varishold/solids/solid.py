"""What every solid has in common: a face that can be pressed onto a skin, and where it lies."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass, fields
from typing import ClassVar, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from varishold.errors import InputError
from varishold.solids.body import Part

__all__ = ["Pose", "Solid"]


# Its square and its cube are finite too.
_LARGEST = 1e100


@dataclass(frozen=True)
class Pose:
    """Where a solid's face lies on a pad: its centre in metres from the pad's centre, and its turn.

    Parameters
    ----------
    x_m, y_m : float
        Centre in metres; x grows with the column index, y with the row index.
    yaw_rad : float
        Turn from +x toward +y, in radians.
    tip_x, tip_y : float
        Slope (rise over run, dimensionless) of the whole face along the pad's x and y.
    """

    x_m: float = 0.0
    y_m: float = 0.0
    yaw_rad: float = 0.0
    tip_x: float = 0.0
    tip_y: float = 0.0

    def __post_init__(self) -> None:
        for field in fields(self):
            value = getattr(self, field.name)
            if not abs(value) <= _LARGEST:
                raise InputError(f"{field.name} of a pose must be finite, at most {_LARGEST:g}, got {value!r}")


@dataclass(frozen=True)
class Solid(ABC):
    """A rigid solid, described by the face that it turns to the skin.

    Lengths are in metres. A solid's own x axis runs along its longer side. A subclass is a frozen
    dataclass whose fields are its sizes; every one must be positive and finite.
    """

    #: The name that recognition should give to this face.
    name: ClassVar[str]

    def __post_init__(self) -> None:
        for field in fields(self):
            value = getattr(self, field.name)
            if not (np.isfinite(value) and value > 0):
                raise InputError(f"{field.name} of a {self.name} must be positive and finite, got {value!r}")
            if value > _LARGEST:
                raise InputError(f"{field.name} of a {self.name} must be at most {_LARGEST:g}, got {value!r}")

    @classmethod
    @abstractmethod
    def of_size(cls, size_m: float) -> Self:
        """Make the solid of usual proportions whose size (diameter or breadth, metres) is `size_m`."""

    @property
    @abstractmethod
    def top_m(self) -> float:
        """Height of the highest point above the base plane, metres."""

    @property
    @abstractmethod
    def base_m(self) -> tuple[float, float]:
        """Lengths (along its own x, along its own y) of the base, metres; infinite where it has no end."""

    @abstractmethod
    def height(self, x: NDArray[np.float64], y: NDArray[np.float64]) -> NDArray[np.float64]:
        """Height above the base plane, metres, at points of the solid's own axes; 0 outside the base."""

    def placed(self, x: ArrayLike, y: ArrayLike, pose: Pose | None = None) -> NDArray[np.float64]:
        """Height above the base plane at points of the pad, for a solid that lies in `pose`.

        Parameters
        ----------
        x, y : array_like of the same shape, float
            Points of the pad in metres from its centre.
        pose : Pose, optional
            Default: centred, not turned, not tipped.

        Returns
        -------
        ndarray of that shape, float64
            Metres; 0 outside the base. A tip raises and lowers the face inside its base only.
        """
        pose = pose or Pose()
        dx = np.asarray(x, dtype=np.float64) - pose.x_m
        dy = np.asarray(y, dtype=np.float64) - pose.y_m
        c, s = np.cos(pose.yaw_rad), np.sin(pose.yaw_rad)
        own = self.height(c * dx + s * dy, c * dy - s * dx)
        if pose.tip_x == 0.0 and pose.tip_y == 0.0:
            return own
        return np.where(own > 0, own + pose.tip_x * dx + pose.tip_y * dy, 0.0)

    def body(self) -> tuple[Part, ...]:
        """Return the whole surface as convex parts, for a hand to grip.

        Raises
        ------
        InputError
            If the solid is only a face, such as a plane, that has no surface to grip.
        """
        raise InputError(f"a {self.name} is only a face and has no body to grip")
