"""The pressure under a ball, a roller, a plate and a disc on an elastic medium, as tables that are quick to look up.

A ball and a roller press a disc and a strip that grow with depth; their profiles are solved for a row of depths, with
p >= 0 and a surface that meets the body where p > 0. A flat face is pressed all over, so that depth and slopes add.
Lengths are metres, pressures units of the contact modulus E / (1 - poisson^2).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline
from scipy.linalg import toeplitz
from scipy.ndimage import distance_transform_edt, map_coordinates
from scipy.sparse.linalg import LinearOperator, cg
from scipy.special import ellipe, ellipk, j0, j1

from varishold.skin.influence import influence_of
from varishold.skin.media import Cells, Layer

__all__ = ["FlatFace", "RoundFace", "flat_on_layer", "round_on_layer"]

Floats = NDArray[np.float64]

# Rings or strips of a contact, contacts that are solved, and the smallest one as a share of the widest.
_RINGS, _CONTACTS, _SMALLEST = 48, 16, 0.04
# Points of a profile's table, over the square of the distance.
_PROFILE = 65
# Cells along a flat face.
_CELLS = 48
# Beyond this k h a layer is a half-space to eight digits.
_DEEP = 10.0
# Nodes of a panel of a period at most, and how many periods of the narrowest strip are summed.
_NODES, _PERIODS = 8, 20.0


@dataclass(frozen=True, eq=False)
class RoundFace:
    """What a ball or a roller leaves, at any depth of a range.

    Parameters
    ----------
    depths_m : ndarray of shape (n_depths,), float64
        Depths that were solved, rising.
    reaches_m : ndarray of shape (n_depths,), float64
        Half the contact's breadth.
    peaks : ndarray of shape (n_depths,), float64
        The highest pressure, in the middle.
    profiles : ndarray of shape (n_depths, n), float64
        Square of the pressure over its peak, at even steps of the square of the distance over the reach.
    """

    depths_m: Floats
    reaches_m: Floats
    peaks: Floats
    profiles: Floats

    def reach_m(self, depth_m: Floats | float) -> Floats:
        """Return half the breadth of a contact so deep, metres; of the shape of the depth."""
        return self._at(self.reaches_m, self._log(depth_m))

    def pressure(self, distance_m: Floats, depth_m: Floats | float) -> Floats:
        """Return the pressure so far from the middle of a contact so deep; 0 beside it and where depth is not positive.

        Parameters
        ----------
        distance_m : ndarray of any shape, float64
        depth_m : float or ndarray that goes with it

        Returns
        -------
        ndarray of the shape of both
        """
        log = self._log(depth_m)
        reach, peak = self._at(self.reaches_m, log), self._at(self.peaks, log)
        row = np.interp(log, np.log(self.depths_m), np.arange(self.depths_m.size))
        away, last = np.square(distance_m / reach), self.profiles.shape[1] - 1
        if np.ndim(row) == 0:
            low = min(int(row), len(self.profiles) - 2)
            profile = (1 - (row - low)) * self.profiles[low] + (row - low) * self.profiles[low + 1]
            squares = np.interp(away, np.arange(last + 1) / last, profile)
        else:
            where = np.broadcast_arrays(row, np.minimum(away, 1.0) * last)
            squares = map_coordinates(self.profiles, where, order=1, mode="nearest")
        there = (away < 1.0) & (np.asarray(depth_m) > 0)
        return np.where(there, peak * np.sqrt(np.maximum(squares, 0.0)), 0.0)

    def _log(self, depth_m: Floats | float) -> Floats:
        return np.asarray(np.log(np.clip(depth_m, 1e-9 * self.depths_m[0], self.depths_m[-1])))

    def _at(self, values: Floats, log: Floats) -> Floats:
        return np.asarray(np.exp(_spline(self.depths_m.tobytes(), values.tobytes())(log)))


@lru_cache(maxsize=64)
def _spline(depths: bytes, values: bytes) -> CubicSpline:
    """Logarithm over logarithm, straight on below and above."""
    x, y = np.log(np.frombuffer(depths)), np.log(np.frombuffer(values))
    first, last = (y[1] - y[0]) / (x[1] - x[0]), (y[-1] - y[-2]) / (x[-1] - x[-2])
    far = 30.0
    x = np.concatenate([[x[0] - far], x, [x[-1] + far]])
    y = np.concatenate([[y[0] - far * first], y, [y[-1] + far * last]])
    return CubicSpline(x, y, bc_type=((1, first), (1, last)))


@dataclass(frozen=True, eq=False)
class FlatFace:
    """What a flat face leaves that is pressed by a metre, and sloped by a metre a metre.

    Pressure rises to infinity at the edge, as one over the root of the distance; kept is the part that does not.

    Parameters
    ----------
    half_m : float
        Half the face's breadth.
    shape : str
        "square" or "disc".
    level, sloped : ndarray of shape (n, n), float64
        Pressure over what rises, on cells all over the face's square, of a depth of 1 and of a slope of 1 along the
        columns.
    """

    half_m: float
    shape: Literal["square", "disc"]
    level: Floats
    sloped: Floats

    def pressure(
        self, u_m: Floats, v_m: Floats, depth_m: float, slope_u: float, slope_v: float, breadth_m: float
    ) -> Floats:
        """Return the mean pressure over points of some breadth, (u, v) from the middle of the face; 0 outside."""
        n = len(self.level)
        u, v = u_m / self.half_m, v_m / self.half_m
        table = depth_m * self.level + slope_u * self.sloped + slope_v * self.sloped.T
        at = [(np.clip(each, -1, 1) + 1) / 2 * n - 0.5 for each in np.broadcast_arrays(v, u)]
        smooth = map_coordinates(table, at, order=1, mode="nearest")
        return np.maximum(smooth, 0.0) * _rise(self.shape, u, v, breadth_m / self.half_m)


def _rise(shape: str, u: Floats, v: Floats, breadth: float) -> Floats:
    """Return the mean of 1 / sqrt(1 - s^2), s towards each edge of a face of half a breadth of 1; 0 outside."""

    def mean(s: Floats) -> Floats:
        ends = (np.arcsin(np.clip(s + way * breadth / 2, -1, 1)) for way in (-1, 1))
        low, high = ends
        return (high - low) / breadth

    return mean(np.hypot(u, v)) if shape == "disc" else mean(u) * mean(v)


@lru_cache(maxsize=32)
def round_on_layer(layer: Layer, radius_m: float, reach_m: float, shape: Literal["ball", "roller"]) -> RoundFace:
    """Return what a ball or a long roller leaves on a layer.

    Parameters
    ----------
    layer : Layer
    radius_m : float
        The ball's or the roller's.
    reach_m : float
        Half the breadth of the widest contact, less than the radius.
    shape : str
        "ball" or "roller".
    """
    compliance, rows = _COMPLIANCES[shape], []
    for reach in np.geomspace(_SMALLEST, 1.0, _CONTACTS) * reach_m:
        edges = np.linspace(0.0, reach, _RINGS + 1)
        middle = (edges[1:] + edges[:-1]) / 2
        gap = radius_m - np.sqrt(radius_m**2 - middle**2)
        level, hollow = np.linalg.solve(compliance(layer, edges, middle), np.stack([np.ones(_RINGS), gap], axis=1)).T
        depth = _smooth_edge(level, hollow, middle, reach)
        pressure = np.maximum(depth * level - hollow, 0.0)
        share = np.append(np.square(pressure / pressure[0]), 0.0)
        profile = np.interp(np.linspace(0, 1, _PROFILE), np.append(np.square(middle / reach), 1.0), share)
        rows.append((depth, reach, pressure[0], profile))
    depths, reaches, peak, profiles = (np.array(each) for each in zip(*rows, strict=True))
    return RoundFace(depths, reaches, peak, profiles)


@lru_cache(maxsize=32)
def flat_on_layer(layer: Layer, breadth_m: float, shape: Literal["square", "disc"]) -> FlatFace:
    """Return what a flat face leaves on a layer.

    Parameters
    ----------
    layer : Layer
    breadth_m : float
        Breadth of a square, diameter of a disc.
    shape : str
        "square" or "disc".
    """
    side = breadth_m / _CELLS
    influence = influence_of(layer, Cells(_CELLS, _CELLS, side, side), _CELLS, _CELLS)
    at = (np.arange(_CELLS) + 0.5) * side - breadth_m / 2
    x, y = np.meshgrid(at, at)
    inside = np.hypot(x, y) < breadth_m / 2 if shape == "disc" else np.ones(x.shape, np.bool_)
    number = int(inside.sum())

    def spread(values: Floats, by: str) -> Floats:
        field = np.zeros(x.shape)
        field[inside] = values
        return np.asarray(getattr(influence, by)(field)[inside])

    forward = LinearOperator((number, number), matvec=lambda p: spread(p, "displacement"), dtype=np.float64)
    inverse = LinearOperator((number, number), matvec=lambda w: spread(w, "inverse"), dtype=np.float64)
    nearest = distance_transform_edt(~inside, return_distances=False, return_indices=True)
    rise = _rise(shape, 2 * x / breadth_m, 2 * y / breadth_m, 2 / _CELLS)
    tables = []
    for depth in (np.ones(x.shape), x):
        pressure = np.zeros(x.shape)
        pressure[inside] = cg(forward, depth[inside], rtol=1e-5, maxiter=500, M=inverse)[0]
        tables.append((pressure / np.where(inside, rise, 1.0))[tuple(nearest)])
    return FlatFace(breadth_m / 2, shape, *tables)


def _smooth_edge(level: Floats, hollow: Floats, middle: Floats, edge: float) -> float:
    """Return the depth at which pressure falls to nothing at the edge as a square root, and rises nowhere to infinity.

    Near an edge pressure is A / sqrt(s) + B sqrt(s), s from the edge; A must be 0.
    """
    s = np.sqrt(edge - middle[-3:-1])
    terms = np.stack([1 / s, s], axis=1)
    of_level, of_hollow = (np.linalg.solve(terms, each[-3:-1])[0] for each in (level, hollow))
    return float(of_hollow / of_level)


def _of_rings(layer: Layer, edges: Floats, middle: Floats) -> Floats:
    """Return the displacement at each ring's middle under a unit pressure on each ring: a Hankel transform."""
    k, weight = _nodes(_DEEP / layer.thickness_m, 2 * edges[-1])
    held = (layer.compliance(k) - 2.0 / k) * weight
    discs = _of_disc(middle[:, None], edges[None, 1:])
    discs += (j0(middle[:, None] * k) * held) @ (edges[1:, None] * j1(edges[1:, None] * k)).T
    return np.diff(discs, axis=1, prepend=0.0)


def _of_disc(r: Floats, a: Floats) -> Floats:
    """Displacement of a half-space at r under a unit pressure on a disc of radius a (Johnson 1985, 3.4)."""
    inner, outer = np.minimum(r / a, 1.0) ** 2, np.minimum(a / r, 1.0) ** 2
    within = a * ellipe(inner)
    # What multiplies K goes to nothing faster than K grows.
    beyond = r * (ellipe(outer) - (1 - outer) * ellipk(np.minimum(outer, 1 - 1e-15)))
    return np.asarray(4 / np.pi * np.where(r < a, within, beyond))


def _of_strips(layer: Layer, edges: Floats, middle: Floats) -> Floats:
    """Return the displacement at each strip's middle under a unit pressure on it and on its twin beyond the middle."""
    n, breadth_m = middle.size, edges[1]
    k, weight = _nodes(2 * np.pi * _PERIODS / breadth_m, 2 * middle[-1])
    spectrum = 2 / np.pi * layer.compliance(k) * np.sin(k * breadth_m / 2) / k * weight
    away = np.array([np.cos(k * (j * breadth_m)) @ spectrum for j in range(2 * n)])
    # Strip j lies (j + 1/2) breadths from the middle, its twin as far on the other side.
    twins = away[np.add.outer(np.arange(n), np.arange(n)) + 1]
    return np.asarray(toeplitz(away[:n]) + twins)


_COMPLIANCES = {"ball": _of_rings, "roller": _of_strips}


def _nodes(top: float, longest_m: float) -> tuple[Floats, Floats]:
    """Return wave numbers up to a highest one, and weights, so close that a wave over the longest way is summed."""
    panels = int(np.ceil(top * longest_m / (2 * np.pi))) + 8
    node, weight = np.polynomial.legendre.leggauss(_NODES)
    edges = np.linspace(0.0, top, panels + 1)
    half = np.diff(edges)[:, None] / 2
    return (edges[:-1, None] + half + half * node).ravel(), (half * weight).ravel()
