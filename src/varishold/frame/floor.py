"""The standard plane delta: how high above nothing a touch begins."""

from __future__ import annotations

from varishold.files.compiling import njit

__all__ = ["FLOOR_OF_PEAK", "FLOOR_SIGMAS", "MOST_OF_PEAK", "default_floor"]

# The standard plane stands clear of the noise (one taxel in 30,000 exceeds 4 sigma by chance) and of the faint skirt
# that skins and cross-talk put around a contact.
FLOOR_SIGMAS = 4.0
FLOOR_OF_PEAK = 0.05
# What changes from taxel to taxel in one frame is noise or the taxels' own unevenness, which nothing tells apart: it
# lifts the plane so far, and no form is swallowed. What noise passes is sorted out afterwards.
MOST_OF_PEAK = 0.10
# Below it there are too few floating-point numbers to put thresholds between.
_LEAST_FLOOR = 2.2250738585072014e-308


@njit(cache=True, nogil=True)
def default_floor(sigma: float, peak: float) -> float:
    """Return the standard plane of a single frame, from its noise and its peak, in their unit."""
    return max(min(FLOOR_SIGMAS * sigma, MOST_OF_PEAK * peak), FLOOR_OF_PEAK * peak, _LEAST_FLOOR)
