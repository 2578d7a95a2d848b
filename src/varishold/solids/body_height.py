"""The face that a body of convex parts turns upward."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from varishold.solids.body import Part

__all__ = ["height_of", "top_of"]

_DOWN = np.array([0.0, 0.0, -1.0])


def top_of(parts: Sequence[Part]) -> float:
    """Return the height of the highest point of a body. Metres."""
    return max(part.centre_m[2] + part.half_m[2] for part in parts)


def height_of(parts: Sequence[Part], x: NDArray[np.float64], y: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the height of a body over the base plane.

    Parameters
    ----------
    parts : sequence of Part
    x, y : ndarray of shapes that broadcast
        Points of the base plane. Metres.

    Returns
    -------
    ndarray of their common shape, float64
        Metres; 0 where there is nothing.
    """
    x, y = np.broadcast_arrays(np.asarray(x, dtype=np.float64), np.asarray(y, dtype=np.float64))
    above = 2 * top_of(parts)
    points = np.column_stack([x.ravel(), y.ravel(), np.full(x.size, above)])
    reach = np.min([part.hits(points, _DOWN) for part in parts], axis=0)
    return np.where(np.isfinite(reach), above - reach, 0.0).reshape(x.shape)
