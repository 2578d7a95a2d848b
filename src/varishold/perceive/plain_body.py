"""The plainest bodies that a touched thing may be told from: a ball, and an upright bar with a flat top."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import NDArray

__all__ = ["Ball", "Bar", "PlainBody", "plain_bodies"]

Floats = NDArray[np.float64]

# Slopes are differences over so much to either side. Metres.
_STEP_M = 1e-5

# Standard deviation of a fitted body's numbers, and of the top of a thing whose top nobody touched. Metres.
_SIGMA_M, _TOP_UNKNOWN_M = 0.005, 0.03

# No body is fitted thinner than this. Metres.
_LEAST_M = 0.002

# Normals tell a radius by how they turn. Where that is less than this, their mean square, they are taken for so many of
# a body as broad as things that a hand holds. 1, metres.
_TURNED, _USUAL_M = 0.1, 0.03

# A contact whose normal looks up by more than this lies on the top; its normal lies flat where less does, 1.
_UP, _FLAT = 0.7, 0.7


@dataclass(frozen=True)
class PlainBody(ABC):
    """A body whose signed distance is known everywhere.

    Parameters
    ----------
    numbers_m : tuple of float
        What it is fitted by. Metres.
    sigma_m : tuple of float
        How unsure each of them is: a standard deviation. Metres.
    """

    numbers_m: tuple[float, ...]
    sigma_m: tuple[float, ...]

    @abstractmethod
    def _off(self, places: Floats, numbers_m: Floats) -> Floats:
        """Signed distance with these numbers."""

    @abstractmethod
    def box(self) -> Floats:
        """Return two corners of a box around it, shape (2, 3). Metres."""

    def distance(self, places: Floats) -> Floats:
        """Return the signed distances (n,) from its surface, positive outside, of places (n, 3). Metres."""
        return self._off(places, np.array(self.numbers_m))

    def change(self, places: Floats) -> Floats:
        """Return how much a standard deviation of each number changes the distances, shape (n, n_numbers). Metres."""
        numbers, steps = np.array(self.numbers_m), _STEP_M * np.eye(len(self.numbers_m))
        ways = [(self._off(places, numbers + h) - self._off(places, numbers - h)) / (2 * _STEP_M) for h in steps]
        out: Floats = np.stack(ways, axis=1) * self.sigma_m
        return out

    def slope(self, places: Floats, *, change: bool = False) -> Floats:
        """Return the slopes of `distance` along x, y and z, shape (3, n), or those of `change`, (3, n, n_numbers)."""
        of = self.change if change else self.distance
        steps = _STEP_M * np.eye(3)
        return np.stack([(of(places + h) - of(places - h)) / (2 * _STEP_M) for h in steps])


@dataclass(frozen=True)
class Ball(PlainBody):
    """A ball: its middle's x, y and z, and its radius."""

    @classmethod
    def fitted(cls, points: Floats, normals: Floats) -> Self:
        """Fit it to points and normals by least squares."""
        return cls(_round(points, normals), (_SIGMA_M,) * 4)

    def _off(self, places: Floats, numbers_m: Floats) -> Floats:
        out: Floats = np.linalg.norm(places - numbers_m[:3], axis=1) - numbers_m[3]
        return out

    def box(self) -> Floats:
        *middle, radius = self.numbers_m
        return np.array([middle, middle]) + radius * np.array([[-1.0], [1.0]])


@dataclass(frozen=True)
class Bar(PlainBody):
    """An upright round bar that goes on below the table: its middle's x and y, its radius, and its top."""

    @classmethod
    def fitted(cls, points: Floats, normals: Floats) -> Self:
        """Fit it to points and normals by least squares; its top is unknown where no point looks up."""
        flat = np.hypot(normals[:, 0], normals[:, 1]) > _FLAT
        some = flat if flat.sum() > 2 else np.ones(len(flat), bool)
        top = points[normals[:, 2] > _UP, 2]
        height = float(np.median(top)) if top.size else float(points[:, 2].max()) + _SIGMA_M
        sigma = _SIGMA_M if top.size else _TOP_UNKNOWN_M
        return cls((*_round(points[some, :2], normals[some, :2]), height), (_SIGMA_M, _SIGMA_M, _SIGMA_M, sigma))

    def _off(self, places: Floats, numbers_m: Floats) -> Floats:
        beside = np.linalg.norm(places[:, :2] - numbers_m[:2], axis=1) - numbers_m[2]
        above = places[:, 2] - numbers_m[3]
        out: Floats = np.minimum(np.maximum(beside, above), 0) + np.hypot(np.maximum(beside, 0), np.maximum(above, 0))
        return out

    def box(self) -> Floats:
        x, y, r, top = self.numbers_m
        return np.array([[x - r, y - r, top], [x + r, y + r, top]])


def plain_bodies(points: Floats, normals: Floats, *, stands: bool) -> list[PlainBody]:
    """Return the bodies that a surface may be told from, fitted to points (n, 3) in metres and unit normals.

    What hangs free is told from a ball. What stands may be told from a bar too, and from nothing else until a point
    looks up: a ball would claim to know its top.
    """
    if not stands:
        return [Ball.fitted(points, normals)]
    bar = Bar.fitted(points, normals)
    return [Ball.fitted(points, normals), bar] if (normals[:, 2] > _UP).any() else [bar]


def _round(points: Floats, normals: Floats) -> tuple[float, ...]:
    """Middle c and radius r with p = c + r n on the mean."""
    off_p, off_n = points - points.mean(axis=0), normals - normals.mean(axis=0)
    turned = float((off_n**2).sum())
    lacking = max(_TURNED * len(points) - turned, 0.0)
    radius = max((float((off_p * off_n).sum()) + lacking * _USUAL_M) / (turned + lacking), _LEAST_M)
    return *(points.mean(axis=0) - radius * normals.mean(axis=0)).tolist(), radius
