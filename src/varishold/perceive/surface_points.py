"""Where a thing was touched: points of its surface with their normals, and places that are free; checked."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from varishold.errors import InputError, require
from varishold.frame.checks import as_given

__all__ = ["FEWEST", "MOST", "SurfaceContacts", "blocks", "places_of"]

Floats = NDArray[np.float64]

#: Fewer points than this close no surface; more make the exact process slow, and so do more free places.
FEWEST, MOST, MOST_FREE = 4, 1000, 2000

# Nobody feels a thing that is farther away; what is has been given in millimetres. Metres.
_REACH_M = 2.0

# Places that are looked at at once.
_BLOCK = 2000


@dataclass(frozen=True)
class SurfaceContacts:
    """Where a thing was touched, in one frame; z points up.

    Parameters
    ----------
    point_m : ndarray of shape (n, 3)
        Points of the surface. Metres.
    normal : ndarray of shape (n, 3)
        Outward; of any length but zero.
    sigma_m : ndarray of shape (n,) or float
        Standard deviation of a point along its normal. Metres.
    normal_sigma : ndarray of shape (n,) or float
        Standard deviation of each component of a unit normal, 1.
    touch : ndarray of shape (n,), int, optional
        The touch that each point belongs to: points of one touch err alike. Default: each by itself.
    free_m : ndarray of shape (k, 3), optional
        Places that are outside for certain. Metres.

    Raises
    ------
    InputError
        If the arrays do not belong together, are not finite, lie out of reach, a normal has no length, or a standard
        deviation is not positive; if there are fewer than 4 points or more than 1,000, or more than 2,000
        free places.
    """

    point_m: Floats
    normal: Floats
    sigma_m: ArrayLike = 0.0005
    normal_sigma: ArrayLike = 0.1
    touch: ArrayLike | None = None
    free_m: ArrayLike | None = None

    def __post_init__(self) -> None:
        points = places_of(self.point_m, "point_m", far=False)
        n = len(points)
        require(FEWEST <= n <= MOST, f"a surface needs {FEWEST} to {MOST} contact points, got {n}")
        normals = places_of(self.normal, "normal")
        require(normals.shape == (n, 3), f"normal of {n} contact points must have shape ({n}, 3), got {normals.shape}")
        length = np.linalg.norm(normals, axis=1)
        require(length.min() > 1e-9, f"normal of contact point {int(length.argmin())} has no length; leave it out")
        object.__setattr__(self, "point_m", points)
        object.__setattr__(self, "normal", normals / length[:, None])
        for name in ("sigma_m", "normal_sigma"):
            value = _numbers(getattr(self, name), name)
            require(value.shape in ((), (n,)), f"{name} must be a number or {n} of them, got shape {value.shape}")
            require(
                np.isfinite(value).all() and value.min() > 0, f"{name} must be positive and finite, got {value.min()}"
            )
            object.__setattr__(self, name, np.broadcast_to(value, (n,)))
        touch = np.arange(n) if self.touch is None else as_given(self.touch, f"touch must be {n} whole numbers")
        require(
            touch.shape == (n,) and touch.dtype.kind in "iu",
            f"touch of {n} contact points must be {n} whole numbers, got {touch.dtype} of shape {touch.shape}",
        )
        object.__setattr__(self, "touch", touch)
        free = np.zeros((0, 3)) if self.free_m is None else places_of(self.free_m, "free_m", far=False)
        require(len(free) <= MOST_FREE, f"a surface takes up to {MOST_FREE} free places, got {len(free)}")
        object.__setattr__(self, "free_m", free)


def _numbers(given: ArrayLike, name: str) -> Floats:
    array = as_given(given, f"{name} must be numbers in an even array")
    require(array.dtype.kind in "iuf", f"{name} must be numbers in an even array, got {array.dtype}")
    return array.astype(np.float64)


def blocks(places: Floats) -> list[Floats]:
    """Return places (n, 3) in parts, so many of which are looked at at once; of none one part of none."""
    return [places[k : k + _BLOCK] for k in range(0, len(places), _BLOCK)] or [places]


def places_of(given: ArrayLike, name: str, *, far: bool = True) -> Floats:
    """Return points (n, 3) as numbers, refused where they are none, or (unless `far`) farther than a hand reaches."""
    out = _numbers(given, name)
    require(out.ndim == 2 and out.shape[1] == 3, f"{name} must have shape (n, 3), got {out.shape}")
    for row in np.flatnonzero(~np.isfinite(out).all(axis=1))[:1].tolist():
        raise InputError(f"{name} must be finite, got {out[row].tolist()} in row {row}")
    for row in np.flatnonzero(np.abs(out).max(axis=1, initial=0.0) > _REACH_M)[:1].tolist() if not far else ():
        raise InputError(f"{name} of row {row} is farther than {_REACH_M:g} m from the origin; give metres")
    return out
