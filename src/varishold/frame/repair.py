"""Dead and hot taxels and dead lines of one frame: found where the evidence is strong, and filled.

A dead taxel reads the rest while everything around it is pressed; a dead line does so along a whole row or column. A
hot taxel stands far above pressed neighbours that hardly fall among themselves, as no body that is pressed in does.
Nothing else is touched: a frame in which nothing is found stays as it is, to the last bit.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from varishold.frame.fill import fill_taxels
from varishold.frame.noise import noise_sigma
from varishold.kernel import address, bind, work_space

__all__ = ["Repaired", "repair"]

_find_dead = bind("vh_find_dead", "ppiidpp", "i")
_find_dead_work = bind("vh_find_dead_work", "ii", "z")
_find_hot = bind("vh_find_hot", "ppiidp", "i")


@dataclass(frozen=True)
class Repaired:
    """A frame whose dead and hot taxels are filled.

    Parameters
    ----------
    values : ndarray of shape (rows, cols), float64
        The frame; the same numbers where nothing was found.
    dead : ndarray of shape (rows, cols), bool
        The taxels that were filled.
    """

    values: NDArray[np.float64]
    dead: NDArray[np.bool_]


def repair(frame: ArrayLike, field: ArrayLike | None = None, valid: ArrayLike | None = None) -> Repaired:
    """Fill the taxels that read the rest while everything around them is pressed, and those that stick high there.

    Parameters
    ----------
    frame : array_like of shape (rows, cols), float or integer
        Finite inside the field; its rest is zero.
    field, valid : array_like of shape (rows, cols), bool, optional
        False where there is no taxel, and where a taxel is known to be broken (it is filled too).

    Returns
    -------
    Repaired

    Examples
    --------
    >>> import numpy as np
    >>> frame = np.zeros((12, 12))
    >>> frame[3:9, 3:9] = 1.0
    >>> frame[5, 6] = 0.0
    >>> mended = repair(frame)
    >>> round(float(mended.values[5, 6]), 6), int(mended.dead.sum())
    (1.0, 1)
    """
    values = np.array(frame, dtype=np.float64, order="C")
    inside = np.ones(values.shape, np.bool_) if field is None else np.array(field, dtype=np.bool_)
    usable = inside.copy() if valid is None else inside & np.asarray(valid, dtype=np.bool_)
    dead, hot = np.zeros(values.shape, np.bool_), np.empty(values.shape, np.bool_)
    sigma, (rows, cols) = noise_sigma(values, usable), values.shape
    room = work_space(_find_dead_work(rows, cols))
    if _find_dead(address(values), address(usable), rows, cols, sigma, address(dead), room):
        fill_taxels(values, usable & ~dead, inside)
    works = usable & ~dead
    if _find_hot(address(values), address(works), rows, cols, sigma, address(hot)):
        fill_taxels(values, works & ~hot, inside)
        dead |= hot
    return Repaired(values, dead)
