"""Filling broken taxels from their neighbours."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from varishold.errors import InputError
from varishold.frame.checks import as_floats, as_usable
from varishold.kernel import address, bind, work_space

__all__ = ["fill_invalid", "fill_taxels", "filled_above_rest"]

_fill = bind("vh_fill", "pppiip", "i")
_fill_work = bind("vh_fill_work", "ii", "z")


def fill_taxels(frame: NDArray[np.float64], usable: NDArray[np.bool_], field: NDArray[np.bool_]) -> int:
    """Fill a frame in place where `field` and not `usable`: `fill_invalid` of the kernel's arrays, unchecked.

    Parameters
    ----------
    frame : ndarray of shape (rows, cols), float64
        Overwritten where filled.
    usable : ndarray of shape (rows, cols), bool
        Where the frame's values are to be believed; it is not read outside the field.
    field : ndarray of shape (rows, cols), bool
        Where there are taxels.

    Returns
    -------
    int
        Number of taxels filled.
    """
    rows, cols = frame.shape
    room = work_space(_fill_work(rows, cols))
    n: int = _fill(address(frame), address(usable), address(field), rows, cols, room)
    return n


def fill_invalid(frame: ArrayLike, valid: ArrayLike, field: ArrayLike | None = None) -> NDArray[np.float64]:
    """Fill broken taxels so that each is the mean of its neighbours (a discrete harmonic function).

    Filled values never leave the range of the others. A part of the field that has no working taxel at all is
    filled with the lowest value of the rest: no contact is seen where nothing was felt.

    Parameters
    ----------
    frame : array_like of shape (rows, cols), float or integer
        The frame; broken taxels may hold anything, also NaN.
    valid : array_like of shape (rows, cols), bool
        False where a taxel is broken.
    field : array_like of shape (rows, cols), bool, optional
        False where there is no taxel: never filled and never a neighbour. Default: taxels everywhere.

    Returns
    -------
    ndarray of shape (rows, cols), float64
        A new frame; outside the field as it was.

    Raises
    ------
    InputError
        If shapes differ or no taxel is left to fill from.

    Examples
    --------
    >>> import numpy as np
    >>> frame = np.array([[1.0, 2.0, 1.0], [2.0, np.nan, 4.0], [1.0, 4.0, 1.0]])
    >>> round(float(fill_invalid(frame, np.isfinite(frame))[1, 1]), 6)
    3.0
    """
    filled = as_floats(frame, 2, "a frame", masked=True).copy()
    inside = as_usable(filled, filled.shape, field)
    usable = as_usable(frame, filled.shape, None, valid)
    if not np.any(usable & inside):
        raise InputError(f"all {np.count_nonzero(inside)} taxels are broken: nothing to fill from")
    fill_taxels(filled, usable, inside)
    return filled


def filled_above_rest(
    values: NDArray[Any], wrong: NDArray[np.bool_], rest: NDArray[np.float64], usable: NDArray[np.bool_]
) -> NDArray[Any]:
    """Return a reading of which wrong taxels rest as they did, and rise as those beside them do.

    Parameters
    ----------
    values : ndarray of shape (rows, cols), float or integer
    wrong, usable : ndarray of shape (rows, cols), bool
    rest : ndarray of shape (rows, cols), float64
        What each taxel reads at rest.

    Returns
    -------
    ndarray of shape (rows, cols)
        The values themselves where no taxel is left to fill from.
    """
    good = ~wrong & np.isfinite(values)
    if not (good & usable).any():
        return values
    filled = fill_invalid(np.where(good, values - rest, 0.0), good, usable) + rest
    return np.where(wrong, filled, values)
