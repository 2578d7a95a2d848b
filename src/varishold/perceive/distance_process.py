"""The Gaussian process of how far a surface strays from a plain body, told by points, normals and free places."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.typing import NDArray

from varishold._lazy import missing_extra
from varishold.perceive.plain_body import PlainBody, plain_bodies
from varishold.perceive.surface_points import FEWEST, SurfaceContacts, blocks

__all__ = ["DistanceProcess", "Straying", "likeliest_process"]

Floats = NDArray[np.float64]

# Lengths over which the surface varies, and by how much, that are tried. Metres.
_LENGTHS_M, _AMPLITUDES_M = (0.02, 0.035, 0.06, 0.1), (0.002, 0.004, 0.008, 0.016)

# What stands may vary so much more slowly upward than sideways: the length upward in parts of that sideways.
_UPRIGHT = (1.0, 3.0)

# They are chosen on so many points at most.
_CHOSEN_ON = 120

# A free place that the surface would hold lies so far outside, half as much as a finger is thick on either side of its
# middle, and the standard deviation of that. Metres.
_FREE_M, _FREE_SIGMA_M = 0.004, 0.0005


@dataclass(frozen=True)
class Straying:
    """How a surface strays from its plain body: over which length, by how much, and how much slower upward.

    Parameters
    ----------
    length_m, amplitude_m : float
        Of a Matern process of order 5/2. Metres.
    upright : float
        Its length upward in parts of that sideways.
    """

    length_m: float
    amplitude_m: float
    upright: float


class DistanceProcess:
    """The process with one body, length and amplitude, given some of the contacts and free places."""

    def __init__(
        self,
        contacts: SurfaceContacts,
        some: NDArray[np.int64],
        body: PlainBody,
        shape: Straying,
        free_m: Floats | None = None,
    ) -> None:
        try:
            from scipy.linalg import cho_solve, cholesky, solve_triangular
        except ModuleNotFoundError as error:
            raise missing_extra(error) from None
        self._solve = solve_triangular
        self.body, self.shape = body, shape
        # Upward all is measured in a longer unit, so that one length serves all ways; slopes grow by as much.
        unit = np.array([1.0, 1.0, shape.upright])
        self._unit = unit
        points, normals = contacts.point_m[some], contacts.normal[some]
        self._points = points if free_m is None else np.vstack([points, free_m])
        self._sloped = len(points)
        value = -body.distance(self._points)
        slope = (normals.T - body.slope(points)) * unit[:, None]
        noise = np.asarray(contacts.sigma_m)[some]
        if free_m is not None:
            value[len(points) :] += _FREE_M
            noise = np.concatenate([noise, np.full(len(free_m), _FREE_SIGMA_M)])
        told = np.concatenate([value, slope.ravel()])
        variance = np.concatenate([noise, np.outer(unit, np.asarray(contacts.normal_sigma)[some]).ravel()]) ** 2
        changes = (body.slope(points, change=True) * unit[:, None, None]).reshape(-1, len(body.numbers_m))
        self._change = np.concatenate([body.change(self._points), changes])
        k = self._rows(self._points, slopes=True) + self._change @ self._change.T
        k[np.diag_indices(len(k))] += variance
        self._root = cholesky(k, lower=True)
        self._weight = cho_solve((self._root, True), told)
        #: Log of the marginal likelihood, up to a constant.
        self.evidence = -0.5 * float(told @ self._weight) - float(np.log(np.diag(self._root)).sum())
        self.evidence += len(points) * float(np.log(shape.upright))

    def _rows(self, places: Floats, others: Floats | None = None, *, slopes: bool = False) -> Floats:
        """Covariance of the deviation at places (and its slope at the sloped ones) with that at others, or all told."""
        n = self._sloped if others is None else 0
        a, s2 = np.sqrt(5) / self.shape.length_m, self.shape.amplitude_m**2
        apart = (places[:, None, :] - (self._points if others is None else others)) / self._unit
        ar = a * np.sqrt((apart**2).sum(axis=-1))
        fade = s2 * np.exp(-ar)
        bend = a * a / 3 * (1 + ar) * fade
        across = np.moveaxis(bend[:, :n, None] * apart[:, :n], -1, 1)
        values = np.concatenate([(1 + ar + ar**2 / 3) * fade, across.reshape(len(places), 3 * n)], axis=1)
        if not slopes:
            return values
        d, g, f = apart[:n, :n], bend[:n, :n], a**4 / 3 * fade[:n, :n]
        blocks = [
            np.concatenate(
                [-bend[:n] * apart[:n, :, i], *(g * (i == j) - f * d[..., i] * d[..., j] for j in range(3))], 1
            )
            for i in range(3)
        ]
        return np.concatenate([values, *blocks])

    def mean(self, places: Floats) -> Floats:
        """Signed distance at places."""
        parts = [self._told(part) @ self._weight for part in blocks(places)]
        out: Floats = self.body.distance(places) + np.concatenate(parts)
        return out

    def sigma(self, places: Floats) -> Floats:
        """Its standard deviation, as the process has it."""
        parts = [(self._solve(self._root, self._told(part).T, lower=True) ** 2).sum(axis=0) for part in blocks(places)]
        before = self.sigma_before(places) ** 2
        out: Floats = np.sqrt(np.maximum(before - np.concatenate(parts), 1e-12))
        return out

    def sigma_before(self, places: Floats) -> Floats:
        """Its standard deviation before anything was touched."""
        out: Floats = np.sqrt(self.shape.amplitude_m**2 + (self.body.change(places) ** 2).sum(axis=1))
        return out

    def covariance(self, places: Floats, others: Floats) -> Floats:
        """Covariance of the distance at places and at others."""
        one, other = (self._solve(self._root, self._told(each).T, lower=True) for each in (places, others))
        before = self._rows(places, others) + self.body.change(places) @ self.body.change(others).T
        out: Floats = before - one.T @ other
        return out

    def _told(self, places: Floats) -> Floats:
        out: Floats = self._rows(places) + self.body.change(places) @ self._change.T
        return out

    def odd(self, contacts: SurfaceContacts, some: NDArray[np.int64]) -> Floats:
        """How many standard deviations each of these points is off what other touches say; 0 of very few touches."""
        touch = np.asarray(contacts.touch)[some]
        n, touches = len(touch), np.unique(touch)
        out = np.zeros(n)
        if len(touches) < FEWEST:
            return out
        inverse = self._solve(self._root, np.eye(len(self._root)), lower=True)
        inverse = inverse.T @ inverse
        for each in touches:
            own = np.flatnonzero(touch == each)
            rows = np.concatenate([own, *(n + k * n + own for k in range(3))])
            left = np.linalg.inv(inverse[np.ix_(rows, rows)])
            out[own] = np.abs((left @ self._weight[rows])[: len(own)]) / np.sqrt(np.diag(left)[: len(own)])
        return out


def likeliest_process(contacts: SurfaceContacts, some: NDArray[np.int64], *, stands: bool) -> DistanceProcess:
    """The process on these points, with the body, length and amplitude that make them likeliest."""
    bodies = plain_bodies(contacts.point_m[some], contacts.normal[some], stands=stands)
    few = some[_spread_out(contacts.point_m[some], _CHOSEN_ON)]
    shapes = [Straying(*each) for each in product(_LENGTHS_M, _AMPLITUDES_M, _UPRIGHT if stands else (1.0,))]
    best = max(
        (DistanceProcess(contacts, few, *each) for each in product(bodies, shapes)), key=lambda each: each.evidence
    )
    return DistanceProcess(contacts, some, best.body, best.shape)


def _spread_out(points: Floats, most: int) -> NDArray[np.int64]:
    """Indices of at most so many points, each the farthest from those before it: their order does not matter."""
    if len(points) <= most:
        return np.arange(len(points))
    away = ((points - points.mean(axis=0)) ** 2).sum(axis=1)
    chosen = [int(away.argmax())]
    away = np.full(len(points), np.inf)
    while len(chosen) < most:
        away = np.minimum(away, ((points - points[chosen[-1]]) ** 2).sum(axis=1))
        chosen.append(int(away.argmax()))
    return np.array(chosen)
