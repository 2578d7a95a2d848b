"""How much a signed distance can be: no more than one goes from where it is known, anything behind a side alone."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from varishold.perceive.surface_points import blocks

__all__ = ["DistanceBound", "cut_off", "depth_behind"]

Floats = NDArray[np.float64]

# A normal that is so much wider than the interval it is cut to lies evenly there.
_EVEN = 100.0

# Near points tell on which side a place lies: they count by this power of how much nearer they are. No place is nearer
# than this. Metres.
_NEARER, _LEAST_M = 8, 1e-6


class DistanceBound:
    """The most that the signed distance can be, told by points that lie on the surface but for a slack.

    Parameters
    ----------
    points_m : ndarray of shape (n, 3)
    slack_m : ndarray of shape (n,)
        How far off each may lie. Metres.
    """

    def __init__(self, points_m: Floats, slack_m: Floats) -> None:
        self._points, self._slack = points_m, slack_m

    def at(self, places: Floats) -> tuple[Floats, Floats]:
        """Return how far places (k, 3) are from the nearest point, and the bound there; both (k,), metres."""
        from scipy.spatial.distance import cdist

        apart = (cdist(part, self._points) for part in blocks(places))
        parts = [(each.min(axis=1), (each + self._slack).min(axis=1)) for each in apart]
        away, most = (np.concatenate(of) for of in zip(*parts, strict=True))
        return away, most


def depth_behind(places: Floats, points_m: Floats, normals: Floats) -> Floats:
    """Return how deep places (k, 3) lie inside of what was touched near them, 0 outside; (k,), metres."""
    from scipy.spatial.distance import cdist

    reach, parts = (points_m * normals).sum(axis=1), []
    for part in blocks(places):
        apart = np.maximum(cdist(part, points_m), _LEAST_M)
        counts = (apart.min(axis=1, keepdims=True) / apart) ** _NEARER
        deep = reach - part @ normals.T
        parts.append((deep * counts).sum(axis=1) / counts.sum(axis=1))
    return np.asarray(np.maximum(np.concatenate(parts), 0.0))


def cut_off(mean: Floats, sigma: Floats, most: Floats) -> tuple[Floats, Floats]:
    """Return mean and standard deviation of normals that are cut off beyond -most and most, all (k,).

    A mean that lies beyond is taken to the end first. Means keep their sign.
    """
    from scipy.special import ndtr

    mean = np.clip(mean, -most, most)
    sigma = np.minimum(sigma, _EVEN * most)
    low, high = (-most - mean) / sigma, (most - mean) / sigma
    at_low, at_high = np.exp(-(low**2) / 2), np.exp(-(high**2) / 2)
    whole = np.sqrt(2 * np.pi) * (ndtr(high) - ndtr(low))
    shift = (at_low - at_high) / whole
    part = 1 + (low * at_low - high * at_high) / whole - shift**2
    return mean + sigma * shift, sigma * np.sqrt(np.maximum(part, 0.0))
