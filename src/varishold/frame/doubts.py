"""What seems odd about how frames were taken, which nobody can be sure of."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from varishold.files import let_go
from varishold.frame.scaled import scaled_words
from varishold.frame.spread import spread_over
from varishold.frame.wiring import wiring_words

__all__ = ["doubts_of"]

# Frames that are looked at.
_LOOKED_AT = 64


def doubts_of(frames: NDArray[Any], usable: NDArray[np.bool_]) -> tuple[str, ...]:
    """Say what seems odd, in words; nothing where nothing does.

    Parameters
    ----------
    frames : ndarray of shape (n_frames, rows, cols)
        May be mapped; some are read.
    usable : ndarray of shape (rows, cols), bool
    """
    some = np.asarray(frames[spread_over(len(frames), _LOOKED_AT)])
    let_go(frames)
    return (*wiring_words(some, usable), *scaled_words(some, usable))
