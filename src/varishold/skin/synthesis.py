"""The forward model of analysis by synthesis: a frame from a face, with its gradients.

`press` solves a contact to a hundred-thousandth on a fine grid; a fit needs a hundred contacts a frame, one
percent of the taxels' peak, and how the frame changes with the face. On a coarse grid the pressure of a
known contact is one Cholesky factor away, and with the factor every derivative is a back-substitution.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
import scipy.fft
from numpy.typing import NDArray
from scipy.linalg.lapack import spotrf, spotrs

from varishold.errors import NotConvergedError
from varishold.kernel import address, bind
from varishold.sensor.cover import Skin
from varishold.skin.influence import influence_of
from varishold.skin.media import Cells, Medium, medium_of
from varishold.skin.nonnegative import solve_nonnegative
from varishold.skin.transmission import Transmission

__all__ = ["CoarseFace", "Synthesis", "Synthetic", "synthesis_of"]

_fill = bind("vh_toeplitz", "pippip")

Floats = NDArray[np.float64]
Floating = NDArray[np.floating[Any]]
Mask = NDArray[np.bool_]

# Cells less covered than this carry no load that taxels could tell.
_LEAST_COVER = 0.003
# Cells less covered than this yield so much more that their load fades evenly as a wall moves out of them.
_THIN_COVER = 0.03
# Changes of the contact within one face; a warm start needs two or three.
_MOST_CHANGES = 12
# A gap below this share of the depth is an overlap, not a rounding error of single precision.
_OVERLAP = 1e-4
# Step in covered share for the slope of a partial cell's compliance.
_COVER_STEP = 1e-4
# Cells without a face are held this many depths away.
_NO_FACE = 100.0
# Conjugate gradients stop at this gap, as a share of the depth, or after so many steps.
_FINE_GAP, _FINE_STEPS = 3e-3, 60


@dataclass(frozen=True)
class CoarseFace:
    """A face over a grid of cells, with its gradients.

    Parameters
    ----------
    wanted : ndarray of shape (n_cells,), float64
        How far each cell would have to be pressed down to meet the face, as a share of the depth of its
        highest point; negative where the face lies above the free skin.
    covered : ndarray of shape (n_cells,), float64
        Share of each cell that lies under the face; below 1 where a wall crosses the cell, 0 beyond.
    d_wanted, d_covered : ndarray of shape (n_parameters, n_cells), float64
        Their derivatives by each parameter.
    """

    wanted: Floats
    covered: Floats
    d_wanted: Floats
    d_covered: Floats


@dataclass(frozen=True)
class Synthetic:
    """A frame that a face makes, for a depth and a contact modulus of 1.

    Parameters
    ----------
    frame : ndarray of shape (rows, cols), float64
        Mean stress over each taxel.
    gradient : ndarray of shape (n_parameters, rows, cols), float64
        Its derivative by each parameter.
    active : ndarray of shape (n_cells,), bool
        The cells in contact.
    pressure : ndarray of shape (n_cells,), float64
        Surface pressure.
    """

    frame: Floats
    gradient: Floats
    active: Mask
    pressure: Floats


class Synthesis:
    """The forward model over a window of taxels.

    Parameters
    ----------
    skin : Skin
        The skin.
    rows, cols : int
        Taxels of the window.
    pitch_m : (float, float)
        Row and column spacing of the taxels, metres.
    per_taxel : int
        Cells along each side of a taxel.
    """

    def __init__(self, skin: Skin, rows: int, cols: int, pitch_m: tuple[float, float], per_taxel: int) -> None:
        self.shape = (rows, cols)
        self.per_taxel = per_taxel
        self.cells = Cells(rows * per_taxel, cols * per_taxel, pitch_m[0] / per_taxel, pitch_m[1] / per_taxel)
        self._medium = medium_of(skin)
        self._kernel = _kernel(self._medium, self.cells)
        self._influence = influence_of(self._medium, self.cells, self.cells.rows, self.cells.cols, single=True)
        self._transmission = Transmission(self._medium, self.cells, skin.sensing_depth_m, per_taxel, np.float32)
        row, col = np.indices((self.cells.rows, self.cells.cols))
        self._row, self._col = row.ravel(), col.ravel()

    @property
    def points_m(self) -> tuple[Floats, Floats]:
        """Middles (x, y) of the cells, metres from the window's centre, each of shape (n_cells,)."""
        c = self.cells
        x = (self._col.astype(np.float64) + 0.5 - c.cols / 2) * c.col_m
        y = (self._row.astype(np.float64) + 0.5 - c.rows / 2) * c.row_m
        return x, y

    def frame(self, face: CoarseFace, *, start: Mask | None = None) -> Synthetic:
        """Press a face in and return the frame with its gradients.

        The pressure minimizes p'Gp / 2 - p'w over p >= 0, w the wanted displacement. On its contact A,
        G_AA p_A = w_A, hence G_AA dp_A = dw_A - dS_A p_A, where S holds what partly covered cells add to
        their own compliance.

        Parameters
        ----------
        face : CoarseFace
        start : ndarray of shape (n_cells,), bool, optional
            Where to begin the search for the contact; default: wherever the face lies below the free skin.

        Returns
        -------
        Synthetic

        Raises
        ------
        NotConvergedError
            If nothing touches.

        References
        ----------
        M. Hintermueller, K. Ito and K. Kunisch, "The primal-dual active set strategy as a semismooth Newton
        method", SIAM J. Optim. 13, 2002.
        """
        allowed, part, spring = self._springs(face)
        active = allowed & (face.wanted > 0) if start is None or not (start & allowed).any() else allowed & start
        shape = (self.cells.rows, self.cells.cols)
        pressure = np.zeros(face.wanted.shape, dtype=np.float32)
        for _ in range(_MOST_CHANGES):
            index = np.flatnonzero(active)
            if index.size == 0:
                raise NotConvergedError("nothing touches: the fitted face has left the contact")
            factor = self._factor(index, spring)
            p, _ = spotrs(factor, face.wanted[index].astype(np.float32))
            pressure[:] = 0.0
            pressure[index] = p
            gap = self._influence.displacement(pressure.reshape(shape)).ravel() + spring * pressure - face.wanted
            pulls = index[p < 0]
            joins = np.flatnonzero(allowed & ~active & (gap < -_OVERLAP))
            if pulls.size == 0 and joins.size == 0:
                break
            active[pulls] = False
            active[joins] = True
        index = index[p > 0]
        if pulls.size:
            # The last changes were few: drop them, and let the factor fit what is left.
            pressure[pressure < 0] = 0.0
            factor = self._factor(index, spring)
        change = face.d_wanted[:, index] - self._spring_change(face, part)[:, index] * pressure[index]
        d_pressure = np.zeros((len(change) + 1, face.wanted.size), dtype=np.float32)
        d_pressure[0] = pressure
        if len(change):
            solved, _ = spotrs(factor, np.asfortranarray(change.T, dtype=np.float32))
            d_pressure[1:, index] = solved.T
        frames = self._sensed(d_pressure)
        touching = np.zeros(face.wanted.shape, dtype=bool)
        touching[index] = True
        return Synthetic(frames[0], frames[1:], touching, pressure.astype(np.float64))

    def pressure(self, face: CoarseFace, *, start: Floats | None = None) -> Floats:
        """Return the pressure under a face by conjugate gradients: for grids too fine to factor.

        Parameters
        ----------
        face : CoarseFace
            Its gradients are not used.
        start : ndarray of shape (n_cells,), float64, optional
            Pressure to begin with.

        Returns
        -------
        ndarray of shape (n_cells,), float64
        """
        allowed, _, spring = self._springs(face)
        shape = (self.cells.rows, self.cells.cols)
        wanted = np.where(allowed, face.wanted, -_NO_FACE).reshape(shape).astype(np.float32)
        first = np.zeros_like(wanted) if start is None else np.where(allowed, start, 0.0).reshape(shape)
        own = spring.reshape(shape).astype(np.float32)
        ease = 1.0 / np.sqrt(1.0 + own / np.float32(self._influence.own))
        solved = solve_nonnegative(
            lambda p: self._influence.displacement(p) + own * p,
            lambda r: ease * self._influence.inverse(ease * r),
            wanted,
            first.astype(np.float32),
            tolerance=_FINE_GAP,
            max_iterations=_FINE_STEPS,
        )
        return np.asarray(solved.x.ravel(), dtype=np.float64)

    def sensed(self, pressure: Floats) -> Floats:
        """Return the mean stress over each taxel, shape (rows, cols), under a pressure of shape (n_cells,)."""
        out: Floats = self._sensed(pressure.astype(np.float32)[None])[0]
        return out

    def _springs(self, face: CoarseFace) -> tuple[Mask, Mask, Floats]:
        """Return which cells can carry load, which are partly covered, and what those add to their compliance."""
        allowed = face.covered > _LEAST_COVER
        spring = np.zeros_like(face.wanted)
        part = allowed & (face.covered < 1)
        spring[part] = self._partial(face.covered[part])
        return allowed, part, spring

    def _factor(self, index: NDArray[np.int64], spring: Floats) -> NDArray[np.float32]:
        matrix = _toeplitz(self._kernel, self._row[index], self._col[index])
        matrix.flat[:: len(index) + 1] += spring[index].astype(np.float32)
        factor, info = spotrf(matrix.T, lower=0, overwrite_a=1, clean=0)
        if info:
            raise NotConvergedError("the influence of the contact's cells on each other is not positive")
        out: NDArray[np.float32] = factor
        return out

    def _partial(self, covered: Floats) -> Floats:
        own = self._influence.own
        return self._medium.partial_cell(covered, own) + own * (1 - covered) * (_THIN_COVER / covered) ** 2

    def _spring_change(self, face: CoarseFace, part: Mask) -> Floats:
        out = np.zeros_like(face.d_covered)
        if part.any() and len(out):
            covered = face.covered[part]
            high = np.minimum(covered + _COVER_STEP, 1.0)
            low = covered - _COVER_STEP
            slope = (self._partial(high) - self._partial(low)) / (high - low)
            out[:, part] = slope * face.d_covered[:, part]
        return out

    def _sensed(self, pressures: Floating) -> Floats:
        """Transmit several pressures, shape (n, n_cells), to the taxels."""
        t, n = self._transmission, self.per_taxel
        rows, cols = self.cells.rows, self.cells.cols
        spectrum = scipy.fft.rfft2(pressures.reshape(-1, rows, cols), s=t.size)
        spectrum *= t.symbol
        stress = scipy.fft.irfft2(spectrum, s=t.size, overwrite_x=True)[:, :rows, :cols]
        frames: Floats = stress.reshape(-1, rows // n, n, cols // n, n).mean(axis=(2, 4)).astype(np.float64)
        return frames


@lru_cache(maxsize=64)
def synthesis_of(skin: Skin, rows: int, cols: int, pitch_m: tuple[float, float], per_taxel: int) -> Synthesis:
    """Return the forward model over a window; kept for the next call."""
    return Synthesis(skin, rows, cols, pitch_m, per_taxel)


@lru_cache(maxsize=64)
def _kernel(medium: Medium, cells: Cells) -> NDArray[np.float32]:
    return np.ascontiguousarray(medium.influence(cells)[: cells.rows, : cells.cols], dtype=np.float32)


def _toeplitz(kernel: NDArray[np.float32], row: NDArray[np.int64], col: NDArray[np.int64]) -> NDArray[np.float32]:
    """Return the influence of cells on each other, below and on the diagonal only."""
    n = row.shape[0]
    out = np.empty((n, n), dtype=np.float32)
    _fill(address(kernel), kernel.shape[1], address(row), address(col), n, address(out))
    return out
