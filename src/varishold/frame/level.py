"""The rest of one frame: a slope or an offset, taken off where the taxels that nothing presses show it.

The rest is a plane that about a quarter of the field or more lies in, that hardly a taxel lies below, and that
something stands clearly above. A frame without such a plane, or whose plane is zero, stays as it is, to the last bit.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from varishold.frame.noise import noise_sigma
from varishold.kernel import address, bind, work_space

__all__ = ["Levelled", "level"]

_level = bind("vh_level", "ppiidpp", "i")
_level_work = bind("vh_level_work", "ii", "z")


@dataclass(frozen=True)
class Levelled:
    """A frame whose rest is zero.

    Parameters
    ----------
    values : ndarray of shape (rows, cols), float64
        The frame; the same numbers where no rest was found.
    rest : (float, float, float)
        The plane that was taken off, in the unit of the frame: at the pad's first taxel, its rise by column and by row;
        zeros where nothing was.
    """

    values: NDArray[np.float64]
    rest: tuple[float, float, float]


def level(frame: ArrayLike, field: ArrayLike | None = None, valid: ArrayLike | None = None) -> Levelled:
    """Take off the plane that the taxels lie in which nothing presses.

    Parameters
    ----------
    frame : array_like of shape (rows, cols), float or integer
        Finite inside the field.
    field, valid : array_like of shape (rows, cols), bool, optional
        False where there is no taxel, and where a taxel is known to be broken.

    Returns
    -------
    Levelled

    Examples
    --------
    >>> import numpy as np
    >>> y, x = np.mgrid[-6:6, -6:6]
    >>> frame = 50.0 + 5.0 * np.maximum(4.0 - np.hypot(x, y), 0.0)
    >>> taken = level(frame)
    >>> float(taken.values.max()), [round(v, 6) for v in taken.rest]
    (20.0, [50.0, 0.0, 0.0])
    """
    values = np.array(frame, dtype=np.float64, order="C")
    usable = np.ones(values.shape, np.bool_) if field is None else np.array(field, dtype=np.bool_)
    if valid is not None:
        usable &= np.asarray(valid, dtype=np.bool_)
    rest = np.zeros(3)
    sigma, (rows, cols) = noise_sigma(values, usable), values.shape
    room = work_space(_level_work(rows, cols))
    _level(address(values), address(usable), rows, cols, sigma, address(rest), room)
    return Levelled(values, (float(rest[0]), float(rest[1]), float(rest[2])))
