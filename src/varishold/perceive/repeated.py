"""What a touch says that is made again and again at an object that stays in its place."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

__all__ = ["Repeated"]

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Repeated:
    """What one touch has said of the particles, however often it was made at an object that stayed in its place.

    It errs each time as it did before, so that all times together are worth one. What knows other numbers, as another
    sensor does, is a part of the same time.

    Parameters
    ----------
    total : ndarray of shape (n,)
        The sum over all times.
    times : ndarray of shape (d,), int
        How often each of the touch's numbers was known.
    """

    total: Floats
    times: NDArray[np.int64]

    @property
    def log_weight(self) -> Floats:
        """What it says of each particle."""
        return self.total / max(1, int(self.times.max(initial=0)))

    @property
    def whole(self) -> bool:
        """Whether every number of the touch was known in some time: another one tells nothing more."""
        return bool(self.times.all())

    def again(self, log_weight: Floats, known: NDArray[np.bool_]) -> Repeated:
        """Return what is said with another time."""
        return Repeated(self.total + log_weight, self.times + known)
