"""What a sensor lost of a contact, and what was done about it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from varishold.levelset.contact import Borders

__all__ = ["ContactState", "Losses"]


@dataclass(frozen=True, eq=False)
class Losses:
    """What a sensor lost of a frame.

    Parameters
    ----------
    repaired : ndarray of shape (rows, cols), bool, or None
        Where a broken taxel was filled from its neighbours; None for nowhere.
    saturated : ndarray of shape (rows, cols), bool, or None
        Where the stress is at least the frame's.
    beneath : float
        What every taxel that felt anything felt more than the frame holds, in its unit.
    stands : ndarray of shape (rows, cols), bool, or None
        Where a taxel stands, of a frame that was made from taxels on no grid; None for everywhere.
    """

    repaired: NDArray[np.bool_] | None = None
    saturated: NDArray[np.bool_] | None = None
    beneath: float = 0.0
    stands: NDArray[np.bool_] | None = None


@dataclass(frozen=True)
class ContactState:
    """What a sensor lost of one contact.

    Parameters
    ----------
    repaired : int
        Taxels of it that are broken, and were filled from their neighbours.
    saturated : int
        Taxels of it of which only the least that they can have felt is known.
    cut : Borders
        The borders of the field at which it ends, where the object may go on.
    beneath : float
        What its taxels felt more than the frame holds, in the frame's unit.
    """

    repaired: int
    saturated: int
    cut: Borders
    beneath: float
