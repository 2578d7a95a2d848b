"""What every solid has in common: a face that can be pressed onto a skin, and where it lies."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass, fields
from typing import ClassVar, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from varishold.errors import InputError
from varishold.frame.checks import as_positive
from varishold.solids.body import Part
from varishold.solids.chance import Chance

__all__ = ["Drawn", "Pose", "Solid"]


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
    #: Whether it looks the same from all sides.
    round: ClassVar[bool] = False
    #: Whether a contact that is drawn at random may end outside of the pad's field.
    may_leave_field: ClassVar[bool] = False

    def __post_init__(self) -> None:
        for field in fields(self):
            value = getattr(self, field.name)
            if as_positive(value, f"{field.name} of a {self.name}") > _LARGEST:
                raise InputError(f"{field.name} of a {self.name} must be at most {_LARGEST:g}, got {value!r}")

    @classmethod
    @abstractmethod
    def of_size(cls, size_m: float) -> Self:
        """Make the solid of usual proportions whose size (diameter or breadth, metres) is `size_m`."""

    @classmethod
    def to_grip(cls, size_m: float) -> Self:
        """Make the solid of this size in proportions that four stacked fingers can hold."""
        return cls.of_size(size_m)

    @classmethod
    def to_lie(cls, size_m: float, aspects: tuple[float, float]) -> Self:
        """Make the solid of this size in proportions to lie on its side before a hand.

        Parameters
        ----------
        size_m : float
            Metres.
        aspects : (float, float)
            Its length, and its other breadth where that is free, in parts of its size.
        """
        return cls.to_grip(size_m)

    @classmethod
    def drawn(cls, chance: Chance) -> Drawn:
        """Make the contact of this solid that chance wants.

        Raises
        ------
        InputError
            If such a solid is not drawn at random.
        """
        raise InputError(f"a {cls.name} cannot be drawn at random: its class does not say how")

    def at_random(self, chance: Chance, depth_m: float, long_m: float, short_m: float) -> Drawn:
        """Return this solid in a random pose: its contact in the field, or its middle where it may leave that.

        Parameters
        ----------
        chance : Chance
        depth_m : float
            How much of it stands above the contact line. Metres.
        long_m, short_m : float
            Lengths of the contact along the solid's own x and y. Metres; infinite where it leaves the field.
        """
        height_m, width_m = chance.field_m
        if self.may_leave_field or long_m > 2 * max(chance.field_m):
            # Half of the field's shorter side, so that enough of the contact is seen.
            free_x = free_y = 0.25 * min(chance.field_m)
        else:
            c, s = abs(np.cos(chance.yaw_rad)), abs(np.sin(chance.yaw_rad))
            half_x, half_y = (long_m * c + short_m * s) / 2, (long_m * s + short_m * c) / 2
            if self.round:
                half_x = half_y = long_m / 2
            free_x, free_y = max(width_m / 2 - half_x, 0.0), max(height_m / 2 - half_y, 0.0)
        x_m, y_m = (float(chance.rng.uniform(-free, free)) for free in (free_x, free_y))
        return Drawn(self, Pose(x_m, y_m, chance.yaw_rad), depth_m, (long_m, short_m))

    def true_size_m(self, contact_m: tuple[float, float]) -> tuple[float, float]:
        """Return the (long, short) lengths that recognition should report of a contact with these lengths. Metres."""
        return max(contact_m), min(contact_m)

    @property
    @abstractmethod
    def top_m(self) -> float:
        """Height of the highest point above the base plane, metres."""

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

    @property
    def rolls(self) -> bool:
        """Whether it would roll away on a bare table, as a ball does."""
        return any(part.kind == "ellipsoid" for part in self.body())

    def body(self) -> tuple[Part, ...]:
        """Return the whole surface as convex parts, for a hand to grip.

        Raises
        ------
        InputError
            If the solid is only a face, such as a plane, that has no surface to grip.
        """
        raise InputError(f"a {self.name} is only a face and has no body to grip")


@dataclass(frozen=True)
class Drawn:
    """A solid that touches a pad: which, where, and how deep.

    Parameters
    ----------
    solid : Solid
        The solid; sloped ones go on below the contact line.
    pose : Pose
        Where it lies on the pad.
    depth_m : float
        How much of it stands above the contact line. Metres.
    size_m : (float, float)
        Lengths of the contact at the contact line along the solid's own x and y. Metres; infinite where it
        leaves the field.
    """

    solid: Solid
    pose: Pose
    depth_m: float
    size_m: tuple[float, float]

    @property
    def true_size_m(self) -> tuple[float, float]:
        """The (long, short) lengths that recognition should report: a frustum's are its top's. Metres."""
        return self.solid.true_size_m(self.size_m)
