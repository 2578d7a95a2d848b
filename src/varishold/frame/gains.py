"""What each taxel of a pad reads more or less than others, as far as its presses show it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from varishold.frame.fault import Floats, Mask
from varishold.frame.line_gains import line_gains
from varishold.frame.taxel_gains import taxel_gains

__all__ = ["gains_of", "gains_words"]

# What is not told of.
_FAINT = 1e-9


def gains_of(loads: Sequence[Floats], usable: Mask, sigma: float) -> Floats | None:
    """Return how much more or less each taxel reads, by its row, its column and itself; None where that is not certain.

    Parameters
    ----------
    loads : sequence of ndarray of shape (rows, cols), float64
        The strongest frame of each press, zero at rest.
    usable : ndarray of shape (rows, cols), bool
    sigma : float
        Standard deviation of the noise.

    Returns
    -------
    ndarray of shape (rows, cols), float64, or None
        About 1.
    """
    of_lines = line_gains(loads, usable, sigma)
    of_taxels = taxel_gains(loads if of_lines is None else [load / of_lines for load in loads], usable, sigma)
    if of_lines is None or of_taxels is None:
        return of_taxels if of_lines is None else of_lines
    return of_lines * of_taxels


def gains_words(gains: Floats) -> str:
    """Return what is evened out, in words.

    Examples
    --------
    >>> gains_words(np.array([[0.9, 0.9], [1.1, 1.1]]))
    'readings differ from line to line, rows by 10 %, as presses at many places show: evened out'
    >>> gains_words(np.array([[0.9, 1.1], [1.1, 0.9]]))
    'readings differ from taxel to taxel by 10 %, as presses at many places show: evened out'
    """
    logs = np.log(gains)
    rows, columns = logs.mean(axis=1, keepdims=True), logs.mean(axis=0, keepdims=True)
    if float(np.std(logs - rows - columns)) > _FAINT:
        unlike = f"taxel to taxel by {100 * float(logs.std()):.2g} %"
    else:
        lines = {"rows": float(rows.std()), "columns": float(columns.std())}
        said = " and ".join(f"{name} by {100 * by:.2g} %" for name, by in lines.items() if by > _FAINT)
        unlike = f"line to line, {said}"
    return f"readings differ from {unlike}, as presses at many places show: evened out"
