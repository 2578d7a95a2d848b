"""What lies between a known object and the taxels: nothing but springs, or an elastic layer."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, Protocol

import numpy as np
from numpy.typing import NDArray

from varishold.sensor import Skin
from varishold.skin.indentation import flat_on_layer, round_on_layer
from varishold.skin.media import Layer

__all__ = ["SPRINGS", "Cover", "Elastic", "Springs", "cover_of"]

Floats = NDArray[np.float64]

# A contact of a ball or roller reaches no further than this share of its radius.
_WIDEST = 0.9
# A body without a floor is a layer so many times as thick as the pad is long.
_FLOORLESS = 100.0


class Round(Protocol):
    """What a ball or a roller leaves."""

    def reach_m(self, depth_m: Floats | float) -> Floats:
        """Return half the breadth of what it presses, so deep."""

    def pressure(self, distance_m: Floats, depth_m: Floats | float) -> Floats:
        """Return the stress so far from its lowest point or line, which is so deep."""


class Flat(Protocol):
    """What a flat face leaves."""

    def pressure(
        self, u_m: Floats, v_m: Floats, depth_m: float, slope_u: float, slope_v: float, breadth_m: float
    ) -> Floats:
        """Return the mean stress over points of some breadth, (u, v) from its middle, which is so deep; 0 outside."""


class Cover(Protocol):
    """How an object's face becomes stress, in units that are the same for all presses."""

    def round(self, shape: Literal["ball", "roller"], size_m: float) -> Round:
        """Return what a ball or a roller of that diameter leaves."""

    def flat(self, shape: Literal["square", "disc"], size_m: float) -> Flat:
        """Return what a flat face of that breadth leaves."""


@dataclass(frozen=True)
class Springs:
    """Stress is the depth of the face, each place for itself."""

    def round(self, shape: Literal["ball", "roller"], size_m: float) -> Round:
        return _Sunk(size_m / 2)

    def flat(self, shape: Literal["square", "disc"], size_m: float) -> Flat:
        return _Sloped(shape, size_m / 2)


SPRINGS = Springs()


@dataclass(frozen=True)
class _Sunk:
    """How deep a round face is below the pad; beside it there is nothing, however deep it is pressed."""

    radius_m: float

    def reach_m(self, depth_m: Floats | float) -> Floats:
        depth = np.clip(depth_m, 0.0, self.radius_m)
        return np.asarray(np.sqrt(depth * (2 * self.radius_m - depth)))

    def pressure(self, distance_m: Floats, depth_m: Floats | float) -> Floats:
        gap = self.radius_m - np.sqrt(np.maximum(self.radius_m**2 - distance_m**2, 0.0))
        return np.where(np.abs(distance_m) < self.radius_m, np.maximum(depth_m - gap, 0.0), 0.0)


@dataclass(frozen=True)
class _Sloped:
    """How deep a flat face is below the pad; its edge rises over a point's breadth, so that it moves smoothly."""

    shape: Literal["square", "disc"]
    half_m: float

    def pressure(
        self, u_m: Floats, v_m: Floats, depth_m: float, slope_u: float, slope_v: float, breadth_m: float
    ) -> Floats:
        away = np.hypot(u_m, v_m) if self.shape == "disc" else np.maximum(np.abs(u_m), np.abs(v_m))
        inside = np.clip((self.half_m - away) / breadth_m + 0.5, 0.0, 1.0)
        depth: Floats = inside * np.maximum(depth_m + slope_u * u_m + slope_v * v_m, 0.0)
        return depth


@dataclass(frozen=True)
class Elastic:
    """A layer on a rigid floor to which it sticks.

    Parameters
    ----------
    thickness_m : float
    poisson : float
    pad_m : float
        Diagonal of the pad: no contact is wider.
    """

    thickness_m: float
    poisson: float
    pad_m: float

    def round(self, shape: Literal["ball", "roller"], size_m: float) -> Round:
        return round_on_layer(self._layer, size_m / 2, min(_WIDEST * size_m / 2, self.pad_m), shape)

    def flat(self, shape: Literal["square", "disc"], size_m: float) -> Flat:
        return flat_on_layer(self._layer, size_m, shape)

    @property
    def _layer(self) -> Layer:
        return Layer(self.thickness_m, self.poisson)


def cover_of(skin: Skin, pad_m: float) -> Cover:
    """Return the cover that a sensor file's skin is, over a pad whose diagonal is so long."""
    if skin.kind == "winkler":
        return SPRINGS
    return Elastic(_FLOORLESS * pad_m if skin.thickness_m is None else skin.thickness_m, skin.poisson, pad_m)
