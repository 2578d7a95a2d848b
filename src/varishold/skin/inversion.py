"""From a frame back to the pressure on the skin: the operators, computed once, and the solve."""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import numpy as np
import scipy.fft
from numpy.typing import NDArray

from varishold.sensor.cover import Skin
from varishold.skin.influence import influence_of
from varishold.skin.media import Cells, medium_of, wave_numbers
from varishold.skin.nonnegative import solve_nonnegative
from varishold.skin.transmission import Transmission

__all__ = ["Inversion", "inversion_of"]

Floats = NDArray[np.float64]
Floating = NDArray[np.floating[Any]]

# The gradient may remain at this share of the data's own.
_TOLERANCE = 3e-3
_MOST_ITERATIONS = 60
# Share of the penalty that the pad's outermost cells bear.
_RIM_PENALTY = 0.5
# Up to so many taxels a matrix is faster than transforms, whose cost is then mostly the calls.
_MATRIX_TAXELS = 320


class Inversion:
    """Pressure from a frame by regularized, non-negative least squares, and displacement from pressure.

    Parameters
    ----------
    skin : Skin
        The skin.
    rows, cols : int
        Taxels.
    spacing : (float, float)
        (row, column) spacing of the taxels, metres.
    penalty : float
        Penalty on the square of the pressure, as a share of its own even transmission.
    per_taxel : int
        Cells of the pressure along each side of a taxel.
    """

    def __init__(
        self, skin: Skin, rows: int, cols: int, spacing: tuple[float, float], penalty: float, per_taxel: int
    ) -> None:
        n = per_taxel
        self.cells = Cells(rows * n, cols * n, spacing[0] / n, spacing[1] / n)
        self.shape = (rows * n, cols * n)
        medium = medium_of(skin)
        self._transmission = Transmission(medium, self.cells, skin.sensing_depth_m, n, np.float32)
        self._influence = influence_of(medium, self.cells, *self.shape, single=True)
        # B B' has the gain 1 / n^2 at an even load.
        self._penalty = np.float32(penalty / n**2)
        # Where a face goes on beyond the pad, its pressure is singular along the pad's border.
        self._penalties = np.full(self.shape, self._penalty, dtype=np.float32)
        for rim in (self._penalties[:1], self._penalties[-1:], self._penalties[:, :1], self._penalties[:, -1:]):
            rim[...] = self._penalty * np.float32(_RIM_PENALTY)
        size = self._size = self._transmission.size
        ky, kx = wave_numbers(*size, self.cells.row_m, self.cells.col_m)
        mean = np.outer(np.sinc(ky * spacing[0] / (2 * np.pi)), np.sinc(kx * spacing[1] / (2 * np.pi)))
        symbol = self._transmission.symbol
        normal = (symbol * mean / n) ** 2 + self._penalty
        self._inverse = (1.0 / normal).astype(np.float32)
        self._matrix: Floating | None = None
        if rows * cols <= _MATRIX_TAXELS:
            units = np.eye(rows * cols, dtype=np.float32).reshape(rows * cols, rows, cols)
            matrix = np.stack([self._transmission.adjoint(unit).ravel() for unit in units]).astype(np.float64)
            # Woodbury's identity: (L + M'M)^-1 = L^-1 - L^-1 M' (1 + M L^-1 M')^-1 M L^-1.
            core = np.linalg.inv(np.eye(rows * cols) + (matrix / self._penalties.ravel()) @ matrix.T)
            self._matrix, self._core = matrix.astype(np.float32), core.astype(np.float32)
        # Frame noise is white over taxels; B' spreads it over n^2 cells each with the weight 1 / n^2.
        k = np.hypot(ky[:, None], kx[None, :])
        k[0, 0] = min(ky[1], kx[1])
        gain = medium.compliance(k) * symbol * mean / n**2 / normal
        twice = np.full(kx.shape, 2.0)
        twice[0] = 1.0
        power = np.sum((gain * mean) ** 2 * twice[None, :]) / (size[0] * size[1])
        self.noise_gain = float(np.sqrt(power * n**2))

    def pressure(self, frame: Floating, start: Floats | None) -> tuple[Floats, int]:
        """Return the pressure that makes a frame, from a first guess if there is one, and the steps taken."""
        b = self._transmission.adjoint(frame)
        first = np.maximum(self._precondition(b), 0) if start is None else start.astype(np.float32)
        solved = solve_nonnegative(
            self._normal,
            self._precondition,
            b,
            first,
            tolerance=_TOLERANCE * float(np.sqrt(np.mean(b * b))),
            max_iterations=_MOST_ITERATIONS,
        )
        return solved.x.astype(np.float64), solved.iterations

    def _normal(self, pressure: Floating) -> Floating:
        if self._matrix is not None:
            seen: Floating = (self._matrix.T @ (self._matrix @ pressure.ravel())).reshape(pressure.shape)
        else:
            seen = self._transmission.adjoint(self._transmission.forward(pressure))
        return seen + self._penalties * pressure

    def displacement(self, pressure: Floats) -> Floats:
        """Return how far a pressure presses the surface down, for a contact modulus of 1."""
        return self._influence.displacement(pressure.astype(np.float32)).astype(np.float64)

    def _precondition(self, residual: Floating) -> Floating:
        if self._matrix is not None:
            first = (residual / self._penalties).ravel()
            taken = (self._matrix.T @ (self._core @ (self._matrix @ first))).reshape(residual.shape)
            return first.reshape(residual.shape) - taken / self._penalties
        spectrum = scipy.fft.rfft2(residual, s=self._size)
        spectrum *= self._inverse
        out: Floating = scipy.fft.irfft2(spectrum, s=self._size, overwrite_x=True)
        return out[: residual.shape[0], : residual.shape[1]]


@lru_cache(maxsize=32)
def inversion_of(
    skin: Skin, rows: int, cols: int, spacing: tuple[float, float], penalty: float, per_taxel: int
) -> Inversion:
    """Return the operators of a skin and a pad; kept for the next call."""
    return Inversion(skin, rows, cols, spacing, penalty, per_taxel)
