"""Taxels that feel nothing of presses all around them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from varishold._counted import counted

__all__ = ["marked_broken", "pressed_around", "silent_taxels"]

Floats = NDArray[np.float64]
Mask = NDArray[np.bool_]

# A press presses a taxel where what surrounds it stands above this share of the press's peak.
_INSIDE = 0.25
# A taxel that stays below this share of what surrounds it is broken, if it does in so many of the presses.
_BROKEN, _NEARLY_ALL = 0.03, 0.8


def pressed_around(frames: Floats, usable: Mask) -> tuple[Floats, Mask]:
    """Return what surrounds each taxel in each press, and where that presses it; each (n_presses, rows, cols)."""
    around = ndimage.median_filter(np.where(usable, frames, 0.0), size=(1, 3, 3), mode="nearest")
    return around, around > _INSIDE * around.max(axis=(1, 2), keepdims=True)


def silent_taxels(frames: Floats, usable: Mask, pressed: tuple[Floats, Mask], *, fewest: int) -> Mask:
    """Return the taxels that stay silent, shape (rows, cols), where so many presses press them or more.

    `pressed` is what `pressed_around` says of these frames.
    """
    around, high = pressed
    silent = ((frames < _BROKEN * around) & high).sum(axis=0)
    found: Mask = usable & (silent >= fewest) & (silent > _NEARLY_ALL * high.sum(axis=0))
    return found


def marked_broken(broken: Mask) -> list[str]:
    """Say how many taxels stay silent."""
    if not broken.any():
        return []
    words = counted(
        np.count_nonzero(broken), "taxel stays silent under presses and is", "taxels stay silent under presses and are"
    )
    return [f"{words} marked broken"]
