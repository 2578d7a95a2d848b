"""Runs of frames, or of lines, for which something holds on end."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

__all__ = ["runs_of"]


def runs_of(where: NDArray[np.bool_]) -> Iterator[range]:
    """Yield the places of each run of True, in order.

    Examples
    --------
    >>> list(runs_of(np.array([True, False, True, True])))
    [range(0, 1), range(2, 4)]
    """
    edges = np.flatnonzero(np.diff(np.r_[False, where, False].astype(np.int8)))
    for first, stop in zip(edges[::2].tolist(), edges[1::2].tolist(), strict=True):
        yield range(first, stop)
