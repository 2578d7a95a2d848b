"""From the pressure on a skin's surface to the stress that its taxels read."""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import numpy as np
import scipy.fft
from numpy.typing import NDArray

from varishold.errors import InputError
from varishold.sensor.cover import Skin
from varishold.skin.media import MOST_CELLS, Cells, Medium, cell_symbol, medium_of

__all__ = ["Transmission", "transmission_of"]

Floating = NDArray[np.floating[Any]]

# The stress under a point load falls as the fifth power of the distance; beyond these depths it is nothing.
_REACH_DEPTHS = 8.0


class Transmission:
    """Mean stress over each taxel under a surface pressure on finer cells: B T of the reconstruction.

    Parameters
    ----------
    medium : Medium
        The elastic medium.
    cells : Cells
        Cells of the pressure.
    depth_m : float
        Sensing depth, metres.
    per_taxel : int
        Cells along each side of a taxel.
    dtype : dtype
        Precision of the transforms.

    Raises
    ------
    InputError
        If the cells are so small against the depth that no memory holds those that a load reaches.
    """

    def __init__(
        self, medium: Medium, cells: Cells, depth_m: float, per_taxel: int, dtype: type[np.floating[Any]]
    ) -> None:
        self.cells = cells
        self.per_taxel = per_taxel
        self.dtype = dtype
        reach = _REACH_DEPTHS * depth_m
        rows, cols = cells.rows + reach / cells.row_m, cells.cols + reach / cells.col_m
        if rows * cols > MOST_CELLS:
            least = per_taxel * reach / (MOST_CELLS**0.5 - max(cells.rows, cells.cols))
            raise InputError(
                f"taxels of {per_taxel * cells.row_m:g} x {per_taxel * cells.col_m:g} m lie too close for a sensing "
                f"depth of {depth_m:g} m, over which stress spreads; give a pitch_m of {least:.2g} or more, or a "
                "smaller sensing_depth_m"
            )
        self.size = (
            scipy.fft.next_fast_len(int(np.ceil(rows)), real=True),
            scipy.fft.next_fast_len(int(np.ceil(cols)), real=True),
        )
        if depth_m == 0:
            symbol = np.ones((self.size[0], self.size[1] // 2 + 1))
        else:
            symbol = cell_symbol(lambda k: medium.transfer(k, depth_m), *self.size, cells.row_m, cells.col_m, aliases=2)
        self.symbol = symbol.astype(dtype)

    def forward(self, pressure: Floating) -> Floating:
        """Return the mean stress over each taxel, shape (..., rows / per_taxel, cols / per_taxel)."""
        stress = self._spread(pressure)
        n = self.per_taxel
        if n == 1:
            return stress
        *more, rows, cols = stress.shape
        mean: Floating = stress.reshape(*more, rows // n, n, cols // n, n).mean(axis=(-3, -1))
        return mean

    def adjoint(self, frame: Floating) -> Floating:
        """Return the transpose of `forward` applied to a frame."""
        n = self.per_taxel
        if n > 1:
            frame = np.repeat(np.repeat(frame, n, axis=0), n, axis=1) / frame.dtype.type(n * n)
        return self._spread(frame)

    def _spread(self, field: Floating) -> Floating:
        spectrum = scipy.fft.rfft2(field, s=self.size)
        spectrum *= self.symbol
        out: Floating = scipy.fft.irfft2(spectrum, s=self.size, overwrite_x=True)
        return out[..., : field.shape[-2], : field.shape[-1]]


@lru_cache(maxsize=32)
def transmission_of(skin: Skin, cells: Cells, per_taxel: int, *, single: bool = False) -> Transmission:
    """Return the transmission of a skin; kept for the next call.

    Raises
    ------
    InputError
        If the cells are larger than the sensing depth, so that the stress there would not be resolved.
    """
    if 0 < skin.sensing_depth_m < max(cells.row_m, cells.col_m) * (1 - 1e-9):
        need = int(np.ceil(per_taxel * max(cells.row_m, cells.col_m) / skin.sensing_depth_m - 1e-9))
        raise InputError(
            f"the grid is too coarse for the sensing depth: cells of {max(cells.row_m, cells.col_m):g} m, "
            f"depth {skin.sensing_depth_m:g} m; use per_taxel={need} or more"
        )
    dtype = np.float32 if single else np.float64
    return Transmission(medium_of(skin), cells, skin.sensing_depth_m, per_taxel, dtype)
