"""An elastic body without a floor."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from varishold.skin.media.medium import Cells

__all__ = ["HalfSpace"]

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class HalfSpace:
    """A half-space: a load is felt everywhere, as 1 / (pi r).

    References
    ----------
    J. Boussinesq, "Application des potentiels", 1885. A. E. H. Love, "The stress produced in a
    semi-infinite solid by pressure on part of the boundary", Phil. Trans. R. Soc. A 228, 1929.
    """

    @property
    def reach_m(self) -> float:
        return np.inf

    def compliance(self, k: Floats) -> Floats:
        """2 / k; infinite at k = 0, for the whole body yields without end."""
        with np.errstate(divide="ignore"):
            return 2.0 / np.asarray(k, dtype=np.float64)

    def transfer(self, k: Floats, depth_m: float) -> Floats:
        """(1 + k d) exp(-k d)."""
        kd = np.asarray(k, dtype=np.float64) * depth_m
        return (1.0 + kd) * np.exp(-kd)

    def influence(self, cells: Cells) -> Floats:
        """Love's closed form at the centre of each cell."""
        y = ((np.arange(cells.rows + 1) - 0.5) * cells.row_m)[:, None]
        x = ((np.arange(cells.cols + 1) - 0.5) * cells.col_m)[None, :]
        corner = x * np.arcsinh(y / np.abs(x)) + y * np.arcsinh(x / np.abs(y))
        inside: Floats = corner[1:, 1:] - corner[:-1, 1:] - corner[1:, :-1] + corner[:-1, :-1]
        return inside / np.pi

    def partial_cell(self, fraction: Floats, own: float) -> Floats:
        """A load on a part of a cell sinks deeper as the part's side shrinks: own (1 / sqrt(f) - 1)."""
        return own * (1.0 / np.sqrt(fraction) - 1.0)
