"""The standard plane delta: how high above nothing a touch begins, and what above it is still noise."""

from __future__ import annotations

import math

from varishold.files.compiling import njit

__all__ = [
    "FLOOR_OF_PEAK",
    "FLOOR_SIGMAS",
    "LEAST_OF_PEAK",
    "MOST_OF_PEAK",
    "default_floor",
    "noise_reach",
    "timed_floor",
]

# The standard plane stands clear of the noise (one taxel in 30,000 exceeds 4 sigma by chance) and of the faint skirt
# that skins and cross-talk put around a contact.
FLOOR_SIGMAS = 4.0
FLOOR_OF_PEAK = 0.05
# What changes from taxel to taxel in one frame is noise or the taxels' own unevenness, which nothing tells apart: it
# lifts the plane so far, and no form is swallowed. What noise passes is sorted out afterwards.
MOST_OF_PEAK = 0.10
# Where time has told the noise from the unevenness, fainter skirts are seen.
LEAST_OF_PEAK = 0.02
# Below it there are too few floating-point numbers to put thresholds between.
_LEAST_FLOOR = 2.2250738585072014e-308
# One frame in a hundred has a taxel beyond the reach of its noise.
_ONE_IN = 100.0


@njit(cache=True, nogil=True)
def default_floor(sigma: float, peak: float) -> float:
    """Return the standard plane of a single frame, from its noise and its peak, in their unit."""
    return max(min(FLOOR_SIGMAS * sigma, MOST_OF_PEAK * peak), FLOOR_OF_PEAK * peak, _LEAST_FLOOR)


@njit(cache=True, nogil=True)
def timed_floor(sigma: float, peak: float) -> float:
    """Return the standard plane where sigma was measured in time, in their unit."""
    return max(FLOOR_SIGMAS * sigma, LEAST_OF_PEAK * peak, _LEAST_FLOOR)


@njit(cache=True, nogil=True)
def noise_reach(sigma: float, n_taxels: int) -> float:
    """Return how high the noise of so many taxels reaches: 4 sigma on 16 x 16, 5.5 on 640 x 480."""
    # n (1 - Phi(k)) is n exp(-k^2 / 2) / (k sqrt(2 pi)); for the k in question the divisor is about 10.
    return sigma * math.sqrt(2.0 * math.log(max(0.1 * _ONE_IN * n_taxels, 1.0)))
