"""What every elastic medium offers: its answer to a load, by wave number and by distance."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import numpy as np
import scipy.fft
from numpy.typing import NDArray

__all__ = ["MOST_CELLS", "Cells", "Medium", "cell_symbol", "wave_numbers"]

Floats = NDArray[np.float64]

#: More take a machine's memory.
MOST_CELLS = 2**25


@dataclass(frozen=True)
class Cells:
    """A grid of rectangular cells on which a pressure is constant.

    Parameters
    ----------
    rows, cols : int
        Cells along y and x.
    row_m, col_m : float
        Cell sides along y and x, metres.
    """

    rows: int
    cols: int
    row_m: float
    col_m: float


class Medium(Protocol):
    """A linear elastic body under normal, frictionless load, with a contact modulus of 1.

    Displacements are in metres for pressures in units of the contact modulus E / (1 - poisson^2).
    """

    def __hash__(self) -> int:
        """Media are small frozen values, so that what is computed for one can be kept."""

    @property
    def reach_m(self) -> float:
        """Distance beyond which a load is no longer felt, metres; infinite where there is none."""

    def compliance(self, k: Floats) -> Floats:
        """Surface displacement over surface pressure at wave number `k` (radians a metre), metres."""

    def transfer(self, k: Floats, depth_m: float) -> Floats:
        """Normal stress `depth_m` under the surface over the surface pressure, at wave number `k`."""

    def influence(self, cells: Cells) -> Floats:
        """Displacement of cell (i, j) under a unit pressure on cell (0, 0), shape (rows, cols), metres."""

    def partial_cell(self, fraction: Floats, own: float) -> Floats:
        """Compliance added to a cell of which only `fraction` is loaded; `own` is a whole cell's, metres."""


def wave_numbers(rows: int, cols: int, row_m: float, col_m: float) -> tuple[Floats, Floats]:
    """Return the wave numbers along y (rows,) and x (cols // 2 + 1,) of a real transform, radians a metre."""
    ky: Floats = 2 * np.pi * scipy.fft.fftfreq(rows, row_m)
    kx: Floats = 2 * np.pi * scipy.fft.rfftfreq(cols, col_m)
    return ky, kx


def cell_symbol(
    response: Callable[[Floats], Floats],
    rows: int,
    cols: int,
    row_m: float,
    col_m: float,
    *,
    aliases: int = 3,
) -> Floats:
    """Return the periodic symbol of a response between cell loads and cell means.

    A load that is constant on cells has spectrum beyond the grid's Nyquist number, and so has its
    answer; both fold back. Summing the folded parts keeps the symbol positive where the response is.

    Parameters
    ----------
    response : callable
        Isotropic response as a function of the wave number.
    rows, cols, row_m, col_m
        The periodic grid.
    aliases : int
        How many foldings to sum on each side.

    Returns
    -------
    ndarray of shape (rows, cols // 2 + 1), float64
    """
    ky, kx = wave_numbers(rows, cols, row_m, col_m)
    total = np.zeros((ky.size, kx.size))
    for i in range(-aliases, aliases + 1):
        fold_y = ky + 2 * np.pi * i / row_m
        mean_y = np.sinc(fold_y * row_m / (2 * np.pi)) ** 2
        for j in range(-aliases, aliases + 1):
            fold_x = kx + 2 * np.pi * j / col_m
            mean_x = np.sinc(fold_x * col_m / (2 * np.pi)) ** 2
            total += response(np.hypot(fold_y[:, None], fold_x[None, :])) * mean_y[:, None] * mean_x[None, :]
    return total
