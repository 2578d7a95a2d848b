"""The standard plane delta: how high above nothing a touch begins, and what above it is still noise."""

from __future__ import annotations

from varishold.kernel import bind

__all__ = [
    "FLOOR_OF_PEAK",
    "FLOOR_SIGMAS",
    "LEAST_OF_PEAK",
    "MOST_OF_PEAK",
    "noise_reach",
]

# What `native/floor.c` computes with, for those who explain it.
# The standard plane stands clear of the noise (one taxel in 30,000 exceeds 4 sigma by chance) and of the faint skirt
# that skins and cross-talk put around a contact.
FLOOR_SIGMAS = 4.0
FLOOR_OF_PEAK = 0.05
# What changes from taxel to taxel in one frame is noise or the taxels' own unevenness, which nothing tells apart: it
# lifts the plane so far, and no form is swallowed. What noise passes is sorted out afterwards.
MOST_OF_PEAK = 0.10
# Where time has told the noise from the unevenness, fainter skirts are seen.
LEAST_OF_PEAK = 0.02

_noise_reach = bind("vh_noise_reach", "di", "d")


def noise_reach(sigma: float, n_taxels: int) -> float:
    """Return how high the noise of so many taxels reaches: 4 sigma on 16 x 16, 5.5 on 640 x 480."""
    reach: float = _noise_reach(sigma, n_taxels)
    return reach
