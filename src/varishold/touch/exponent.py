"""The apex exponent k of A ~ (theta_1 - theta)^k."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from varishold.files.compiling import njit

__all__ = ["apex_exponent"]

#: Sections below this many taxels, and the lowest ones, near the noise, say nothing of the apex.
LEAST_AREA = 4.0
_DEEPEST = 0.85
# How far above the highest taxel the true apex may lie, as shares of the contact's span: taxels average tips away.
_ABOVE = (0.0, 0.02, 0.04, 0.07, 0.1, 0.15, 0.2)


@njit(cache=True, nogil=True)
def _fit(depth: NDArray[np.float64], log_area: NDArray[np.float64], n: int) -> float:
    best_error = np.inf
    best_k = math.nan
    for above in _ABOVE:
        sx = 0.0
        sy = 0.0
        sxx = 0.0
        sxy = 0.0
        syy = 0.0
        for i in range(n):
            x = math.log(depth[i] + above)
            y = log_area[i]
            sx += x
            sy += y
            sxx += x * x
            sxy += x * y
            syy += y * y
        spread = sxx - sx * sx / n
        if spread <= 0.0:
            continue
        k = (sxy - sx * sy / n) / spread
        error = syy - sy * sy / n - k * (sxy - sx * sy / n)
        if error < best_error:
            best_error = error
            best_k = k
    return best_k


def apex_exponent(
    threshold: NDArray[np.float64],
    area: NDArray[np.float64],
    *,
    peak: float,
    floor: float,
    taxel_area: float = 1.0,
) -> float | None:
    """Fit k of A = c (theta_1 - theta)^k to a profile, theta_1 free a little above the highest taxel.

    Parameters
    ----------
    threshold, area : ndarray of shape (n_levels,), float64
        A contact's profile.
    peak, floor : float
        Highest taxel and the standard plane, in the thresholds' unit.
    taxel_area : float
        Area of one taxel, in the areas' unit.

    Returns
    -------
    float or None
        None where fewer than four sections are usable. On a height map a pillar has 0, a lying cylinder
        1/2, a sphere or a ridge 1, a cone or a pyramid 2; on taxels over an elastic skin it tells little.

    Examples
    --------
    >>> theta = np.linspace(0.95, 0.05, 19)
    >>> round(apex_exponent(theta, 200 * (1 - theta) ** 2, peak=1.0, floor=0.0), 2)
    2.0
    """
    depth = (peak - threshold) / max(peak - floor, 1e-300)
    usable = (area >= LEAST_AREA * taxel_area) & (depth > 0) & (depth <= _DEEPEST)
    n = int(usable.sum())
    if n < 4:
        return None
    k = float(_fit(depth[usable], np.log(area[usable]), n))
    return k if math.isfinite(k) else None
