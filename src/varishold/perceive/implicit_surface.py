"""The surface of a thing from where it was touched: a Gaussian process of the signed distance, with its uncertainty.

What is known are points of the surface, the outward normals there, and places where nothing is. A plain body (a ball,
or an upright bar on the table) is fitted first; the process models how far the true signed distance is off that body's.
"""

from __future__ import annotations

from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from varishold.errors import require, require_a
from varishold.frame.checks import is_number
from varishold.perceive.contour_mesh import SurfaceMesh, contour_mesh
from varishold.perceive.distance_bound import DistanceBound, cut_off, depth_behind
from varishold.perceive.distance_process import DistanceProcess, likeliest_process
from varishold.perceive.surface_points import FEWEST, SurfaceContacts, places_of

__all__ = ["ImplicitSurface"]

Floats = NDArray[np.float64]

# The share of left-out touches that the stated band must hold, its half width in standard deviations, and the factors
# that the standard deviation may be corrected by before the last one.
_BAND, _BAND_SIGMAS, _FACTORS = 0.9, 1.645, (1.0, 4.0)

# A surface is odder than the touches that are left out: these seek what a hand can reach, and corners lie between them.
# Settled on eighteen surfaces of known solids and lumps, of which the band then held .92.
_BETWEEN = 1.5

# Farther than this from all that was touched, the surface may turn away from what the process says: by so much for each
# metre beyond, times the part of the process's deviation that touches leave. Settled on thirteen kinds of solid touched
# on one half: the least with which the band holds .85 of the other half of each kind. Metres, 1.
_FAR_M, _TURNS = 0.025, 1.5

# A point that is off by more standard deviations than this is not believed.
_BELIED = 5.0

# The surface is looked for so far around what was touched, in parts of its greatest extent.
_MARGIN = 0.15


class ImplicitSurface:
    """The signed distance to a touched surface, positive outside, as a Gaussian process.

    Parameters
    ----------
    contacts : SurfaceContacts
    table_m : float, optional
        Height of the table on which the thing stands: nothing of it is below. Metres. Default: it hangs free.

    Raises
    ------
    InputError
        If the table's height is not finite, or lies above every point.
    MissingExtraError
        If SciPy is not installed.

    References
    ----------
    O. Williams and A. Fitzgibbon, "Gaussian process implicit surfaces", 2007. S. Dragiev, M. Toussaint and M. Gienger,
    "Gaussian process implicit surfaces for shape estimation and grasping", ICRA 2011, eq. 4 to 8: normals as
    observations of the derivative. C. E. Rasmussen and C. K. I. Williams, "Gaussian Processes for Machine Learning",
    2006, eq. 5.12 for what is left out.

    Examples
    --------
    >>> out = np.random.default_rng(1).normal(size=(40, 3))
    >>> out /= np.linalg.norm(out, axis=1, keepdims=True)
    >>> ball = ImplicitSurface(SurfaceContacts(0.04 * out, out))
    >>> distance, sigma = ball.distance([[0.05, 0.0, 0.0], [0.0, 0.0, 0.0]])
    >>> distance.round(3), bool(sigma.max() < 0.03)
    (array([ 0.01 , -0.039]), True)
    """

    def __init__(self, contacts: SurfaceContacts, *, table_m: float | None = None) -> None:
        require_a(SurfaceContacts, contacts, "contacts", "where a thing was touched")
        if table_m is not None:
            top = float(contacts.point_m[:, 2].max())
            require(
                is_number(table_m) and -np.inf < table_m < top,
                f"table_m must lie below the points' top {top:g}, got {table_m}",
            )
        self.contacts, self.table_m = contacts, table_m
        everything = np.arange(len(contacts.point_m))
        made = likeliest_process(contacts, everything, stands=table_m is not None)
        odd = made.odd(contacts, everything)
        #: Which of the contact points count: those that the points of other touches do not belie.
        self.kept = np.flatnonzero(odd < _BELIED)
        if FEWEST <= len(self.kept) < len(everything):
            made = likeliest_process(contacts, self.kept, stands=table_m is not None)
            odd = made.odd(contacts, self.kept)
        else:
            self.kept = everything
        #: The plain body that the surface is told from, and how far and how fast the surface strays from it.
        self.body, self.shape = made.body, made.shape
        #: By how much standard deviations are multiplied, so that nine tenths of left-out touches lie in their band.
        self.factor = _BETWEEN * float(np.clip(np.quantile(odd, _BAND) / _BAND_SIGMAS, *_FACTORS))
        #: What no number of touches tells better: how far all points may be off together. Metres.
        self.floor_m = float(np.median(np.asarray(contacts.sigma_m)))
        for _ in range(2):
            free = np.asarray(contacts.free_m)
            taken = free[made.mean(free) < 0] if len(free) else free
            if not len(taken):
                break
            made = DistanceProcess(contacts, self.kept, self.body, self.shape, taken)
        self._process = made
        points = contacts.point_m[self.kept]
        band = _BAND_SIGMAS * np.hypot(self.factor * made.sigma(points), self.floor_m)
        self._bound = DistanceBound(points, np.abs(made.mean(points)) + band)
        # How much one side alone was touched: 1 of one flat face, .4 of two that meet, 0 of half of a thing or more.
        self._one_sided = max(2 * float(np.linalg.norm(contacts.normal[self.kept].mean(axis=0))) - 1, 0.0)

    def distance(self, places_m: ArrayLike) -> tuple[Floats, Floats]:
        """Return the signed distance from the surface and its standard deviation.

        Parameters
        ----------
        places_m : array_like of shape (k, 3)
            Metres.

        Returns
        -------
        tuple of 2 ndarrays of shape (k,), float64
            Metres; positive outside. The table is not part of it. No more than how far touched points are.
        """
        places = places_of(places_m, "places_m")
        away, most = self._bound.at(places)
        sigma = self._process.sigma(places)
        turned = np.maximum(away - _FAR_M, 0.0) * sigma / self._process.sigma_before(places)
        # Behind one side alone a thing may end anywhere, however well the process knows how that side goes on.
        points, normals = self.contacts.point_m[self.kept], self.contacts.normal[self.kept]
        ends = self._one_sided * depth_behind(places, points, normals)
        wide = np.hypot(self.factor * sigma, _TURNS * np.maximum(turned, ends))
        mean, sigma = cut_off(self._process.mean(places), wide, most)
        return mean, np.hypot(sigma, self.floor_m)

    def covariance(self, places_m: ArrayLike, others_m: ArrayLike) -> Floats:
        """Return the covariance of the distance at places (n, 3) and at others (m, 3), metres; shape (n, m), m^2."""
        # It is the process's own: the bound has none.
        out = self._process.covariance(places_of(places_m, "places_m"), places_of(others_m, "others_m"))
        return self.factor**2 * out

    def mesh(self, *, steps: int = 30) -> SurfaceMesh:
        """Return the surface where the distance is zero as a closed mesh, with its standard deviation.

        Parameters
        ----------
        steps : int
            Steps of the grid along the greatest extent, 8 to 120.

        Raises
        ------
        InputError
            If there are fewer or more steps, or nothing is inside.
        """
        require(
            is_number(steps) and 8 <= steps <= 120, f"steps of a surface's grid must lie in 8 .. 120, got {steps!r}"
        )
        low, high = self.bounds_m
        pitch = float((high - low).max()) / steps
        shape = np.ceil((high - low) / pitch).astype(int) + 1
        grid = low + pitch * np.stack(np.meshgrid(*map(np.arange, shape), indexing="ij"), axis=-1)
        level = self._process.mean(grid.reshape(-1, 3)).reshape(shape)
        if self.table_m is not None:
            level = np.maximum(level, self.table_m - grid[..., 2])
        vertices, faces = contour_mesh(level, low, pitch)
        _, sigma = self.distance(vertices)
        return SurfaceMesh(vertices, faces, sigma)

    def least_known(self, mesh: SurfaceMesh | None = None) -> tuple[Floats, float]:
        """Return the place of the surface with the largest standard deviation, and that; the table's face is known."""
        mesh = self.mesh() if mesh is None else mesh
        require_a(SurfaceMesh, mesh, "mesh", "as mesh() makes it")
        seen = np.ones(len(mesh.vertices_m), bool)
        if self.table_m is not None:
            seen = mesh.vertices_m[:, 2] > self.table_m + 1e-4
        where = int(np.where(seen, mesh.sigma_m, -1.0).argmax())
        return mesh.vertices_m[where], float(mesh.sigma_m[where])

    @cached_property
    def bounds_m(self) -> tuple[Floats, Floats]:
        """The box in which the surface is looked for. Metres."""
        points = np.vstack([self.contacts.point_m, self.body.box()])
        low, high = points.min(axis=0), points.max(axis=0)
        if self.table_m is not None:
            low[2] = self.table_m
        margin = _MARGIN * float((high - low).max())
        low, high = low - margin, high + margin
        return low, high
