"""A bed of independent springs."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from varishold.skin.media.medium import Cells

__all__ = ["Winkler"]

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Winkler:
    """Columns that yield each for itself, as a thin layer's do when it is pressed evenly.

    Parameters
    ----------
    thickness_m : float
        Length of the columns, metres.
    poisson : float
        Poisson's ratio in (-1, .5).
    """

    thickness_m: float
    poisson: float

    @property
    def reach_m(self) -> float:
        return 0.0

    def compliance(self, k: Floats) -> Floats:
        """h (1 - 2 nu) / (1 - nu)^2 for every k."""
        nu = self.poisson
        return np.full_like(np.asarray(k, dtype=np.float64), self.thickness_m * (1 - 2 * nu) / (1 - nu) ** 2)

    def transfer(self, k: Floats, depth_m: float) -> Floats:
        """1: a column's stress is the same at every depth."""
        return np.ones_like(np.asarray(k, dtype=np.float64))

    def influence(self, cells: Cells) -> Floats:
        """One spring's compliance, and nothing elsewhere."""
        kernel = np.zeros((cells.rows, cells.cols))
        kernel[0, 0] = self.compliance(np.zeros(1))[0]
        return kernel

    def partial_cell(self, fraction: Floats, own: float) -> Floats:
        """Fewer springs carry the load: own (1 / f - 1)."""
        return own * (1.0 / fraction - 1.0)
