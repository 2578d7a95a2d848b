"""Some of many frames, taxels or presses, spread evenly over all of them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

__all__ = ["spread_over"]


def spread_over(n: int, most: int) -> NDArray[np.intp]:
    """Return at most so many of the numbers 0 to n - 1, each once, rising: the first and the last are among them.

    Examples
    --------
    >>> spread_over(3, 8).tolist(), spread_over(100, 4).tolist()
    ([0, 1, 2], [0, 33, 66, 99])
    """
    return np.unique(np.linspace(0, n - 1, most).astype(np.intp))
