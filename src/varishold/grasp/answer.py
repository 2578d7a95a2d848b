"""One grasp's answer, and what is to be known of the readings behind it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from varishold.grasp.encoder import ThresholdEncoder

__all__ = ["GraspAnswer", "Readings", "readings_of"]


@dataclass(frozen=True)
class GraspAnswer:
    """What is said of one grasp.

    Parameters
    ----------
    object : str
        The likeliest object.
    probability : float
        Of that object; at most .9 outside of what was learned.
    p_value : float
        How rare it is that a grasp of something known is as strange.
    rejected : bool
        Whether it looks like no object that was learned, or nothing is known of it.
    outside : tuple of str
        Columns that are unknown, or whose number lies beyond all that was learned.
    why : tuple of str
        Which hyperplanes and switches decided, and how many wrong switches it bears; empty unless asked for.
    """

    object: str
    probability: float
    p_value: float
    rejected: bool
    outside: tuple[str, ...] = ()
    why: tuple[str, ...] = ()

    def to_dict(self) -> dict[str, Any]:
        """Return what JSON holds."""
        return {
            "object": self.object,
            "probability": round(self.probability, 6),
            "rejected": self.rejected,
            "p_value": round(self.p_value, 6),
            "outside": list(self.outside),
            **({"why": list(self.why)} if self.why else {}),
        }


@dataclass(frozen=True, eq=False)
class Readings:
    """Grasps as the classifier sees them.

    Parameters
    ----------
    switches : ndarray of shape (n, n_switches), bool or float64
        NaN where unknown.
    beyond : ndarray of shape (n,), float64
        How far the readings lie beyond those learned, in switches.
    outside : ndarray of shape (n, n_columns), bool
        Which columns are unknown or lie beyond.
    """

    switches: NDArray[Any]
    beyond: NDArray[np.float64]
    outside: NDArray[np.bool_]


def readings_of(values: NDArray[np.float64], encoder: ThresholdEncoder | None) -> Readings:
    """Return what columns of numbers, shape (n, n_columns) and NaN where unknown, are to the classifier."""
    unknown = np.isnan(values)
    if encoder is None:
        return Readings(values, np.zeros(len(values)), unknown)
    beyond = encoder.beyond(values)
    bits = encoder.transform(np.where(unknown, 0.0, values))
    switches = np.where(np.repeat(unknown, encoder.bits_per_channel_, axis=1), np.nan, bits) if unknown.any() else bits
    return Readings(switches, beyond.sum(axis=1), unknown | (beyond > 0))
