"""What the contacts of one frame share."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from varishold.levelset.columns import N_COLUMNS, N_PLACES
from varishold.levelset.contact_state import Losses

__all__ = ["Frame"]

_NOTHING = Losses()


@dataclass(frozen=True, eq=False)
class Frame:
    """What the contacts of one frame share; each contact is a view into it.

    Parameters
    ----------
    shape : (int, int)
        Rows and columns.
    n_levels, n_contacts : int
    taxels : ndarray, float64
        `padded`, `label` and `dead`, one after the other, as the kernel writes them.
    found : ndarray, float64
        `values`, `measures`, `counts` and `places`, the same.
    sigma : float
        Standard deviation of the frame's noise; NaN where it has not been asked for.
    pitch : (float, float) or None
        Row and column spacing, metres.
    rest : (float, float, float)
        The rest that was taken off: at the first taxel, its rise by column and by row; zeros where none was.
    losses : Losses
        What the sensor lost.
    """

    shape: tuple[int, int]
    n_levels: int
    n_contacts: int
    taxels: NDArray[np.float64]
    found: NDArray[np.float64]
    sigma: float
    pitch: tuple[float, float] | None
    rest: tuple[float, float, float]
    losses: Losses = _NOTHING

    @cached_property
    def padded(self) -> NDArray[np.float64]:
        """The frame with broken taxels filled and one taxel of rim; -inf where there is no taxel."""
        rows, cols = self.shape
        return self.taxels[: (rows + 2) * (cols + 2)].reshape(rows + 2, cols + 2)

    @cached_property
    def label(self) -> NDArray[np.int32]:
        """The index of each taxel's contact, -1 for none; shape (rows + 2, cols + 2)."""
        size = self.padded.size
        return self.taxels[size:].view(np.int32)[:size].reshape(self.padded.shape)

    @cached_property
    def dead(self) -> NDArray[np.bool_]:
        """The taxels that read the rest while all around them is pressed; they are filled; shape (rows, cols)."""
        rows, cols = self.shape
        start = 4 * self.padded.size
        return self.taxels[self.padded.size :].view(np.bool_)[start : start + rows * cols].reshape(rows, cols)

    @cached_property
    def values(self) -> NDArray[np.float64]:
        """Each contact's peak and end, as `columns` names their places; shape (n_contacts, 2)."""
        return self.found[: 2 * self.n_contacts].reshape(-1, 2)

    @cached_property
    def measures(self) -> NDArray[np.float64]:
        """Each contact's measures, as `columns` names their places; shape (n_contacts, 25 * n_levels)."""
        start, size = 2 * self.n_contacts, N_COLUMNS * self.n_levels
        return self.found[start : start + self.n_contacts * size].reshape(self.n_contacts, size)

    @cached_property
    def counts(self) -> NDArray[np.int64]:
        """Each contact's parts and holes at each level; shape (n_contacts, 2, n_levels)."""
        n, levels = self.n_contacts, self.n_levels
        start = n * (2 + N_COLUMNS * levels)
        return self.found[start : start + 2 * n * levels].view(np.int64).reshape(n, 2, levels)

    @cached_property
    def places(self) -> NDArray[np.int64]:
        """Where each contact is in the padded frame, as `columns` names it; shape (n_contacts, 9)."""
        return self.found[self.found.size - N_PLACES * self.n_contacts :].view(np.int64).reshape(-1, N_PLACES)

    @cached_property
    def field(self) -> NDArray[np.bool_]:
        """Where there are taxels; shape (rows, cols)."""
        return self.padded[1:-1, 1:-1] > -np.inf
