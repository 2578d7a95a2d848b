"""What a file leaves unsaid when it is played, and what its pads say in a layout."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

__all__ = ["Reading", "places"]


@dataclass(frozen=True)
class Reading:
    """How a file is read.

    Parameters
    ----------
    shape : (int, int) or None
    pitch_m : float or None
    polarity : {"up", "down"}
        As in `varishold.recording.read`.
    """

    shape: tuple[int, int] | None = None
    pitch_m: float | None = None
    polarity: Literal["up", "down"] = "up"


def places(mask: NDArray[np.bool_] | None) -> tuple[int, ...]:
    """Return where a mask is False, row by row."""
    return () if mask is None else tuple(np.flatnonzero(~mask).tolist())
