"""Presses that tell what taxels read: where each presses, and whether they differ."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from varishold.frame.fault import Floats, Mask

__all__ = ["press_places"]

# A taxel takes part in a press where it stands above this share of its peak, and of so many sigma of the noise.
_INSIDE, _SIGMAS = 0.25, 8.0
# Presses whose cosine with their mean is above this on the median are all alike: a form stays too.
_SAME = 0.9


def press_places(loads: Sequence[Floats], usable: Mask, sigma: float) -> tuple[Floats, Mask] | None:
    """Return what presses read and where each presses; None where they are all the same thing at the same place.

    Parameters
    ----------
    loads : sequence of ndarray of shape (rows, cols), float64
        The strongest frame of each press, zero at rest.
    usable : ndarray of shape (rows, cols), bool
    sigma : float
        Standard deviation of the noise.

    Returns
    -------
    presses : ndarray of shape (n, rows, cols), float64
    inside : ndarray of shape (n, rows, cols), bool
    """
    presses = np.where(usable, loads, 0.0)
    least = np.maximum(_INSIDE * presses.max(axis=(1, 2)), _SIGMAS * sigma)[:, None, None]
    inside = presses >= np.where(least > 0.0, least, np.inf)
    flat = np.where(inside, presses, 0.0).reshape(len(presses), -1)
    flat /= np.maximum(np.linalg.norm(flat, axis=1, keepdims=True), np.finfo(float).tiny)
    mean = flat.mean(axis=0)
    # What stays from press to press is then the thing as well as the gains.
    alike = float(np.median(flat @ mean)) > _SAME * float(np.linalg.norm(mean))
    return None if alike else (presses, inside)
