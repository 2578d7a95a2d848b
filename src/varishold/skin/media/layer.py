"""An elastic layer bonded to a rigid floor."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
import scipy.fft
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline
from scipy.special import j0

from varishold.errors import InputError
from varishold.skin.media.half_space import HalfSpace
from varishold.skin.media.medium import MOST_CELLS, Cells, cell_symbol

__all__ = ["Layer"]

Floats = NDArray[np.float64]

# Beyond this k h a layer and a half-space agree to double precision, and cosh has not overflowed.
_DEEP = 18.0
# Below this k h the closed form cancels; its series is exact to double precision.
_SHALLOW = 1e-3
# At worst (Poisson's ratio .5) a load fades to a half every thickness; a millionth is left after these many.
_REACH_THICKNESSES = 20.0
# A layer of fewer cells than this has no smooth part; its influence is found on the grid.
_THIN_CELLS = 4.0


@dataclass(frozen=True)
class Layer:
    """A layer of given thickness on a rigid floor to which it sticks.

    Parameters
    ----------
    thickness_m : float
        Thickness h, metres.
    poisson : float
        Poisson's ratio in (-1, .5]. At .5 the layer does not yield to an even load (k = 0).

    References
    ----------
    R. H. Bentall and K. L. Johnson, "An elastic strip in plane rolling contact", Int. J. Mech. Sci. 10,
    1968; A. W. Bower's and J. R. Barber's texts give the same transform. The stress inside follows from
    Airy's function f(z) exp(i k x) with f = cosh z + B (z cosh z - sinh z) + D z sinh z (z in units of
    1 / k), which has no shear at the surface; B and D make both displacements vanish at the floor.
    """

    thickness_m: float
    poisson: float

    @property
    def reach_m(self) -> float:
        return _REACH_THICKNESSES * self.thickness_m

    def compliance(self, k: Floats) -> Floats:
        """(2 / k) [(3 - 4 nu) sinh 2a - 2a] / [(3 - 4 nu) cosh 2a + 2a^2 + 5 - 12 nu + 8 nu^2], a = k h."""
        h, nu = self.thickness_m, self.poisson
        a = np.asarray(k, dtype=np.float64) * h
        out = np.empty_like(a)
        shallow, deep = a < _SHALLOW, a > _DEEP
        middle = ~(shallow | deep)
        out[deep] = 2.0 * h / a[deep]
        series = (4 - 8 * nu) + (3 - 4 * nu) * (4 / 3) * a[shallow] ** 2
        out[shallow] = 2.0 * h * series / (8 * (1 - nu) ** 2 + (8 - 8 * nu) * a[shallow] ** 2)
        m = a[middle]
        over = (3 - 4 * nu) * np.cosh(2 * m) + 2 * m * m + 5 - 12 * nu + 8 * nu * nu
        out[middle] = 2.0 * h / m * ((3 - 4 * nu) * np.sinh(2 * m) - 2 * m) / over
        return out

    def transfer(self, k: Floats, depth_m: float) -> Floats:
        """f(k d) of the class's reference, a half-space's beyond k h = 18."""
        h, nu = self.thickness_m, self.poisson
        a = np.asarray(k, dtype=np.float64) * h
        deep = a > _DEEP
        out = HalfSpace().transfer(np.asarray(k, dtype=np.float64), depth_m)
        a = a[~deep]
        t = np.tanh(a)
        # Rows (1 - nu) f'' + nu f = 0 and (1 - nu) f''' - (2 - nu) f' = 0 at z = a, divided by cosh a.
        even = (1 - nu) + nu
        even_b = (1 - nu) * (t + a) + nu * (a - t)
        even_d = (1 - nu) * (2 + a * t) + nu * a * t
        odd = ((1 - nu) - (2 - nu)) * t
        odd_b = (1 - nu) * (2 + a * t) - (2 - nu) * a * t
        odd_d = (1 - nu) * (3 * t + a) - (2 - nu) * (t + a)
        determinant = even_b * odd_d - even_d * odd_b
        b = (-even * odd_d + even_d * odd) / determinant
        d = (-even_b * odd + even * odd_b) / determinant
        z = a * (depth_m / h)
        out[~deep] = np.cosh(z) + b * (z * np.cosh(z) - np.sinh(z)) + d * z * np.sinh(z)
        return out

    def influence(self, cells: Cells) -> Floats:
        """A half-space's influence less what the floor holds back, which is smooth over a thickness."""
        if self.thickness_m < _THIN_CELLS * max(cells.row_m, cells.col_m):
            return self._thin_influence(cells)
        y = np.arange(cells.rows)[:, None] * cells.row_m
        x = np.arange(cells.cols)[None, :] * cells.col_m
        r = np.hypot(y, x)
        held = _held_back(self)(np.minimum(r, self.reach_m)) * (cells.row_m * cells.col_m)
        return np.where(r < self.reach_m, HalfSpace().influence(cells) + held, 0.0)

    def _thin_influence(self, cells: Cells) -> Floats:
        """Inverse transform of the compliance, on a period so long that its images do not meet."""
        most = [2 * n + int(self.reach_m / side) for n, side in ((cells.rows, cells.row_m), (cells.cols, cells.col_m))]
        if most[0] * most[1] > MOST_CELLS:
            raise InputError(
                f"cells of {cells.row_m:g} x {cells.col_m:g} m are too oblong for a layer of {self.thickness_m:g} m; "
                "give a pitch_m that is more alike both ways, or a thinner skin"
            )
        rows, cols = (scipy.fft.next_fast_len(n, real=True) for n in most)
        symbol = cell_symbol(self.compliance, rows, cols, cells.row_m, cells.col_m)
        kernel: Floats = scipy.fft.irfft2(symbol, s=(rows, cols))
        return np.ascontiguousarray(kernel[: cells.rows, : cells.cols])

    def partial_cell(self, fraction: Floats, own: float) -> Floats:
        """As a half-space's, for a cell is small against the thickness."""
        return HalfSpace().partial_cell(fraction, own)


@lru_cache(maxsize=8)
def _held_back(layer: Layer) -> CubicSpline:
    """Green's function less a half-space's, over the distance: a Hankel transform of order 0."""
    top = _DEEP / layer.thickness_m
    # Panels short enough that no more than a period of the Bessel function falls into one.
    node, weight = np.polynomial.legendre.leggauss(20)
    edges = np.linspace(0.0, top, 61)
    half = np.diff(edges)[:, None] / 2
    k = (edges[:-1, None] + half + half * node).ravel()
    spectrum = (layer.compliance(k) * k - 2.0) * (half * weight).ravel() / (2 * np.pi)
    r = np.linspace(0.0, layer.reach_m, 1000)
    return CubicSpline(r, j0(r[:, None] * k[None, :]) @ spectrum)
