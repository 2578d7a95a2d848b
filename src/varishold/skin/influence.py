"""Displacement under pressure on a grid of cells, and a rough inverse of it, by fast convolution."""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import numpy as np
import scipy.fft
from numpy.typing import NDArray

from varishold.skin.media import Cells, Medium

Floating = NDArray[np.floating[Any]]

__all__ = ["Influence", "influence_of"]

# Cells of silence around a box in which the preconditioner, which is periodic, is applied.
_GUARD = 8
# The preconditioner does not amplify what the medium hardly yields to (k = 0 of an incompressible layer).
_FLOOR = 1e-3


class Influence:
    """Displacement of every cell under pressures on all of them: a convolution that does not wrap around.

    Parameters
    ----------
    kernel : ndarray of shape (rows, cols), float64
        Displacement of cell (i, j) under a unit pressure on cell (0, 0).
    reach : (int, int)
        Cells along y and x beyond which the kernel is nothing.
    dtype : dtype
        float32 or float64: the precision of the transforms.
    """

    def __init__(self, kernel: NDArray[np.float64], reach: tuple[int, int], dtype: type[np.floating[Any]]) -> None:
        self.shape = kernel.shape
        self.own = float(kernel[0, 0])
        self.dtype = dtype
        padded = [n + min(n - 1, reach_n) for n, reach_n in zip(kernel.shape, reach, strict=True)]
        self._full = _good_size(padded[0], padded[1])
        self._symbol = _symbol(kernel, *self._full).astype(dtype)
        guard = [n + min(_GUARD, n - 1, reach_n) for n, reach_n in zip(kernel.shape, reach, strict=True)]
        self._periodic = _good_size(guard[0], guard[1])
        symbol = _symbol(kernel, *self._periodic)
        self._inverse = (1.0 / np.maximum(symbol, _FLOOR * symbol.max())).astype(dtype)

    def displacement(self, pressure: Floating) -> Floating:
        """Return the displacement, same shape as the pressure, whose last two axes are the cells."""
        return _filter(pressure, self._full, self._symbol)

    def inverse(self, displacement: Floating) -> Floating:
        """Return about the pressure that would make the displacement."""
        return _filter(displacement, self._periodic, self._inverse)


@lru_cache(maxsize=128)
def influence_of(medium: Medium, cells: Cells, rows: int, cols: int, *, single: bool = False) -> Influence:
    """Return the influence between `rows` x `cols` of the cells; kept for the next call."""
    kernel = _kernel(medium, cells)[:rows, :cols]
    reach_m = medium.reach_m
    reach = tuple(
        int(min(np.ceil(reach_m / side), 1e9)) if np.isfinite(reach_m) else int(1e9)
        for side in (cells.row_m, cells.col_m)
    )
    return Influence(kernel, (reach[0], reach[1]), np.float32 if single else np.float64)


@lru_cache(maxsize=16)
def _kernel(medium: Medium, cells: Cells) -> NDArray[np.float64]:
    return medium.influence(cells)


def _good_size(rows: int, cols: int) -> tuple[int, int]:
    return scipy.fft.next_fast_len(rows, real=True), scipy.fft.next_fast_len(cols, real=True)


def _symbol(kernel: NDArray[np.float64], rows: int, cols: int) -> NDArray[np.float64]:
    """Transform of the kernel continued evenly; real, because it is even."""
    away_y = np.minimum(np.arange(rows), rows - np.arange(rows))
    away_x = np.minimum(np.arange(cols), cols - np.arange(cols))
    even = kernel[np.minimum(away_y, kernel.shape[0] - 1)][:, np.minimum(away_x, kernel.shape[1] - 1)]
    even[away_y >= kernel.shape[0]] = 0.0
    even[:, away_x >= kernel.shape[1]] = 0.0
    return scipy.fft.rfft2(even).real


def _filter(field: Floating, size: tuple[int, int], symbol: Floating) -> Floating:
    spectrum = scipy.fft.rfft2(field, s=size)
    spectrum *= symbol
    out: Floating = scipy.fft.irfft2(spectrum, s=size, overwrite_x=True)
    return out[..., : field.shape[-2], : field.shape[-1]]
